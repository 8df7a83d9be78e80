//! A response from a pool of recorded inputs: one of the k nearest that are still unused, which moves the sample there.
//!
//! Distances are scaled by the standard deviation of each coordinate over the pool. The inputs lie sorted into cells of
//! about eight; rings of cells around a query are searched until no nearer input can follow. Tested against sorting in
//! `tests/physics/design.rs`.

use crate::numerics::random::below;
use crate::numerics::sums::standard_deviation;
use rand_chacha::ChaCha12Rng;

/// Inputs per cell, on average.
const CROWD: usize = 8;

/// Recorded inputs, shared by all realisations.
#[derive(Clone, Debug)]
pub struct Pool {
    points: Vec<[f64; 2]>,
    inverse_scale: [f64; 2],
    /// Least scaled coordinates.
    lower: [f64; 2],
    /// Side of a cell, scaled.
    side: f64,
    /// Cells along each coordinate.
    cells: [usize; 2],
    /// Where each cell begins in `members`, and the end of the last.
    first: Vec<u32>,
    /// Indices of the inputs, cell by cell, ascending within a cell.
    members: Vec<u32>,
}

/// The inputs that one realisation has drawn, in order of the draws.
#[derive(Clone, Debug, Default)]
pub struct Used {
    /// Indices into the pool.
    pub indices: Vec<u32>,
}

impl Pool {
    /// A pool of the given inputs (N).
    pub fn new(points: &[[f64; 2]]) -> Self {
        let inverse_scale = [0, 1].map(|d| {
            let coordinate: Vec<f64> = points.iter().map(|x| x[d]).collect();
            let deviation = standard_deviation(&coordinate);
            if deviation > 0.0 { 1.0 / deviation } else { 1.0 }
        });
        let (mut lower, mut upper) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        for x in points {
            for d in 0..2 {
                let v = x[d] * inverse_scale[d];
                lower[d] = if v < lower[d] { v } else { lower[d] };
                upper[d] = if v > upper[d] { v } else { upper[d] };
            }
        }
        // As many cells as groups of CROWD if the inputs filled their box; a flat box is one cell thick.
        let wanted = (points.len() / CROWD + 1) as f64;
        let extent = [0, 1].map(|d| if upper[d] > lower[d] { upper[d] - lower[d] } else { 0.0 });
        let side = (extent[0] * extent[1] / wanted).sqrt();
        let side = if side > 0.0 {
            side
        } else {
            (extent[0] + extent[1]) / wanted
        };
        let side = if side > 0.0 { side } else { 1.0 };
        let cells = extent.map(|extent| (extent / side) as usize + 1);
        let mut pool = Self {
            points: points.to_vec(),
            inverse_scale,
            lower: lower.map(|v| if v.is_finite() { v } else { 0.0 }),
            side,
            cells,
            first: vec![0; cells[0] * cells[1] + 1],
            members: vec![0; points.len()],
        };
        pool.sort();
        pool
    }

    /// Counts, then places, the inputs of every cell.
    fn sort(&mut self) {
        let cell: Vec<usize> = self.points.iter().map(|x| self.index(self.cell(x))).collect();
        for c in &cell {
            self.first[c + 1] += 1;
        }
        for c in 1..self.first.len() {
            self.first[c] += self.first[c - 1];
        }
        let mut next = self.first.clone();
        for (i, c) in cell.iter().enumerate() {
            self.members[next[*c] as usize] = i as u32;
            next[*c] += 1;
        }
    }

    /// The cell of a point; points beyond the box belong to its edge.
    fn cell(&self, x: &[f64; 2]) -> [usize; 2] {
        // A cast to an unsigned integer saturates.
        [0, 1].map(|d| (((x[d] * self.inverse_scale[d] - self.lower[d]) / self.side) as usize).min(self.cells[d] - 1))
    }

    fn index(&self, cell: [usize; 2]) -> usize {
        cell[0] + cell[1] * self.cells[0]
    }

    /// The input with this index.
    pub fn point(&self, index: u32) -> [f64; 2] {
        self.points[index as usize]
    }

    /// Draws one of the `neighbours` unused inputs nearest to x, uniformly, and marks it used; `None` once all are.
    pub fn draw(&self, x: &[f64; 2], neighbours: u32, used: &mut Used, stream: &mut ChaCha12Rng) -> Option<u32> {
        let nearest = self.nearest(x, neighbours as usize, used);
        if nearest.is_empty() {
            return None;
        }
        let index = nearest[below(stream, nearest.len())].1;
        used.indices.push(index);
        Some(index)
    }

    /// (squared distance, index) of the unused inputs nearest to x, nearest first, the smaller index first on a tie.
    pub fn nearest(&self, x: &[f64; 2], neighbours: usize, used: &Used) -> Vec<(f64, u32)> {
        let mut nearest: Vec<(f64, u32)> = Vec::with_capacity(neighbours + 1);
        let centre = self.cell(x);
        for ring in 0..self.cells[0] + self.cells[1] {
            // Inputs of this ring lie at least so far: a query beyond the box is only farther.
            let distance = if ring > 1 { (ring - 1) as f64 * self.side } else { 0.0 };
            let full = nearest.len() == neighbours;
            if full
                && nearest
                    .last()
                    .is_none_or(|(farthest, _)| distance * distance > *farthest)
            {
                break;
            }
            self.search(x, centre, ring, neighbours, used, &mut nearest);
        }
        nearest
    }

    /// Takes in the inputs of the cells at Chebyshev distance `ring` from `centre`.
    fn search(
        &self,
        x: &[f64; 2],
        centre: [usize; 2],
        ring: usize,
        neighbours: usize,
        used: &Used,
        nearest: &mut Vec<(f64, u32)>,
    ) {
        let low = centre.map(|c| c.saturating_sub(ring));
        let high = [0, 1].map(|d| (centre[d] + ring).min(self.cells[d] - 1));
        for row in low[1]..=high[1] {
            let whole = row.abs_diff(centre[1]) == ring;
            for column in low[0]..=high[0] {
                if !whole && column.abs_diff(centre[0]) != ring {
                    continue;
                }
                let cell = self.index([column, row]);
                for index in &self.members[self.first[cell] as usize..self.first[cell + 1] as usize] {
                    let point = self.points[*index as usize];
                    let u = (point[0] - x[0]) * self.inverse_scale[0];
                    let v = (point[1] - x[1]) * self.inverse_scale[1];
                    let entry = (u * u + v * v, *index);
                    let before = |other: &(f64, u32)| (other.0, other.1) <= entry;
                    if nearest.len() == neighbours && nearest.last().is_some_and(before) {
                        continue;
                    }
                    if !used.indices.contains(index) {
                        nearest.insert(nearest.partition_point(before), entry);
                        nearest.truncate(neighbours);
                    }
                }
            }
        }
    }
}
