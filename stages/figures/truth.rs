//! truth.csv: what the continuous record of every ship in every sea counted.

use serde::{Deserialize, Serialize};

use crate::engine::arrow::{CaseOf, Cases};
use crate::engine::case::Axis;
use crate::engine::error::Result;
use crate::engine::stage::{Here, Published, Stage};
use crate::plot::csv::{TruthRow, truth};
use crate::ship::exceedance::Probabilities;
use crate::stages::axes::{SEA, SHIP};
use crate::stages::exceedance::Exceedance;

/// truth.csv.
pub struct Truth;

/// Parameters of the file.
#[derive(Serialize, Deserialize)]
pub struct Params {
    truth: Level,
}

/// The part of `[truth]` that names a column.
#[derive(Serialize, Deserialize)]
pub struct Level {
    /// rad.
    temporal_level: f64,
}

impl Stage for Truth {
    const NAME: &'static str = "truth";
    const PAPER: &'static str = "§3";
    const GATHERS: &'static [Axis] = &[SHIP, SEA];
    const SCHEMA: &'static str = Published::SCHEMA;
    type Params = Params;
    type Inputs = (Cases<Exceedance>,);
    type Output = Published;

    fn run(p: &Params, (cases,): (Vec<CaseOf<'_, Probabilities>>,), _: Here<'_>) -> Result<Published> {
        let mut rows = Vec::new();
        for case in &cases {
            rows.extend(case.get()?.counts.iter().map(|counts| TruthRow {
                ship: case.case.value(SHIP).unwrap_or_default().to_owned(),
                spectrum: case.case.value(SEA).unwrap_or_default().to_owned(),
                epsilon_1: counts.epsilon_1,
                fields: counts.fields,
                groups: counts.groups,
                capsizes: counts.capsizes,
                temporal_exceedance: (counts.fields > 0).then_some(counts.time_above),
            }));
        }
        Ok(Published::new(
            Self::NAME,
            [("csv", truth(&rows, p.truth.temporal_level))],
        ))
    }
}
