//! The rows of Table 1, which the table shows and the findings judge: P_true, every method's estimates, and the paper's numbers.

use serde::{Deserialize, Serialize};

use crate::design::convergence::{Convergence, Spread};
use crate::design::floor::Floor;
use crate::design::settings::Case;
use crate::engine::arrow::CaseOf;
use crate::engine::error::Result;
use crate::numerics::domain;
use crate::plot::table::{self, Estimate, Printed, Row};
use crate::ship::exceedance::Probabilities;
use crate::stages::axes::SEA;

/// The part of `[vhgp_seq]` that the table shows.
#[derive(Serialize, Deserialize)]
pub struct Rows {
    /// The rows: sea and theta_t.
    pub case: Vec<Case>,
    /// The place of the table's epsilon_1 in the ship's list.
    pub epsilon_1_index: u32,
    /// Samples of every estimate.
    pub total: u32,
}

/// The `[table1]` table: the paper's numbers.
#[derive(Serialize, Deserialize)]
pub struct PrintedTable {
    /// One row per sea.
    pub paper: Vec<PrintedRow>,
}

/// A row as the paper prints it.
#[derive(Clone, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PrintedRow {
    /// Name of the sea.
    pub sea: String,
    /// Threshold, rad.
    #[serde(deserialize_with = "domain::positive")]
    pub theta_t: f64,
    /// P_true.
    #[serde(deserialize_with = "domain::fraction")]
    pub p_true: f64,
    /// Mean of VHGP-Seq.
    #[serde(deserialize_with = "domain::fraction")]
    pub sequential_mean: f64,
    /// Its standard deviation, % of the mean.
    #[serde(deserialize_with = "domain::positive")]
    pub sequential_std_percent: f64,
    /// Mean of random sampling.
    #[serde(deserialize_with = "domain::fraction")]
    pub random_mean: f64,
    /// Its standard deviation, % of the mean.
    #[serde(deserialize_with = "domain::positive")]
    pub random_std_percent: f64,
}

/// The part of `[truth]` beyond which no threshold makes sense.
#[derive(Serialize, Deserialize)]
pub struct Limit {
    /// rad.
    capsize_angle: f64,
}

impl PrintedTable {
    /// Checks that every threshold can be exceeded by a ship that has not capsized.
    ///
    /// # Errors
    /// `key: expected .., found ..`.
    pub fn check(&self, limit: &Limit) -> std::result::Result<(), String> {
        let limit = limit.capsize_angle;
        match self.paper.iter().position(|row| row.theta_t >= limit) {
            None => Ok(()),
            Some(place) => Err(format!(
                "paper[{place}].theta_t: expected a number below capsize_angle = {limit}, found {}",
                self.paper[place].theta_t
            )),
        }
    }

    /// The paper's row for a sea, if it stands at the same threshold.
    fn of(&self, case: &Case) -> Option<Printed> {
        let same = |row: &&PrintedRow| row.sea == case.sea && row.theta_t == case.theta_t;
        self.paper.iter().find(same).map(|row| Printed {
            p_true: row.p_true,
            sequential_mean: row.sequential_mean,
            sequential_std_percent: row.sequential_std_percent,
            random_mean: row.random_mean,
            random_std_percent: row.random_std_percent,
        })
    }
}

/// Means and standard deviations of every method in one sea.
type Methods<'a> = CaseOf<'a, Convergence>;

/// The rows of one ship, a sea each, in the order of `methods`.
///
/// # Errors
/// An input that cannot be read.
pub fn table_rows(
    rows: &Rows,
    printed: &PrintedTable,
    truth: &[&CaseOf<'_, Probabilities>],
    methods: &[&Methods<'_>],
) -> Result<Vec<Row>> {
    let mut found = Vec::new();
    for methods in methods {
        let sea = methods.case.value(SEA).unwrap_or_default();
        let Some(case) = rows.case.iter().find(|case| case.sea == sea) else {
            continue;
        };
        let mut row = estimates(rows, case, &*methods.get()?);
        row.paper = printed.of(case);
        if let Some(truth) = truth.iter().find(|other| other.case.value(SEA) == Some(sea)) {
            let truth = truth.get()?;
            let index = rows.epsilon_1_index as usize;
            if let Some((_, p_true, error)) = truth.at_table("truth", index) {
                (row.p_true, row.p_true_se) = (Some(p_true), known_error(error));
                row.p_true_groups = truth.counts.get(index).map_or(0, |counts| counts.groups);
            }
        }
        found.push(row);
    }
    Ok(found)
}

/// A standard error as counted, if it says anything: it is 0 where none or all of the groups exceed, and where all groups lie in
/// one field.
pub fn known_error(counted: f64) -> Option<f64> {
    (counted > 0.0).then_some(counted)
}

/// A row with the estimates of every method, the truth and the paper's numbers left out.
fn estimates(rows: &Rows, case: &Case, known: &Convergence) -> Row {
    let at = |spread: &Spread| {
        let estimate = spread.at(rows.total);
        estimate.map(|(mean, std)| Estimate {
            mean,
            std: known.deviation(std),
        })
    };
    let all = [
        &known.sequential,
        &known.random,
        &known.best,
        &known.control,
        &known.lhs,
    ];
    let most = |spread: &&Spread| spread.n_samples.iter().filter(|n| **n <= rows.total).max().copied();
    Row {
        spectrum: case.sea.clone(),
        theta_t: case.theta_t,
        p_true: None,
        p_true_se: None,
        p_true_groups: 0,
        reached: all
            .iter()
            .map(|spread| most(spread).unwrap_or(0))
            .min()
            .map_or(0, u64::from),
        sequential: at(&known.sequential),
        random: at(&known.random),
        best: at(&known.best),
        control: at(&known.control),
        lhs: at(&known.lhs),
        floor: known.floors.groups.map(of_floor),
        control_floor: known.floors.control.map(of_floor),
        paper: None,
    }
}

fn of_floor(floor: Floor) -> table::Floor {
    table::Floor {
        importance: floor.importance,
        model: floor.model,
    }
}
