//! Exceedance probability per wave group: Eqs. (1), (3) and (4), which are all means over groups, and its standard error.
//!
//! ```text
//! (1)  P = (1/n) sum_i I(r_i > theta_t)
//! (T1) s.e.^2 = sum_f (c_f - P n_f)^2 / n^2      c_f exceedances among the n_f groups of field f
//! (R1) sd / P = sqrt((1 - P) / (n P))            n groups drawn at random
//! ```
//! Groups of one field are not independent, fields are. Counts are whole numbers and add up exactly, piece by piece.
//! Tested in `tests/physics/exceedance.rs` on data made by hand and against seeded sampling.

use crate::numerics::lanes::{Kernel, dispatch};
use crate::numerics::{domain, invariant};
use crate::ship::response::Response;
use serde::{Deserialize, Serialize};

/// The methods of Figure 3, in its order.
pub const METHODS: [&str; 5] = ["truth", "cic", "pic", "nic", "nic_groups"];
/// The most thresholds a curve may have.
const MOST: f64 = 10_000.0;

/// The thresholds theta_t of a curve: from, from + step, .. up to `to`, in rad.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Thresholds {
    /// The first threshold, rad.
    #[serde(deserialize_with = "domain::non_negative")]
    pub from: f64,
    /// The last threshold, rad, if the steps meet it.
    #[serde(deserialize_with = "domain::positive")]
    pub to: f64,
    /// Distance of neighbours, rad.
    #[serde(deserialize_with = "domain::positive")]
    pub step: f64,
}

impl Thresholds {
    /// Checks that the thresholds ascend and are not absurdly many.
    pub fn check(&self) -> Result<(), String> {
        let Self { from, to, step } = self;
        if to < from {
            return Err(format!("to: expected a number from {from} (`from`), found {to}"));
        }
        if (to - from) / step >= MOST {
            return Err(format!(
                "step: expected at most {MOST} thresholds, found a step of {step}"
            ));
        }
        Ok(())
    }

    /// The thresholds, as the decimal numbers they are written as (rounded to 1e-12).
    pub fn values(&self) -> Vec<f64> {
        let count = ((self.to - self.from) / self.step + 1e-9).floor() as u32 + 1;
        (0..count)
            .map(|i| ((self.from + f64::from(i) * self.step) * 1e12).round() / 1e12)
            .collect()
    }
}

/// A line of Figure 3: exceedance probability of one method against the threshold.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Curve {
    /// truth, cic, pic, nic or nic_groups.
    pub method: String,
    /// The parametric excitation, 1/(m s^2).
    pub epsilon_1: f64,
    /// Thresholds, rad.
    pub theta_t: Vec<f64>,
    /// P(r > theta_t) per threshold; empty if n = 0.
    pub probability: Vec<f64>,
    /// Standard error of each probability by (T1); empty if n = 0.
    pub standard_error: Vec<f64>,
    /// Number of groups.
    pub n: u64,
}

impl Curve {
    /// Checks that it is a curve over these thresholds: all its points or, without groups, none.
    ///
    /// # Errors
    /// Another threshold, another number of points, or a number that is no probability.
    pub fn check(&self, theta_t: &[f64]) -> Result<(), String> {
        invariant::equal("theta_t", &self.theta_t[..], theta_t)?;
        let points = if self.n > 0 { theta_t.len() } else { 0 };
        invariant::length("probability", &self.probability, points)?;
        invariant::length("standard_error", &self.standard_error, points)?;
        invariant::all_within("probability", &self.probability, &(0.0..=1.0))?;
        invariant::all_within("standard_error", &self.standard_error, &(0.0..=1.0))
    }
}

/// Exceedances counted field by field: all that Eq. (1) and (T1) need, exact, and mergeable in any order.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Exceedances {
    /// Number of groups, n = sum of n_f.
    pub n: u64,
    /// Sum of n_f^2.
    pub n_n: u64,
    /// Sum of c_f, per threshold.
    pub c: Vec<u64>,
    /// Sum of c_f^2, per threshold.
    pub c_c: Vec<u64>,
    /// Sum of c_f n_f, per threshold.
    pub c_n: Vec<u64>,
}

