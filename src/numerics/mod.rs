//! Mathematics without a ship in it.

pub mod domain;
pub mod elementary;
pub mod hermite;
pub mod lanes;
pub mod random;
pub mod rk4;
pub mod sums;
