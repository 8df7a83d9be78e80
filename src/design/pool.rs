//! A response from a pool of recorded inputs: one of the k nearest that are still unused, which moves the sample there.
//!
//! Distances are scaled by the standard deviation of each coordinate over the pool. A plain scan: 200,000 points take
//! about 0.2 ms. Tested against sorting in `tests/physics/design.rs`.

use crate::numerics::random::below;
use crate::numerics::sums::standard_deviation;
use rand_chacha::ChaCha12Rng;

/// Recorded inputs, shared by all realisations.
#[derive(Clone, Debug)]
pub struct Pool {
    points: Vec<[f64; 2]>,
    inverse_scale: [f64; 2],
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
        Self {
            points: points.to_vec(),
            inverse_scale,
        }
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
        let mut farthest = f64::INFINITY;
        for (index, point) in self.points.iter().enumerate() {
            let u = (point[0] - x[0]) * self.inverse_scale[0];
            let v = (point[1] - x[1]) * self.inverse_scale[1];
            let distance = u * u + v * v;
            if distance < farthest && !used.indices.contains(&(index as u32)) {
                let place = nearest.partition_point(|(d, _)| *d <= distance);
                nearest.insert(place, (distance, index as u32));
                nearest.truncate(neighbours);
                if nearest.len() == neighbours {
                    farthest = nearest[neighbours - 1].0;
                }
            }
        }
        nearest
    }
}
