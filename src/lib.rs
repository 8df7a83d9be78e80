//! encounter: Gong & Pan's paper on ships encountering wave groups, from seeds to figures.

pub mod engine;
pub mod numerics;
