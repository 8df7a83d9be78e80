//! (Q2) and (R1): exceedance probabilities from a fitted model and from random samples.
//!
//! ```text
//! Q(f, g) = 1 - Φ((θ_t - f)/e^{g/2})
//! (Q2) P_est = mean over all inputs x of Q(f_m(x), g_m(x)), by a fixed quadrature
//! (R1) sd/mean of a share of n independent samples = √((1 - P)/(n P))
//! ```
//! The plug-in means leave f_v and g_v out, as the authors do. Tested in `tests/physics/design.rs`.

use super::quadrature::Quadrature;
use crate::gp::grid::means_on;
use crate::gp::vhgp::Vhgp;
use crate::numerics::elementary::exp;
use crate::numerics::normal::distribution;
use crate::numerics::random::below;
use crate::numerics::sums::sum;
use rand_chacha::ChaCha12Rng;

/// Q(f, g), the probability that a response with mean f and noise variance e^g exceeds the threshold.
pub fn exceedance(f: f64, g: f64, threshold: f64) -> f64 {
    // Φ(-x) keeps its accuracy where 1 - Φ(x) would lose it.
    distribution((f - threshold) * exp(-0.5 * g))
}

/// (Q2) over the nodes of a quadrature.
pub fn probability(model: &Vhgp<2>, quadrature: &Quadrature, threshold: f64) -> f64 {
    let means = means_on(model, &quadrature.axes);
    let q = |i: &usize| quadrature.weight[*i] * exceedance(means.f[*i], means.g[*i], threshold);
    let terms: Vec<f64> = quadrature.support.iter().map(q).collect();
    sum(&terms)
}

/// The share of values above the threshold; 0 for no values.
pub fn share_above(y: &[f64], threshold: f64) -> f64 {
    let above = y.iter().filter(|y| **y > threshold).count();
    if y.is_empty() {
        0.0
    } else {
        above as f64 / y.len() as f64
    }
}

/// (R1), relative to P; `probability` in (0, 1].
pub fn random_relative_deviation(probability: f64, n: u32) -> f64 {
    ((1.0 - probability) / (f64::from(n) * probability)).sqrt()
}

/// Random sampling: P_est after each of `sizes` (ascending) samples drawn independently from 0..`groups`.
///
/// `respond(i)` is the response of group i; it is called once per draw, in order.
pub fn random_sampling(
    groups: usize,
    sizes: &[u32],
    threshold: f64,
    mut respond: impl FnMut(usize) -> f64,
    stream: &mut ChaCha12Rng,
) -> Vec<f64> {
    let (mut drawn, mut above) = (0, 0_u32);
    let mut estimates = Vec::with_capacity(sizes.len());
    for size in sizes {
        while drawn < *size {
            above += u32::from(respond(below(stream, groups)) > threshold);
            drawn += 1;
        }
        estimates.push(if drawn == 0 {
            0.0
        } else {
            f64::from(above) / f64::from(drawn)
        });
    }
    estimates
}
