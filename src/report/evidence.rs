//! What a ship's results say about the paper's claims, as typed numbers.
//!
//! | part | paper | holds |
//! |---|---|---|
//! | `Curve` | P_true, P_est | probabilities of one method in one sea at one epsilon_1, by threshold |
//! | `Moment` | R(a, l) | mean and spread of the response to one group |
//! | `Study` | C_thr | probabilities by groups and by time for several similarity thresholds |
//! | `plot::table::Row` | Table 1 | ours beside the paper's |
//!
//! The published CSV files hold the same numbers, so that every verdict can be checked with a spreadsheet. Look-ups go through
//! an ordered map and a binary search: 10,000 thresholds cost no more than they are long. Tested in `tests/report/claims.rs`.

use std::collections::BTreeMap;

use crate::plot::style::Method;
use crate::plot::table::Row;

/// A measured number.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Measured {
    /// The number.
    pub value: f64,
    /// Its standard error; none if the number is exact.
    pub standard_error: Option<f64>,
    /// Whether nothing was counted, so that the number is 0 and only its upper bound, two standard errors, is known.
    pub is_bound: bool,
}

/// Exceedances among n groups below which a probability lies with 95 %, if none of the n groups exceeded: -ln 0.05.
const NONE_SEEN: f64 = 3.0;

impl Measured {
    /// A number without a standard error.
    pub fn exact(value: f64) -> Self {
        Self {
            value,
            standard_error: None,
            is_bound: false,
        }
    }

    /// A number with its standard error.
    pub fn with_error(value: f64, standard_error: f64) -> Self {
        Self {
            value,
            standard_error: Some(standard_error),
            is_bound: false,
        }
    }

    /// A probability of which n groups showed no exceedance: at most 3/n with 95 %.
    pub fn none_among(n: f64) -> Self {
        Self {
            value: 0.0,
            standard_error: Some(0.5 * NONE_SEEN / n),
            is_bound: true,
        }
    }

    /// A share of n groups with its standard error as counted; none if nothing tells how well it is known.
    ///
    /// The standard error by fields is 0 where none or all of the groups exceed, and then 3/n bounds the share; it is also 0 where
    /// all groups lie in one field, and then nothing bounds it.
    pub fn share(value: f64, standard_error: f64, n: u64) -> Option<Self> {
        if n == 0 || !value.is_finite() {
            return None;
        }
        let n = n as f64;
        if standard_error > 0.0 {
            return Some(Self::with_error(value, standard_error));
        }
        if value <= 0.0 {
            return Some(Self::none_among(n));
        }
        (value >= 1.0).then(|| Self::with_error(value, 0.5 * NONE_SEEN / n))
    }

    /// The largest value that two standard errors allow.
    pub fn at_most(self) -> f64 {
        self.value + 2.0 * self.standard_error.unwrap_or(0.0)
    }
}

/// Probabilities of one method in one sea at one epsilon_1.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Curve {
    /// Thresholds, rad, ascending.
    pub theta_t: Vec<f64>,
    /// The probability at each, as many; none where it is not known.
    pub probability: Vec<Option<Measured>>,
    /// The probability at Table 1's threshold, which need not be one of them.
    pub at_table: Option<Measured>,
}

impl Curve {
    /// The probability at a threshold; none if the curve has no such threshold.
    pub fn at(&self, theta_t: f64) -> Option<Measured> {
        let place = self.theta_t.partition_point(|other| *other < theta_t);
        if self.theta_t.get(place) != Some(&theta_t) {
            return None;
        }
        self.probability.get(place).copied().flatten()
    }
}

/// Mean and standard deviation of the response to groups of one size.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Moment {
    /// Mean, rad.
    pub mean: f64,
    /// Population standard deviation, rad.
    pub std: f64,
    /// Number of responses.
    pub n: u64,
}

/// What one similarity threshold makes of the studied fields, per epsilon_1.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Detection {
    /// Share of groups above each level.
    pub by_groups: Vec<Curve>,
    /// Share of time above each level within the groups' segments.
    pub within_groups: Vec<Curve>,
}

/// The study of the detection.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Study {
    /// Name of the sea.
    pub sea: String,
    /// One entry per similarity threshold.
    pub detections: Vec<Detection>,
}

/// What a ship's results hold.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Evidence {
    /// Name of the ship.
    pub ship: String,
    /// Realisations behind the means and standard deviations of Table 1.
    pub realisations: u64,
    /// Samples behind each of its estimates.
    pub samples: u64,
    /// The seas of the run, in order.
    pub seas: Vec<String>,
    /// The ship's values of epsilon_1, ascending, 1/(m s^2).
    pub epsilons: Vec<f64>,
    /// Figure 3, by method, place of the sea and place of epsilon_1.
    pub curves: BTreeMap<(Method, usize, usize), Curve>,
    /// Figure 4, by method, place of the group and place of epsilon_1.
    pub moments: BTreeMap<(Method, usize, usize), Moment>,
    /// Figure 7; none without a study.
    pub study: Option<Study>,
    /// Table 1.
    pub table: Vec<Row>,
}

impl Evidence {
    /// The curve of a method; an empty one if it was not run.
    pub fn curve(&self, method: Method, sea: usize, epsilon_1: usize) -> &Curve {
        static NONE: Curve = Curve {
            theta_t: Vec::new(),
            probability: Vec::new(),
            at_table: None,
        };
        self.curves.get(&(method, sea, epsilon_1)).unwrap_or(&NONE)
    }

    /// The threshold of Table 1 in a sea, rad.
    pub fn theta_t(&self, sea: &str) -> Option<f64> {
        let row = self.table.iter().find(|row| row.spectrum == sea);
        row.map(|row| row.theta_t)
    }

    /// The largest threshold at which the truth is known to `share` of its value, rad.
    pub fn last_known(&self, sea: usize, epsilon_1: usize, share: f64) -> Option<f64> {
        let truth = self.curve(Method::Truth, sea, epsilon_1);
        let place = truth
            .probability
            .iter()
            .rposition(|p| p.is_some_and(|p| p.value > 0.0 && is_known(p, share)))?;
        truth.theta_t.get(place).copied()
    }
}

/// Whether a number's standard error is below a share of its value.
pub fn is_known(number: Measured, share: f64) -> bool {
    number.standard_error.is_some_and(|error| error < share * number.value)
}

/// A ratio of two numbers taken for independent; none over nothing.
pub fn ratio(a: Measured, b: Measured) -> Option<Measured> {
    let value = a.value / b.value;
    let error = |known: Measured| known.standard_error.unwrap_or(0.0);
    let spread = error(a) * error(a) + value * value * error(b) * error(b);
    (b.value > 0.0).then(|| Measured {
        value,
        standard_error: Some(spread.sqrt() / b.value),
        is_bound: a.is_bound,
    })
}
