//! The c-optimal design: where to measure so that one linear combination of unknown coefficients is known best.
//!
//! ```text
//! M(ξ) = Σ_i ξ_i p_i b_i b_iᵀ      information of one measurement, b_i (m) the basis at node i, p_i its precision
//! minimise cᵀ M(ξ)⁻¹ c over the shares ξ:   ξ_i <- ξ_i √p_i |b_iᵀ M⁻¹ c| / Σ
//! ```
//! Several functions with one basis may be unknown at once: their variances add up. The multiplicative step lowers the
//! variance each time. Pukelsheim, *Optimal Design of Experiments* (2006), chapters 2 and 9. Tested against Elfving's
//! solution in `tests/physics/floor.rs`.

use nalgebra::{DMatrix, DVector, DVectorView};

/// Steps; the last ones lower the variance by less than 1e-3 of it.
const STEPS: u32 = 1000;
/// Least share of a node: none ends at 0, so M stays regular.
const LEAST_SHARE: f64 = 1e-12;

/// An unknown function of the nodes: basis times coefficients.
#[derive(Clone, Debug, Default)]
pub struct Unknown {
    /// p_i, the precision of a measurement at each node (nodes).
    pub precision: Vec<f64>,
    /// c, what the coefficients do to the quantity wanted (m).
    pub c: Vec<f64>,
}

impl Unknown {
    /// Adds a node with its basis, precision and what the function's value there does to the quantity wanted.
    pub fn tell(&mut self, basis: &[f64], precision: f64, slope: f64) {
        self.precision.push(precision);
        self.c.resize(basis.len(), 0.0);
        for (c, b) in self.c.iter_mut().zip(basis) {
            *c += slope * b;
        }
    }

    /// M(ξ)⁻¹ c; `None` if M is singular.
    fn solve(&self, basis: &[Vec<f64>], share: &[f64]) -> Option<DVector<f64>> {
        let m = self.c.len();
        let mut information = DMatrix::zeros(m, m);
        for ((b, p), w) in basis.iter().zip(&self.precision).zip(share) {
            let b = DVectorView::from_slice(b, m);
            information.syger(w * p, &b, &b, 1.0);
        }
        Some(information.cholesky()?.solve(&DVector::from_column_slice(&self.c)))
    }
}

/// The least variance over all designs on the nodes with this `basis` (nodes)(m); `None` if it is not positive.
pub fn c_optimal(basis: &[Vec<f64>], unknown: &[Unknown]) -> Option<f64> {
    let mut share = vec![1.0 / basis.len() as f64; basis.len()];
    let mut variance = f64::INFINITY;
    for _ in 0..STEPS {
        let known: Option<Vec<DVector<f64>>> = unknown.iter().map(|u| u.solve(basis, &share)).collect();
        let solved = known?;
        variance = 0.0;
        for (u, h) in unknown.iter().zip(&solved) {
            variance += dot(&u.c, h.as_slice());
        }
        let mut total = 0.0;
        for (i, b) in basis.iter().enumerate() {
            let mut gain = 0.0;
            for (u, h) in unknown.iter().zip(&solved) {
                let value = dot(b, h.as_slice());
                gain += value * value * u.precision[i];
            }
            share[i] *= gain.sqrt();
            total += share[i];
        }
        for w in &mut share {
            let scaled = *w / total;
            *w = if scaled > LEAST_SHARE { scaled } else { LEAST_SHARE };
        }
    }
    (variance > 0.0 && variance.is_finite()).then_some(variance)
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).fold(0.0, |total, (a, b)| total + a * b)
}
