//! encounter: Gong & Pan's paper on ships encountering wave groups, from seeds to figures.

pub mod cli;
pub mod design;
pub mod engine;
pub mod gp;
pub mod numerics;
pub mod plot;
pub mod sea;
pub mod ship;
#[path = "../stages/mod.rs"]
pub mod stages;
