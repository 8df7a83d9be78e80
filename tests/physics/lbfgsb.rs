//! Claims about bounded quasi-Newton minimisation: known minima, active bounds, kinks, failures, limits.

use encounter::numerics::lbfgsb::{Minimum, Settings, minimise};

const SETTINGS: Settings = Settings {
    memory: 8,
    max_iterations: 500,
    max_evaluations: 2000,
    gradient_tolerance: 1e-9,
    value_tolerance: 0.0,
};
const WIDE: [f64; 8] = [1e3; 8];
const LOW: [f64; 8] = [-1e3; 8];

fn rosenbrock(x: &[f64], g: &mut [f64]) -> f64 {
    g.fill(0.0);
    let mut value = 0.0;
    for i in 0..x.len() - 1 {
        let (a, b) = (x[i + 1] - x[i] * x[i], 1.0 - x[i]);
        value += 100.0 * a * a + b * b;
        g[i] += -400.0 * a * x[i] - 2.0 * b;
        g[i + 1] += 200.0 * a;
    }
    value
}

/// ½ Σ d_i (x_i - c_i)² with cross terms ½ r (Σ x_i - c_i)².
fn quadratic<'a>(d: &'a [f64], c: &'a [f64], r: f64) -> impl FnMut(&[f64], &mut [f64]) -> f64 + 'a {
    move |x, g| {
        let s: f64 = (0..x.len()).map(|i| x[i] - c[i]).sum();
        let mut value = 0.5 * r * s * s;
        for i in 0..x.len() {
            value += 0.5 * d[i] * (x[i] - c[i]) * (x[i] - c[i]);
            g[i] = d[i] * (x[i] - c[i]) + r * s;
        }
        value
    }
}

fn close(found: &[f64], expected: &[f64], tolerance: f64) {
    for (i, (a, b)) in found.iter().zip(expected).enumerate() {
        assert!(
            (a - b).abs() < tolerance,
            "x[{i}]: found {found:?}, expected {expected:?}"
        );
    }
}

#[test]
fn rosenbrock_s_valley_ends_at_one() {
    for n in [2, 5, 8] {
        let start: Vec<f64> = (0..n).map(|i| if i % 2 == 0 { -1.2 } else { 1.0 }).collect();
        let m = minimise(rosenbrock, &start, &LOW[..n], &WIDE[..n], &SETTINGS);
        assert!(m.converged && m.evaluations < 200, "{m:?}");
        // n >= 4 has a second local minimum near (-1, 1, .., 1).
        let first = if m.value < 1.0 { 1.0 } else { m.x[0] };
        let mut expected = vec![1.0; n];
        expected[0] = first;
        close(&m.x[..2], &expected[..2], if first == 1.0 { 1e-7 } else { 0.1 });
    }
}

#[test]
fn rosenbrock_with_an_active_bound_stops_on_it() {
    // x <= 0.5: the minimum slides along the bound to y = x² = 0.25.
    let m = minimise(rosenbrock, &[-1.2, 1.0], &[-2.0, -2.0], &[0.5, 2.0], &SETTINGS);
    assert!(m.converged, "{m:?}");
    assert_eq!(m.x[0], 0.5);
    close(&m.x, &[0.5, 0.25], 1e-8);
    // y >= 1.5 binds instead: 400 x (x² - 1.5) = 2 (1 - x).
    let m = minimise(rosenbrock, &[-1.2, 3.0], &[-1e3, 1.5], &[1e3, 1e3], &SETTINGS);
    let x = m.x[0];
    assert_eq!(m.x[1], 1.5);
    assert!((400.0 * x * (x * x - 1.5) - 2.0 * (1.0 - x)).abs() < 1e-6, "{m:?}");
}

#[test]
fn a_start_outside_the_box_is_moved_into_it() {
    let m = minimise(rosenbrock, &[7.0, -9.0], &[0.0, 0.0], &[2.0, 2.0], &SETTINGS);
    close(&m.x, &[1.0, 1.0], 1e-7);
}

#[test]
fn a_quadratic_ends_at_its_known_minimum_for_any_scale_of_its_axes() {
    let d = [1e-2, 1.0, 30.0, 1e3, 5.0, 0.3];
    let c = [3.0, -2.0, 0.5, 0.25, 10.0, -7.0];
    let m = minimise(quadratic(&d, &c, 0.7), &[0.0; 6], &LOW[..6], &WIDE[..6], &SETTINGS);
    assert!(m.converged, "{m:?}");
    close(&m.x, &c, 1e-6);
}