impl Exceedances {
    /// Nothing counted yet, for so many thresholds.
    pub fn none(thresholds: usize) -> Self {
        Self {
            n: 0,
            n_n: 0,
            c: vec![0; thresholds],
            c_c: vec![0; thresholds],
            c_n: vec![0; thresholds],
        }
    }

    /// Checks that these are counts over so many thresholds of fields with the given numbers of items.
    ///
    /// # Errors
    /// The first count that cannot be one.
    pub fn check(&self, thresholds: usize, items: impl IntoIterator<Item = u64>) -> Result<(), String> {
        let (mut n, mut n_n, mut largest) = (0, 0, 0);
        for n_f in items {
            n += n_f;
            n_n += n_f * n_f;
            largest = n_f.max(largest);
        }
        invariant::equal("n", &self.n, &n)?;
        invariant::equal("n_n", &self.n_n, &n_n)?;
        for (place, list) in [("c", &self.c), ("c_c", &self.c_c), ("c_n", &self.c_n)] {
            invariant::length(place, list, thresholds)?;
        }
        for k in 0..thresholds {
            // c_f <= n_f <= the largest, field by field.
            let (c, c_c, c_n) = (self.c[k], self.c_c[k], self.c_n[k]);
            let counted = c <= n && c_c <= c_n && c <= c_c && c_n <= c * largest;
            invariant::holds(
                &format!("c[{k}], c_c[{k}], c_n[{k}]"),
                counted,
                "sums over fields of one count",
            )?;
        }
        Ok(())
    }

    /// Counts the responses of one field.
    pub fn add_field(&mut self, theta_t: &[f64], r: &[f64]) {
        let n_f = r.len() as u64;
        self.n += n_f;
        self.n_n += n_f * n_f;
        for (k, c_f) in dispatch(Above { theta_t, r }).into_iter().enumerate() {
            self.c[k] += c_f;
            self.c_c[k] += c_f * c_f;
            self.c_n[k] += c_f * n_f;
        }
    }

    /// Adds what was counted elsewhere, over the same thresholds and other fields.
    pub fn merge(&mut self, other: &Self) {
        self.n += other.n;
        self.n_n += other.n_n;
        let rows = [
            (&mut self.c, &other.c),
            (&mut self.c_c, &other.c_c),
            (&mut self.c_n, &other.c_n),
        ];
        for (mine, theirs) in rows {
            for (a, b) in mine.iter_mut().zip(theirs) {
                *a += b;
            }
        }
    }

    /// Eq. (1): the share of groups above threshold k; none of no groups.
    pub fn probability(&self, k: usize) -> Option<f64> {
        (self.n > 0).then(|| self.c[k] as f64 / self.n as f64)
    }

    /// (T1): the standard error by fields of the probability at threshold k; none of no groups.
    pub fn standard_error(&self, k: usize) -> Option<f64> {
        let [n, n_n, c, c_c, c_n] = [self.n, self.n_n, self.c[k], self.c_c[k], self.c_n[k]].map(i128::from);
        // The sum of (n c_f - c n_f)^2, n^2 times that of (T1), without rounding.
        let squares = n * n * c_c - 2 * n * c * c_n + c * c * n_n;
        let n = self.n as f64;
        (self.n > 0).then(|| (squares as f64).sqrt() / (n * n))
    }

    /// The curve of a method; without probabilities if there are no groups.
    pub fn curve(&self, method: &str, epsilon_1: f64, theta_t: &[f64]) -> Curve {
        Curve {
            method: method.to_string(),
            epsilon_1,
            theta_t: theta_t.to_vec(),
            probability: (0..theta_t.len()).filter_map(|k| self.probability(k)).collect(),
            standard_error: (0..theta_t.len()).filter_map(|k| self.standard_error(k)).collect(),
            n: self.n,
        }
    }
}

/// How many responses are above each threshold.
struct Above<'a> {
    theta_t: &'a [f64],
    r: &'a [f64],
}

impl Kernel for Above<'_> {
    type Output = Vec<u64>;

    #[inline(always)]
    fn run(self) -> Vec<u64> {
        let mut highest = f64::NEG_INFINITY;
        for r in self.r {
            highest = if *r > highest { *r } else { highest };
        }
        let mut counts = vec![0; self.theta_t.len()];
        for (count, level) in counts.iter_mut().zip(self.theta_t) {
            // Most levels are above all of a field.
            if highest > *level {
                *count = self.r.iter().filter(|r| *r > level).count() as u64;
            }
        }
        counts
    }
}

