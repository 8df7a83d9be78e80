//! The smallest standard deviation that any method of a kind can reach with n samples, the whole pool known.
//!
//! ```text
//! importance sampling:  √((E√π)² - P²)/(P √n)           x drawn from p √π, π(x) = P(r > θ_t | x)
//! stratified sampling:  E√(π(1 - π))/(P √n)             every x its own stratum
//! smooth model:         √(cᵀ M(ξ)⁻¹ c/n)/P              minimised over the design ξ (c-optimal)
//! ```
//! The smooth model is r ~ N(f(x), e^{g(x)}) with unknown polynomials added to the f and g of the whole pool; M is the
//! Fisher information of one sample, c the gradient of P_est by the polynomials' coefficients: the Cramer-Rao bound of
//! an unbiased estimate. A prior that knows more than the degree may go below it, at the price of bias.
//! Tested in `tests/physics/floor.rs`.

use super::estimate::exceedance;
use super::quadrature::Quadrature;
use crate::numerics::elementary::{exp, ln};
use crate::numerics::invariant;
use crate::numerics::normal::density;
use crate::numerics::optimal_design::{Unknown, c_optimal};
use crate::numerics::sums::{mean, sum};
use serde::{Deserialize, Serialize};

/// Least local variance of the responses.
const LEAST_VARIANCE: f64 = 1e-6;

/// No relative deviation of one sample is larger.
const LARGEST_DEVIATION: f64 = 1e15;

/// Standard deviations relative to P of the estimate from one sample; divide by √n.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Floor {
    /// P, the share of exceedances in the pool.
    pub probability: f64,
    /// Independent groups, (R1).
    pub random: f64,
    /// Optimal importance sampling.
    pub importance: f64,
    /// Optimal stratified sampling.
    pub stratified: f64,
    /// The smooth model's Cramer-Rao bound.
    pub model: f64,
    /// P by the smooth model over the whole pool: what the normal law itself is wrong by.
    pub model_probability: f64,
}

/// The floors of the kinds of methods in use; none where no group exceeds the threshold.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Floors {
    /// Of those that see (ln L/T_p, A/H_s).
    pub groups: Option<Floor>,
    /// Of those that see (z/θ_t, A/H_s).
    pub control: Option<Floor>,
}

impl Floors {
    /// Checks that probabilities are such and no deviation is below zero.
    ///
    /// # Errors
    /// The first number that cannot be one.
    pub fn check(&self) -> Result<(), String> {
        for (place, floor) in [("groups", self.groups), ("control", self.control)] {
            let Some(floor) = floor else { continue };
            let own = |key: &str| format!("{place}.{key}");
            invariant::within(&own("probability"), floor.probability, 0.0..=1.0)?;
            // A quadrature's weights add up to 1 but for rounding.
            invariant::within(&own("model_probability"), floor.model_probability, 0.0..=1.0 + 1e-9)?;
            let deviations = [floor.random, floor.importance, floor.stratified, floor.model];
            invariant::all_within(place, &deviations, &(0.0..=LARGEST_DEVIATION))?;
        }
        Ok(())
    }
}

/// What is known of the pool at every node of a quadrature, by Gaussian kernels.
struct Local {
    /// π, the share of exceedances.
    share: Vec<f64>,
    /// Mean of the responses.
    f: Vec<f64>,
    /// Log variance of the responses.
    g: Vec<f64>,
}

/// The floor for responses `r` (N) of inputs `x` (N).
///
/// `cap` is the largest response a model sees, `bandwidth` that of the kernels at the nodes, `degree` that of the
/// polynomials. `None` if nothing or everything exceeds the threshold, or a matrix is singular.
pub fn floor(
    (x, r): (&[[f64; 2]], &[f64]),
    (threshold, cap): (f64, f64),
    quadrature: &Quadrature,
    bandwidth: [f64; 2],
    degree: u32,
) -> Option<Floor> {
    let above: Vec<f64> = r.iter().map(|r| f64::from(*r > threshold)).collect();
    let probability = mean(&above);
    // Where no group exceeds, or all do, no method has anything to find.
    if probability <= 0.0 || probability >= 1.0 {
        return None;
    }
    let capped: Vec<f64> = r.iter().map(|r| if *r < cap { *r } else { cap }).collect();
    let local = Local::new(x, &above, &capped, quadrature, bandwidth);
    let over = |h: &dyn Fn(usize) -> f64| -> f64 {
        let terms: Vec<f64> = quadrature
            .support
            .iter()
            .map(|i| quadrature.weight[*i] * h(*i))
            .collect();
        sum(&terms)
    };
    let root = over(&|i| local.share[i].sqrt());
    let variance = least_variance(&local, quadrature, threshold, degree)?;
    Some(Floor {
        probability,
        random: ((1.0 - probability) / probability).sqrt(),
        importance: at_least(root * root - probability * probability, 0.0).sqrt() / probability,
        stratified: over(&|i| (local.share[i] * (1.0 - local.share[i])).sqrt()) / probability,
        model: variance.sqrt() / probability,
        model_probability: over(&|i| exceedance(local.f[i], local.g[i], threshold)),
    })
}

