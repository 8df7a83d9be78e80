//! The model's estimate set right by what its own samples exceeded: the normal law says how π(x) varies, the samples how
//! large it is where the input lies.
//!
//! ```text
//! Q_i⁻ = Q(f⁻, g⁻) at sample i, its own response left out;  e_i = 1 if r_i > θ_t, else 0
//! v_i ∝ p(x_i)/q(x_i),  Σ v = (Σ v)²/Σ v²            p of the input, q of the samples, by one Gaussian kernel
//! Q(ω) = ωQ/(1 - Q + ωQ)                             every odds of exceeding times ω
//! Σ_i v_i (e_i - Q_i⁻(ω)) = ln ω/s²                  ln ω ~ N(0, s²) before any sample
//! P_est = Σ_j w_j Q_j(ω)                             w_j of the quadrature
//! ```
//! For s -> ∞ it is the targeted estimate of van der Laan & Rubin, *Targeted maximum likelihood learning*, Int. J. Biostat. 2,
//! 2006: consistent if either the model or the weights are right. A finite s keeps it between 0 and 1 where no sample, or
//! every one, exceeds. Bandwidths are Scott's, n^(-1/6) standard deviations of the samples. Tested in
//! `tests/physics/targeted.rs`.

use super::estimate::exceedance;
use super::look_ahead;
use super::quadrature::Quadrature;
use crate::gp::grid::means_on;
use crate::gp::left_out::left_out;
use crate::gp::vhgp::Vhgp;
use crate::numerics::elementary::{exp, ln};
use crate::numerics::sums::{standard_deviation, sum};

/// Halvings of the interval that holds ln ω: from 60 to the last bit of a number near 1.
const HALVINGS: u32 = 60;
/// Odds are e³⁰ times the model's at most.
const LARGEST_LOG_ODDS: f64 = 30.0;

/// By how much the samples raise a model's odds of exceeding.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Targeted {
    /// ln ω.
    pub log_odds: f64,
    /// Variance of ln ω by the scatter of the samples: Σ v² (e - Q⁻(ω))² over the square of the information.
    pub variance: f64,
    /// The share of the model's own error that the samples leave: 1/s² of the information Σ v Q⁻(ω)(1 - Q⁻(ω)) + 1/s².
    pub left: f64,
}

impl Targeted {
    /// From a model of the responses `y` (n), of which those `above` (n) exceeded the threshold; `deviation` is s > 0.
    pub fn new(
        model: &Vhgp<2>,
        (y, above): (&[f64], &[bool]),
        quadrature: &Quadrature,
        threshold: f64,
        deviation: f64,
    ) -> Self {
        let left_out = left_out(model, y);
        let pairs = left_out.f.iter().zip(&left_out.g);
        let q: Vec<f64> = pairs.map(|(f, g)| exceedance(*f, *g, threshold)).collect();
        let weight = weights(&model.x, quadrature);
        let log_odds = log_odds(&q, above, &weight, deviation);
        let (mut scatter, mut information) = (0.0, 1.0 / (deviation * deviation));
        let prior = information;
        for ((q, above), w) in q.iter().zip(above).zip(&weight) {
            let q = raised(*q, exp(log_odds));
            let error = w * (f64::from(*above) - q);
            scatter += error * error;
            information += w * q * (1.0 - q);
        }
        Self {
            log_odds,
            variance: scatter / (information * information),
            left: prior / information,
        }
    }

    /// P_est over the nodes of a quadrature.
    pub fn probability(&self, model: &Vhgp<2>, quadrature: &Quadrature, threshold: f64) -> f64 {
        self.mean(model, quadrature, threshold, |q| q)
    }

    /// The standard deviation of P_est, of first order: what the samples leave of the model's own, and how they scatter.
    ///
    /// Too small where the law is badly wrong, by up to half: it takes weights and places for given, and knows no bias.
    pub fn deviation(&self, model: &Vhgp<2>, quadrature: &Quadrature, threshold: f64) -> f64 {
        let odds = exp(self.log_odds);
        let own = look_ahead::variance(model, quadrature, threshold, |q| {
            let lowered = 1.0 - q + odds * q;
            odds / (lowered * lowered)
        });
        // Rounding may make a variance of nothing negative.
        let own = if own > 0.0 { own } else { 0.0 };
        // ∂P_est/∂ln ω.
        let slope = self.mean(model, quadrature, threshold, |q| q * (1.0 - q));
        (self.left * self.left * own + slope * slope * self.variance).sqrt()
    }