/// Exceedance of every method, and what the truth counted beside it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Probabilities {
    /// One curve per method and epsilon_1 over the thresholds of Figure 3.
    pub curves: Vec<Curve>,
    /// The same over the threshold of Table 1 alone; no points if the sea has no row there.
    pub table: Vec<Curve>,
    /// What the continuous record counted, per epsilon_1.
    pub counts: Vec<Counts>,
    /// The share of time with |theta| above a level, over the levels of `[truth] temporal_levels`, per epsilon_1; s.e. by
    /// fields, n in instants.
    pub temporal: Vec<Curve>,
}

/// What the continuous record counted at one epsilon_1.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Counts {
    /// epsilon_1, 1/(m s^2).
    pub epsilon_1: f64,
    /// Fields in the statistics.
    pub fields: u64,
    /// Fields that left the statistics.
    pub dropped: u64,
    /// Groups in the statistics.
    pub groups: u64,
    /// Capsizes in [0, T_f) of all fields.
    pub capsizes: u64,
    /// Fields with a capsize.
    pub fields_with_capsize: u64,
    /// Groups whose segment holds a capsize.
    pub capsized_groups: u64,
    /// Share of time with |theta| above the temporal level.
    pub time_above: f64,
}

impl Counts {
    /// Adds one field; the share of time is a mean over the fields in the statistics, taken at the end.
    pub fn add(&mut self, field: &Response, capsize_angle: f64) {
        self.fields += u64::from(!field.dropped);
        self.dropped += u64::from(field.dropped);
        self.groups += field.r.len() as u64;
        self.capsizes += u64::from(field.capsizes);
        self.fields_with_capsize += u64::from(field.capsizes > 0);
        self.capsized_groups += field.capsized_groups(capsize_angle) as u64;
    }
}

impl Probabilities {
    /// Checks that every method and the share of time have a curve for each epsilon_1, over the thresholds of Figure 3, of
    /// Table 1 and of the levels.
    ///
    /// # Errors
    /// The first curve that is missing, or none of probabilities.
    pub fn check(&self, figure: &[f64], table: &[f64], levels: &[f64]) -> Result<(), String> {
        let epsilons = self.counts.len();
        invariant::holds("counts", epsilons > 0, "at least one epsilon_1")?;
        for (place, curves, theta_t) in [("curves", &self.curves, figure), ("table", &self.table, table)] {
            invariant::length(place, curves, METHODS.len() * epsilons)?;
            for (i, curve) in curves.iter().enumerate() {
                let own = |why: String| format!("{place}[{i}].{why}");
                invariant::equal("method", curve.method.as_str(), METHODS[i / epsilons]).map_err(own)?;
                invariant::equal("epsilon_1", &curve.epsilon_1, &self.counts[i % epsilons].epsilon_1).map_err(own)?;
                curve.check(theta_t).map_err(own)?;
            }
        }
        invariant::length("temporal", &self.temporal, epsilons)?;
        for (e, (curve, counts)) in self.temporal.iter().zip(&self.counts).enumerate() {
            curve.check(levels).map_err(|why| format!("temporal[{e}].{why}"))?;
            let place = |key: &str| format!("counts[{e}].{key}");
            invariant::within(&place("time_above"), counts.time_above, 0.0..=1.0)?;
            let capsized = counts.capsized_groups <= counts.groups;
            invariant::holds(&place("capsized_groups"), capsized, "at most all groups")?;
        }
        Ok(())
    }

    /// (epsilon_1, probability, standard error) of a method at Table 1's threshold, for one value of the ship's list.
    pub fn at_table(&self, method: &str, epsilon_1_index: usize) -> Option<(f64, f64, f64)> {
        let epsilon_1 = self.counts.get(epsilon_1_index)?.epsilon_1;
        let curve = self
            .table
            .iter()
            .find(|curve| curve.method == method && curve.epsilon_1 == epsilon_1)?;
        Some((epsilon_1, *curve.probability.first()?, *curve.standard_error.first()?))
    }
}
