//! (V1), (V2): the marginalised variational bound F of the VHGP, evaluated as written in its stable form.
//!
//! ```text
//! (V1) Σ = (K_g⁻¹ + Λ)⁻¹,  μ = K_g(λ - ½) + μ₀,  R = diag(exp(μ_i - Σ_ii/2))
//! (V2) F = log N(y | 0, K_f + R) - tr(Σ)/4 - KL(N(μ, Σ) ‖ N(μ₀1, K_g))
//! s = √λ;  C = chol(I + (s sᵀ) ∘ K_g);  V = C⁻¹;  Σ = diag(s)⁻¹ (I - VᵀV) diag(s)⁻¹
//! ```
//! Σ equals K_g - HᵀH, H = V diag(s) K_g, by the push-through identity, without a product. The diagonal loses the digits
//! by which λ k_g falls below 1: three at the bounds in use.
//! Parameters stand in one vector [log λ (n), log var_f, log len_f (D), log var_g, log len_g (D), μ₀].
//! Tested against the published vector in `tests/physics/gp.rs`.

use super::elbo_gradient::gradient;
use super::kernel::{Ard, covariance, squared_differences};
use crate::numerics::cholesky::{factor, inverse_transposed, log_diagonal, solve, symmetric_inverse};
use crate::numerics::elementary::exp;
use crate::numerics::lanes::{Kernel, dispatch};
use crate::numerics::square::Square;

/// Largest |μ_i - Σ_ii/2| that enters an exponential.
const LARGEST_EXPONENT: f64 = 60.0;
/// ½ ln 2π.
const HALF_LN_TWO_PI: f64 = 0.918_938_533_204_672_7;

/// The parameters of a VHGP, decoded from their vector.
#[derive(Clone, Debug, PartialEq)]
pub struct Parameters {
    /// λ (n).
    pub lambda: Vec<f64>,
    /// k_f.
    pub k_f: Ard,
    /// k_g.
    pub k_g: Ard,
    /// μ₀.
    pub mu_0: f64,
}

impl Parameters {
    /// Decodes [log λ (n), log k_f (1 + D), log k_g (1 + D), μ₀].
    pub fn decode(theta: &[f64], n: usize, dimensions: usize) -> Self {
        let g = n + 1 + dimensions;
        Self {
            lambda: theta[..n].iter().map(|l| exp(*l)).collect(),
            k_f: Ard::from_log(&theta[n..g]),
            k_g: Ard::from_log(&theta[g..g + 1 + dimensions]),
            mu_0: theta[g + 1 + dimensions],
        }
    }
}

/// The bound for one set of samples, with all its intermediate matrices: one evaluation allocates next to nothing.
#[derive(Clone, Debug)]
pub struct Elbo {
    /// Samples' responses (n).
    pub y: Vec<f64>,
    /// Added to the diagonals of K_f and K_g.
    pub jitter: f64,
    /// Squared differences of the samples, one (n, n) per coordinate.
    pub squares: Vec<Square>,
    /// The parameters last evaluated.
    pub parameters: Parameters,
    /// K_f, K_g (n, n), with jitter.
    pub k_f: Square,
    /// K_g (n, n), with jitter.
    pub k_g: Square,
    /// C (n, n), the factor of I + (s sᵀ) ∘ K_g.
    pub c: Square,
    /// VᵀV = (I + (s sᵀ) ∘ K_g)⁻¹ (n, n).
    pub vtv: Square,
    /// Σ (n, n).
    pub sigma_g: Square,
    /// L (n, n), the factor of K_f + R.
    pub l: Square,
    /// B = (K_f + R)⁻¹ (n, n).
    pub b: Square,
    /// Scratch (n, n).
    pub scratch: [Square; 2],
    /// s = √λ (n).
    pub s: Vec<f64>,
    /// β_g = λ - ½ (n).
    pub beta_g: Vec<f64>,
    /// μ (n).
    pub mu: Vec<f64>,
    /// R (n).
    pub r_noise: Vec<f64>,
    /// α_f = (K_f + R)⁻¹ y (n).
    pub alpha_f: Vec<f64>,
    /// b̂ = -½(R ∘ diag B - R ∘ α_f²) (n).
    pub b_hat: Vec<f64>,
    /// KL(N(μ, Σ) ‖ N(μ₀1, K_g)).
    pub kl: f64,
}

impl Elbo {
    /// The bound for samples `x` (n) with responses `y` (n).
    pub fn new<const D: usize>(x: &[[f64; D]], y: &[f64], jitter: f64) -> Self {
        let n = x.len();
        let square = Square::zeros(n);
        let zeros = vec![0.0; n];
        Self {
            y: y.to_vec(),
            jitter,
            squares: squared_differences(x),
            parameters: Parameters {
                lambda: vec![0.5; n],
                k_f: Ard::from_log(&[0.0; 1]),
                k_g: Ard::from_log(&[0.0; 1]),
                mu_0: 0.0,
            },
            k_f: square.clone(),
            k_g: square.clone(),
            c: square.clone(),
            vtv: square.clone(),
            sigma_g: square.clone(),
            l: square.clone(),
            b: square.clone(),
            scratch: [square.clone(), square],
            s: zeros.clone(),
            beta_g: zeros.clone(),
            mu: zeros.clone(),
            r_noise: zeros.clone(),
            alpha_f: zeros.clone(),
            b_hat: zeros,
            kl: 0.0,
        }
    }

