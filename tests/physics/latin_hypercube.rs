//! Claims about Latin hypercubes: one point per stratum, inside the box, reproducible.

use encounter::numerics::latin_hypercube::latin_hypercube;
use rand_chacha::ChaCha12Rng;
use rand_chacha::rand_core::SeedableRng;

fn design(n: usize, seed: u64) -> Vec<[f64; 2]> {
    latin_hypercube(n, [0.4, 0.05], [6.0, 1.1], &mut ChaCha12Rng::seed_from_u64(seed))
}

#[test]
fn every_stratum_of_every_coordinate_holds_one_point() {
    for n in [1, 2, 30, 41] {
        let points = design(n, 5);
        for (d, (low, high)) in [(0.4, 6.0), (0.05, 1.1)].into_iter().enumerate() {
            let mut strata: Vec<usize> = points
                .iter()
                .map(|x| ((x[d] - low) / (high - low) * n as f64) as usize)
                .collect();
            strata.sort_unstable();
            assert_eq!(strata, (0..n).collect::<Vec<_>>());
        }
    }
}

#[test]
fn a_seed_is_a_design() {
    assert_eq!(design(30, 1), design(30, 1));
    assert_ne!(design(30, 1), design(30, 2));
}

#[test]
fn coordinates_are_paired_without_correlation() {
    let mut total = 0.0;
    for seed in 0..200 {
        for x in design(30, seed) {
            total += (x[0] - 3.2) / 5.6 * (x[1] - 0.575) / 1.05 / (200.0 * 30.0);
        }
    }
    // Standard deviation of the mean product of 6000 independent pairs: (1/12)/√6000 = 0.0011.
    assert!(total.abs() < 0.004, "{total}");
}
