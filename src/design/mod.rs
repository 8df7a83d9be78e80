//! §4 Sequential design on a heteroscedastic Gaussian process (VHGP-Seq), and random sampling beside it.
//!
//! X. Gong & Y. Pan, *Sequential Bayesian experimental design for estimation of extreme-event probability in stochastic
//! input-to-response systems*, CMAME 2022. The method knows no ship: it sees a box, a density on candidate points, a
//! fixed Monte-Carlo set and a response that may move its point.
//!
//! | paper | code | meaning |
//! |---|---|---|
//! | x | `[f64; 2]` | input; here (L/T_p, A/H_s) |
//! | p(x) | `density` | density of the input |
//! | θ_t | `threshold` | response that counts as extreme when exceeded |
//! | Q(f, g) | `exceedance` | 1 - Φ((θ_t - f)/e^{g/2}) |
//! | P_est | `estimate` | estimated exceedance probability |
//!
//! Tested on the published 1-D reference case and on pools of points in `tests/physics/design.rs`.

pub mod acquisition;
pub mod convergence;
pub mod estimate;
pub mod floor;
pub mod input_density;
pub mod look_ahead;
pub mod pool;
pub mod quadrature;
pub mod response_pool;
pub mod response_scale;
pub mod sequence;
pub mod sequential;
pub mod settings;
pub mod targeted;
