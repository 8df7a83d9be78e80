//! A fitted VHGP: the posterior of f and of the log noise variance g at new points.
//!
//! ```text
//! f_m = k_f*ᵀ α_f              f_v = k_f** - k_f*ᵀ (K_f + R)⁻¹ k_f*
//! g_m = k_g*ᵀ β_g + μ₀         g_v = k_g** - ‖U k_g*‖²
//! E[y] = f_m                   Var[y] = f_v + exp(g_m + g_v/2)
//! ```
//! Points are taken eight at a time, one per lane. Tested against the published vector in `tests/physics/gp.rs`.

use super::elbo::{Elbo, Parameters};
use super::kernel::{cross, pack, sum_of_squares, weighted_sum};
use crate::numerics::cholesky::forward;
use crate::numerics::elementary::exp;
use crate::numerics::lanes::{Kernel, dispatch};
use crate::numerics::square::{ROWS, Square};

/// A VHGP with its samples and parameters.
#[derive(Clone, Debug)]
pub struct Vhgp<const D: usize> {
    /// Samples (n).
    pub x: Vec<[f64; D]>,
    /// λ, kernels, μ₀.
    pub parameters: Parameters,
    /// F at these parameters.
    pub elbo: f64,
    pub(super) alpha_f: Vec<f64>,
    pub(super) beta_g: Vec<f64>,
    pub(super) s: Vec<f64>,
    /// μ (n).
    pub(super) mu: Vec<f64>,
    /// The diagonals of (K_f + R)⁻¹ and of (I + (s sᵀ) ∘ K_g)⁻¹ (n each).
    pub(super) inverses: [Vec<f64>; 2],
    /// The factor of K_f + R.
    pub(super) l: Square,
    /// The factor of I + (s sᵀ) ∘ K_g.
    pub(super) c: Square,
}

/// The posterior at one point, in units of y (f) and of log y² (g).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Prediction {
    /// Mean of f.
    pub f_m: f64,
    /// Variance of f.
    pub f_v: f64,
    /// Mean of g, the log noise variance.
    pub g_m: f64,
    /// Variance of g.
    pub g_v: f64,
}

impl Prediction {
    /// E\[y\].
    pub fn mean(&self) -> f64 {
        self.f_m
    }

    /// Var\[y\].
    pub fn variance(&self) -> f64 {
        self.f_v + exp(self.g_m + 0.5 * self.g_v)
    }
}

impl<const D: usize> Vhgp<D> {
    /// The posterior for samples x, y (n) at the parameter vector `theta` of [`Parameters::decode`]; `jitter` as in the
    /// bound. `None` if a matrix is not positive definite.
    pub fn new(x: &[[f64; D]], y: &[f64], theta: &[f64], jitter: f64) -> Option<Self> {
        let mut bound = Elbo::new(x, y, jitter);
        let elbo = bound.evaluate(theta, &mut vec![0.0; theta.len()])?;
        let diagonal = |of: &Square| (0..x.len()).map(|i| of.at(i, i)).collect();
        Some(Self {
            x: x.to_vec(),
            inverses: [diagonal(&bound.b), diagonal(&bound.vtv)],
            mu: bound.mu,
            parameters: bound.parameters,
            elbo,
            alpha_f: bound.alpha_f,
            beta_g: bound.beta_g,
            s: bound.s,
            l: bound.l,
            c: bound.c,
        })
    }

    /// The posterior at each point.
    pub fn predict(&self, points: &[[f64; D]]) -> Vec<Prediction> {
        dispatch(Predict { model: self, points })
    }

    /// Calls `each(f_m, g_m)` for every point in order: the plug-in means alone cost a twentieth of [`Self::predict`].
    pub fn means(&self, points: &[[f64; D]], each: impl FnMut(f64, f64)) {
        dispatch(Means {
            model: self,
            points,
            each,
        });
    }
}

struct Predict<'a, const D: usize> {
    model: &'a Vhgp<D>,
    points: &'a [[f64; D]],
}

impl<const D: usize> Kernel for Predict<'_, D> {
    type Output = Vec<Prediction>;
    #[inline(always)]
    fn run(self) -> Vec<Prediction> {
        let m = self.model;
        let mut out = Vec::with_capacity(self.points.len());
        let mut rows = vec![0.0; ROWS * m.l.stride];
        let used = ROWS * m.x.len();
        for points in self.points.chunks(ROWS) {
            let packed = pack(points);
            cross(&m.parameters.k_f, &m.x, &packed, &mut rows[..used]);
            let f_m = weighted_sum(&rows[..used], &m.alpha_f);
            forward(&m.l, &mut rows);
            let f_known = sum_of_squares(&rows);
            // U k = C⁻¹ (s ∘ k).
            cross(&m.parameters.k_g, &m.x, &packed, &mut rows[..used]);
            let g_m = weighted_sum(&rows[..used], &m.beta_g);
            for (row, s) in rows.chunks_exact_mut(ROWS).zip(&m.s) {
                for v in row {
                    *v *= s;
                }
            }
            forward(&m.c, &mut rows);
            let g_known = sum_of_squares(&rows);
            for r in 0..points.len() {
                out.push(Prediction {
                    f_m: f_m[r],
                    f_v: at_least_zero(m.parameters.k_f.variance - f_known[r]),
                    g_m: g_m[r] + m.parameters.mu_0,
                    g_v: at_least_zero(m.parameters.k_g.variance - g_known[r]),
                });
            }
        }
        out
    }
}

struct Means<'a, const D: usize, F> {
    model: &'a Vhgp<D>,
    points: &'a [[f64; D]],
    each: F,
}

impl<const D: usize, F: FnMut(f64, f64)> Kernel for Means<'_, D, F> {
    type Output = ();
    #[inline(always)]
    fn run(mut self) {
        let m = self.model;
        for points in self.points.chunks(ROWS) {
            let packed = pack(points);
            let (mut f_m, mut g_m) = ([0.0; ROWS], [m.parameters.mu_0; ROWS]);
            for i in 0..m.x.len() {
                let f = m.parameters.k_f.eight(&m.x[i], &packed);
                let g = m.parameters.k_g.eight(&m.x[i], &packed);
                for r in 0..ROWS {
                    f_m[r] += m.alpha_f[i] * f[r];
                    g_m[r] += m.beta_g[i] * g[r];
                }
            }
            for r in 0..points.len() {
                (self.each)(f_m[r], g_m[r]);
            }
        }
    }
}

/// A variance that rounding made negative is 0.
fn at_least_zero(variance: f64) -> f64 {
    if variance > 0.0 { variance } else { 0.0 }
}
