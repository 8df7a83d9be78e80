//! VHGP-Seq with the responses at hand: how a realisation is laid out, what it knows of its input, and what comes out.
//!
//! Three plans share the loop: the paper's, one that looks ahead, and a Latin hypercube laid out beforehand.
//! One realisation uses one random stream, so it does not depend on how many others run or in which order.
//! Tested on the published 1-D reference case in `tests/physics/design.rs`.

use super::acquisition::Candidates;
use super::input_density::Grid;
use super::quadrature::Quadrature;
use super::response_scale::ResponseScale;
use super::sequence::Sequence;
use crate::gp::fit::Fitting;
use crate::numerics::invariant;
use rand_chacha::ChaCha12Rng;
use serde::{Deserialize, Serialize};

/// How a realisation is laid out.
#[derive(Clone, Debug, PartialEq)]
pub struct Design {
    /// First samples, n_init.
    pub initial: u32,
    /// Samples between two fits.
    pub batch: u32,
    /// Samples at the end.
    pub total: u32,
    /// Largest response that enters the model.
    pub cap: f64,
    /// The scale on which the model is normal.
    pub scale: ResponseScale,
    /// Whether the model sees (y - mean)/sd of the current samples, or y itself, on its scale.
    pub standardise: bool,
    /// s of the targeted estimate; 0 for the model's own, (Q2).
    pub log_odds_deviation: f64,
    /// How the model is fitted.
    pub fit: Fitting,
    /// Where samples are taken.
    pub plan: Plan,
}

/// Where samples are taken.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Plan {
    /// The paper's: a Latin hypercube where p exceeds the share `least_density` of its maximum, then batches about the
    /// largest (Q1) with standard deviation `tau`.
    Doubt {
        /// Least p of the first samples, relative to its maximum.
        least_density: f64,
        /// τ.
        tau: [f64; 2],
    },
    /// The first samples from the input's distribution, then each where it lowers the variance of the estimate most, by
    /// standard deviation `tau` beside it: what is best under the model alone puts all samples in a few places and
    /// cannot see between them.
    LookAhead {
        /// τ.
        tau: [f64; 2],
    },
    /// All samples from one Latin hypercube where p exceeds the share `least_density` of its maximum, in random order.
    Hypercube {
        /// Least p, relative to its maximum.
        least_density: f64,
    },
}

/// What the design knows about its input: the same for all realisations of a case.
#[derive(Clone, Debug)]
pub struct Input {
    pub(super) grid: Grid,
    /// p at the grid points, in any unit.
    pub(super) density: Vec<f64>,
    pub(super) candidates: Candidates,
    pub(super) quadrature: Quadrature,
}

impl Input {
    /// An input with density `density` at the points of `grid`, and a quadrature over all of it.
    pub fn new(grid: Grid, density: Vec<f64>, quadrature: Quadrature) -> Self {
        let candidates = Candidates::new(&grid.points(), &density);
        Self {
            grid,
            density,
            candidates,
            quadrature,
        }
    }

    /// An input whose candidates are the nodes of its quadrature.
    pub fn on_nodes(quadrature: Quadrature) -> Self {
        let [first, second] = [&quadrature.axes.first, &quadrature.axes.second];
        let grid = Grid {
            lower: [first[0], second[0]],
            upper: [first[first.len() - 1], second[second.len() - 1]],
            size: [first.len() as u32, second.len() as u32],
        };
        Self::new(grid, quadrature.weight.clone(), quadrature)
    }
}

/// One realisation of a sequential design.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Realisation {
    /// Numbers of samples at which the model was fitted.
    pub n_samples: Vec<u32>,
    /// P_est at each of them.
    pub estimate: Vec<f64>,
    /// Samples, in order; (L/T_p, A/H_s) in the ship case.
    pub points: Vec<[f64; 2]>,
    /// Their responses, before the cap.
    pub y: Vec<f64>,
    /// Fits that failed from every start; the model before stayed in use.
    pub failed_fits: u32,
    /// Fits whose best start met no tolerance within its iterations.
    pub unconverged_fits: u32,
    /// Evaluations of the bound.
    pub evaluations: u32,
}

impl Realisation {
    /// Checks that the numbers of samples ascend to the number of points, each with an estimate, every point with its
    /// response.
    ///
    /// # Errors
    /// The first thing that is not so.
    pub fn check(&self, total: u32) -> Result<(), String> {
        invariant::ascending("n_samples", &self.n_samples)?;
        invariant::length("estimate", &self.estimate, self.n_samples.len())?;
        // Rounding may leave a quadrature a little above 1.
        invariant::all_within("estimate", &self.estimate, &(-1e-9..=1.0 + 1e-9))?;
        invariant::length("y", &self.y, self.points.len())?;
        let most = self.points.len().min(total as usize) as u32;
        let reached = self.n_samples.last().is_none_or(|n| *n <= most);
        invariant::holds(
            "n_samples",
            reached,
            &format!("numbers up to {most}, the samples there are"),
        )?;
        invariant::holds(
            "points",
            self.points.len() <= total as usize,
            &format!("at most {total} samples"),
        )
    }
}

/// Runs one realisation.
///
/// `respond(x, stream)` answers a query with the point where the response was taken and the response, or `None` if no
/// response is left, which ends the realisation. `threshold` is θ_t in units of the response.
pub fn sequential(
    design: &Design,
    input: &Input,
    threshold: f64,
    mut respond: impl FnMut([f64; 2], &mut ChaCha12Rng) -> Option<([f64; 2], f64)>,
    stream: &mut ChaCha12Rng,
) -> Realisation {
    let mut sequence = Sequence::new(design, input, threshold, stream);
    while !sequence.queries().is_empty() {
        let wanted = sequence.queries().len();
        let answers = sequence.queries().iter().map_while(|query| respond(*query, stream));
        let answers: Vec<([f64; 2], f64)> = answers.collect();
        sequence.tell(&answers, stream);
        if answers.len() < wanted {
            break;
        }
    }
    sequence.realisation
}
