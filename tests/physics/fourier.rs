//! Transforms against direct sums, and against rustfft without our number type.
#![expect(clippy::disallowed_methods, reason = "the oracles are the platform's own functions")]

use encounter::numerics::fourier::{Lanes, Synthesis, Transform, WIDTH, turn};
use encounter::numerics::lanes::Level;
use encounter::numerics::random::uniform;
use encounter::numerics::rows::Rows;
use num_complex::Complex;
use num_traits::{FromPrimitive, Zero};
use rand_chacha::ChaCha12Rng;
use rand_chacha::rand_core::SeedableRng;
use rustfft::{FftDirection, FftPlannerScalar};

fn noise(n: usize, seed: u64) -> Vec<Complex<Lanes>> {
    let mut rng = ChaCha12Rng::seed_from_u64(seed);
    let mut lanes = || Lanes([0.0; WIDTH].map(|_: f64| uniform(&mut rng) - 0.5));
    (0..n)
        .map(|_| Complex {
            re: lanes(),
            im: lanes(),
        })
        .collect()
}

fn lane(z: &Complex<Lanes>, i: usize) -> Complex<f64> {
    Complex::new(z.re.0[i], z.im.0[i])
}

#[test]
fn a_transform_is_the_direct_sum() {
    for n in [1, 2, 4, 8, 16, 32, 64, 128, 256] {
        for (transform, sign) in [(Transform::forward(n), -1.0), (Transform::inverse(n), 1.0)] {
            let x = noise(n, n as u64);
            let mut y = x.clone();
            transform.process(&mut y, &mut Vec::new());
            for (m, found) in y.iter().enumerate() {
                for i in 0..WIDTH {
                    let sum: Complex<f64> = (0..n).map(|j| lane(&x[j], i) * oracle_turn((j * m) % n, n, sign)).sum();
                    assert!((sum - lane(found, i)).norm() < 1e-13 * n as f64, "n = {n}, m = {m}");
                }
            }
        }
    }
}

fn oracle_turn(k: usize, n: usize, sign: f64) -> Complex<f64> {
    let (sin, cos) = (sign * std::f64::consts::TAU * k as f64 / n as f64).sin_cos();
    Complex::new(cos, sin)
}

#[test]
fn a_transform_is_that_of_rustfft_on_plain_numbers() {
    for n in [512, 1024, 2048, 4096, 32_768] {
        let x = noise(n, 3);
        let mut y = x.clone();
        Transform::inverse(n).process(&mut y, &mut Vec::new());
        for i in [0, 5] {
            let mut plain: Vec<_> = x.iter().map(|z| lane(z, i)).collect();
            FftPlannerScalar::new()
                .plan_fft(n, FftDirection::Inverse)
                .process(&mut plain);
            let size = (n as f64 / 6.0).sqrt();
            for (p, z) in plain.iter().zip(&y) {
                assert!((p - lane(z, i)).norm() < 1e-14 * size, "n = {n}");
            }
        }
    }
}

#[test]
fn a_turn_is_exact_on_the_octants_and_symmetric() {
    let n = 4096;
    for k in 0..n {
        let z = turn(k, n);
        assert!((z - oracle_turn(k, n, 1.0)).norm() < 1e-15);
        assert_eq!(turn(n - k, n), z.conj());
        assert_eq!(turn(k + n / 4, n), Complex::new(-z.im, z.re));
    }
    assert_eq!(turn(n / 8, n).re, turn(n / 8, n).im);
    assert_eq!(turn(n / 4, n), Complex::new(0.0, 1.0));
}

#[test]
fn a_twiddle_is_moved_to_the_table() {
    for k in [0, 1, 77, 512, 1000] {
        let exact = turn(k, 4096).re;
        let near = Lanes::from_f64(exact + 4e-16).expect("twiddles are numbers");
        assert_eq!(near, Lanes([exact; WIDTH]));
    }
}

#[test]
#[should_panic(expected = "no cosine of a power-of-two circle")]
fn a_foreign_constant_is_refused() {
    let _ = Lanes::from_f64(1.0 / 3.0);
}

