//! Sums of a fixed shape: exact where they can be, close where they cannot, and the same shape for the same length.

use encounter::numerics::random::uniform;
use encounter::numerics::sums::{mean, standard_deviation, sum, variance};
use rand_chacha::ChaCha12Rng;
use rand_chacha::rand_core::SeedableRng;

/// The slow twin: Neumaier's compensated sum.
fn compensated(x: &[f64]) -> f64 {
    let (mut total, mut lost) = (0.0_f64, 0.0);
    for term in x {
        let next = total + term;
        lost += if total.abs() >= term.abs() {
            (total - next) + term
        } else {
            (term - next) + total
        };
        total = next;
    }
    total + lost
}

fn uniforms(n: usize) -> Vec<f64> {
    let mut stream = ChaCha12Rng::seed_from_u64(7);
    (0..n).map(|_| uniform(&mut stream)).collect()
}

#[test]
fn whole_numbers_add_up_exactly_at_every_length() {
    for n in 0..600_u32 {
        let x: Vec<f64> = (1..=n).map(f64::from).collect();
        assert_eq!(sum(&x), f64::from(n * (n + 1) / 2), "n = {n}");
    }
}

#[test]
fn the_sum_is_the_compensated_one_within_a_few_roundings() {
    for n in [17, 1000, 100_000] {
        let x = uniforms(n);
        let exact = compensated(&x);
        assert!((sum(&x) - exact).abs() <= 8.0 * f64::EPSILON * exact, "n = {n}");
    }
}

#[test]
fn the_moments_are_those_of_a_uniform_number() {
    let x = uniforms(100_000);
    assert!((mean(&x) - 0.5).abs() < 4.0 * (1.0 / 12.0_f64 / 100_000.0).sqrt());
    assert!((variance(&x) - 1.0 / 12.0).abs() < 1e-3);
    assert_eq!(standard_deviation(&x), variance(&x).sqrt());
    assert_eq!((sum(&[]), mean(&[])), (0.0, 0.0));
}
