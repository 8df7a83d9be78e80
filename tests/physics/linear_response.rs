//! Claims about the linear oscillator beside the ship: its transfer function, its balance, the maximum about a group.

use encounter::numerics::elementary::{cos, sin};
use encounter::numerics::fourier::{Lanes, Synthesis, WIDTH};
use encounter::ship::linear_response::{Oscillator, geometric_means, largest_about};
use encounter::ship::roll_equation::{Damping, RollEquation, Ship};
use num_complex::Complex;

fn ship(damping: Damping) -> Ship {
    Ship {
        alpha_1: 0.01,
        alpha_2: if damping == Damping::Cubic { 0.4 } else { 0.1 },
        damping,
        beta_1: 0.13,
        beta_2: -0.06,
        epsilon_1: vec![0.0],
        epsilon_2: 0.0043,
    }
}

/// The largest |θ| of the last of 300 periods in a regular wave of amplitude `a` and frequency `omega`, at rest before.
fn regular(ship: &Ship, a: f64, omega: f64) -> f64 {
    let steps = 200;
    let h = std::f64::consts::TAU / omega / f64::from(steps);
    let acceleration = |x: f64, v: f64, t: f64| {
        let eta = [a * cos(omega * t)];
        match ship.damping {
            Damping::Cubic => {
                let equation = RollEquation::<1, true>::new(ship, [0.0]);
                equation.acceleration([x], [v], equation.forcing(eta))[0]
            }
            Damping::Quadratic => {
                let equation = RollEquation::<1, false>::new(ship, [0.0]);
                equation.acceleration([x], [v], equation.forcing(eta))[0]
            }
        }
    };
    let (mut x, mut v, mut largest) = (0.0, 0.0, 0.0_f64);
    for i in 0..300 * steps {
        // Heun's method: the error of an amplitude is about (2 pi/200)^2.
        let t = f64::from(i) * h;
        let (dx, dv) = (v, acceleration(x, v, t));
        let (ex, ev) = (v + h * dv, acceleration(x + h * dx, v + h * dv, t + h));
        x += 0.5 * h * (dx + ex);
        v += 0.5 * h * (dv + ev);
        if i >= 299 * steps {
            largest = largest.max(x.abs());
        }
    }
    largest
}

#[test]
fn balanced_at_its_own_amplitude_the_oscillator_rolls_as_the_ship_does_in_regular_waves() {
    for damping in [Damping::Cubic, Damping::Quadratic] {
        for (a, omega) in [(0.5, 0.419), (3.0, 0.419), (6.0, 0.419), (4.0, 0.5)] {
            let ship = ship(damping);
            let theta_a = regular(&ship, a, omega);
            let h = Oscillator::balanced(&ship, theta_a, omega).transfer(omega);
            let expected = a * (h.re * h.re + h.im * h.im).sqrt();
            assert!(
                (theta_a / expected - 1.0).abs() < 0.03,
                "{damping:?} {a} {omega}: {theta_a} {expected}"
            );
        }
    }
}

#[test]
fn every_mode_of_the_response_is_the_transfer_function_times_its_own() {
    let oscillator = Oscillator::balanced(&ship(Damping::Cubic), 0.5, 0.419);
    let (delta_omega, mode) = (0.01, 40);
    let mut spectrum = vec![Complex::new(Lanes([0.0; WIDTH]), Lanes([0.0; WIDTH])); 64];
    spectrum[mode - 1] = Complex::new(Lanes([3.0; WIDTH]), Lanes([-4.0; WIDTH]));
    oscillator.respond(&mut spectrum, delta_omega);
    let mut modulus = vec![[0.0; WIDTH]; 256];
    Synthesis::new(64, 256).modulus(&spectrum, &mut modulus);
    // x'' + alpha x' + beta x = epsilon_2 eta by hand: |H| = epsilon_2/|beta - omega^2 + i alpha omega|.
    let omega = 0.4;
    let (re, im) = (oscillator.beta - omega * omega, oscillator.alpha * omega);
    let expected = 5.0 * oscillator.epsilon_2 / (re * re + im * im).sqrt();
    assert!(modulus.iter().flatten().all(|z| (z / expected - 1.0).abs() < 1e-12));
    // The roll lags: x = H eta with eta = cos wt solves the equation with H = re + i im.
    let h = oscillator.transfer(omega);
    for t in [0.0, 1.0, 7.0] {
        let (c, s) = (cos(omega * t), sin(omega * t));
        let (x, v) = (h.re * c - h.im * s, omega * (-h.re * s - h.im * c));
        let left = -omega * omega * x + oscillator.alpha * v + oscillator.beta * x;
        assert!((left - oscillator.epsilon_2 * c).abs() < 1e-15);
    }
}

#[test]
fn the_largest_about_a_group_is_the_whole_scan_s_and_wraps() {
    let series: Vec<f64> = (0..64).map(|i| sin(f64::from(i) * 1.7) + 1.0).collect();
    for (centre, reach) in [(30.0, 9.0), (2.0, 11.0), (127.0, 6.5), (63.9, 0.2)] {
        let mut expected = 0.0_f64;
        for i in -64_i32..192 {
            if (f64::from(i) * 2.0 - centre).abs() <= reach {
                expected = expected.max(series[i.rem_euclid(64) as usize]);
            }
        }
        assert_eq!(largest_about(|i| series[i], 64, 2.0, centre, reach), expected);
    }
}

#[test]
fn groups_are_known_by_the_geometric_mean_over_the_oscillators() {
    let z = geometric_means(&[vec![0.2, 0.5, 0.0], vec![0.8, 0.5, 1.0]]);
    assert!((z[0] - 0.4).abs() < 1e-15 && (z[1] - 0.5).abs() < 1e-15, "{z:?}");
    assert_eq!(z[2], 0.0, "at rest in one of them");
    assert!(geometric_means(&[vec![]]).is_empty());
}
