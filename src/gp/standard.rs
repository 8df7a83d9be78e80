//! The standard Gaussian process with one constant noise variance: baseline of the comparison and start of the VHGP.
//!
//! ```text
//! log N(y | 0, K + σ_n² I) = -½ yᵀα - Σ log L_ii - (n/2) log 2π,   α = (K + σ_n² I)⁻¹ y
//! ∂/∂φ = ½ Σ_ij (α αᵀ - B)_ij (∂K/∂φ)_ij
//! ```
//! Rasmussen & Williams, *Gaussian Processes for Machine Learning* (2006), section 5.4. Parameters stand in one vector
//! [log variance, log length (D), log σ_n²]. Tested by finite differences in `tests/physics/gp.rs`.

use super::kernel::{
    Ard, covariance, cross, pack, squared_differences, sum_of_squares, weighted_derivatives, weighted_sum,
};
use crate::numerics::cholesky::{factor, forward, inverse_transposed, log_diagonal, solve, symmetric_inverse};
use crate::numerics::elementary::exp;
use crate::numerics::lanes::{Kernel, dispatch};
use crate::numerics::square::{ROWS, Square};

/// ½ ln 2π.
const HALF_LN_TWO_PI: f64 = 0.918_938_533_204_672_7;

/// The log marginal likelihood for one set of samples, with its matrices.
#[derive(Clone, Debug)]
pub struct Likelihood {
    y: Vec<f64>,
    squares: Vec<Square>,
    k: Square,
    l: Square,
    inverse: Square,
    scratch: Square,
    alpha: Vec<f64>,
}

impl Likelihood {
    /// The likelihood of responses `y` (n) at samples `x` (n).
    pub fn new<const D: usize>(x: &[[f64; D]], y: &[f64]) -> Self {
        let square = Square::zeros(x.len());
        Self {
            y: y.to_vec(),
            squares: squared_differences(x),
            k: square.clone(),
            l: square.clone(),
            inverse: square.clone(),
            scratch: square,
            alpha: y.to_vec(),
        }
    }

    /// Its logarithm at `theta` and the gradient; `None` if K + σ_n² I is not positive definite there.
    pub fn evaluate(&mut self, theta: &[f64], gradient: &mut [f64]) -> Option<f64> {
        dispatch(Evaluate {
            likelihood: self,
            theta,
            gradient,
        })
    }
}

struct Evaluate<'a> {
    likelihood: &'a mut Likelihood,
    theta: &'a [f64],
    gradient: &'a mut [f64],
}

impl Kernel for Evaluate<'_> {
    type Output = Option<f64>;
    #[inline(always)]
    fn run(self) -> Option<f64> {
        let m = self.likelihood;
        let (n, last) = (m.y.len(), self.theta.len() - 1);
        let (kernel, noise) = (Ard::from_log(&self.theta[..last]), exp(self.theta[last]));
        covariance(&kernel, &m.squares, noise, &mut m.k);
        m.l.values.copy_from_slice(&m.k.values);
        if !factor(&mut m.l) {
            return None;
        }
        m.alpha.copy_from_slice(&m.y);
        solve(&m.l, &mut m.alpha);
        inverse_transposed(&m.l, &mut m.scratch);
        symmetric_inverse(&m.scratch, &mut m.inverse);
        let (mut quadratic, mut trace) = (0.0, 0.0);
        for j in 0..n {
            let alpha = m.alpha[j];
            quadratic += m.y[j] * alpha;
            let (b, column) = (m.inverse.column(j), m.scratch.column_mut(j));
            for i in 0..n {
                column[i] = 0.5 * (alpha * m.alpha[i] - b[i]);
            }
            trace += column[j];
        }
        weighted_derivatives(&kernel, &m.squares, noise, &m.k, &m.scratch, &mut self.gradient[..last]);
        self.gradient[last] = noise * trace;
        let value = -0.5 * quadratic - log_diagonal(&m.l) - n as f64 * HALF_LN_TWO_PI;
        value.is_finite().then_some(value)
    }
}

/// A fitted standard Gaussian process.
#[derive(Clone, Debug)]
pub struct Standard<const D: usize> {
    /// Samples (n).
    pub x: Vec<[f64; D]>,
    /// The kernel.
    pub kernel: Ard,
    /// σ_n².
    pub noise: f64,
    alpha: Vec<f64>,
    l: Square,
}

impl<const D: usize> Standard<D> {
    /// The posterior for samples x, y (n) at `theta`; `None` if its matrix is not positive definite.
    pub fn new(x: &[[f64; D]], y: &[f64], theta: &[f64]) -> Option<Self> {
        let mut m = Likelihood::new(x, y);
        m.evaluate(theta, &mut vec![0.0; theta.len()])?;
        Some(Self {
            x: x.to_vec(),
            kernel: Ard::from_log(&theta[..=D]),
            noise: exp(theta[D + 1]),
            alpha: m.alpha,
            l: m.l,
        })
    }

    /// Mean and variance of f at each point (the variance of y is larger by `noise`).
    pub fn predict(&self, points: &[[f64; D]]) -> Vec<(f64, f64)> {
        dispatch(Predict { model: self, points })
    }
}

struct Predict<'a, const D: usize> {
    model: &'a Standard<D>,
    points: &'a [[f64; D]],
}

impl<const D: usize> Kernel for Predict<'_, D> {
    type Output = Vec<(f64, f64)>;
    #[inline(always)]
    fn run(self) -> Vec<(f64, f64)> {
        let m = self.model;
        let mut out = Vec::with_capacity(self.points.len());
        let mut rows = vec![0.0; ROWS * m.l.stride];
        for points in self.points.chunks(ROWS) {
            cross(&m.kernel, &m.x, &pack(points), &mut rows[..ROWS * m.x.len()]);
            let mean = weighted_sum(&rows, &m.alpha);
            forward(&m.l, &mut rows);
            let known = sum_of_squares(&rows);
            for r in 0..points.len() {
                let variance = m.kernel.variance - known[r];
                out.push((mean[r], if variance > 0.0 { variance } else { 0.0 }));
            }
        }
        out
    }
}
