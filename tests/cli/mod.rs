//! The contract of the command line (house.md, section 5), on the real binary.

mod refusals;
mod verbs;
