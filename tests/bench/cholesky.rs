//! One Cholesky factor of 120 samples' covariance, the inner work of VHGP: how long, beside nalgebra's?

use divan::counter::ItemsCount;
use divan::{Bencher, black_box};
use encounter::numerics::cholesky::Factor;
use encounter::numerics::lanes::{Level, dispatch_at};
use encounter::numerics::square::Square;
use nalgebra::DMatrix;

const N: usize = 120;

/// Positive definite: ones off the diagonal, N on it.
fn element(i: usize, j: usize) -> f64 {
    if i == j { N as f64 } else { 1.0 }
}

/// Ours, the copy of the matrix included.
#[divan::bench(args = ["base", "avx2", "avx512"])]
fn ours(bencher: Bencher, name: &str) {
    let Ok(level) = Level::choose(Some(name)) else { return };
    let matrix = Square::from_fn(N, element);
    bencher.counter(ItemsCount::new(1_u32)).bench_local(|| {
        let mut a = black_box(&matrix).clone();
        assert!(dispatch_at(level, Factor { a: &mut a }), "positive definite");
        a
    });
}

/// nalgebra's, the copy of the matrix included.
#[divan::bench]
fn nalgebra(bencher: Bencher) {
    let matrix = DMatrix::from_fn(N, N, element);
    bencher
        .counter(ItemsCount::new(1_u32))
        .bench_local(|| black_box(&matrix).clone().cholesky().expect("positive definite"));
}
