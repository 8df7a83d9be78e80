//! Scatter of the response about what (L, A) tell, near the threshold: what a surrogate in (L, A) has to average away.
//!
//! ```text
//! (C3)  s^2 = sum_i w_i (y_i - m(L_i, A_i))^2 / sum_i w_i,   w = q (1 - q),   y = min(r, cap)
//! ```
//! m and q are local means of y and of I(r > theta_t) with Gaussian kernels on a grid of (ln L/T_p, A/H_s); w picks the
//! groups whose (L, A) leave open on which side of the threshold they end. Tested in `tests/physics/calibration.rs`.

use crate::numerics::elementary::{exp, ln};

/// Cells along each coordinate.
const CELLS: usize = 64;
/// Range of ln(L/T_p): 0.5 to 12.
const LN_L: [f64; 2] = [-0.75, 2.5];
/// Range of A/H_s.
const A: [f64; 2] = [0.0, 1.4];
/// Standard deviations of the kernel along each, in the units of the grid.
const KERNEL: [f64; 2] = [0.11, 0.028];

/// One group: L/T_p, A/H_s, its response in rad.
pub type Point = [f64; 3];

/// Sums over the groups of a cell: 1, y, I(r > theta_t).
type Sums = [f64; 3];

/// (C3), rad; none if no group is near the threshold.
pub fn spread(points: &[Point], theta_t: f64, cap: f64) -> Option<f64> {
    let mut cells = vec![[0.0; 3]; CELLS * CELLS];
    let cut = |r: f64| if r < cap { r } else { cap };
    for point in points {
        let sums = &mut cells[cell(point)];
        sums[0] += 1.0;
        sums[1] += cut(point[2]);
        sums[2] += f64::from(u8::from(point[2] > theta_t));
    }
    let steps = [(LN_L[1] - LN_L[0]) / CELLS as f64, (A[1] - A[0]) / CELLS as f64];
    let smooth = blurred(&blurred(&cells, CELLS, KERNEL[0] / steps[0]), 1, KERNEL[1] / steps[1]);
    let (mut squares, mut weights) = (0.0, 0.0);
    for point in points {
        let [n, y, above] = smooth[cell(point)];
        let q = above / n;
        let d = cut(point[2]) - y / n;
        squares += q * (1.0 - q) * d * d;
        weights += q * (1.0 - q);
    }
    (weights > 0.0).then(|| (squares / weights).sqrt())
}

/// The cell of a group; those outside the grid fall into its edge.
fn cell(point: &Point) -> usize {
    let place = |value: f64, [low, high]: [f64; 2]| {
        let place = ((value - low) / (high - low) * CELLS as f64) as i64;
        place.clamp(0, CELLS as i64 - 1) as usize
    };
    place(ln(point[0]), LN_L) * CELLS + place(point[1], A)
}

/// Sums weighted by a Gaussian of `width` cells along the coordinate whose cells lie `stride` apart.
fn blurred(cells: &[Sums], stride: usize, width: f64) -> Vec<Sums> {
    let reach = (4.0 * width).ceil() as i64;
    let weights: Vec<f64> = (0..=reach)
        .map(|d| exp(-0.5 * (d as f64 / width) * (d as f64 / width)))
        .collect();
    let mut out = vec![[0.0; 3]; cells.len()];
    for (at, sums) in out.iter_mut().enumerate() {
        let own = (at / stride % CELLS) as i64;
        for d in -reach..=reach {
            if !(0..CELLS as i64).contains(&(own + d)) {
                continue;
            }
            let from = &cells[(at as i64 + d * stride as i64) as usize];
            let weight = weights[d.unsigned_abs() as usize];
            for (sum, value) in sums.iter_mut().zip(from) {
                *sum += weight * value;
            }
        }
    }
    out
}
