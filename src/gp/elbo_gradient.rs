//! The analytic gradient of the bound F, from the matrices that its value left behind.
//!
//! ```text
//! b̂ = -½(R ∘ diag B - R ∘ α_f²);  λ̂ = b̂ + ½
//! ∂F/∂log λ = -λ ∘ [(K_g + ½ Σ∘Σ)(λ - λ̂)]
//! ∂F/∂φ_f = ½ Σ_ij (α_f α_fᵀ - B)_ij (∂K_f/∂φ_f)_ij
//! ∂F/∂φ_g = ½ Σ_ij W_ij (∂K_g/∂φ_g)_ij,  W = β_g β_gᵀ + 2(b̂ - β_g)β_gᵀ - Mᵀ diag(λ̂/λ - 1) M - UᵀU,  M = VᵀU
//! ∂F/∂μ₀ = Σ b̂
//! ```
//! Tested by finite differences and against the published vector in `tests/physics/gp.rs`.

use super::elbo::Elbo;
use super::kernel::weighted_derivatives;

/// Writes ∂F/∂[log λ (n), log k_f (1 + D), log k_g (1 + D), μ₀] at the parameters last evaluated.
#[inline(always)]
pub(super) fn gradient(elbo: &mut Elbo, out: &mut [f64]) {
    let (n, hypers) = (elbo.y.len(), 1 + elbo.squares.len());
    let (lambda, rest) = out.split_at_mut(n);
    let (f, rest) = rest.split_at_mut(hypers);
    let (g, mu_0) = rest.split_at_mut(hypers);
    by_log_lambda(elbo, lambda);
    by_kernel_f(elbo, f);
    by_kernel_g(elbo, g);
    let mut total = 0.0;
    for b in &elbo.b_hat {
        total += b;
    }
    mu_0[0] = total;
}

#[inline(always)]
fn by_log_lambda(elbo: &Elbo, out: &mut [f64]) {
    out.fill(0.0);
    for j in 0..elbo.y.len() {
        let difference = elbo.beta_g[j] - elbo.b_hat[j];
        for ((out, k), sigma) in out.iter_mut().zip(elbo.k_g.column(j)).zip(elbo.sigma_g.column(j)) {
            *out += difference * (k + 0.5 * (sigma * sigma));
        }
    }
    for (out, lambda) in out.iter_mut().zip(&elbo.parameters.lambda) {
        *out *= -lambda;
    }
}

#[inline(always)]
fn by_kernel_f(elbo: &mut Elbo, out: &mut [f64]) {
    let n = elbo.y.len();
    let weight = &mut elbo.scratch[0];
    for j in 0..n {
        let alpha = elbo.alpha_f[j];
        let column = weight.column_mut(j).iter_mut();
        for ((w, b), other) in column.zip(elbo.b.column(j)).zip(&elbo.alpha_f) {
            *w = 0.5 * (alpha * other - b);
        }
    }
    weighted_derivatives(&elbo.parameters.k_f, &elbo.squares, elbo.jitter, &elbo.k_f, weight, out);
}

#[inline(always)]
fn by_kernel_g(elbo: &mut Elbo, out: &mut [f64]) {
    let (n, stride) = (elbo.y.len(), elbo.k_g.stride);
    // M = VᵀV diag(s), so Mᵀ D M + UᵀU = diag(s) (VᵀV D VᵀV + VᵀV) diag(s).
    let [scaled, weight] = &mut elbo.scratch;
    for j in 0..n {
        let ratio = (elbo.b_hat[j] + 0.5) / elbo.parameters.lambda[j] - 1.0;
        let (vtv, column) = (elbo.vtv.column(j), scaled.column_mut(j));
        for (scaled, v) in column.iter_mut().zip(vtv) {
            *scaled = ratio * v;
        }
    }
    scaled.values[n * stride..].fill(0.0);
    weight.product(scaled, &elbo.vtv, true, |_, _| (0, stride));
    weight.mirror();
    for j in 0..n {
        let (beta, hat, s) = (elbo.beta_g[j], elbo.b_hat[j] - elbo.beta_g[j], elbo.s[j]);
        let (beta_i, hat_i, s_i) = (&elbo.beta_g[..n], &elbo.b_hat[..n], &elbo.s[..n]);
        let (vtv, column) = (&elbo.vtv.column(j)[..n], &mut weight.column_mut(j)[..n]);
        for i in 0..n {
            // 2(b̂ - β)βᵀ in its symmetric form: ∂K_g is symmetric.
            let outer = (beta + hat) * beta_i[i] + beta * (hat_i[i] - beta_i[i]);
            column[i] = 0.5 * (outer - s * s_i[i] * (column[i] + vtv[i]));
        }
    }
    weighted_derivatives(&elbo.parameters.k_g, &elbo.squares, elbo.jitter, &elbo.k_g, weight, out);
}
