//! `truth.c`, compiled by this machine's gcc: the roll, the whole truth and the flop peak as C has them.

use std::path::{Path, PathBuf};
use std::process::Command;

/// The compiled program; none without gcc.
fn program() -> Option<PathBuf> {
    let program = Path::new(env!("CARGO_TARGET_TMPDIR")).join("bench-truth-c");
    let built = Command::new("gcc")
        .args([
            "-O3",
            "-march=native",
            "-mprefer-vector-width=512",
            "-fopenmp-simd",
            "-ffp-contract=off",
            "-o",
        ])
        .arg(&program)
        .arg(concat!(env!("CARGO_MANIFEST_DIR"), "/tests/bench/truth.c"))
        .arg("-lm")
        .status();
    built.is_ok_and(|status| status.success()).then_some(program)
}

/// What the program prints.
fn output(program: &Path, arguments: &[&str]) -> String {
    let said = Command::new(program).args(arguments).output();
    String::from_utf8_lossy(&said.expect("a program just built").stdout).into_owned()
}

/// The most multiplications and additions of one core, without FMA, GFlop/s.
pub(crate) fn peak() -> Option<f64> {
    output(&program()?, &[]).trim().parse().ok()
}

/// What a lane-step takes in C at best, timed by the program itself: `rk4` or `truth`, ns.
pub(crate) fn lane_step(what: &str) -> Option<f64> {
    output(&program()?, &[what]).trim().parse().ok()
}
