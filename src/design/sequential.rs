//! The loop of VHGP-Seq: fit, estimate, query, until the samples are spent.
//!
//! Three plans share it: the paper's, one that looks ahead, and a Latin hypercube laid out beforehand.
//! One realisation uses one random stream, so it does not depend on how many others run or in which order.
//! Tested on the published 1-D reference case in `tests/physics/design.rs`.

use super::acquisition::Candidates;
use super::estimate::{probability, share_above};
use super::input_density::Grid;
use super::look_ahead;
use super::quadrature::Quadrature;
use crate::gp::fit::{Fit, Fitting};
use crate::gp::vhgp::Vhgp;
use crate::numerics::elementary::ln;
use crate::numerics::latin_hypercube::latin_hypercube;
use crate::numerics::normal::from_uniform;
use crate::numerics::random::uniform;
use crate::numerics::sums::{mean, standard_deviation};
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
    /// Whether the model sees (y - mean)/sd of the current samples, or y itself.
    pub standardise: bool,
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
    grid: Grid,
    /// p at the grid points, in any unit.
    density: Vec<f64>,
    candidates: Candidates,
    quadrature: Quadrature,
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
    let mut state = State::default();
    // 1. The first n_init points, or all of them.
    let mut queries = match design.plan {
        Plan::Doubt { least_density, .. } => hypercube(design.initial, least_density, input, stream),
        Plan::LookAhead { .. } => from_density(design.initial, &input.quadrature, stream),
        Plan::Hypercube { least_density } => hypercube(design.total, least_density, input, stream),
    };
    let mut wanted = design.initial as usize;
    loop {
        // 2. Evaluate and append.
        let later = queries.split_off(wanted.min(queries.len()));
        for query in queries {
            let Some((x, y)) = respond(query, stream) else {
                return state.result;
            };
            state.result.points.push(x);
            state.result.y.push(y);
        }
        // 3. Fit and record P_est.
        state.fit(design, stream);
        state.record(input, threshold);
        wanted = (design.total as usize - state.result.points.len()).min(design.batch as usize);
        if wanted == 0 {
            return state.result;
        }
        // 4. The next batch.
        queries = match design.plan {
            Plan::Doubt { tau, .. } => {
                let x_star = state.doubtful(input, threshold);
                let around = |_| [0, 1].map(|d| x_star[d] + tau[d] * from_uniform(uniform(stream)));
                (0..wanted).map(around).collect()
            }
            Plan::LookAhead { tau } => {
                let around =
                    |x: [f64; 2], stream: &mut _| [0, 1].map(|d| x[d] + tau[d] * from_uniform(uniform(stream)));
                let told = state.telling(design, input, threshold, wanted);
                told.into_iter().map(|x| around(x, stream)).collect()
            }
            Plan::Hypercube { .. } => later,
        };
    }
}

/// The largest hypercube that the initial design is picked from, in multiples of n_init.
const MOST_QUERIES: usize = 64;

