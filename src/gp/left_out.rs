//! What a model says of its own samples, each one's response left out: a check of the model by the data it was made of.
//!
//! ```text
//! 1/f_v⁻ = 1/f_v - 1/R     f⁻ = f_v⁻ (f_m/f_v - y/R)       R = exp(g_m - g_v/2)
//! 1/g_v⁻ = 1/g_v - λ       g⁻ = g_m - g_v⁻ (λ - ½)
//! ```
//! A sample's term is divided out of the posterior of f, and out of that of g, where it has precision λ and slope λ - ½; all
//! parameters stay. Tested against conditioning on the other samples in `tests/physics/gp.rs`.

use super::grid::Pair;
use super::vhgp::Vhgp;
use crate::numerics::elementary::exp;

/// (f⁻, g⁻) at every sample; `y` (n) are the responses that the model was fitted to.
pub fn left_out<const D: usize>(model: &Vhgp<D>, y: &[f64]) -> Pair {
    let mut means = Pair {
        f: Vec::new(),
        g: Vec::new(),
    };
    let known = model.predict(&model.x).into_iter().zip(&model.parameters.lambda);
    // Nothing left out is known less well than by the prior alone: it holds where rounding does not.
    let [least_f, least_g] = [&model.parameters.k_f, &model.parameters.k_g].map(|k| 1.0 / k.variance);
    for ((p, lambda), y) in known.zip(y) {
        let noise = exp(p.g_m - 0.5 * p.g_v);
        means.f.push(if p.f_v > 0.0 {
            (p.f_m / p.f_v - y / noise) / at_least(1.0 / p.f_v - 1.0 / noise, least_f)
        } else {
            p.f_m
        });
        means.g.push(if p.g_v > 0.0 {
            p.g_m - (lambda - 0.5) / at_least(1.0 / p.g_v - lambda, least_g)
        } else {
            p.g_m
        });
    }
    means
}

fn at_least(x: f64, least: f64) -> f64 {
    if x > least { x } else { least }
}
