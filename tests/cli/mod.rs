//! The contract of the command line, on the real binary.

mod diff;
mod doctor;
mod exits;
mod figures;
mod graph;
mod locks;
mod ranges;
mod refusals;
mod resolution;
mod robust;
mod threads;
mod timing;
pub(crate) mod verbs;
mod verify;
mod why;
