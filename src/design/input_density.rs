//! p(x): the density of the inputs on a grid of candidates, by Gaussian kernels.
//!
//! ```text
//! p(x) = 1/N Σ_i Π_d exp(-(x_d - x_id)²/(2 b_d²)) / (√(2π) b_d)
//! ```
//! Kernels end at 5 bandwidths (relative weight 4e-6). Tested against the whole sum in `tests/physics/design.rs`.

use crate::numerics::elementary::exp;

/// Half-width of a kernel, in bandwidths.
const REACH: f64 = 5.0;
/// 1/√(2π).
const DENSITY_AT_ZERO: f64 = 0.398_942_280_401_432_7;

/// A regular grid over a box, both ends included; the second coordinate is the outer one.
#[derive(Clone, Debug, PartialEq)]
pub struct Grid {
    /// Least coordinates.
    pub lower: [f64; 2],
    /// Largest coordinates.
    pub upper: [f64; 2],
    /// Points along each coordinate.
    pub size: [u32; 2],
}

impl Grid {
    /// Distance of neighbours along d; 0 for a single point.
    fn spacing(&self, d: usize) -> f64 {
        if self.size[d] < 2 {
            return 0.0;
        }
        (self.upper[d] - self.lower[d]) / f64::from(self.size[d] - 1)
    }

    /// All points: index = i_0 + i_1 size_0.
    pub fn points(&self) -> Vec<[f64; 2]> {
        let at = |d: usize, i: u32| self.lower[d] + f64::from(i) * self.spacing(d);
        (0..self.size[1])
            .flat_map(|i1| (0..self.size[0]).map(move |i0| [at(0, i0), at(1, i1)]))
            .collect()
    }

    /// The index of the grid point nearest to x; points outside the box belong to its edge.
    pub fn nearest(&self, x: &[f64; 2]) -> usize {
        let mut index = [0; 2];
        for d in 0..2 {
            let spacing = self.spacing(d);
            if spacing > 0.0 {
                let steps = ((x[d] - self.lower[d]) / spacing).round();
                index[d] = (steps as usize).min(self.size[d] as usize - 1);
            }
        }
        index[0] + index[1] * self.size[0] as usize
    }

    /// p at all grid points from the inputs' own points; `bandwidth` in the units of each coordinate.
    pub fn density(&self, inputs: &[[f64; 2]], bandwidth: [f64; 2]) -> Vec<f64> {
        let width = self.size[0] as usize;
        let mut density = vec![0.0; width * self.size[1] as usize];
        let mut weights = [Vec::new(), Vec::new()];
        for x in inputs {
            let first = [0, 1].map(|d| self.kernel(x[d], d, bandwidth[d], &mut weights[d]));
            for (row, outer) in weights[1].iter().enumerate() {
                let start = (first[1] + row) * width + first[0];
                for (p, inner) in density[start..].iter_mut().zip(&weights[0]) {
                    *p += outer * inner;
                }
            }
        }
        for p in &mut density {
            *p /= inputs.len() as f64;
        }
        density
    }

    /// The kernel of one coordinate at the grid values it reaches; returns the index of the first.
    fn kernel(&self, x: f64, d: usize, bandwidth: f64, weights: &mut Vec<f64>) -> usize {
        weights.clear();
        let spacing = self.spacing(d);
        let step = if spacing > 0.0 { spacing } else { 1.0 };
        // A cast to an unsigned integer saturates, so points far outside reach nothing or the edge alone.
        let from = ((x - REACH * bandwidth - self.lower[d]) / step).ceil() as usize;
        let beyond = ((x + REACH * bandwidth - self.lower[d]) / step).floor() + 1.0;
        let to = (beyond as usize).min(self.size[d] as usize);
        for i in from..to {
            let u = (self.lower[d] + i as f64 * spacing - x) / bandwidth;
            weights.push(DENSITY_AT_ZERO * exp(-0.5 * u * u) / bandwidth);
        }
        from.min(self.size[d] as usize - 1)
    }
}
