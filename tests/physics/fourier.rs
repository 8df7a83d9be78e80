//! Transforms against direct sums, and against rustfft without our number type.
#![expect(clippy::disallowed_methods, reason = "the oracles are the platform's own functions")]

use encounter::numerics::fourier::{Lanes, Synthesis, Transform, WIDTH, turn};
use encounter::numerics::random::uniform;
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

#[test]
fn lanes_do_not_meet() {
    let mut spectrum = noise(100, 1);
    let mut whole = vec![[0.0; WIDTH]; 1024];
    Synthesis::new(100, 1024).real_series(&spectrum, &mut whole);
    for c in &mut spectrum {
        for i in 1..WIDTH {
            c.re.0[i] = 0.0;
            c.im.0[i] = 0.0;
        }
    }
    let mut alone = vec![[1.0; WIDTH]; 1024];
    Synthesis::new(100, 1024).real_series(&spectrum, &mut alone);
    for (w, a) in whole.iter().zip(&alone) {
        assert_eq!(w[0].to_bits(), a[0].to_bits());
        assert!(a[1..].iter().all(|x| *x == 0.0));
    }
    assert!(!Complex::<Lanes>::is_zero(&spectrum[0]));
}
