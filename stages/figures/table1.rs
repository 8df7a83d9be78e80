//! Table 1: P_true, VHGP-Seq and random sampling, ours beside the paper's; the look-ahead design, plain and with a control, and a
//! hypercube.

use serde::{Deserialize, Serialize};

use crate::design::convergence::Convergence as Spreads;
use crate::engine::arrow::{CaseOf, Cases};
use crate::engine::case::Axis;
use crate::engine::error::Result;
use crate::engine::stage::{Here, Published, Select, Stage};
use crate::plot::table::{Table, csv, latex, markdown, svg};
use crate::ship::exceedance::Probabilities;
use crate::stages::axes::SEA;
use crate::stages::convergence::Convergence;
use crate::stages::exceedance::Exceedance;
use crate::stages::figures::refusal::refused;
use crate::stages::figures::table_rows::{Limit, PrintedTable, Rows, table_rows};

/// Table 1.
pub struct Table1;

/// Parameters of the table.
#[derive(Serialize, Deserialize)]
pub struct Params {
    case: Names,
    truth: Limit,
    vhgp_seq: Rows,
    table1: PrintedTable,
}

/// The name of the ship.
#[derive(Serialize, Deserialize)]
pub struct Names {
    ship: String,
}

impl Stage for Table1 {
    const NAME: &'static str = "table1";
    const PAPER: &'static str = "Table 1";
    const GATHERS: &'static [Axis] = &[SEA];
    const NAMES: &'static [Select] = &[Select::Rows(SEA, "table1.paper")];
    const SCHEMA: &'static str = Published::SCHEMA;
    type Params = Params;
    type Inputs = (Cases<Exceedance>, Cases<Convergence>);
    type Output = Published;

    fn check(p: &Params) -> std::result::Result<(), String> {
        p.table1.check(&p.truth).map_err(|why| format!("table1.{why}"))
    }

    fn run(
        p: &Params,
        (truth, methods): (Vec<CaseOf<'_, Probabilities>>, Vec<CaseOf<'_, Spreads>>),
        _: Here<'_>,
    ) -> Result<Published> {
        let (seas, cases): (Vec<_>, Vec<_>) = (truth.iter().collect(), methods.iter().collect());
        let mut table = Table {
            ship: p.case.ship.clone(),
            epsilon_1: None,
            samples: u64::from(p.vhgp_seq.total),
            realisations: 0,
            rows: table_rows(&p.vhgp_seq, &p.table1, &seas, &cases)?,
        };
        if let Some(methods) = methods.last() {
            table.realisations = methods.get()?.realisations;
        }
        if let Some(truth) = truth.first() {
            let counts = truth.get()?;
            let counts = counts.counts.get(p.vhgp_seq.epsilon_1_index as usize);
            table.epsilon_1 = counts.map(|counts| counts.epsilon_1);
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
