//! Benchmarks: one file per question.

mod vhgp;

fn main() {
    divan::main();
}
