//! The loop of VHGP-Seq taken apart: a sequence asks for queries and is told their responses, until the samples are spent.
//!
//! Whoever answers may take days over it: nothing but the answers and the random stream shapes what is asked next.
//! Tested on the published 1-D reference case in `tests/physics/design.rs`.

use super::estimate::{probability, share_above};
use super::look_ahead;
use super::quadrature::Quadrature;
use super::sequential::{Design, Input, Plan, Realisation};
use super::targeted::Targeted;
use crate::gp::fit::Fit;
use crate::gp::vhgp::Vhgp;
use crate::numerics::elementary::ln;
use crate::numerics::latin_hypercube::latin_hypercube;
use crate::numerics::normal::from_uniform;
use crate::numerics::random::uniform;
use crate::numerics::sums::{mean, standard_deviation};
use rand_chacha::ChaCha12Rng;

/// A realisation under way.
pub struct Sequence<'a> {
    design: &'a Design,
    input: &'a Input,
    threshold: f64,
    /// What has been told, and the estimates so far.
    pub realisation: Realisation,
    queries: Vec<[f64; 2]>,
    /// What a hypercube asks after them.
    later: Vec<[f64; 2]>,
    fit: Option<Fit>,
    model: Option<Model>,
}

/// A model, and what it sees of the threshold.
struct Model {
    vhgp: Vhgp<2>,
    /// Responses as the model sees them (n).
    y: Vec<f64>,
    /// The parameters of `vhgp` in their vector.
    theta: Vec<f64>,
    /// θ_t as the model sees it.
    threshold: f64,
}

impl<'a> Sequence<'a> {
    /// A sequence that asks for its first n_init points; `threshold` is θ_t in units of the response.
    pub fn new(design: &'a Design, input: &'a Input, threshold: f64, stream: &mut ChaCha12Rng) -> Self {
        let mut queries = match design.plan {
            Plan::Doubt { least_density, .. } => hypercube(design.initial, least_density, input, stream),
            Plan::LookAhead { .. } => from_density(design.initial, &input.quadrature, stream),
            Plan::Hypercube { least_density } => hypercube(design.total, least_density, input, stream),
        };
        let later = queries.split_off(queries.len().min(design.initial as usize));
        Self {
            design,
            input,
            threshold,
            realisation: Realisation::default(),
            queries,
            later,
            fit: None,
            model: None,
        }
    }

    /// The points asked for; none once the samples are spent.
    pub fn queries(&self) -> &[[f64; 2]] {
        &self.queries
    }

    /// Takes the answers, each the point where the response was taken and the response, fits, estimates and asks anew.
    ///
    /// Fewer answers than queries mean that no response is left: nothing is fitted and nothing asked any more.
    pub fn tell(&mut self, answers: &[([f64; 2], f64)], stream: &mut ChaCha12Rng) {
        let complete = answers.len() == self.queries.len();
        self.queries.clear();
        for (x, y) in answers {
            self.realisation.points.push(*x);
            self.realisation.y.push(*y);
        }
        if !complete {
            return;
        }
        self.fit(stream);
        self.record();
        let left = self.design.total as usize - self.realisation.points.len();
        let wanted = left.min(self.design.batch as usize);
        if wanted > 0 {
            self.queries = self.next(wanted, stream);
        }
    }

    /// The next batch.
    fn next(&mut self, wanted: usize, stream: &mut ChaCha12Rng) -> Vec<[f64; 2]> {
        let mut around = |x: [f64; 2], tau: [f64; 2]| [0, 1].map(|d| x[d] + tau[d] * from_uniform(uniform(stream)));
        match self.design.plan {
            Plan::Doubt { tau, .. } => {
                let x_star = self.doubtful();
                (0..wanted).map(|_| around(x_star, tau)).collect()
            }
            Plan::LookAhead { tau } => self.telling(wanted).into_iter().map(|x| around(x, tau)).collect(),
            Plan::Hypercube { .. } => self.later.drain(..wanted.min(self.later.len())).collect(),
        }
    }

