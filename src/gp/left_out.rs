//! What a model says of its own samples, each one's response left out: a check of the model by the data it was made of.
//!
//! ```text
//! f⁻ = y - α_f/B                        B = diag (K_f + R)⁻¹
//! g⁻ = μ - (λ - ½)(1/D - 1)/λ           D = diag (I + (s sᵀ) ∘ K_g)⁻¹
//! ```
//! The means of the other samples' conditional distribution, without another factor (Rasmussen & Williams, *Gaussian Processes
//! for Machine Learning*, 2006, Eq. 5.12): of f with the responses and their R, of g with what stands for them in q(g), normal
//! terms of precision λ and mean μ - μ₀ + (λ - ½)/λ. All parameters stay. Tested against elimination in
//! `tests/physics/gp.rs`.

use super::grid::Pair;
use super::vhgp::Vhgp;

/// (f⁻, g⁻) at every sample; `y` (n) are the responses that the model was fitted to.
pub fn left_out<const D: usize>(model: &Vhgp<D>, y: &[f64]) -> Pair {
    let [b, d] = &model.inverses;
    let f = y.iter().zip(&model.alpha_f).zip(b);
    let g = model.mu.iter().zip(&model.parameters.lambda).zip(d);
    Pair {
        f: f.map(|((y, alpha), b)| y - alpha / b).collect(),
        g: g.map(|((mu, lambda), d)| mu - (lambda - 0.5) * (1.0 / d - 1.0) / lambda)
            .collect(),
    }
}
