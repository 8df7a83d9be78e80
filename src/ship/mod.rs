//! Roll of the ship: the equation, the truth along a record, single runs through wave groups, exceedance.

mod block;
mod columns;
pub mod continuous_roll;
pub mod encounter;
pub mod exceedance;
mod group_waves;
pub mod initial_condition;
pub mod linear_response;
pub mod resolution;
pub mod response;
pub mod roll_equation;
pub mod sample;
pub mod segments;
pub mod simulation;
pub mod temporal;
mod turn;
