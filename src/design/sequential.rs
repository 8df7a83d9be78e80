//! The loop of VHGP-Seq: fit, estimate, query where the doubt is largest, until the samples are spent.
//!
//! One realisation uses one random stream, so it does not depend on how many others run or in which order.
//! Tested on the published 1-D reference case in `tests/physics/design.rs`.

use super::acquisition::Candidates;
use super::estimate::{probability, share_above};
use super::input_density::Grid;
use super::settings::VhgpSeq;
use crate::gp::fit::Fit;
use crate::gp::vhgp::Vhgp;
use crate::numerics::latin_hypercube::latin_hypercube;
use crate::numerics::normal::from_uniform;
use crate::numerics::random::uniform;
use crate::numerics::sums::{mean, standard_deviation};
use rand_chacha::ChaCha12Rng;
use serde::{Deserialize, Serialize};

/// What the design knows about its input: the same for all realisations of a case.
#[derive(Clone, Debug)]
pub struct Input {
    grid: Grid,
    /// p at the grid points.
    density: Vec<f64>,
    candidates: Candidates,
    /// The fixed Monte-Carlo set of (Q2).
    monte_carlo: Vec<[f64; 2]>,
}

impl Input {
    /// An input with density `density` at the points of `grid`, and a fixed sample `monte_carlo` of it.
    pub fn new(grid: Grid, density: Vec<f64>, monte_carlo: Vec<[f64; 2]>) -> Self {
        let candidates = Candidates::new(&grid.points(), &density);
        Self {
            grid,
            density,
            candidates,
            monte_carlo,
        }
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

/// Runs one realisation.
///
/// `respond(x, stream)` answers a query with the point where the response was taken and the response, or `None` if no
/// response is left, which ends the realisation. `threshold` is θ_t in units of the response.
pub fn sequential(
    settings: &VhgpSeq,
    input: &Input,
    threshold: f64,
    mut respond: impl FnMut([f64; 2], &mut ChaCha12Rng) -> Option<([f64; 2], f64)>,
    stream: &mut ChaCha12Rng,
) -> Realisation {
    let mut state = State::default();
    // 1. Latin hypercube of n_init points.
    let mut queries = initial(settings, input, stream);
    loop {
        // 2. Evaluate and append.
        for query in queries {
            let Some((x, y)) = respond(query, stream) else {
                return state.result;
            };
            state.result.points.push(x);
            state.result.y.push(y);
        }
        // 3. Fit and record P_est.
        state.fit(settings, stream);
        let x_star = state.record(input, threshold);
        let left = settings.total as usize - state.result.points.len();
        if left == 0 {
            return state.result;
        }
        // 4. A batch about the largest acquisition.
        queries = (0..left.min(settings.batch as usize))
            .map(|_| [0, 1].map(|d| x_star[d] + settings.tau[d] * from_uniform(uniform(stream))))
            .collect();
    }
}

/// The largest hypercube that the initial design is picked from, in multiples of n_init.
const MOST_QUERIES: usize = 64;

/// n_init points of a Latin hypercube where p exceeds `least_density` of its maximum: of a hypercube just large enough,
/// the first n_init such points.
fn initial(settings: &VhgpSeq, input: &Input, stream: &mut ChaCha12Rng) -> Vec<[f64; 2]> {
    let wanted = settings.initial as usize;
    let mut largest = 0.0;
    for p in &input.density {
        largest = if *p > largest { *p } else { largest };
    }
    let mut size = wanted;
    let mut found = Vec::new();
    while largest > 0.0 && size <= MOST_QUERIES * wanted {
        let mut points = latin_hypercube(size, input.grid.lower, input.grid.upper, stream);
        points.retain(|x| input.density[input.grid.nearest(x)] > settings.least_density * largest);
        if points.len() >= wanted {
            points.truncate(wanted);
            return points;
        }
        size += size.max(8) * (wanted - points.len()) / (points.len() + 4);
        size += 1;
        found = points;
    }
    // Hardly any of the domain holds groups: the rest is asked for anywhere, and answered by the nearest ones.
    let rest = wanted - found.len();
    found.extend(latin_hypercube(rest, input.grid.lower, input.grid.upper, stream));
    found
}

#[derive(Default)]
struct State {
    result: Realisation,
    fit: Option<Fit>,
    model: Option<Model>,
}

/// A model with the scale of its y: scaled y = (y - centre)/scale.
struct Model {
    vhgp: Vhgp<2>,
    centre: f64,
    scale: f64,
}

impl State {
    /// Fits all samples; a failure is counted and leaves the model before in place.
    fn fit(&mut self, settings: &VhgpSeq, stream: &mut ChaCha12Rng) {
        let cap = settings.cap;
        let mut y: Vec<f64> = self.result.y.iter().map(|y| if *y > cap { cap } else { *y }).collect();
        let (mut centre, mut scale) = (0.0, 1.0);
        if settings.standardise {
            centre = mean(&y);
            let deviation = standard_deviation(&y);
            scale = if deviation > 0.0 { deviation } else { 1.0 };
        }
        for value in &mut y {
            *value = (*value - centre) / scale;
        }
        let x = &self.result.points;
        let fit = settings.fit.fit(x, &y, self.fit.as_ref(), stream);
        let Some(fit) = fit else {
            self.result.failed_fits += 1;
            return;
        };
        self.result.evaluations += fit.evaluations;
        self.result.unconverged_fits += u32::from(!fit.converged);
        if let Some(vhgp) = Vhgp::new(x, &y, &fit.theta, settings.fit.jitter) {
            self.model = Some(Model { vhgp, centre, scale });
        }
        self.fit = Some(fit);
    }

    /// Records P_est and returns the next query; without any model the share of exceedances and the densest point.
    fn record(&mut self, input: &Input, threshold: f64) -> [f64; 2] {
        let (estimate, query) = match &self.model {
            None => (share_above(&self.result.y, threshold), None),
            Some(Model { vhgp, centre, scale }) => {
                let threshold = (threshold - centre) / scale;
                (
                    probability(vhgp, &input.monte_carlo, threshold),
                    input.candidates.best(vhgp, threshold),
                )
            }
        };
        self.result.n_samples.push(self.result.points.len() as u32);
        self.result.estimate.push(estimate);
        query.or_else(|| input.candidates.densest()).unwrap_or(input.grid.lower)
    }
}
