//! Gaussian kernel density on a grid: the joint density p(L, A) of Figures 1(c) and 3, and the weight of a sample.
//!
//! | symbol | code | unit or shape | meaning |
//! |---|---|---|---|
//! | p | `p` | (ny, nx), 1/(unit of x times unit of y) | density |
//! | h | `bandwidth` | 2 | standard deviation of the kernel in x and y |
//!
//! Tested against the direct double sum and the normal law in `tests/physics/density.rs`.

use crate::numerics::{elementary, invariant};
use serde::{Deserialize, Serialize};

/// Kernels are cut off at this many bandwidths, where they are 1.5e-8 of their peak.
const REACH: f64 = 6.0;

/// A rectangular grid of nx times ny points, from (x0, y0) in steps of dx and dy.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Grid {
    /// First abscissa.
    pub x0: f64,
    /// Step in x, > 0.
    pub dx: f64,
    /// Points in x, >= 1.
    pub nx: u32,
    /// First ordinate.
    pub y0: f64,
    /// Step in y, > 0.
    pub dy: f64,
    /// Points in y, >= 1.
    pub ny: u32,
}

impl Grid {
    /// The grid of nx times ny points, both >= 2, whose outermost points lie on the given intervals' ends.
    pub fn spanning(x: [f64; 2], nx: u32, y: [f64; 2], ny: u32) -> Self {
        Self {
            x0: x[0],
            dx: (x[1] - x[0]) / f64::from(nx - 1),
            nx,
            y0: y[0],
            dy: (y[1] - y[0]) / f64::from(ny - 1),
            ny,
        }
    }
}

/// A density sampled on a grid.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct DensityMap {
    /// First abscissa.
    pub x0: f64,
    /// Step in x.
    pub dx: f64,
    /// Points in x.
    pub nx: u32,
    /// First ordinate.
    pub y0: f64,
    /// Step in y.
    pub dy: f64,
    /// Points in y.
    pub ny: u32,
    /// Density at (x0 + ix dx, y0 + iy dy), stored at iy nx + ix.
    pub p: Vec<f64>,
}

impl DensityMap {
    /// Checks that it is a density of kernels of a bandwidth on a grid: no point is higher than a single kernel's peak.
    ///
    /// # Errors
    /// Another grid, or a value that no density has.
    pub fn check(&self, grid: &Grid, bandwidth: [f64; 2]) -> Result<(), String> {
        let own = Grid {
            x0: self.x0,
            dx: self.dx,
            nx: self.nx,
            y0: self.y0,
            dy: self.dy,
            ny: self.ny,
        };
        invariant::equal("density", &own, grid)?;
        invariant::length("density.p", &self.p, grid.nx as usize * grid.ny as usize)?;
        let highest = 1.0 / (std::f64::consts::TAU * bandwidth[0] * bandwidth[1]);
        invariant::all_within("density.p", &self.p, &(0.0..=highest * (1.0 + 1e-6)))
    }

    /// The bilinear interpolant at (x, y); 0 outside the grid.
    pub fn at(&self, x: f64, y: f64) -> f64 {
        let (Some((ix, u)), Some((iy, v))) = (
            cell((x - self.x0) / self.dx, self.nx as usize),
            cell((y - self.y0) / self.dy, self.ny as usize),
        ) else {
            return 0.0;
        };
        let nx = self.nx as usize;
        let (right, up) = ((ix + 1).min(nx - 1), (iy + 1).min(self.ny as usize - 1));
        let low = self.p[iy * nx + ix] * (1.0 - u) + self.p[iy * nx + right] * u;
        let high = self.p[up * nx + ix] * (1.0 - u) + self.p[up * nx + right] * u;
        low * (1.0 - v) + high * v
    }

    /// The largest value on the grid.
    pub fn max(&self) -> f64 {
        self.p.iter().fold(0.0, |most, p| if *p > most { *p } else { most })
    }
}

/// The grid point at or below a position in steps and the fraction beyond it, None outside 0..=n-1.
fn cell(position: f64, n: usize) -> Option<(usize, f64)> {
    if !(position >= 0.0 && position <= (n - 1) as f64) {
        return None;
    }
    let index = position.floor();
    Some((index as usize, position - index))
}

/// The Gaussian kernel density of the points (x_i, y_i) with an uncorrelated kernel; all zero for no points.
///
/// ```text
/// p(x, y) = 1/n sum_i exp(-(x - x_i)^2/(2 h_x^2) - (y - y_i)^2/(2 h_y^2)) / (2 pi h_x h_y)
/// ```
pub fn kernel_density(x: &[f64], y: &[f64], bandwidth: [f64; 2], grid: &Grid) -> DensityMap {
    let (nx, ny) = (grid.nx as usize, grid.ny as usize);
    let mut p = vec![0.0; nx * ny];
    let (mut in_x, mut in_y) = (Vec::with_capacity(nx), Vec::with_capacity(ny));
    for (x_i, y_i) in x.iter().zip(y) {
        let left = kernel(*x_i, bandwidth[0], [grid.x0, grid.dx], nx, &mut in_x);
        let low = kernel(*y_i, bandwidth[1], [grid.y0, grid.dy], ny, &mut in_y);
        for (row, weight) in in_y.iter().enumerate() {
            let start = (low + row) * nx + left;
            for (cell, k) in p[start..start + in_x.len()].iter_mut().zip(&in_x) {
                *cell += weight * k;
            }
        }
    }
    let n = x.len().min(y.len()).max(1) as f64;
    let norm = 1.0 / (n * std::f64::consts::TAU * bandwidth[0] * bandwidth[1]);
    for cell in &mut p {
        *cell *= norm;
    }
    DensityMap {
        x0: grid.x0,
        dx: grid.dx,
        nx: grid.nx,
        y0: grid.y0,
        dy: grid.dy,
        ny: grid.ny,
        p,
    }
}

/// exp(-u^2/2), u = (grid - centre)/h, at the grid points within reach; returns the first of them.
fn kernel(centre: f64, h: f64, [start, step]: [f64; 2], n: usize, out: &mut Vec<f64>) -> usize {
    out.clear();
    let last = ((centre + REACH * h - start) / step).floor();
    let first = ((centre - REACH * h - start) / step).ceil();
    let first = if first > 0.0 { first } else { 0.0 };
    if !(last >= first && first < n as f64) {
        return 0;
    }
    let (first, last) = (first as usize, (last as usize).min(n - 1));
    for i in first..=last {
        let u = (start + i as f64 * step - centre) / h;
        out.push(elementary::exp(-0.5 * u * u));
    }
    first
}
