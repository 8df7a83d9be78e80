//! (Q1): where the next sample lowers the doubt about the exceedance probability most.
//!
//! ```text
//! a(x) = p(x) sd_pop{ Q(f_m ± √2 s_f, g_m), Q(f_m, g_m ± √2 s_g) }
//! ```
//! the standard deviation of the local exceedance probability by a 4-point spherical cubature over the posteriors of f
//! and g (standard deviations s_f, s_g). Tested against a whole scan in `tests/physics/design.rs`.

use super::estimate::exceedance;
use crate::gp::vhgp::{Prediction, Vhgp};

/// Candidates predicted at a time, between looks at the bound.
const CHUNK: usize = 64;

/// (Q1) without p(x): at most ½, the standard deviation of two zeros and two ones.
pub fn doubt(p: &Prediction, threshold: f64) -> f64 {
    let (s_f, s_g) = ((2.0 * p.f_v).sqrt(), (2.0 * p.g_v).sqrt());
    let q = [
        exceedance(p.f_m + s_f, p.g_m, threshold),
        exceedance(p.f_m - s_f, p.g_m, threshold),
        exceedance(p.f_m, p.g_m + s_g, threshold),
        exceedance(p.f_m, p.g_m - s_g, threshold),
    ];
    let mean = (q[0] + q[1] + q[2] + q[3]) / 4.0;
    let mut squares = 0.0;
    for value in q {
        squares += (value - mean) * (value - mean);
    }
    (squares / 4.0).sqrt()
}

/// The points an acquisition chooses from, densest first.
#[derive(Clone, Debug)]
pub struct Candidates {
    points: Vec<[f64; 2]>,
    density: Vec<f64>,
}

impl Candidates {
    /// The points with p > 0, sorted by falling density, ties in the order given.
    pub fn new(points: &[[f64; 2]], density: &[f64]) -> Self {
        let mut order: Vec<usize> = (0..points.len()).filter(|i| density[*i] > 0.0).collect();
        order.sort_by(|a, b| density[*b].total_cmp(&density[*a]));
        Self {
            points: order.iter().map(|i| points[*i]).collect(),
            density: order.iter().map(|i| density[*i]).collect(),
        }
    }

    /// The densest point, if any.
    pub fn densest(&self) -> Option<[f64; 2]> {
        self.points.first().copied()
    }

    /// The candidate with the largest (Q1), the densest on a tie; `None` without candidates.
    ///
    /// Candidates whose density alone, times ½, cannot beat the best are not predicted.
    pub fn best(&self, model: &Vhgp<2>, threshold: f64) -> Option<[f64; 2]> {
        let (mut best, mut largest) = (self.densest(), 0.0);
        for (points, density) in self.points.chunks(CHUNK).zip(self.density.chunks(CHUNK)) {
            if 0.5 * density[0] <= largest {
                break;
            }
            for (i, prediction) in model.predict(points).iter().enumerate() {
                let value = density[i] * doubt(prediction, threshold);
                if value > largest {
                    (best, largest) = (Some(points[i]), value);
                }
            }
        }
        best
    }
}
