//! Benchmarks: one file per question.

mod noop;

fn main() {
    divan::main();
}
