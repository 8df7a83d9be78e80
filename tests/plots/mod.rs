//! Figures and tables drawn from formulas: what they hold, how large they are, and that equal input gives equal bytes.
//!
//! `ENCOUNTER_PLOTS=folder cargo test plots` also writes every figure there, to be looked at.

mod axes;
mod calibration;
mod csv;
mod density;
mod figures;
mod method_error;
mod samples;
mod svg;
mod table;
mod temporal;
