//! What a parameter may be: checks used while a parameter file is decoded.
//!
//! Each of the first functions is a `deserialize_with` of serde; its error says what was expected and what was found. The
//! last ones serve rules: they refuse a size above its bound, with the reason of the bound, and numbers outside a range.

use serde::de::{Deserialize, Deserializer, Error};

/// The largest magnitude of a parameter: the powers of it that the equations form stay far from overflow.
pub const LARGEST: f64 = 1e12;
/// The least of a parameter that has to be above 0: its inverse is no larger than the largest.
pub const LEAST: f64 = 1.0 / LARGEST;

fn checked<'de, D: Deserializer<'de>>(d: D, expected: &str, ok: impl Fn(f64) -> bool) -> Result<f64, D::Error> {
    let value = f64::deserialize(d)?;
    if !value.is_finite() || !ok(value) {
        return Err(D::Error::custom(format!("expected {expected}, found {value}")));
    }
    if value.abs() > LARGEST {
        let why = format!("expected at most {LARGEST:e}, since powers of larger numbers overflow, found {value:e}");
        return Err(D::Error::custom(why));
    }
    Ok(value)
}

/// Any finite number.
pub fn finite<'de, D: Deserializer<'de>>(d: D) -> Result<f64, D::Error> {
    checked(d, "a finite number", |_| true)
}

/// A finite number > 0.
pub fn positive<'de, D: Deserializer<'de>>(d: D) -> Result<f64, D::Error> {
    let value = checked(d, "a number > 0", |x| x > 0.0)?;
    if value >= LEAST {
        return Ok(value);
    }
    let why =
        format!("expected a number > 0, at least {LEAST:e}, since powers of its inverse overflow, found {value:e}");
    Err(D::Error::custom(why))
}

/// A finite number >= 0.
pub fn non_negative<'de, D: Deserializer<'de>>(d: D) -> Result<f64, D::Error> {
    checked(d, "a number >= 0", |x| x >= 0.0)
}

/// A number strictly between 0 and 1.
pub fn fraction<'de, D: Deserializer<'de>>(d: D) -> Result<f64, D::Error> {
    checked(d, "a number between 0 and 1", |x| x > 0.0 && x < 1.0)
}

/// A whole number >= 1.
pub fn count<'de, D: Deserializer<'de>>(d: D) -> Result<u32, D::Error> {
    let value = i64::deserialize(d)?;
    u32::try_from(value)
        .ok()
        .filter(|n| *n >= 1)
        .ok_or_else(|| D::Error::custom(format!("expected a whole number from 1 to {}, found {value}", u32::MAX)))
}

/// A power of two >= 2.
pub fn power_of_two<'de, D: Deserializer<'de>>(d: D) -> Result<u32, D::Error> {
    let value = i64::deserialize(d)?;
    u32::try_from(value)
        .ok()
        .filter(|n| *n >= 2 && n.is_power_of_two())
        .ok_or_else(|| {
            D::Error::custom(format!(
                "expected a power of two from 2 to {}, found {value}",
                1_u32 << 31
            ))
        })
}

/// Refuses a size above its bound.
///
/// # Errors
/// `key: expected at most .., since .., found ..`.
pub fn at_most(key: &str, found: u64, most: u64, since: &str) -> Result<(), String> {
    if found <= most {
        return Ok(());
    }
    Err(format!("{key}: expected at most {most}, since {since}, found {found}"))
}

/// Refuses numbers of which one lies outside a range, or is none.
///
/// # Errors
/// `key: expected numbers from .. to .., found ..`, which names the first such number.
pub fn all_within(key: &str, found: &[f64], low: f64, high: f64) -> Result<(), String> {
    match found.iter().find(|x| !(**x >= low && **x <= high)) {
        None => Ok(()),
        Some(x) => Err(format!("{key}: expected numbers from {low:e} to {high:e}, found {x:e}")),
    }
}

/// The most nodes of a mesh along one coordinate, and in all.
const MESH: (u32, u64) = (1024, 65_536);

/// Refuses a mesh without nodes, or with so many that a fit on it never ends.
///
/// # Errors
/// `key: expected .., found ..`.
pub fn mesh(key: &str, [width, height]: [u32; 2]) -> Result<(), String> {
    let (side, all) = MESH;
    let sides = [width, height].iter().all(|n| (1..=side).contains(n));
    if sides && u64::from(width) * u64::from(height) <= all {
        return Ok(());
    }
    Err(format!(
        "{key}: expected whole numbers >= 1, at most {side} each and {all} nodes in all, since the model is asked at every \
         node after every fit, found [{width}, {height}]"
    ))
}
