//! The cache: knows no wave and no ship; imports nothing of ours.

pub mod code;
