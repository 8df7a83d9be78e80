//! The contract of the command line (house.md, section 5), on the real binary.

mod diff;
mod exits;
mod graph;
mod ranges;
mod refusals;
pub(crate) mod verbs;
mod verify;
mod why;
