//! Table 1: P_true, VHGP-Seq and random sampling, ours beside the paper's; the look-ahead design, plain and with a control, and a
//! hypercube.

use serde::{Deserialize, Serialize};

use crate::design::convergence::{Convergence as Spreads, Spread};
use crate::design::floor::Floor;
use crate::design::settings::Case;
use crate::engine::arrow::{CaseOf, Cases};
use crate::engine::case::Axis;
use crate::engine::error::Result;
use crate::engine::stage::{Here, Published, Stage};
use crate::plot::table::{self, Estimate, Printed, Row, Table, csv, latex, markdown, svg};
use crate::ship::exceedance::Probabilities;
use crate::stages::axes::SEA;
use crate::stages::convergence::Convergence;
use crate::stages::exceedance::Exceedance;
use crate::stages::figures::refusal::refused;

/// Table 1.
pub struct Table1;

/// Parameters of the table.
#[derive(Serialize, Deserialize)]
pub struct Params {
    case: Names,
    vhgp_seq: Rows,
    table1: PrintedTable,
}

/// The name of the ship.
#[derive(Serialize, Deserialize)]
pub struct Names {
    ship: String,
}

/// The part of `[vhgp_seq]` that the table shows.
#[derive(Serialize, Deserialize)]
pub struct Rows {
    case: Vec<Case>,
    epsilon_1_index: u32,
    total: u32,
}

/// The `[table1]` table: the paper's numbers.
#[derive(Serialize, Deserialize)]
pub struct PrintedTable {
    paper: Vec<PrintedRow>,
}

/// A row as the paper prints it.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PrintedRow {
    sea: String,
    theta_t: f64,
    p_true: f64,
    sequential_mean: f64,
    sequential_std_percent: f64,
    random_mean: f64,
    random_std_percent: f64,
}

impl Stage for Table1 {
    const NAME: &'static str = "table1";
    const PAPER: &'static str = "Table 1";
    const GATHERS: &'static [Axis] = &[SEA];
    const SCHEMA: &'static str = Published::SCHEMA;
    type Params = Params;
    type Inputs = (Cases<Exceedance>, Cases<Convergence>);
    type Output = Published;

    fn run(
        p: &Params,
        (truth, methods): (Vec<CaseOf<'_, Probabilities>>, Vec<CaseOf<'_, Spreads>>),
        _: Here<'_>,
    ) -> Result<Published> {
        let mut table = Table {
            ship: p.case.ship.clone(),
            epsilon_1: 0.0,
            samples: u64::from(p.vhgp_seq.total),
            realisations: 0,
            rows: Vec::new(),
        };
        for methods in &methods {
            let sea = methods.case.value(SEA).unwrap_or_default();
            let Some(case) = p.vhgp_seq.case.iter().find(|case| case.sea == sea) else {
                continue;
            };
            let truth = truth.iter().find(|other| other.case.value(SEA) == Some(sea));
            let known = methods.get()?;
            table.realisations = known.realisations;
            let at = |spread: &Spread| {
                let estimate = spread.at(p.vhgp_seq.total);
                estimate.map(|(mean, std)| Estimate { mean, std })
            };
            let mut row = Row {
                spectrum: sea.to_owned(),
                theta_t: case.theta_t,
                p_true: None,
                p_true_se: None,
                sequential: at(&known.sequential),
                random: at(&known.random),
                best: at(&known.best),
                control: at(&known.control),
                lhs: at(&known.lhs),
                floor: known.floors.groups.map(of_floor),
                control_floor: known.floors.control.map(of_floor),
                paper: p.printed(case),
            };
            if let Some(truth) = truth {
                let truth = truth.get()?.at_table("truth", p.vhgp_seq.epsilon_1_index as usize);
                if let Some((epsilon_1, p_true, se)) = truth {
                    table.epsilon_1 = epsilon_1;
                    (row.p_true, row.p_true_se) = (Some(p_true), Some(se));
                }
            }
            table.rows.push(row);
        }
        let picture = svg(&table).map_err(refused)?;
        let texts = [
            ("svg", picture),
            ("csv", csv(&table)),
            ("md", markdown(&table)),
            ("tex", latex(&table)),
        ];
        Ok(Published::new(Self::NAME, texts))
    }
}

fn of_floor(floor: Floor) -> table::Floor {
    table::Floor {
        importance: floor.importance,
        model: floor.model,
    }
}

impl Params {
    /// The paper's row for a sea, if it stands at the same threshold.
    fn printed(&self, case: &Case) -> Option<Printed> {
        let same = |row: &&PrintedRow| row.sea == case.sea && row.theta_t == case.theta_t;
        self.table1.paper.iter().find(same).map(|row| Printed {
            p_true: row.p_true,
            sequential_mean: row.sequential_mean,
            sequential_std_percent: row.sequential_std_percent,
            random_mean: row.random_mean,
            random_std_percent: row.random_std_percent,
        })
    }
}
