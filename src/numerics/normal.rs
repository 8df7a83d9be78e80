//! The standard normal distribution: density, distribution, quantile.
//!
//! | paper | code | meaning |
//! |---|---|---|
//! | φ(x) | `density` | exp(-x²/2) / √(2π) |
//! | Φ(x) | `distribution` | ½ erfc(-x/√2): accurate in the lower tail too |
//! | Φ⁻¹(p) | `quantile` | rational start, then two steps of Halley on Φ(x) = p |
//!
//! Tested by round trips and table values in `tests/physics/normal.rs`.

use super::elementary::{erfc, exp, ln};

/// 1/√(2π).
const DENSITY_AT_ZERO: f64 = 0.398_942_280_401_432_7;

/// φ(x).
pub fn density(x: f64) -> f64 {
    DENSITY_AT_ZERO * exp(-0.5 * x * x)
}

/// Φ(x).
pub fn distribution(x: f64) -> f64 {
    0.5 * erfc(-x * std::f64::consts::FRAC_1_SQRT_2)
}

/// Φ⁻¹(p): about 1e-15 relative for p in (0, 1); minus and plus infinity at and beyond 0 and 1.
pub fn quantile(p: f64) -> f64 {
    if p <= 0.0 {
        return f64::NEG_INFINITY;
    }
    if p >= 1.0 {
        return f64::INFINITY;
    }
    // 1 - p is exact for p >= 1/2, so both halves are as accurate as the lower one.
    if p > 0.5 { -lower(1.0 - p) } else { lower(p) }
}

/// A standard normal number from one uniform in [0, 1).
pub fn from_uniform(u: f64) -> f64 {
    // The middle of the uniform's cell of width 2^-53 is never 0 or 1.
    let middle = if u < 0.5 { u + 0.5 / 9_007_199_254_740_992.0 } else { u };
    quantile(middle)
}

/// Φ⁻¹(p) for 0 < p <= 1/2.
fn lower(p: f64) -> f64 {
    let mut x = first_guess(p);
    for _ in 0..2 {
        // Cubic convergence: 4.5e-4, then below 1e-7 even at x = -37, then the last bits.
        let error = (distribution(x) - p) / density(x);
        x -= error / (1.0 + 0.5 * x * error);
    }
    x
}

/// Rational approximation of Abramowitz & Stegun 26.2.23, error below 4.5e-4.
fn first_guess(p: f64) -> f64 {
    let t = (-2.0 * ln(p)).sqrt();
    let above = 2.515_517 + t * (0.802_853 + t * 0.010_328);
    let below = 1.0 + t * (1.432_788 + t * (0.189_269 + t * 0.001_308));
    above / below - t
}