#[test]
fn a_synthesis_is_the_direct_sum_of_modes() {
    for (modes, samples) in [(1, 8), (5, 16), (8, 16), (8, 64), (12, 128), (33, 512)] {
        let spectrum = noise(modes, samples as u64);
        let (mut eta, mut rho) = (vec![[0.0; WIDTH]; samples], vec![[0.0; WIDTH]; samples]);
        let mut synthesis = Synthesis::new(modes, samples);
        synthesis.real_series(&spectrum, &mut eta);
        synthesis.modulus(&spectrum, &mut rho);
        for j in 0..samples {
            for i in 0..WIDTH {
                let z: Complex<f64> = (1..=modes)
                    .map(|k| lane(&spectrum[k - 1], i) * oracle_turn((j * k) % samples, samples, 1.0))
                    .sum();
                assert!((z.re - eta[j][i]).abs() < 1e-13 && (z.norm() - rho[j][i]).abs() < 1e-13);
            }
        }
    }
}

/// One field's series by plain rustfft: a transform as long as the series, with the modes in its first bins.
fn oracle_series(spectrum: &[Complex<Lanes>], samples: usize, i: usize) -> Vec<Complex<f64>> {
    let mut series = vec![Complex::zero(); samples];
    for (k, c) in spectrum.iter().enumerate() {
        series[k + 1] = lane(c, i);
    }
    FftPlannerScalar::new()
        .plan_fft(samples, FftDirection::Inverse)
        .process(&mut series);
    series
}

#[test]
fn two_shifts_in_one_transform_are_the_series_of_rustfft() {
    for (modes, samples) in [(1024, 2048), (1000, 4096), (600, 8192), (1024, 32_768)] {
        let spectrum = noise(modes, 11);
        let mut eta = Rows::new(samples);
        Synthesis::new(modes, samples).real_series(&spectrum, &mut eta);
        let size = (modes as f64 / 12.0).sqrt();
        for i in 0..WIDTH {
            for (z, row) in oracle_series(&spectrum, samples, i).iter().zip(&*eta) {
                assert!((z.re - row[i]).abs() < 1e-14 * size, "{modes} modes, {samples} samples");
            }
        }
    }
}

#[test]
fn two_shifts_in_one_transform_are_the_sum_of_modes() {
    let (modes, samples) = (1024, 32_768);
    let spectrum = noise(modes, 12);
    let mut eta = Rows::new(samples);
    Synthesis::new(modes, samples).real_series(&spectrum, &mut eta);
    for j in [0, 1, 15, 16, 17, 31, 32, 1023, 1024, 20_011, 32_767] {
        let z: Complex<f64> = (1..=modes)
            .map(|k| lane(&spectrum[k - 1], 3) * oracle_turn((j * k) % samples, samples, 1.0))
            .sum();
        assert!((z.re - eta[j][3]).abs() < 1e-12, "sample {j}");
    }
}

#[test]
fn a_series_has_the_same_bits_at_every_level() {
    let spectrum = noise(1024, 13);
    let series = [Level::Base, Level::Avx2, Level::Avx512].map(|level| {
        let mut eta = Rows::new(8192);
        let mut synthesis = Synthesis::new(1024, 8192);
        synthesis.level = level;
        synthesis.real_series(&spectrum, &mut eta);
        eta.as_flattened().iter().map(|x| x.to_bits()).collect::<Vec<_>>()
    });
    assert!(series[0] == series[1] && series[0] == series[2]);
}

#[test]
fn a_row_has_a_cache_line_of_its_own() {
    for length in [0, 1, 7, 1000] {
        let rows = Rows::new(length);
        assert_eq!(rows.len(), length);
        assert!(length == 0 || rows.as_ptr().addr().is_multiple_of(64));
    }
}

#[test]
fn lanes_do_not_meet() {
    for (modes, samples) in [(100, 1024), (1024, 4096)] {
        lanes_do_not_meet_in(modes, samples);
    }
}

fn lanes_do_not_meet_in(modes: usize, samples: usize) {
    let mut spectrum = noise(modes, 1);
    let mut whole = vec![[0.0; WIDTH]; samples];
    Synthesis::new(modes, samples).real_series(&spectrum, &mut whole);
    for c in &mut spectrum {
        for i in 1..WIDTH {
            c.re.0[i] = 0.0;
            c.im.0[i] = 0.0;
        }
    }
    let mut alone = vec![[1.0; WIDTH]; samples];
    Synthesis::new(modes, samples).real_series(&spectrum, &mut alone);
    for (w, a) in whole.iter().zip(&alone) {
        assert_eq!(w[0].to_bits(), a[0].to_bits());
        assert!(a[1..].iter().all(|x| *x == 0.0));
    }
    assert!(!Complex::<Lanes>::is_zero(&spectrum[0]));
}
