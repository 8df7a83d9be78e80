//! Latin hypercube designs: in every coordinate each of n equal strata holds exactly one of n points.
//!
//! McKay, Beckman & Conover, Technometrics 21 (1979). Tested in `tests/physics/latin_hypercube.rs`.

use super::random::{below, uniform};
use rand_chacha::ChaCha12Rng;

/// n points over the box [lower, upper], each uniform in its strata, strata paired at random.
///
/// Draws coordinate by coordinate: n - 1 draws shuffle the strata, n place the points in them.
pub fn latin_hypercube<const D: usize>(
    n: usize,
    lower: [f64; D],
    upper: [f64; D],
    stream: &mut ChaCha12Rng,
) -> Vec<[f64; D]> {
    let mut points = vec![[0.0; D]; n];
    let mut strata: Vec<usize> = (0..n).collect();
    for d in 0..D {
        for i in (1..n).rev() {
            strata.swap(i, below(stream, i + 1));
        }
        for (point, stratum) in points.iter_mut().zip(&strata) {
            let share = (*stratum as f64 + uniform(stream)) / n as f64;
            point[d] = lower[d] + share * (upper[d] - lower[d]);
        }
    }
    points
}
