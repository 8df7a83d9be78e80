//! Mathematics without a ship in it.

pub mod cholesky;
pub mod density;
pub mod domain;
pub mod elementary;
pub mod fourier;
pub mod hermite;
pub mod invariant;
pub mod lanes;
pub mod latin_hypercube;
pub mod lbfgs_memory;
pub mod lbfgsb;
pub mod normal;
pub mod optimal_design;
pub mod paired;
pub mod random;
pub mod rk4;
pub mod rows;
pub mod self_test;
pub mod square;
pub mod sums;
