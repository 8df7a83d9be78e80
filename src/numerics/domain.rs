//! What a parameter may be: checks used while a parameter file is decoded.
//!
//! Each function is a `deserialize_with` of serde; its error says what was expected and what was found.

use serde::de::{Deserialize, Deserializer, Error};

fn checked<'de, D: Deserializer<'de>>(d: D, expected: &str, ok: impl Fn(f64) -> bool) -> Result<f64, D::Error> {
    let value = f64::deserialize(d)?;
    if value.is_finite() && ok(value) {
        return Ok(value);
    }
    Err(D::Error::custom(format!("expected {expected}, found {value}")))
}

/// Any finite number.
pub fn finite<'de, D: Deserializer<'de>>(d: D) -> Result<f64, D::Error> {
    checked(d, "a finite number", |_| true)
}

/// A finite number > 0.
pub fn positive<'de, D: Deserializer<'de>>(d: D) -> Result<f64, D::Error> {
    checked(d, "a number > 0", |x| x > 0.0)
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
