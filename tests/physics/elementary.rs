//! The door to transcendental functions: identities, the errors that the lane functions promise, the same bits everywhere.

use encounter::numerics::elementary::{cos, erf, erfc, exp, exp_lanes, ln, log10, pow, sin, sin_cos, sin_cos_lanes};
use encounter::numerics::lanes::{Kernel, Level, dispatch_at};
use encounter::numerics::random::uniform;
use rand_chacha::ChaCha12Rng;
use rand_chacha::rand_core::SeedableRng;

const LEVELS: [Level; 3] = [Level::Base, Level::Avx2, Level::Avx512];

/// Uniform points in (-reach, reach).
fn points(reach: f64) -> Vec<f64> {
    let mut stream = ChaCha12Rng::seed_from_u64(1);
    (0..24_000)
        .map(|_| reach * (2.0 * uniform(&mut stream) - 1.0))
        .collect()
}

/// The distance of two numbers of one sign, in units of the last place.
fn apart(a: f64, b: f64) -> u64 {
    a.to_bits().abs_diff(b.to_bits())
}

#[test]
fn the_functions_keep_their_identities() {
    for x in points(30.0) {
        let (s, c) = sin_cos(x);
        assert_eq!((s, c), (sin(x), cos(x)));
        assert!((s * s + c * c - 1.0).abs() < 1e-15);
        assert_eq!((sin(-x), cos(-x)), (-s, c));
        assert!((exp(x) * exp(-x) - 1.0).abs() < 1e-15);
        assert!((ln(exp(x)) - x).abs() < 1e-14 * (1.0 + x.abs()));
        assert!((erf(x) + erfc(x) - 1.0).abs() < 1e-15);
        assert!((pow(10.0, x) / exp(x * ln(10.0)) - 1.0).abs() < 1e-13);
    }
    for k in -20..20 {
        assert_eq!(log10(pow(10.0, f64::from(k))), f64::from(k));
    }
}

#[test]
fn the_exponential_of_a_lane_is_within_one_unit_of_the_last_place() {
    for x in points(700.0) {
        assert!(apart(exp_lanes([x])[0], exp(x)) <= 1, "x = {x}");
    }
    assert_eq!(
        exp_lanes([0.0, -708.5, -1e300, 1e300]),
        [1.0, 0.0, 0.0, exp_lanes([709.0])[0]]
    );
}

#[test]
fn sine_and_cosine_of_a_lane_are_within_what_they_promise() {
    for x in points(50.0) {
        let ([s], [c]) = sin_cos_lanes([x]);
        assert!((s - sin(x)).abs() < 2.3e-16 && (c - cos(x)).abs() < 2.3e-16, "x = {x}");
    }
}

struct Wide<'a>(&'a [f64]);

impl Kernel for Wide<'_> {
    type Output = Vec<u64>;

    #[inline(always)]
    fn run(self) -> Vec<u64> {
        let (blocks, _) = self.0.as_chunks::<24>();
        let results = blocks.iter().flat_map(|block| {
            let (s, c) = sin_cos_lanes(*block);
            [exp_lanes(*block), s, c]
        });
        results.flatten().map(f64::to_bits).collect()
    }
}

#[test]
fn lanes_have_the_same_bits_at_every_level_and_width() {
    let points = points(40.0);
    let narrow: Vec<u64> = points
        .chunks(24)
        .flat_map(|block| {
            let alone = |f: fn(f64) -> f64| block.iter().map(move |x| f(*x).to_bits()).collect::<Vec<_>>();
            let functions: [fn(f64) -> f64; 3] = [
                |x| exp_lanes([x])[0],
                |x| sin_cos_lanes([x]).0[0],
                |x| sin_cos_lanes([x]).1[0],
            ];
            functions.into_iter().flat_map(alone).collect::<Vec<_>>()
        })
        .collect();
    for level in LEVELS {
        assert!(dispatch_at(level, Wide(&points)) == narrow, "{level:?}");
    }
}