/// Points of a Latin hypercube where p exceeds `least_density` of its maximum: of a hypercube just large enough, the
/// first `wanted` such points.
fn hypercube(wanted: u32, least_density: f64, input: &Input, stream: &mut ChaCha12Rng) -> Vec<[f64; 2]> {
    let wanted = wanted as usize;
    let mut largest = 0.0;
    for p in &input.density {
        largest = if *p > largest { *p } else { largest };
    }
    let mut size = wanted;
    let mut found = Vec::new();
    while largest > 0.0 && size <= MOST_QUERIES * wanted {
        let mut points = latin_hypercube(size, input.grid.lower, input.grid.upper, stream);
        points.retain(|x| input.density[input.grid.nearest(x)] > least_density * largest);
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

/// Points drawn from the input's distribution: one in each of `wanted` equal shares of the nodes' weight.
fn from_density(wanted: u32, quadrature: &Quadrature, stream: &mut ChaCha12Rng) -> Vec<[f64; 2]> {
    let (mut points, mut below) = (Vec::with_capacity(wanted as usize), 0.0);
    let mut target = uniform(stream) / f64::from(wanted);
    for &i in &quadrature.support {
        below += quadrature.weight[i];
        while below > target && points.len() < wanted as usize {
            points.push(quadrature.axes.node(i));
            target = (points.len() as f64 + uniform(stream)) / f64::from(wanted);
        }
    }
    // Rounding may leave the last share without a node.
    let last = quadrature.support.last().map_or([0.0; 2], |i| quadrature.axes.node(*i));
    points.resize(wanted as usize, last);
    points
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
    /// Scaled responses (n).
    y: Vec<f64>,
    /// The parameters of `vhgp` in their vector.
    theta: Vec<f64>,
    centre: f64,
    scale: f64,
}

impl State {
    /// Fits all samples; a failure is counted and leaves the model before in place.
    fn fit(&mut self, design: &Design, stream: &mut ChaCha12Rng) {
        let cap = design.cap;
        let mut y: Vec<f64> = self.result.y.iter().map(|y| if *y > cap { cap } else { *y }).collect();
        let (mut centre, mut scale) = (0.0, 1.0);
        if design.standardise {
            centre = mean(&y);
            let deviation = standard_deviation(&y);
            scale = if deviation > 0.0 { deviation } else { 1.0 };
        }
        for value in &mut y {
            *value = (*value - centre) / scale;
        }
        let x = &self.result.points;
        let fit = design.fit.fit(x, &y, self.fit.as_ref(), stream);
        let Some(fit) = fit else {
            self.result.failed_fits += 1;
            return;
        };
        self.result.evaluations += fit.evaluations;
        self.result.unconverged_fits += u32::from(!fit.converged);
        if let Some(vhgp) = Vhgp::new(x, &y, &fit.theta, design.fit.jitter) {
            let theta = fit.theta.clone();
            self.model = Some(Model {
                vhgp,
                y,
                theta,
                centre,
                scale,
            });
        }
        self.fit = Some(fit);
    }

    /// Records P_est; without any model the share of exceedances.
    fn record(&mut self, input: &Input, threshold: f64) {
        let estimate = self.model.as_ref().map_or_else(
            || share_above(&self.result.y, threshold),
            |m| probability(&m.vhgp, &input.quadrature, (threshold - m.centre) / m.scale),
        );
        self.result.n_samples.push(self.result.points.len() as u32);
        self.result.estimate.push(estimate);
    }

    /// The candidate with the largest (Q1); without any model the densest.
    fn doubtful(&self, input: &Input, threshold: f64) -> [f64; 2] {
        let model = self.model.as_ref();
        let query = model.and_then(|m| input.candidates.best(&m.vhgp, (threshold - m.centre) / m.scale));
        query.or_else(|| input.candidates.densest()).unwrap_or(input.grid.lower)
    }

    /// `wanted` nodes, each chosen as if the ones before had answered with the model's mean.
    fn telling(&self, design: &Design, input: &Input, threshold: f64, wanted: usize) -> Vec<[f64; 2]> {
        let mut queries = Vec::with_capacity(wanted);
        let Some(m) = &self.model else {
            return vec![input.candidates.densest().unwrap_or(input.grid.lower); wanted];
        };
        let threshold = (threshold - m.centre) / m.scale;
        let (mut vhgp, mut y, mut theta) = (m.vhgp.clone(), m.y.clone(), m.theta.clone());
        loop {
            let query = look_ahead::best(&vhgp, &input.quadrature, threshold).unwrap_or(input.grid.lower);
            queries.push(query);
            if queries.len() == wanted {
                return queries;
            }
            let mut x = vhgp.x.clone();
            theta.insert(x.len(), ln(0.5));
            x.push(query);
            y.push(vhgp.predict(&[query])[0].f_m);
            if let Some(next) = Vhgp::new(&x, &y, &theta, design.fit.jitter) {
                vhgp = next;
            }
        }
    }
}
