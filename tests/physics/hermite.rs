//! Claims about the peak inside a step.

use encounter::numerics::elementary::{cos, ln, sin};
use encounter::numerics::hermite::extremum;

fn interpolant(h: f64, x: [f64; 2], v: [f64; 2], u: f64) -> f64 {
    let (a, b) = (1.0 - u, u);
    x[0] * (a * a * (1.0 + 2.0 * u))
        + x[1] * (b * b * (3.0 - 2.0 * u))
        + h * v[0] * u * a * a
        + h * v[1] * b * b * (u - 1.0)
}

#[test]
fn the_extremum_is_that_of_a_dense_search() {
    let h = 0.25;
    for k in 0..2000 {
        let z = |n: i32| sin(f64::from(k) * 0.7 + f64::from(n) * 1.9);
        let (x, v) = ([z(0), z(0) + 0.1 * z(1)], [z(2).abs() + 1e-6, -z(3).abs() - 1e-6]);
        let sign = if k % 2 == 0 { 1.0 } else { -1.0 };
        let (x, v) = (x.map(|x| sign * x), v.map(|v| sign * v));
        // The slope turns once: the extremum is where the walk along the slope ends.
        let slope = |u: f64| {
            let (p, q, d) = (h * v[0], h * v[1], x[1] - x[0]);
            (3.0 * (p + q) - 6.0 * d) * u * u + (6.0 * d - 4.0 * p - 2.0 * q) * u + p
        };
        let (mut low, mut high) = (0.0, 1.0);
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if sign * slope(middle) > 0.0 {
                low = middle;
            } else {
                high = middle;
            }
        }
        let found = extremum(h, x.map(|x| [x]), v.map(|v| [v]))[0];
        let expected = interpolant(h, x, v, low);
        assert!((found - expected).abs() < 1e-12, "case {k}: {found} for {expected}");
    }
}

#[test]
fn the_peak_of_a_cosine_is_found_to_fourth_order() {
    let error = |h: f64| {
        let (t0, t1) = (-0.3 * h, 0.7 * h);
        let found = extremum(h, [[cos(t0)], [cos(t1)]], [[-sin(t0)], [-sin(t1)]])[0];
        (found - 1.0).abs()
    };
    assert!(error(0.1) < 1e-6 && error(0.1) > 0.0);
    let order = ln(error(0.2) / error(0.1)) / ln(2.0);
    assert!((order - 4.0).abs() < 0.1, "observed order {order}");
}

#[test]
fn without_a_turn_the_start_is_returned() {
    let x = [[0.3, 0.3, 0.3, 0.3], [0.4, 0.4, 0.4, 0.4]];
    let v = [[1.0, 0.0, -1.0, 1.0], [1.0, -1.0, 0.0, f64::NAN]];
    assert_eq!(extremum(0.2, x, v), [0.3; 4]);
}
