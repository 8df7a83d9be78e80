//! Damped least squares (Levenberg, Marquardt) with central differences: the last steps of a search.
//!
//! ```text
//! (Jᵀ J + mu d 1) dx = -Jᵀ f       d the largest of diag Jᵀ J, mu from a fixed ladder, the best of its steps is taken
//! ```
//! The coefficients make up for each other, so Jᵀ J is nearly singular and its scale is far from 1: the damping is relative
//! to it. The residuals are steps in x (counts of exceedances), so differences are wide and the damping does not vanish.
//! All points of a round are evaluated as one batch. Tested in `tests/physics/calibration.rs`.

use crate::numerics::cholesky::{factor, solve};
use crate::numerics::square::Square;

/// Half-width of the differences, in ln ratio.
const WIDTH: f64 = 0.01;
/// Longest step along a coordinate, in ln ratio; a longer step is shortened as a whole.
const LONGEST: f64 = 0.15;
/// The dampings tried in every round, in shares of the largest squared column of J.
const LADDER: [f64; 6] = [1e-6, 1e-5, 1e-4, 1e-3, 1e-2, 0.1];

/// The point after some rounds from `start`; `residuals` evaluates a batch.
///
/// A round that finds nothing better is the last.
pub fn least_squares(
    start: &[f64],
    bounds: &[[f64; 2]],
    rounds: u32,
    mut residuals: impl FnMut(&[Vec<f64>]) -> Vec<Vec<f64>>,
) -> Vec<f64> {
    let n = start.len();
    let mut x = start.to_vec();
    for _ in 0..rounds {
        let mut points = vec![x.clone()];
        for q in 0..n {
            for sign in [1.0, -1.0] {
                let mut moved = x.clone();
                moved[q] += sign * WIDTH;
                points.push(moved);
            }
        }
        let f = residuals(&points);
        let column = |q: usize| {
            let (up, down) = (&f[1 + 2 * q], &f[2 + 2 * q]);
            up.iter().zip(down).map(|(u, d)| (u - d) / (2.0 * WIDTH)).collect()
        };
        let jacobian: Vec<Vec<f64>> = (0..n).map(column).collect();
        let steps: Vec<Vec<f64>> = LADDER
            .iter()
            .filter_map(|mu| step(&jacobian, &f[0], *mu))
            .map(|dx| moved(&x, &dx, bounds))
            .collect();
        let found = residuals(&steps);
        let mut best = (squares(&f[0]), None);
        for (point, f) in steps.iter().zip(&found) {
            let sum = squares(f);
            if sum < best.0 {
                best = (sum, Some(point));
            }
        }
        match best.1 {
            Some(point) => x.clone_from(point),
            None => break,
        }
    }
    x
}

fn step(jacobian: &[Vec<f64>], f: &[f64], mu: f64) -> Option<Vec<f64>> {
    let largest = jacobian.iter().map(|column| squares(column)).fold(0.0, f64::max);
    let normal = |i: usize, j: usize| dot(&jacobian[i], &jacobian[j]) + if i == j { mu * largest } else { 0.0 };
    let mut l = Square::from_fn(jacobian.len(), normal);
    if !factor(&mut l) {
        return None;
    }
    let mut dx: Vec<f64> = jacobian.iter().map(|column| -dot(column, f)).collect();
    solve(&l, &mut dx);
    dx.iter().all(|dx| dx.is_finite()).then_some(dx)
}

/// A step shortened to its longest, and cut at the bounds.
fn moved(x: &[f64], dx: &[f64], bounds: &[[f64; 2]]) -> Vec<f64> {
    let length = dx.iter().map(|dx| dx.abs()).fold(0.0, f64::max);
    let share = if length > LONGEST { LONGEST / length } else { 1.0 };
    let to = |((x, dx), [low, high]): ((&f64, &f64), &[f64; 2])| (x + share * dx).clamp(*low, *high);
    x.iter().zip(dx).zip(bounds).map(to).collect()
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).fold(0.0, |sum, (a, b)| sum + a * b)
}

fn squares(f: &[f64]) -> f64 {
    dot(f, f)
}
