//! Mathematics without a ship in it.

pub mod domain;
pub mod elementary;
pub mod lanes;
pub mod random;
pub mod sums;
