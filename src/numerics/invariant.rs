//! Invariants of artifacts, as sentences: what a value from a store has to keep before anybody computes with it.
//!
//! Each function gives `place: expected .., found ..` of the first thing that is wrong. Tested through
//! `tests/cache/forged.rs`, which breaks the artifacts of every stage.

use std::fmt::{Debug, Display};
use std::ops::RangeInclusive;

/// A list has as many entries as those who read it beside others take for granted.
///
/// # Errors
/// Another length.
pub fn length<T>(place: &str, list: &[T], expected: usize) -> Result<(), String> {
    let found = list.len();
    if found == expected {
        return Ok(());
    }
    Err(format!("{place}: expected {expected} entries, found {found}"))
}

/// Lists within a list have the lengths of those of another.
///
/// # Errors
/// The first that has another length.
pub fn lengths<T, U>(place: &str, lists: &[Vec<T>], others: &[Vec<U>]) -> Result<(), String> {
    length(place, lists, others.len())?;
    let mut pairs = lists.iter().zip(others).enumerate();
    pairs.try_for_each(|(i, (list, other))| length(&format!("{place}[{i}]"), list, other.len()))
}

/// A number lies in a range; one that is none lies in no range.
///
/// # Errors
/// A number outside it.
pub fn within(place: &str, value: f64, range: RangeInclusive<f64>) -> Result<(), String> {
    if range.contains(&value) {
        return Ok(());
    }
    let (low, high) = (range.start(), range.end());
    Err(format!(
        "{place}: expected a number from {low} to {high}, found {value}"
    ))
}

/// All numbers of a list lie in a range.
///
/// # Errors
/// The first number outside it.
pub fn all_within<'a>(
    place: &str,
    values: impl IntoIterator<Item = &'a f64>,
    range: &RangeInclusive<f64>,
) -> Result<(), String> {
    let mut values = values.into_iter().enumerate();
    values.try_for_each(|(i, value)| {
        // The name of a place costs more than the look at it.
        if range.contains(value) {
            return Ok(());
        }
        within(&format!("{place}[{i}]"), *value, range.clone())
    })
}

/// A number is above zero.
///
/// # Errors
/// One that is not.
pub fn positive(place: &str, value: f64) -> Result<(), String> {
    if value > 0.0 {
        return Ok(());
    }
    Err(format!("{place}: expected a number > 0, found {value}"))
}

/// A list ascends, no two entries equal.
///
/// # Errors
/// The first entry that is not above the one before.
pub fn ascending<T: PartialOrd + Display>(place: &str, list: &[T]) -> Result<(), String> {
    let mut pairs = list.windows(2);
    match pairs.find(|pair| !matches!(pair, [low, high] if low < high)) {
        Some([low, high]) => Err(format!(
            "{place}: expected ascending numbers, found {low} before {high}"
        )),
        _ => Ok(()),
    }
}

/// A value is the one that the parameters give.
///
/// # Errors
/// Another value.
pub fn equal<T: PartialEq + Debug + ?Sized>(place: &str, found: &T, expected: &T) -> Result<(), String> {
    if found == expected {
        return Ok(());
    }
    Err(format!("{place}: expected {expected:?}, found {found:?}"))
}

/// A rule holds.
///
/// # Errors
/// The rule in words, if it does not.
pub fn holds(place: &str, rule: bool, expected: &str) -> Result<(), String> {
    if rule {
        return Ok(());
    }
    Err(format!("{place}: expected {expected}, found none"))
}