    /// The standard deviation of the estimate, of first order; `None` without a model.
    ///
    /// A guess from below: the model's own knows what the samples leave open of f and g, not whether the normal law holds;
    /// a targeted estimate adds how the samples scatter about it, and is still up to half too small where it holds badly.
    pub fn deviation(&self) -> Option<f64> {
        let (m, quadrature) = (self.model.as_ref()?, &self.input.quadrature);
        if let Some(targeted) = self.targeted() {
            return Some(targeted.deviation(&m.vhgp, quadrature, m.threshold));
        }
        let variance = look_ahead::variance(&m.vhgp, quadrature, m.threshold, |_| 1.0);
        // Rounding may make a variance of nothing negative.
        (variance >= 0.0).then(|| variance.sqrt())
    }

    /// How the samples correct the model, if the design wants it and there is a model.
    fn targeted(&self) -> Option<Targeted> {
        let (m, deviation) = (self.model.as_ref()?, self.design.log_odds_deviation);
        // A fit that failed leaves a model of fewer samples.
        let modelled = self.realisation.y[..m.y.len()].iter();
        let above: Vec<bool> = modelled.map(|y| *y > self.threshold).collect();
        (deviation > 0.0)
            .then(|| Targeted::new(&m.vhgp, (&m.y, &above), &self.input.quadrature, m.threshold, deviation))
    }

    /// Fits all samples; a failure is counted and leaves the model before in place.
    fn fit(&mut self, stream: &mut ChaCha12Rng) {
        let (cap, fitting) = (self.design.cap, &self.design.fit);
        let seen = |y: &f64| self.design.scale.of(if *y > cap { cap } else { *y });
        let mut y: Vec<f64> = self.realisation.y.iter().map(seen).collect();
        let (mut centre, mut scale) = (0.0, 1.0);
        if self.design.standardise {
            centre = mean(&y);
            let deviation = standard_deviation(&y);
            scale = if deviation > 0.0 { deviation } else { 1.0 };
        }
        for value in &mut y {
            *value = (*value - centre) / scale;
        }
        let x = &self.realisation.points;
        let Some(fit) = fitting.fit(x, &y, self.fit.as_ref(), stream) else {
            self.realisation.failed_fits += 1;
            return;
        };
        if let Some(vhgp) = Vhgp::new(x, &y, &fit.theta, fitting.jitter) {
            let theta = fit.theta.clone();
            self.model = Some(Model {
                vhgp,
                y,
                theta,
                threshold: (self.design.scale.of(self.threshold) - centre) / scale,
            });
        }
        self.realisation.evaluations += fit.evaluations;
        self.realisation.unconverged_fits += u32::from(!fit.converged);
        self.fit = Some(fit);
    }

    /// Records P_est; without any model the share of exceedances.
    fn record(&mut self) {
        let quadrature = &self.input.quadrature;
        let estimate = match (&self.model, self.targeted()) {
            (None, _) => share_above(&self.realisation.y, self.threshold),
            (Some(m), Some(targeted)) => targeted.probability(&m.vhgp, quadrature, m.threshold),
            (Some(m), None) => probability(&m.vhgp, quadrature, m.threshold),
        };
        self.realisation.n_samples.push(self.realisation.points.len() as u32);
        self.realisation.estimate.push(estimate);
    }

    /// The candidate with the largest (Q1); without any model the densest.
    fn doubtful(&self) -> [f64; 2] {
        let candidates = &self.input.candidates;
        let model = self.model.as_ref();
        let query = model.and_then(|m| candidates.best(&m.vhgp, m.threshold));
        query.or_else(|| candidates.densest()).unwrap_or(self.input.grid.lower)
    }

    /// `wanted` nodes, each chosen as if the ones before had answered with the model's mean.
    fn telling(&self, wanted: usize) -> Vec<[f64; 2]> {
        let mut queries = Vec::with_capacity(wanted);
        let Some(m) = &self.model else {
            return vec![self.input.candidates.densest().unwrap_or(self.input.grid.lower); wanted];
        };
        let threshold = m.threshold;
        let (mut vhgp, mut y, mut theta) = (m.vhgp.clone(), m.y.clone(), m.theta.clone());
        loop {
            let query = look_ahead::best(&vhgp, &self.input.quadrature, threshold).unwrap_or(self.input.grid.lower);
            queries.push(query);
            if queries.len() == wanted {
                return queries;
            }
            let mut x = vhgp.x.clone();
            theta.insert(x.len(), ln(0.5));
            x.push(query);
            y.push(vhgp.predict(&[query])[0].f_m);
            if let Some(next) = Vhgp::new(&x, &y, &theta, self.design.fit.jitter) {
                vhgp = next;
            }
        }
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