    /// The mean over all inputs of `of` Q(ω).
    fn mean(&self, model: &Vhgp<2>, quadrature: &Quadrature, threshold: f64, of: impl Fn(f64) -> f64) -> f64 {
        let (means, odds) = (means_on(model, &quadrature.axes), exp(self.log_odds));
        let q = |i: usize| raised(exceedance(means.f[i], means.g[i], threshold), odds);
        let terms = quadrature.support.iter().map(|i| quadrature.weight[*i] * of(q(*i)));
        sum(&terms.collect::<Vec<f64>>())
    }
}

/// A probability with its odds times ω.
fn raised(q: f64, odds: f64) -> f64 {
    odds * q / (1.0 - q + odds * q)
}

/// ln ω for the left-out probabilities `q`, what exceeded, and the weights (n each); it solves the fourth line above.
pub fn log_odds(q: &[f64], above: &[bool], weight: &[f64], deviation: f64) -> f64 {
    let excess = |log_odds: f64| {
        let odds = exp(log_odds);
        let terms = q.iter().zip(above).zip(weight);
        let terms: Vec<f64> = terms
            .map(|((q, above), w)| w * (f64::from(*above) - raised(*q, odds)))
            .collect();
        sum(&terms) - log_odds / (deviation * deviation)
    };
    let (mut low, mut high) = (-LARGEST_LOG_ODDS, LARGEST_LOG_ODDS);
    for _ in 0..HALVINGS {
        let middle = 0.5 * (low + high);
        // It falls as ω grows.
        if excess(middle) > 0.0 {
            low = middle;
        } else {
            high = middle;
        }
    }
    0.5 * (low + high)
}

/// How much of the input each sample (n) stands for; their sum is the number of equal weights that tell as much. All 0
/// where no sample is near any input.
pub fn weights(samples: &[[f64; 2]], quadrature: &Quadrature) -> Vec<f64> {
    let n = samples.len() as f64;
    // n^(-1/6).
    let scott = exp(-ln(n) / 6.0);
    let inverse = [0, 1].map(|d| {
        let coordinate: Vec<f64> = samples.iter().map(|x| x[d]).collect();
        let bandwidth = scott * standard_deviation(&coordinate);
        // Samples that do not differ say nothing about this coordinate; their deviation may be one of rounding.
        let differ = coordinate.iter().any(|x| *x != coordinate[0]);
        if differ && bandwidth > 0.0 {
            1.0 / bandwidth
        } else {
            0.0
        }
    });
    let square = |d: usize, a: f64, b: f64| (a - b) * (a - b) * inverse[d] * inverse[d];
    let ratio = |x: &[f64; 2]| {
        let others = samples
            .iter()
            .map(|y| exp(-0.5 * (square(0, x[0], y[0]) + square(1, x[1], y[1]))));
        let q = others.fold(0.0, |total, k| total + k) / n;
        smoothed(quadrature, |d, node| exp(-0.5 * square(d, x[d], node))) / q
    };
    let ratios: Vec<f64> = samples.iter().map(ratio).collect();
    let squares: Vec<f64> = ratios.iter().map(|w| w * w).collect();
    let (first, second) = (sum(&ratios), sum(&squares));
    let scale = if second > 0.0 { first / second } else { 0.0 };
    ratios.iter().map(|w| w * scale).collect()
}

/// Σ_j w_j times the kernel of both coordinates at node j.
fn smoothed(quadrature: &Quadrature, kernel: impl Fn(usize, f64) -> f64) -> f64 {
    let axes = &quadrature.axes;
    let first: Vec<f64> = axes.first.iter().map(|node| kernel(0, *node)).collect();
    let rows = quadrature.weight.chunks_exact(axes.first.len()).zip(&axes.second);
    let row = |(weight, node): (&[f64], &f64)| {
        let along = weight.iter().zip(&first).fold(0.0, |total, (w, k)| total + w * k);
        along * kernel(1, *node)
    };
    rows.map(row).fold(0.0, |total, value| total + value)
}
