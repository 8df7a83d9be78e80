//! The unit in which the steps of detection measure an envelope: one twelfth of its own significant wave height.
//!
//! ```text
//! H_s  = 4 sqrt(m_0) = sqrt(8 mean_j rho_j^2)      because the mean of rho^2 is 2 m_0
//! unit = H_s/12, rounded to 40 significant bits
//! ```
//! The steps divide rho by this unit before anything else and multiply the amplitudes by it at the end, so a group does
//! not depend on the unit of elevation. The public code states its settings in metres, for seas of H_s = 12 m: D is
//! rounded to 1e-8 m, and the fit counts A in metres beside x and l in samples, with one length of a first step and one
//! tolerance for all three. Here they are H_s/1.2e9 and H_s/12, which is the same at H_s = 12 m.
//!
//! Two properties follow from the rounding, which takes off what the order of a sum decides:
//! - An envelope of H_s = 12 m has the unit 1 m to the last bit, so the division changes none of its bits.
//! - An envelope times 2^k has the unit times 2^k, and then the division gives the same bits.
//!
//! Tested in `tests/physics/scaling.rs`.

use crate::numerics::sums;

/// Units in a significant wave height: the H_s, in metres, of the seas for which the public code states its settings.
const UNITS_PER_HEIGHT: f64 = 12.0;
/// Bits of a 53-bit significand that the rounding takes off. The mean of a field's squares is known to about 50 bits.
const ROUNDED_OFF: u32 = 13;

/// The unit of one envelope (n), in the unit of its samples.
///
/// It is 1 where rho is zero everywhere, and where the squares of rho leave the range of numbers.
pub fn unit_of(rho: &[f64]) -> f64 {
    let squares: Vec<f64> = rho.iter().map(|rho| rho * rho).collect();
    let unit = rounded((8.0 * sums::mean(&squares)).sqrt() / UNITS_PER_HEIGHT);
    if unit.is_normal() { unit } else { 1.0 }
}

/// A positive number rounded to its 40 leading bits, half upwards; a carry runs on into the exponent, as it should.
fn rounded(x: f64) -> f64 {
    let half = 1 << (ROUNDED_OFF - 1);
    f64::from_bits((x.to_bits() + half) >> ROUNDED_OFF << ROUNDED_OFF)
}

/// The envelope (n) in a unit.
pub fn in_units(rho: &[f64], unit: f64) -> Vec<f64> {
    rho.iter().map(|rho| rho / unit).collect()
}