#[test]
fn a_bounded_quadratic_meets_the_kuhn_tucker_conditions() {
    let d = [1e-2, 1.0, 30.0, 1e3, 5.0, 0.3];
    let c = [3.0, -2.0, 0.5, 0.25, 10.0, -7.0];
    let (lower, upper) = ([-1.0; 6], [1.0; 6]);
    let m = minimise(quadratic(&d, &c, 4.0), &[0.3; 6], &lower, &upper, &SETTINGS);
    assert!(m.converged, "{m:?}");
    let mut g = [0.0; 6];
    quadratic(&d, &c, 4.0)(&m.x, &mut g);
    let mut active = 0;
    for i in 0..6 {
        if m.x[i] == lower[i] {
            assert!(g[i] >= 0.0);
            active += 1;
        } else if m.x[i] == upper[i] {
            assert!(g[i] <= 0.0);
            active += 1;
        } else {
            assert!(g[i].abs() < 1e-8, "{g:?}");
        }
    }
    assert!(active >= 1, "the case has active bounds");
}

#[test]
fn a_corner_is_reached_in_one_or_two_steps_of_a_linear_objective() {
    let plane = |x: &[f64], g: &mut [f64]| {
        g.copy_from_slice(&[1.0, -2.0, 0.5]);
        x[0] - 2.0 * x[1] + 0.5 * x[2]
    };
    let m = minimise(plane, &[0.0; 3], &[-1.0; 3], &[1.0; 3], &SETTINGS);
    assert_eq!(m.x, [-1.0, 1.0, -1.0]);
    assert!(m.converged && m.iterations <= 3, "{m:?}");
}

#[test]
fn kinks_do_not_stop_the_descent() {
    // The shape of detection's similarity: a mean of absolute deviations, three variables.
    let kinked = |x: &[f64], g: &mut [f64]| {
        g.fill(0.0);
        let mut value = 0.0;
        for j in -20..=20 {
            let t = f64::from(j) / 10.0;
            let model = x[0] + x[1] * t + x[2] * t * t;
            let truth = 0.7 - 1.3 * t + 0.4 * t * t;
            value += (model - truth).abs() / 41.0;
            let sign = (model - truth).signum() / 41.0;
            g[0] += sign;
            g[1] += sign * t;
            g[2] += sign * t * t;
        }
        value
    };
    let m = minimise(kinked, &[3.0, 3.0, -3.0], &[-10.0; 3], &[10.0; 3], &SETTINGS);
    assert!(m.value < 0.01, "{m:?}");
    close(&m.x, &[0.7, -1.3, 0.4], 0.02);
    let sum = |x: &[f64], g: &mut [f64]| {
        let mut value = 0.0;
        for i in 0..3 {
            let w = [1.0, 10.0, 3.0][i];
            g[i] = w * x[i].signum();
            value += w * x[i].abs();
        }
        value
    };
    let m = minimise(sum, &[1.7, -0.4, 2.9], &[-10.0; 3], &[10.0; 3], &SETTINGS);
    assert!(m.value < 1e-3, "{m:?}");
}

#[test]
fn a_failed_evaluation_is_stepped_back_from() {
    for failure in [f64::INFINITY, f64::NAN] {
        // A wall at x = 0.1, minimum at 0.2, start far right: the first steps jump over the wall.
        let walled = |x: &[f64], g: &mut [f64]| {
            if x[0] < 0.1 {
                g[0] = f64::NAN;
                return failure;
            }
            g[0] = 200.0 * (x[0] - 0.2);
            100.0 * (x[0] - 0.2) * (x[0] - 0.2)
        };
        let m = minimise(walled, &[0.9], &[-10.0], &[10.0], &SETTINGS);
        close(&m.x, &[0.2], 1e-9);
        let m = minimise(walled, &[-1.0], &[-10.0], &[10.0], &SETTINGS);
        assert!(!m.converged && m.value == f64::INFINITY && m.x == [-1.0], "{m:?}");
    }
}

#[test]
fn limits_are_kept_and_reported_as_not_converged() {
    let short = Settings {
        max_evaluations: 7,
        ..SETTINGS
    };
    let m = minimise(rosenbrock, &[-1.2, 1.0], &LOW[..2], &WIDE[..2], &short);
    assert!(!m.converged && m.evaluations <= 7 && m.value < 24.2, "{m:?}");
    let short = Settings {
        max_iterations: 3,
        ..SETTINGS
    };
    let m = minimise(rosenbrock, &[-1.2, 1.0], &LOW[..2], &WIDE[..2], &short);
    assert!(!m.converged && m.iterations == 3, "{m:?}");
}

#[test]
fn the_same_call_gives_the_same_bits() {
    let run = || -> Minimum { minimise(rosenbrock, &[-1.2; 8], &LOW, &WIDE, &SETTINGS) };
    assert_eq!(run(), run());
}
