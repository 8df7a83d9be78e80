//! The contract of the command line (house.md, section 5), on the real binary.

mod exits;
mod ranges;
mod refusals;
mod verbs;
mod verify;
