//! The Cholesky factor A = L Lᵀ of a dense symmetric matrix, its solves, inverse and log diagonal.
//!
//! Left-looking over panels of 4 columns, tiles of 8 x 4 (`numerics::square`); every element subtracts its products in
//! ascending k, so the bits are the same at every level. A matrix that is not positive definite has no factor: that is
//! a value, not a panic. Golub & Van Loan, *Matrix Computations*, section 4.2. Tested against nalgebra in
//! `tests/physics/cholesky.rs`.

use super::elementary::ln;
use super::lanes::Kernel;
use super::square::{COLUMNS, ROWS, Square, Tile, load, products, store};

/// [`factor`] as a kernel.
pub struct Factor<'a> {
    /// The matrix to be replaced by its factor.
    pub a: &'a mut Square,
}

impl Kernel for Factor<'_> {
    type Output = bool;
    #[inline(always)]
    fn run(self) -> bool {
        factor(self.a)
    }
}

/// [`inverse_transposed`] as a kernel.
pub struct Inverse<'a> {
    /// The factor L.
    pub l: &'a Square,
    /// Room for L⁻ᵀ.
    pub t: &'a mut Square,
}

impl Kernel for Inverse<'_> {
    type Output = ();
    #[inline(always)]
    fn run(self) {
        inverse_transposed(self.l, self.t);
    }
}

/// Replaces the lower triangle of a matrix by its factor L and the rest by zeros; false if a pivot is not positive.
#[inline(always)]
pub fn factor(a: &mut Square) -> bool {
    a.pad_with_identity();
    let stride = a.stride;
    for j0 in (0..stride).step_by(COLUMNS) {
        let top = j0 / ROWS * ROWS;
        let tile = products(
            load(&a.values, stride, (top, j0)),
            -1.0,
            (&a.values, stride, top),
            (a, j0),
            0,
            j0,
        );
        let Some(tile) = factor_diagonal(tile, j0 - top) else {
            return false;
        };
        for c in 0..COLUMNS {
            a.column_mut(j0 + c)[..top].fill(0.0);
        }
        store(&mut a.values, stride, (top, j0), &tile);
        for i0 in (top + ROWS..stride).step_by(ROWS) {
            let tile = products(
                load(&a.values, stride, (i0, j0)),
                -1.0,
                (&a.values, stride, i0),
                (a, j0),
                0,
                j0,
            );
            let tile = divide(tile, a, j0);
            store(&mut a.values, stride, (i0, j0), &tile);
        }
    }
    true
}

/// The factor's tile on the diagonal, whose pivots stand in rows `first`, `first` + 1, ..
#[inline(always)]
fn factor_diagonal(mut tile: Tile, first: usize) -> Option<Tile> {
    for c in 0..COLUMNS {
        for d in 0..c {
            let l = tile[d][first + c];
            for r in 0..ROWS {
                tile[c][r] -= l * tile[d][r];
            }
        }
        let pivot = tile[c][first + c];
        if !(pivot > 0.0 && pivot < f64::INFINITY) {
            return None;
        }
        let root = pivot.sqrt();
        for r in 0..ROWS {
            tile[c][r] = if r < first + c { 0.0 } else { tile[c][r] / root };
        }
    }
    Some(tile)
}

/// X with X Dᵀ = tile, D the 4 x 4 diagonal block of `l` at j0.
#[inline(always)]
fn divide(mut tile: Tile, l: &Square, j0: usize) -> Tile {
    for c in 0..COLUMNS {
        for d in 0..c {
            let factor = l.values[j0 + c + (j0 + d) * l.stride];
            for r in 0..ROWS {
                tile[c][r] -= factor * tile[d][r];
            }
        }
        let pivot = l.values[j0 + c + (j0 + c) * l.stride];
        for r in 0..ROWS {
            tile[c][r] /= pivot;
        }
    }
    tile
}

/// Solves L xᵀ = bᵀ for 8 right-hand sides at once: `rows` (8, stride), by columns, holds b and then x.
#[inline(always)]
pub fn forward(l: &Square, rows: &mut [f64]) {
    for j0 in (0..l.stride).step_by(COLUMNS) {
        let tile = products(load(rows, ROWS, (0, j0)), -1.0, (rows, ROWS, 0), (l, j0), 0, j0);
        let tile = divide(tile, l, j0);
        store(rows, ROWS, (0, j0), &tile);
    }
}

/// Writes T = L⁻ᵀ, upper triangular.
#[inline(always)]
pub fn inverse_transposed(l: &Square, t: &mut Square) {
    let stride = l.stride;
    t.values.fill(0.0);
    for i0 in (0..stride).step_by(ROWS) {
        for j0 in (i0..stride).step_by(COLUMNS) {
            let mut tile = products([[0.0; ROWS]; COLUMNS], -1.0, (&t.values, stride, i0), (l, j0), i0, j0);
            if j0 < i0 + ROWS {
                for c in 0..COLUMNS {
                    tile[c][j0 + c - i0] += 1.0;
                }
            }
            let tile = divide(tile, l, j0);
            store(&mut t.values, stride, (i0, j0), &tile);
        }
    }
}

/// Writes A⁻¹ = T Tᵀ, whole, from T = L⁻ᵀ.
#[inline(always)]
pub fn symmetric_inverse(t: &Square, inverse: &mut Square) {
    let stride = t.stride;
    inverse.product(t, t, true, |i0, _| (i0, stride));
    inverse.mirror();
}

/// A⁻¹ b in place of b (n), from the factor L.
#[inline(always)]
pub fn solve(l: &Square, b: &mut [f64]) {
    let n = l.n;
    for j in 0..n {
        let column = l.column(j);
        b[j] /= column[j];
        let x = b[j];
        for i in j + 1..n {
            b[i] -= x * column[i];
        }
    }
    for j in (0..n).rev() {
        let column = l.column(j);
        let mut rest = b[j];
        for i in j + 1..n {
            rest -= column[i] * b[i];
        }
        b[j] = rest / column[j];
    }
}

/// Σ ln L_ii.
pub fn log_diagonal(l: &Square) -> f64 {
    let mut total = 0.0;
    for i in 0..l.n {
        total += ln(l.at(i, i));
    }
    total
}
