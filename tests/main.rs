//! One test binary: every test is a claim.

mod physics;
mod plots;
