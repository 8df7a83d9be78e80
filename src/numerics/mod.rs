//! Mathematics without a ship in it.

pub mod cholesky;
pub mod domain;
pub mod elementary;
pub mod lanes;
pub mod latin_hypercube;
pub mod lbfgs_memory;
pub mod lbfgsb;
pub mod normal;
pub mod random;
pub mod square;
pub mod sums;
