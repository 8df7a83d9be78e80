//! Claims about the RK4 step.

use encounter::numerics::elementary::{cos, exp, ln, sin};
use encounter::numerics::rk4;

/// theta'' = -theta - 0.2 theta' + cos t from (1, 0), its exact solution at t.
fn exact(t: f64) -> f64 {
    // Particular: A cos t + B sin t with A = 0, B = 5; homogeneous with damping 0.1.
    let w = 0.99_f64.sqrt();
    let (c1, c2) = (1.0, (0.1 - 5.0) / w);
    exp(-0.1 * t) * (c1 * cos(w * t) + c2 * sin(w * t)) + 5.0 * sin(t)
}

fn integrated(steps: u32) -> f64 {
    let h = 10.0 / f64::from(steps);
    let acceleration = |x: [f64; 3], v: [f64; 3], f: [f64; 3]| [0, 1, 2].map(|i| f[i] - x[i] - 0.2 * v[i]);
    let (mut x, mut v) = ([1.0; 3], [0.0; 3]);
    for k in 0..steps {
        let t = f64::from(k) * h;
        let forcing = [t, t + 0.5 * h, t + h].map(|t| [cos(t); 3]);
        (x, v) = rk4::step(acceleration, h, x, v, forcing);
    }
    x[1]
}

#[test]
fn halving_the_step_divides_the_error_by_sixteen() {
    let error = |steps| (integrated(steps) - exact(10.0)).abs();
    for steps in [80, 160, 320] {
        let order = ln(error(steps) / error(2 * steps)) / ln(2.0);
        assert!((order - 4.0).abs() < 0.15, "observed order {order} at {steps} steps");
    }
    assert!(error(640) < 1e-8);
}

#[test]
fn the_step_is_exact_for_a_quadratic_in_time() {
    let (x, v) = rk4::step(|_, _, f: [f64; 1]| f, 0.5, [1.0], [2.0], [[3.0]; 3]);
    assert_eq!((x, v), ([1.0 + 2.0 * 0.5 + 3.0 * 0.125], [3.5]));
}

#[test]
fn lanes_do_not_see_each_other() {
    let f = |x: [f64; 2], v: [f64; 2], f: [f64; 2]| [0, 1].map(|i| f[i] - x[i] * x[i] - v[i]);
    let forcing = [[0.3, f64::NAN], [0.4, 1.0], [0.5, f64::INFINITY]];
    let (x, v) = rk4::step(f, 0.1, [0.7, 2.0], [0.1, 3.0], forcing);
    let g = |x: [f64; 1], v: [f64; 1], f: [f64; 1]| [f[0] - x[0] * x[0] - v[0]];
    let alone = rk4::step(g, 0.1, [0.7], [0.1], forcing.map(|row| [row[0]]));
    assert_eq!(([x[0]], [v[0]]), alone);
    assert!(x[1].is_nan() || x[1].is_infinite());
}
