//! The `[vhgp_seq]` table: everything the sequential design may be asked to do differently; and the tables of designs that
//! look ahead.
//!
//! `realisations` is a count of the engine and not read here. Tested in `tests/physics/design.rs`.

use super::input_density::Grid;
use super::response_scale::ResponseScale;
use super::sequential::{Design, Plan};
use crate::gp::fit::{Fitting, KernelSpan};
use crate::numerics::domain::{all_within, at_most, count, mesh, non_negative, positive};
use serde::{Deserialize, Serialize};

/// One row of Table 1: a sea and its threshold.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Case {
    /// Name of the `[sea.NAME]` table.
    pub sea: String,
    /// θ_t, rad.
    #[serde(deserialize_with = "positive")]
    pub theta_t: f64,
}

/// The `[vhgp_seq]` table.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct VhgpSeq {
    /// Samples of the Latin hypercube, n_init.
    #[serde(deserialize_with = "count")]
    pub initial: u32,
    /// Samples added between two fits.
    #[serde(deserialize_with = "count")]
    pub batch: u32,
    /// Samples at the end.
    #[serde(deserialize_with = "count")]
    pub total: u32,
    /// k, unused groups near a query from which its response is drawn.
    #[serde(deserialize_with = "count")]
    pub neighbours: u32,
    /// Rows of Table 1.
    pub case: Vec<Case>,
    /// Which value of the ship's epsilon_1 list.
    pub epsilon_1_index: u32,
    /// Box of (L/T_p, A/H_s): \[\[from, to\], \[from, to\]\].
    pub domain: [[f64; 2]; 2],
    /// Candidates along L/T_p and A/H_s.
    pub grid: [u32; 2],
    /// τ, standard deviation of a batch about its query, in (L/T_p, A/H_s).
    pub tau: [f64; 2],
    /// Bandwidth of the kernel density p, in (L/T_p, A/H_s).
    pub bandwidth: [f64; 2],
    /// Initial samples lie where p exceeds this share of its maximum.
    #[serde(deserialize_with = "non_negative")]
    pub least_density: f64,
    /// Nodes of the quadrature of (Q2) along L/T_p and A/H_s.
    pub quadrature: [u32; 2],
    /// Largest response that enters the model, rad; above every theta_t.
    #[serde(deserialize_with = "positive")]
    pub cap: f64,
    /// Whether the model sees (y - mean)/sd of the current samples, or y itself.
    pub standardise: bool,
    /// Kernels, bounds and tolerances of the fit, in units of what the model sees.
    pub fit: Fitting,
}

impl VhgpSeq {
    /// Rules that span several keys.
    ///
    /// # Errors
    /// A sentence naming the key, what was expected and what was found.
    pub fn check(&self) -> Result<(), String> {
        if self.total < self.initial {
            let (total, initial) = (self.total, self.initial);
            return Err(format!("total: expected at least initial = {initial}, found {total}"));
        }
        sizes(self.total, self.batch, self.neighbours)?;
        all_within("domain", self.domain.as_flattened(), -COORDINATE, COORDINATE)?;
        for (d, [from, to]) in self.domain.into_iter().enumerate() {
            if !(from < to && from.is_finite() && to.is_finite()) {
                return Err(format!(
                    "domain[{d}]: expected two ascending numbers, found [{from}, {to}]"
                ));
            }
        }
        for (key, pair) in [("tau", self.tau), ("bandwidth", self.bandwidth)] {
            if !pair.iter().all(|v| v.is_finite() && *v > 0.0) {
                return Err(format!("{key}: expected numbers > 0, found {pair:?}"));
            }
            all_within(key, &pair, 1.0 / COORDINATE, COORDINATE)?;
        }
        mesh("grid", self.grid)?;
        mesh("quadrature", self.quadrature)?;
        if let Some(case) = self.case.iter().find(|case| case.theta_t >= self.cap) {
            let (sea, theta_t, cap) = (&case.sea, case.theta_t, self.cap);
            return Err(format!(
                "cap: expected more than theta_t = {theta_t} of {sea} in `case`, found {cap}"
            ));
        }
        self.fit.check(2)
    }

    /// How the paper's own method is laid out.
    pub fn design(&self) -> Design {
        self.laid_out(Plan::Doubt {
            least_density: self.least_density,
            tau: self.tau,
        })
    }

    /// The same surrogate and number of samples on one Latin hypercube.
    pub fn hypercube(&self) -> Design {
        self.laid_out(Plan::Hypercube {
            least_density: self.least_density,
        })
    }

    fn laid_out(&self, plan: Plan) -> Design {
        Design {
            initial: self.initial,
            batch: self.batch,
            total: self.total,
            cap: self.cap,
            scale: ResponseScale::Identity,
            standardise: self.standardise,
            log_odds_deviation: 0.0,
            fit: self.fit.clone(),
            plan,
        }
    }

    /// The grid of candidates.
    pub fn candidates(&self) -> Grid {
        Grid {
            lower: [self.domain[0][0], self.domain[1][0]],
            upper: [self.domain[0][1], self.domain[1][1]],
            size: self.grid,
        }
    }
}

