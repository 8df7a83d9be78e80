//! What each trap would do to the bits: the trap is set, the same numbers are made with it and without, and the ids of the
//! two artifacts are compared. `clippy.toml` and `tests/architecture/outside.rs` keep the traps out of the program.
//!
//! Not set here, because the crates may not even be in the tree: run-time kernels of FFT planners and of matrixmultiply.
#![expect(clippy::disallowed_methods, reason = "here the traps are set on purpose")]

use encounter::engine::codec;
use encounter::engine::id::Id;
use encounter::numerics::elementary;
use encounter::numerics::fourier::{Lanes, Transform, WIDTH};
use encounter::numerics::random::uniform;
use encounter::numerics::rk4;
use encounter::numerics::sums::sum;
use num_complex::Complex;
use rand_chacha::ChaCha12Rng;
use rand_chacha::rand_core::SeedableRng;
use rand_distr::{Distribution, LogNormal, StandardNormal};
use rustfft::{FftDirection, FftPlannerScalar};
use serde::Serialize;
use std::collections::{BTreeMap, HashMap};

const POINTS: usize = 20_000;

fn uniforms(n: usize) -> Vec<f64> {
    let mut stream = ChaCha12Rng::seed_from_u64(2022);
    (0..n).map(|_| uniform(&mut stream)).collect()
}

/// The id under which the engine would store a value.
fn id<T: Serialize>(value: &T) -> Id {
    Id::of(1, 1, &codec::encode(value).expect("plain values can be encoded"))
}

/// The ids differ with the trap; without it, they are the same twice.
#[track_caller]
fn assert_changes<T: Serialize>(without: impl Fn() -> T, with: impl Fn() -> T) {
    let kept = id(&without());
    assert_eq!(kept, id(&without()), "without the trap, the same twice");
    assert_ne!(kept, id(&with()), "the trap changes nothing here");
}

#[test]
fn the_platform_s_functions_change_the_ids() {
    type Function = fn(f64) -> f64;
    let pairs: [(&str, Function, Function); 5] = [
        ("sin", elementary::sin, f64::sin),
        ("cos", elementary::cos, f64::cos),
        ("exp", elementary::exp, f64::exp),
        ("log10", |x| elementary::log10(x + 20.5), |x| f64::log10(x + 20.5)),
        ("pow", |x| elementary::pow(x + 20.5, 1.7), |x| f64::powf(x + 20.5, 1.7)),
    ];
    let points: Vec<f64> = uniforms(POINTS).into_iter().map(|u| 40.0 * u - 20.0).collect();
    let changed: Vec<&str> = pairs
        .into_iter()
        .filter(|(_, ours, theirs)| {
            let values = |f: &Function| points.iter().map(|x| f(*x)).collect::<Vec<f64>>();
            id(&values(ours)) != id(&values(theirs))
        })
        .map(|(name, ..)| name)
        .collect();
    // Which of them differ is up to the platform: that is the trap.
    assert!(
        !changed.is_empty(),
        "this platform's mathematics rounds correctly everywhere"
    );
}

#[test]
fn a_fused_multiplication_changes_the_ids() {
    let roll = |acceleration: fn(f64, f64, f64) -> f64| {
        let (mut theta, mut theta_dot) = ([0.3], [0.0]);
        let lane = |theta: [f64; 1], theta_dot: [f64; 1], eta: [f64; 1]| [acceleration(theta[0], theta_dot[0], eta[0])];
        for eta in uniforms(1000) {
            (theta, theta_dot) = rk4::step(lane, 0.1, theta, theta_dot, [[eta]; 3]);
        }
        (theta, theta_dot)
    };
    assert_changes(
        || roll(|theta, theta_dot, eta| -0.1 * theta_dot - theta + 0.2 * eta),
        || roll(|theta, theta_dot, eta| (-0.1_f64).mul_add(theta_dot, 0.2_f64.mul_add(eta, -theta))),
    );
}

#[test]
fn twiddles_of_the_platform_change_the_ids() {
    let transform_of_all = |transform: fn(&mut Vec<Complex<f64>>)| {
        [512, 1024, 2048, 4096, 32_768].map(|n| {
            let mut series: Vec<Complex<f64>> = uniforms(n).into_iter().map(|u| Complex::new(u, 0.0)).collect();
            transform(&mut series);
            series.into_iter().map(|z| (z.re, z.im)).collect::<Vec<_>>()
        })
    };
    assert_changes(
        || {
            transform_of_all(|series| {
                let lanes = |x: f64| Lanes([x; WIDTH]);
                let wide = series.iter().map(|z| Complex {
                    re: lanes(z.re),
                    im: lanes(z.im),
                });
                let mut wide: Vec<_> = wide.collect();
                Transform::inverse(wide.len()).process(&mut wide, &mut Vec::new());
                *series = wide.iter().map(|z| Complex::new(z.re.0[0], z.im.0[0])).collect();
            })
        },
        || {
            transform_of_all(|series| {
                let plan = FftPlannerScalar::new().plan_fft(series.len(), FftDirection::Inverse);
                plan.process(series);
            })
        },
    );
}

#[test]
fn a_sum_split_by_threads_changes_the_ids() {
    let numbers = uniforms(POINTS);
    let split = |threads: usize| {
        let parts = numbers.chunks(numbers.len().div_ceil(threads));
        parts.map(|part| part.iter().sum::<f64>()).sum::<f64>()
    };
    assert_changes(|| sum(&numbers), || split(7));
    assert_ne!(id(&split(1)), id(&split(7)), "two thread counts, two sums");
}

#[test]
fn the_order_of_a_hash_map_changes_the_ids() {
    let entries = || (0..1000_u64).map(|k| (k, k * k));
    let kept = [(); 2].map(|()| id(&entries().collect::<BTreeMap<_, _>>()));
    assert_eq!(kept[0], kept[1]);
    let of_two_runs = [(); 2].map(|()| id(&entries().collect::<HashMap<_, _>>()));
    assert_ne!(
        of_two_runs[0], of_two_runs[1],
        "two maps of the same entries, two orders"
    );
}

#[test]
fn the_tails_of_rand_distr_change_the_ids() {
    let draws = |draw: fn(&mut ChaCha12Rng) -> f64| {
        let mut stream = ChaCha12Rng::seed_from_u64(2022);
        (0..POINTS).map(|_| draw(&mut stream)).collect::<Vec<f64>>()
    };
    assert_changes(
        || draws(|stream| elementary::exp(StandardNormal.sample(stream))),
        || draws(|stream| LogNormal::new(0.0, 1.0).expect("a deviation of 1").sample(stream)),
    );
}

#[test]
fn a_nan_has_the_sign_of_its_cpu() {
    let zero = std::hint::black_box(0.0_f64);
    let is_negative = (zero / zero).is_sign_negative();
    assert_eq!(
        is_negative,
        cfg!(target_arch = "x86_64"),
        "so none may be in an artifact"
    );
}
