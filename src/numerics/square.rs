//! Square matrices in whole tiles, and the one product that everything dense is made of: A Bᵀ, tile by tile.
//!
//! Columns are contiguous and padded to a multiple of 8 rows, so no tile is ragged. A tile is 8 rows by 4 columns, eight
//! 256-bit registers; the inner index k always ascends, hence the same bits at every level of `numerics::lanes`.
//! The functions marked `#[inline(always)]` are to be called inside a `Kernel`. Tested against nalgebra in
//! `tests/physics/cholesky.rs`.

/// Rows of a tile: one AVX-512 register.
pub const ROWS: usize = 8;
/// Columns of a tile.
pub const COLUMNS: usize = 4;

/// An 8 x 4 tile, by columns.
pub type Tile = [[f64; ROWS]; COLUMNS];

/// A square matrix (n, n), by columns, padded to (stride, stride) with whatever the operations need there.
#[derive(Clone, Debug, PartialEq)]
pub struct Square {
    /// Rows and columns in use.
    pub n: usize,
    /// Rows and columns stored: n rounded up to a multiple of 8.
    pub stride: usize,
    /// Element (i, j) at `i + j * stride`.
    pub values: Vec<f64>,
}

impl Square {
    /// The zero matrix.
    pub fn zeros(n: usize) -> Self {
        let stride = n.next_multiple_of(ROWS);
        Self {
            n,
            stride,
            values: vec![0.0; stride * stride],
        }
    }

    /// The matrix with the elements `element(i, j)`.
    pub fn from_fn(n: usize, element: impl Fn(usize, usize) -> f64) -> Self {
        let mut square = Self::zeros(n);
        for j in 0..n {
            for i in 0..n {
                square.values[i + j * square.stride] = element(i, j);
            }
        }
        square
    }

    /// The element in row i, column j.
    pub fn at(&self, i: usize, j: usize) -> f64 {
        self.values[i + j * self.stride]
    }

    /// Column j with its padding (stride).
    #[inline(always)]
    pub fn column(&self, j: usize) -> &[f64] {
        &self.values[j * self.stride..(j + 1) * self.stride]
    }

    /// Column j with its padding (stride).
    #[inline(always)]
    pub fn column_mut(&mut self, j: usize) -> &mut [f64] {
        &mut self.values[j * self.stride..(j + 1) * self.stride]
    }

    /// Ones on the padded diagonal, zeros beside it: a padded factor stays regular.
    #[inline(always)]
    pub fn pad_with_identity(&mut self) {
        for j in 0..self.stride {
            let from = if j < self.n { self.n } else { 0 };
            self.values[j * self.stride + from..(j + 1) * self.stride].fill(0.0);
            if j >= self.n {
                self.values[j + j * self.stride] = 1.0;
            }
        }
    }

    /// Copies the lower triangle onto the upper one.
    #[inline(always)]
    pub fn mirror(&mut self) {
        let stride = self.stride;
        for j in 0..stride {
            for i in 0..j {
                self.values[i + j * stride] = self.values[j + i * stride];
            }
        }
    }

    /// Writes the transpose of `other`, of the same size.
    #[inline(always)]
    pub fn transpose_of(&mut self, other: &Self) {
        let stride = self.stride;
        for j0 in (0..stride).step_by(ROWS) {
            for i0 in (0..stride).step_by(ROWS) {
                for j in j0..j0 + ROWS {
                    for i in i0..i0 + ROWS {
                        self.values[i + j * stride] = other.values[j + i * stride];
                    }
                }
            }
        }
    }

    /// Writes A Bᵀ; element (i, j) sums over k in `range(first row, first column)` of its tile, which must cover the
    /// k where both factors differ from 0. With `lower` only tiles that touch the lower triangle are written.
    #[inline(always)]
    pub fn product(&mut self, a: &Self, b: &Self, lower: bool, range: impl Fn(usize, usize) -> (usize, usize)) {
        let stride = self.stride;
        for i0 in (0..stride).step_by(ROWS) {
            let columns = if lower { i0 + ROWS } else { stride };
            for j0 in (0..columns).step_by(COLUMNS) {
                let (from, to) = range(i0, j0);
                let tile = products([[0.0; ROWS]; COLUMNS], 1.0, (&a.values, stride, i0), (b, j0), from, to);
                store(&mut self.values, stride, (i0, j0), &tile);
            }
        }
    }
}

/// A tile plus `sign` times Σ_k a[i0.., k] b[j0.., k]ᵀ, k from `from` up to `to`.
///
/// `a` is (values by columns, its stride, first row); `b` is (matrix, first row).
#[inline(always)]
pub fn products(tile: Tile, sign: f64, a: (&[f64], usize, usize), b: (&Square, usize), from: usize, to: usize) -> Tile {
    let (values, stride, i0) = a;
    let (b, j0) = b;
    let mut tile = tile;
    if from >= to {
        return tile;
    }
    let left = values[from * stride..to * stride].chunks_exact(stride);
    let right = b.values[from * b.stride..to * b.stride].chunks_exact(b.stride);
    for (left, right) in left.zip(right) {
        let (left, right) = (&left[i0..i0 + ROWS], &right[j0..j0 + COLUMNS]);
        for c in 0..COLUMNS {
            let factor = sign * right[c];
            for r in 0..ROWS {
                tile[c][r] += factor * left[r];
            }
        }
    }
    tile
}

/// The tile whose first element is (i0, j0).
#[inline(always)]
pub fn load(values: &[f64], stride: usize, at: (usize, usize)) -> Tile {
    let (i0, j0) = at;
    let mut tile = [[0.0; ROWS]; COLUMNS];
    for c in 0..COLUMNS {
        tile[c].copy_from_slice(&values[(j0 + c) * stride + i0..][..ROWS]);
    }
    tile
}

/// Writes a tile with its first element at (i0, j0).
#[inline(always)]
pub fn store(values: &mut [f64], stride: usize, at: (usize, usize), tile: &Tile) {
    let (i0, j0) = at;
    for c in 0..COLUMNS {
        values[(j0 + c) * stride + i0..][..ROWS].copy_from_slice(&tile[c]);
    }
}