/// What the designs that look ahead share with the paper's: all that they read of `[vhgp_seq]`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Shared {
    /// Samples at the end.
    #[serde(deserialize_with = "count")]
    pub total: u32,
    /// k, unused groups near a query from which its response is drawn.
    #[serde(deserialize_with = "count")]
    pub neighbours: u32,
    /// Rows of Table 1.
    pub case: Vec<Case>,
    /// Whether the model sees (y - mean)/sd of the current samples, or y itself.
    pub standardise: bool,
    /// Bounds and tolerances of the fit, in units of what the model sees; its kernels are replaced.
    pub fit: Fitting,
}

impl Shared {
    /// Rules that span several keys.
    ///
    /// # Errors
    /// A sentence naming the key, what was expected and what was found.
    pub fn check(&self) -> Result<(), String> {
        sizes(self.total, 1, self.neighbours)?;
        self.fit.check(2)
    }
}

/// Most samples of a realisation; the paper has 120.
const MOST_SAMPLES: u64 = 1000;
/// Most inputs from among which a response is drawn.
const MOST_NEIGHBOURS: u64 = 10_000;
/// Largest magnitude of a coordinate, and of the inverse of a distance between two.
const COORDINATE: f64 = 1e6;

/// Refuses sizes with which a realisation would not end.
fn sizes(total: u32, batch: u32, neighbours: u32) -> Result<(), String> {
    let cube = "the time of every fit grows with the cube of the samples";
    at_most("total", u64::from(total), MOST_SAMPLES, cube)?;
    at_most(
        "batch",
        u64::from(batch),
        MOST_SAMPLES,
        "no realisation has more samples",
    )?;
    let sorted = "every draw sorts so many groups";
    at_most("neighbours", u64::from(neighbours), MOST_NEIGHBOURS, sorted)
}

/// Below, nothing moves; above, nothing holds.
const LOG_ODDS_DEVIATIONS: std::ops::RangeInclusive<f64> = 1e-3..=1e3;

/// The `[vhgp_best]` and `[vhgp_control]` tables: a design that looks ahead, in two coordinates of its own.
///
/// What it shares with the paper's method stands in `[vhgp_seq]` ([`Shared`]).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LookAhead {
    /// First samples, drawn from the density of the groups.
    #[serde(deserialize_with = "count")]
    pub initial: u32,
    /// Samples added between two fits.
    #[serde(deserialize_with = "count")]
    pub batch: u32,
    /// Standard deviation of a sample about the place that tells most, in its coordinates.
    pub tau: [f64; 2],
    /// Nodes of the quadrature along each coordinate.
    pub quadrature: [u32; 2],
    /// Largest response that enters the model, in θ_t; above 1.
    #[serde(deserialize_with = "positive")]
    pub cap: f64,
    /// The scale on which the model is normal.
    pub response_scale: ResponseScale,
    /// By how much, one standard deviation of its logarithm, the samples' odds of exceeding may be off the model's; 0, or
    /// nothing, leaves the estimate to the model.
    #[serde(default, deserialize_with = "non_negative")]
    pub log_odds_deviation: f64,
    /// Kernel of the mean.
    pub k_f: KernelSpan,
    /// Kernel of the log noise variance.
    pub k_g: KernelSpan,
}

impl LookAhead {
    /// How it is laid out for a threshold.
    pub fn design(&self, shared: &Shared, theta_t: f64) -> Design {
        let mut fit = shared.fit.clone();
        (fit.k_f, fit.k_g) = (self.k_f.clone(), self.k_g.clone());
        Design {
            initial: self.initial,
            batch: self.batch,
            total: shared.total,
            cap: self.cap * theta_t,
            scale: self.response_scale,
            standardise: shared.standardise,
            log_odds_deviation: self.log_odds_deviation,
            fit,
            plan: Plan::LookAhead { tau: self.tau },
        }
    }

    /// Rules that span several keys.
    ///
    /// # Errors
    /// A sentence naming the key, what was expected and what was found.
    pub fn check(&self, shared: &Shared) -> Result<(), String> {
        if shared.total < self.initial {
            let (total, initial) = (shared.total, self.initial);
            return Err(format!(
                "initial: expected at most `vhgp_seq.total` = {total}, found {initial}"
            ));
        }
        if !self.tau.iter().all(|v| v.is_finite() && *v >= 0.0) {
            return Err(format!("tau: expected numbers >= 0, found {:?}", self.tau));
        }
        all_within("tau", &self.tau, 0.0, COORDINATE)?;
        at_most(
            "batch",
            u64::from(self.batch),
            MOST_SAMPLES,
            "no realisation has more samples",
        )?;
        mesh("quadrature", self.quadrature)?;
        if self.cap <= 1.0 {
            return Err(format!("cap: expected more than 1 (theta_t), found {}", self.cap));
        }
        let s = self.log_odds_deviation;
        if s != 0.0 && !LOG_ODDS_DEVIATIONS.contains(&s) {
            let (least, most) = (LOG_ODDS_DEVIATIONS.start(), LOG_ODDS_DEVIATIONS.end());
            return Err(format!(
                "log_odds_deviation: expected 0, or a number from {least} to {most}, found {s}"
            ));
        }
        let fit = self.design(shared, 1.0).fit.check(2);
        fit.map_err(|why| why.trim_start_matches("fit.").to_owned())
    }
}
