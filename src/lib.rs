//! encounter: Gong & Pan's paper on ships encountering wave groups, from seeds to figures.

pub mod cli;
pub mod engine;
pub mod design;
pub mod gp;
pub mod numerics;
pub mod sea;
pub mod ship;
#[path = "../stages/mod.rs"]
pub mod stages;
pub mod plot;
