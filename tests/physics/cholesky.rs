//! Claims about dense algebra in tiles: nalgebra is the oracle, the bits are the same at every level.

use encounter::numerics::cholesky::{Factor, Inverse, forward, log_diagonal, solve, symmetric_inverse};
use encounter::numerics::elementary::{cos, sin};
use encounter::numerics::lanes::{Level, dispatch, dispatch_at};
use encounter::numerics::random::uniform;
use encounter::numerics::square::Square;
use nalgebra::DMatrix;
use rand_chacha::ChaCha12Rng;
use rand_chacha::rand_core::SeedableRng;

const SIZES: [usize; 6] = [1, 7, 8, 13, 64, 120];

/// G Gᵀ + n·1e-2 I of a random G: condition number about 1e3.
fn positive(n: usize) -> DMatrix<f64> {
    let mut stream = ChaCha12Rng::seed_from_u64(n as u64);
    let g = DMatrix::from_fn(n, n, |_, _| uniform(&mut stream) - 0.5);
    &g * g.transpose() + DMatrix::identity(n, n) * (0.01 * n as f64)
}

fn square(a: &DMatrix<f64>) -> Square {
    Square::from_fn(a.nrows(), |i, j| a[(i, j)])
}

/// L; none if the matrix is not positive definite.
fn factored(a: &Square) -> Option<Square> {
    let mut l = a.clone();
    dispatch(Factor { a: &mut l }).then_some(l)
}

fn close(found: &Square, expected: &DMatrix<f64>, tolerance: f64) {
    let scale = expected.amax();
    for j in 0..found.n {
        for i in 0..found.n {
            let error = (found.at(i, j) - expected[(i, j)]).abs() / scale;
            assert!(error < tolerance, "n = {}: ({i}, {j}) off by {error}", found.n);
        }
    }
}

#[test]
fn the_factor_is_nalgebra_s() {
    for n in SIZES {
        let a = positive(n);
        let l = factored(&square(&a)).expect("positive definite");
        close(&l, &a.cholesky().expect("positive definite").l(), 1e-14);
    }
}

#[test]
fn solves_inverses_and_the_log_determinant_are_nalgebra_s() {
    for n in SIZES {
        let a = positive(n);
        let l = factored(&square(&a)).expect("positive definite");
        let oracle = a.clone().cholesky().expect("positive definite");
        let (mut t, mut inverse) = (Square::zeros(n), Square::zeros(n));
        dispatch(Inverse { l: &l, t: &mut t });
        close(&t, &oracle.l().try_inverse().expect("regular").transpose(), 1e-13);
        symmetric_inverse(&t, &mut inverse);
        close(&inverse, &oracle.inverse(), 1e-12);
        assert!((2.0 * log_diagonal(&l) - oracle.ln_determinant()).abs() < 1e-12 * n as f64);
        let b = DMatrix::from_fn(n, 1, |i, _| sin(i as f64));
        let mut x: Vec<f64> = b.iter().copied().collect();
        solve(&l, &mut x);
        let expected = oracle.solve(&b);
        for i in 0..n {
            assert!((x[i] - expected[i]).abs() <= 1e-12 * expected.amax());
        }
    }
}

#[test]
fn eight_right_hand_sides_are_solved_as_one_is() {
    for n in SIZES {
        let a = positive(n);
        let l = factored(&square(&a)).expect("positive definite");
        let mut rows = vec![0.0; 8 * l.stride];
        for k in 0..8 * n {
            rows[k] = cos(k as f64);
        }
        let before = DMatrix::from_column_slice(8, n, &rows[..8 * n]);
        forward(&l, &mut rows);
        let after = DMatrix::from_column_slice(8, n, &rows[..8 * n]);
        let l = DMatrix::from_fn(n, n, |i, j| l.at(i, j));
        assert!((&l * after.transpose() - before.transpose()).amax() < 1e-12);
        assert!(rows[8 * n..].iter().all(|v| *v == 0.0), "the padding stays zero");
    }
}

#[test]
fn only_the_lower_triangle_is_read() {
    let a = positive(13);
    let mut half = square(&a);
    for j in 0..13 {
        for i in 0..j {
            half.values[i + j * half.stride] = f64::NAN;
        }
    }
    assert_eq!(factored(&half), factored(&square(&a)));
}

#[test]
fn every_level_gives_the_same_bits() {
    for n in SIZES {
        let run = |level| {
            let mut l = square(&positive(n));
            assert!(dispatch_at(level, Factor { a: &mut l }));
            let mut t = Square::zeros(n);
            dispatch_at(level, Inverse { l: &l, t: &mut t });
            let bits = |s: &Square| s.values.iter().map(|v| v.to_bits()).collect::<Vec<_>>();
            (bits(&l), bits(&t))
        };
        let base = run(Level::Base);
        assert!(base == run(Level::Avx2) && base == run(Level::Avx512), "n = {n}");
    }
}

#[test]
fn an_indefinite_matrix_has_no_factor() {
    for n in SIZES {
        for bad in [-1e-9, f64::NAN, f64::INFINITY] {
            let mut a = square(&positive(n));
            let last = n - 1;
            a.values[last + last * a.stride] = bad;
            assert_eq!(factored(&a), None);
        }
    }
}
