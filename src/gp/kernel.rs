//! The squared exponential kernel with one length per coordinate, and sums over its matrix.
//!
//! ```text
//! k(x, x') = variance exp(-½ Σ_d (x_d - x'_d)² / length_d²)
//! ```
//! Everything here runs inside a `lanes::Kernel`. Tested by finite differences in `tests/physics/gp.rs`.

use crate::numerics::elementary::{exp, exp_lanes};
use crate::numerics::square::{ROWS, Square};
use serde::{Deserialize, Serialize};

/// A squared exponential kernel over D coordinates.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Ard {
    /// σ², the value at distance 0.
    pub variance: f64,
    /// ℓ_d, in units of coordinate d (D).
    pub length: Vec<f64>,
}

impl Ard {
    /// The kernel whose logarithms are `log` = [log variance, log length_1, ..].
    pub fn from_log(log: &[f64]) -> Self {
        Self {
            variance: exp(log[0]),
            length: log[1..].iter().map(|l| exp(*l)).collect(),
        }
    }

    /// -1/(2 ℓ_d²), the factor of the squared distance along d.
    #[inline(always)]
    pub fn factor(&self, d: usize) -> f64 {
        -0.5 / (self.length[d] * self.length[d])
    }

    /// k(x, x') for one x and eight x'; `others[d]` holds their coordinate d.
    #[inline(always)]
    pub fn eight<const D: usize>(&self, x: &[f64; D], others: &[[f64; ROWS]; D]) -> [f64; ROWS] {
        let mut exponent = [0.0; ROWS];
        for d in 0..D {
            let factor = self.factor(d);
            for r in 0..ROWS {
                let difference = others[d][r] - x[d];
                exponent[r] += factor * (difference * difference);
            }
        }
        let mut value = exp_lanes(exponent);
        for v in &mut value {
            *v *= self.variance;
        }
        value
    }
}

/// The squared differences of all pairs of points, one matrix (n, n) per coordinate.
pub fn squared_differences<const D: usize>(points: &[[f64; D]]) -> Vec<Square> {
    (0..D)
        .map(|d| {
            Square::from_fn(points.len(), |i, j| {
                let difference = points[i][d] - points[j][d];
                difference * difference
            })
        })
        .collect()
}

/// Writes K (n, n), zero on the padding, with `jitter` added to its diagonal.
#[inline(always)]
pub fn covariance(kernel: &Ard, squares: &[Square], jitter: f64, k: &mut Square) {
    let (n, stride) = (k.n, k.stride);
    for j in 0..n {
        let from = j * stride + j / ROWS * ROWS;
        let column = &mut k.values[from..(j + 1) * stride];
        column.fill(0.0);
        for (d, square) in squares.iter().enumerate() {
            let factor = kernel.factor(d);
            for (exponent, s) in column.iter_mut().zip(&square.values[from..(j + 1) * stride]) {
                *exponent += factor * s;
            }
        }
        for values in column.as_chunks_mut::<ROWS>().0 {
            *values = exp_lanes(*values).map(|v| kernel.variance * v);
        }
        k.column_mut(j)[n..].fill(0.0);
    }
    k.values[n * stride..].fill(0.0);
    k.mirror();
    for j in 0..n {
        k.values[j + j * stride] += jitter;
    }
}

/// Writes Σ_ij W_ij ∂K_ij/∂φ for φ = log variance, log length_1, .. (1 + D); W (n, n) has the whole symmetric weight.
///
/// ∂K/∂log σ² = K and ∂K/∂log ℓ_d = K ∘ Δ_d²/ℓ_d², both without jitter.
#[inline(always)]
pub fn weighted_derivatives(
    kernel: &Ard,
    squares: &[Square],
    jitter: f64,
    k: &Square,
    weight: &Square,
    out: &mut [f64],
) {
    let mut trace = 0.0;
    for j in 0..k.n {
        trace += weight.at(j, j);
    }
    out[0] = contract(k, weight, None) - jitter * trace;
    for (d, square) in squares.iter().enumerate() {
        out[1 + d] = -2.0 * kernel.factor(d) * contract(k, weight, Some(square));
    }
}

/// Σ_ij K_ij W_ij (S_ij).
#[inline(always)]
fn contract(k: &Square, weight: &Square, square: Option<&Square>) -> f64 {
    let mut lanes = [0.0; ROWS];
    let pairs = k.values.chunks_exact(ROWS).zip(weight.values.chunks_exact(ROWS));
    if let Some(square) = square {
        for ((k, w), s) in pairs.zip(square.values.chunks_exact(ROWS)) {
            for r in 0..ROWS {
                lanes[r] += k[r] * w[r] * s[r];
            }
        }
    } else {
        for (k, w) in pairs {
            for r in 0..ROWS {
                lanes[r] += k[r] * w[r];
            }
        }
    }
    let mut total = 0.0;
    for lane in lanes {
        total += lane;
    }
    total
}

/// Eight points by coordinates, the last one repeated if fewer are left.
pub fn pack<const D: usize>(points: &[[f64; D]]) -> [[f64; ROWS]; D] {
    let mut packed = [[0.0; ROWS]; D];
    for r in 0..ROWS {
        let point = &points[if r < points.len() { r } else { points.len() - 1 }];
        for d in 0..D {
            packed[d][r] = point[d];
        }
    }
    packed
}

/// Writes k(x_i, point) for eight points: `rows` (8, n), by columns.
#[inline(always)]
pub fn cross<const D: usize>(kernel: &Ard, x: &[[f64; D]], points: &[[f64; ROWS]; D], rows: &mut [f64]) {
    for (x, target) in x.iter().zip(rows.chunks_exact_mut(ROWS)) {
        target.copy_from_slice(&kernel.eight(x, points));
    }
}

/// Σ_i w_i rows[.., i] for eight points.
#[inline(always)]
pub fn weighted_sum(rows: &[f64], weight: &[f64]) -> [f64; ROWS] {
    let mut total = [0.0; ROWS];
    for (row, w) in rows.chunks_exact(ROWS).zip(weight) {
        for r in 0..ROWS {
            total[r] += w * row[r];
        }
    }
    total
}

/// Σ_i rows[.., i]² for eight points.
#[inline(always)]
pub fn sum_of_squares(rows: &[f64]) -> [f64; ROWS] {
    let mut total = [0.0; ROWS];
    for row in rows.chunks_exact(ROWS) {
        for r in 0..ROWS {
            total[r] += row[r] * row[r];
        }
    }
    total
}