    /// F at `theta`, and ∂F/∂theta; `None` if a matrix is not positive definite there.
    pub fn evaluate(&mut self, theta: &[f64], derivatives: &mut [f64]) -> Option<f64> {
        dispatch(Evaluate {
            elbo: self,
            theta,
            derivatives,
        })
    }

    /// Steps 1 to 5 of the bound, without derivatives.
    #[inline(always)]
    fn value(&mut self, theta: &[f64]) -> Option<f64> {
        let n = self.y.len();
        self.parameters = Parameters::decode(theta, n, self.squares.len());
        covariance(&self.parameters.k_f, &self.squares, self.jitter, &mut self.k_f);
        covariance(&self.parameters.k_g, &self.squares, self.jitter, &mut self.k_g);
        self.variational_posterior()?;
        let log_likelihood = self.likelihood()?;
        let mut trace = 0.0;
        for i in 0..n {
            trace += self.sigma_g.at(i, i);
        }
        let f = log_likelihood - 0.25 * trace - self.kl;
        f.is_finite().then_some(f)
    }

    /// (V1) in its stable form, and the KL divergence.
    #[inline(always)]
    fn variational_posterior(&mut self) -> Option<()> {
        let n = self.y.len();
        for i in 0..n {
            self.s[i] = self.parameters.lambda[i].sqrt();
            self.beta_g[i] = self.parameters.lambda[i] - 0.5;
        }
        for j in 0..n {
            let (c, s) = (self.c.column_mut(j), self.s[j]);
            for ((c, k), other) in c.iter_mut().zip(self.k_g.column(j)).zip(&self.s) {
                *c = other * (k * s);
            }
            c[j] += 1.0;
        }
        if !factor(&mut self.c) {
            return None;
        }
        inverse_transposed(&self.c, &mut self.scratch[0]);
        symmetric_inverse(&self.scratch[0], &mut self.vtv);
        for j in 0..n {
            let (vtv, sigma, s) = (self.vtv.column(j), self.sigma_g.column_mut(j), self.s[j]);
            for ((sigma, v), other) in sigma.iter_mut().zip(vtv).zip(&self.s) {
                *sigma = -v / (other * s);
            }
            sigma[j] = (1.0 - vtv[j]) / self.parameters.lambda[j];
        }
        self.mean_and_divergence();
        Some(())
    }

    /// μ, R and KL = ½ β_gᵀ(μ - μ₀) - Σ log V_ii + ½‖V‖_F² - n/2.
    #[inline(always)]
    fn mean_and_divergence(&mut self) {
        let n = self.y.len();
        self.mu.fill(self.parameters.mu_0);
        for j in 0..n {
            let beta = self.beta_g[j];
            for (mu, k) in self.mu.iter_mut().zip(self.k_g.column(j)) {
                *mu += beta * k;
            }
        }
        let (mut quadratic, mut trace) = (0.0, 0.0);
        for i in 0..n {
            quadratic += self.beta_g[i] * (self.mu[i] - self.parameters.mu_0);
            // ‖V‖_F² = tr(VᵀV).
            trace += self.vtv.at(i, i);
            self.r_noise[i] = exp(clamped(self.mu[i] - 0.5 * self.sigma_g.at(i, i)));
        }
        self.kl = 0.5 * (quadratic + trace - n as f64) + log_diagonal(&self.c);
    }

    /// log N(y | 0, K_f + R), with L, α_f, B and b̂.
    #[inline(always)]
    fn likelihood(&mut self) -> Option<f64> {
        let n = self.y.len();
        self.l.values.copy_from_slice(&self.k_f.values);
        for i in 0..n {
            self.l.values[i + i * self.k_f.stride] += self.r_noise[i];
        }
        if !factor(&mut self.l) {
            return None;
        }
        self.alpha_f.copy_from_slice(&self.y);
        solve(&self.l, &mut self.alpha_f);
        let mut quadratic = 0.0;
        for i in 0..n {
            quadratic += self.y[i] * self.alpha_f[i];
        }
        inverse_transposed(&self.l, &mut self.scratch[0]);
        symmetric_inverse(&self.scratch[0], &mut self.b);
        for i in 0..n {
            let alpha = self.alpha_f[i];
            self.b_hat[i] = -0.5 * self.r_noise[i] * (self.b.at(i, i) - alpha * alpha);
        }
        Some(-0.5 * quadratic - log_diagonal(&self.l) - n as f64 * HALF_LN_TWO_PI)
    }
}

struct Evaluate<'a> {
    elbo: &'a mut Elbo,
    theta: &'a [f64],
    derivatives: &'a mut [f64],
}

impl Kernel for Evaluate<'_> {
    type Output = Option<f64>;
    #[inline(always)]
    fn run(self) -> Option<f64> {
        let f = self.elbo.value(self.theta)?;
        gradient(self.elbo, self.derivatives);
        Some(f)
    }
}

fn clamped(exponent: f64) -> f64 {
    let exponent = if exponent > LARGEST_EXPONENT {
        LARGEST_EXPONENT
    } else {
        exponent
    };
    if exponent < -LARGEST_EXPONENT {
        -LARGEST_EXPONENT
    } else {
        exponent
    }
}
