//! Where the next sample lowers the variance of the estimate most.
//!
//! ```text
//! P_est = Σ_j w_j Q(f_j, g_j),   ∂Q/∂f = φ(u)/σ,  ∂Q/∂g = -½ u φ(u),  u = (f - θ_t)/σ,  σ = e^{g/2}
//! c_f(x) = Σ_j w_j ∂Q/∂f_j cov(f_j, f(x)),   c_g alike
//! a(x) = c_f(x)²/(f_v(x) + σ²(x)) + c_g(x)²/(g_v(x) + 2)
//! ```
//! The first-order variance of P_est is Σ_j w_j (∂Q/∂f_j c_f(x_j) + ∂Q/∂g_j c_g(x_j)), and a(x) is by how much one more
//! response at x lowers it: a normal response tells its mean with variance σ² and its log variance with variance 2, which
//! is λ = ½ in the bound. Tested against the variance after refactoring in `tests/physics/design.rs`.

use super::estimate::exceedance;
use super::quadrature::Quadrature;
use crate::gp::grid::{Pair, covariances_on, means_on};
use crate::gp::vhgp::Vhgp;
use crate::numerics::elementary::exp;
use crate::numerics::normal::density;

/// What one response tells of its log variance: a measurement of it with this variance.
const LOG_VARIANCE_NOISE: f64 = 2.0;

/// (w ∂Q/∂f, w ∂Q/∂g) at every node.
fn sensitivities(means: &Pair, quadrature: &Quadrature, threshold: f64) -> Pair {
    let nodes = quadrature.weight.len();
    let mut pair = Pair {
        f: vec![0.0; nodes],
        g: vec![0.0; nodes],
    };
    for &i in &quadrature.support {
        let inverse = exp(-0.5 * means.g[i]);
        let u = (means.f[i] - threshold) * inverse;
        let slope = quadrature.weight[i] * density(u);
        pair.f[i] = slope * inverse;
        pair.g[i] = -0.5 * u * slope;
    }
    pair
}

/// The node with weight where a response lowers the variance of the estimate most, the first on a tie; `None` without
/// any.
///
/// A score is at most what it were with f_v = g_v = 0: only nodes whose bound exceeds the score of the node with the
/// largest bound are predicted.
pub fn best(model: &Vhgp<2>, quadrature: &Quadrature, threshold: f64) -> Option<[f64; 2]> {
    let means = means_on(model, &quadrature.axes);
    let covariances = covariances_on(model, &quadrature.axes, &sensitivities(&means, quadrature, threshold));
    let score = |i: usize, f_v: f64, g_v: f64| {
        let (f, g) = (covariances.f[i], covariances.g[i]);
        f * f / (f_v + exp(means.g[i])) + g * g / (g_v + LOG_VARIANCE_NOISE)
    };
    let bounds: Vec<f64> = quadrature.support.iter().map(|i| score(*i, 0.0, 0.0)).collect();
    let (mut top, mut largest_bound) = (*quadrature.support.first()?, f64::NEG_INFINITY);
    for (i, bound) in quadrature.support.iter().zip(&bounds) {
        if *bound > largest_bound {
            (top, largest_bound) = (*i, *bound);
        }
    }
    let exact = |nodes: &[usize]| -> Vec<f64> {
        let points: Vec<[f64; 2]> = nodes.iter().map(|i| quadrature.axes.node(*i)).collect();
        let predictions = model.predict(&points);
        nodes
            .iter()
            .zip(predictions)
            .map(|(i, p)| score(*i, p.f_v, p.g_v))
            .collect()
    };
    let least = exact(&[top])[0];
    let able = quadrature
        .support
        .iter()
        .zip(&bounds)
        .filter(|(_, bound)| **bound >= least);
    let able: Vec<usize> = able.map(|(i, _)| *i).collect();
    let (mut best, mut largest) = (top, f64::NEG_INFINITY);
    for (i, value) in able.iter().zip(exact(&able)) {
        if value > largest {
            (best, largest) = (*i, value);
        }
    }
    Some(quadrature.axes.node(best))
}

/// The first-order variance of Σ_j w_j h(Q_j), where `slope` is h'(Q): 1 for the estimate itself.
pub fn variance(model: &Vhgp<2>, quadrature: &Quadrature, threshold: f64, slope: impl Fn(f64) -> f64) -> f64 {
    let means = means_on(model, &quadrature.axes);
    let mut weight = sensitivities(&means, quadrature, threshold);
    for &i in &quadrature.support {
        let slope = slope(exceedance(means.f[i], means.g[i], threshold));
        weight.f[i] *= slope;
        weight.g[i] *= slope;
    }
    let covariances = covariances_on(model, &quadrature.axes, &weight);
    let mut total = 0.0;
    for &i in &quadrature.support {
        total += weight.f[i] * covariances.f[i] + weight.g[i] * covariances.g[i];
    }
    total
}