impl Local {
    fn new(x: &[[f64; 2]], above: &[f64], r: &[f64], quadrature: &Quadrature, bandwidth: [f64; 2]) -> Self {
        let kernels = [
            (&quadrature.axes.first, bandwidth[0]),
            (&quadrature.axes.second, bandwidth[1]),
        ]
        .map(|(nodes, bandwidth)| -> Vec<f64> {
            let pairs = nodes
                .iter()
                .flat_map(|a| nodes.iter().map(move |b| (a - b) / bandwidth));
            pairs.map(density).collect()
        });
        let size = [quadrature.axes.first.len(), quadrature.axes.second.len()];
        let smoothed = |value: &[f64]| smooth(&quadrature.shared_out(x, value), size, &kernels);
        let squares: Vec<f64> = r.iter().map(|r| r * r).collect();
        let mass = smooth(&quadrature.weight, size, &kernels);
        let (share, first, second) = (smoothed(above), smoothed(r), smoothed(&squares));
        let average = |moment: &[f64], i: usize| if mass[i] > 0.0 { moment[i] / mass[i] } else { 0.0 };
        let nodes = 0..mass.len();
        let f: Vec<f64> = nodes.clone().map(|i| average(&first, i)).collect();
        let g = |i: usize| ln(at_least(average(&second, i) - f[i] * f[i], LEAST_VARIANCE));
        Self {
            share: nodes.clone().map(|i| share_of(average(&share, i))).collect(),
            g: nodes.map(g).collect(),
            f,
        }
    }
}

/// A smoothed share, which rounding may leave a little below 0 or above 1.
fn share_of(smoothed: f64) -> f64 {
    let share = at_least(smoothed, 0.0);
    if share < 1.0 { share } else { 1.0 }
}

fn at_least(x: f64, least: f64) -> f64 {
    if x > least { x } else { least }
}

/// Both coordinates' kernels (A, A), (B, B) applied to values on the nodes (B, A).
fn smooth(values: &[f64], [width, height]: [usize; 2], [first, second]: &[Vec<f64>; 2]) -> Vec<f64> {
    let mut half = Vec::with_capacity(values.len());
    for row in values.chunks_exact(width) {
        half.extend(first.chunks_exact(width).map(|kernel| dot(row, kernel)));
    }
    let mut out = vec![0.0; values.len()];
    for (out, kernel) in out.chunks_exact_mut(width).zip(second.chunks_exact(height)) {
        for (row, k) in half.chunks_exact(width).zip(kernel) {
            for (o, v) in out.iter_mut().zip(row) {
                *o += k * v;
            }
        }
    }
    out
}

/// All monomials up to a degree of two coordinates.
fn monomials([x, y]: [f64; 2], degree: u32) -> Vec<f64> {
    let mut basis = Vec::new();
    let mut left = 1.0;
    for i in 0..=degree {
        let mut term = left;
        for _ in i..=degree {
            basis.push(term);
            term *= y;
        }
        left *= x;
    }
    basis
}

/// The least variance cᵀ M⁻¹ c of one sample, over designs on the nodes.
fn least_variance(local: &Local, quadrature: &Quadrature, threshold: f64, degree: u32) -> Option<f64> {
    let middle = |nodes: &[f64]| 0.5 * (nodes[0] + nodes[nodes.len() - 1]);
    let half = |nodes: &[f64]| at_least((nodes[nodes.len() - 1] - nodes[0]) / 2.0, f64::MIN_POSITIVE);
    let sides = [&quadrature.axes.first, &quadrature.axes.second].map(|nodes| (middle(nodes), half(nodes)));
    let mut basis = Vec::with_capacity(quadrature.support.len());
    let mut unknown = [Unknown::default(), Unknown::default()];
    for &i in &quadrature.support {
        let x = quadrature.axes.node(i);
        let own = monomials([0, 1].map(|d| (x[d] - sides[d].0) / sides[d].1), degree);
        let inverse = exp(-0.5 * local.g[i]);
        let u = (local.f[i] - threshold) * inverse;
        let slope = quadrature.weight[i] * density(u);
        unknown[0].tell(&own, inverse * inverse, slope * inverse);
        unknown[1].tell(&own, 0.5, -0.5 * u * slope);
        basis.push(own);
    }
    c_optimal(&basis, &unknown)
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).fold(0.0, |total, (a, b)| total + a * b)
}
