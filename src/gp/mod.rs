//! §4 Gaussian processes: the variational heteroscedastic one (VHGP) and the standard one it is compared with.
//!
//! M. Lazaro-Gredilla & M. K. Titsias, *Variational heteroscedastic Gaussian process regression*, ICML 2011.
//! Model: y = f(x) + e, f ~ GP(0, k_f), e ~ N(0, exp(g(x))), g ~ GP(mu_0, k_g).
//!
//! | paper | code | shape | meaning |
//! |---|---|---|---|
//! | k_f, k_g | `Ard` | | squared exponential kernels with one length per coordinate |
//! | λ, Λ | `lambda` | (n) | variational parameters |
//! | μ, Σ | `mu`, `sigma_g` | (n), (n, n) | variational mean and covariance of g at the samples |
//! | R | `r_noise` | (n) | effective noise variance exp(μ - Σ_ii/2) |
//! | F | `elbo` | | marginalised variational bound |
//! | β_g, α_f | `beta_g`, `alpha_f` | (n) | weights of g and of f |
//!
//! Tested against a published vector, finite differences and known functions in `tests/physics/gp.rs`.

pub mod elbo;
pub mod elbo_gradient;
pub mod fit;
pub mod grid;
pub mod kernel;
pub mod left_out;
pub mod standard;
pub mod vhgp;
