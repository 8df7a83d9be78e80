//! Figure 8 (ours): the error of every method against the truth, a row per sea and a column per epsilon_1.

use serde::{Deserialize, Serialize};

use crate::engine::arrow::{CaseOf, Cases};
use crate::engine::case::Axis;
use crate::engine::error::Result;
use crate::engine::stage::{Here, Published, Stage};
use crate::plot::method_error::{MethodError, Row, csv, draw};
use crate::sea::statistics::Statistics;
use crate::ship::exceedance::Probabilities;
use crate::stages::axes::SEA;
use crate::stages::exceedance::Exceedance;
use crate::stages::figures::panels::cells;
use crate::stages::figures::refusal::refused;
use crate::stages::group_statistics::GroupStatistics;

/// Figure 8.
pub struct Fig8MethodError;

/// Parameters of the figure.
#[derive(Serialize, Deserialize)]
pub struct Params {
    case: Names,
}

/// The name of the ship.
#[derive(Serialize, Deserialize)]
pub struct Names {
    ship: String,
}

impl Stage for Fig8MethodError {
    const NAME: &'static str = "fig8_method_error";
    const PAPER: &'static str = "Fig. 8 (ours)";
    const GATHERS: &'static [Axis] = &[SEA];
    const SCHEMA: &'static str = Published::SCHEMA;
    type Params = Params;
    type Inputs = (Cases<GroupStatistics>, Cases<Exceedance>);
    type Output = Published;

    fn run(
        p: &Params,
        (statistics, probabilities): (Vec<CaseOf<'_, Statistics>>, Vec<CaseOf<'_, Probabilities>>),
        _: Here<'_>,
    ) -> Result<Published> {
        let mut rows = Vec::new();
        for (statistics, probabilities) in statistics.iter().zip(&probabilities) {
            rows.push(Row {
                spectrum: probabilities.case.value(SEA).unwrap_or_default().to_owned(),
                description: statistics.get()?.description.clone(),
                cells: cells(&*probabilities.get()?),
            });
        }
        let figure = MethodError {
            ship: p.case.ship.clone(),
            rows,
        };
        let svg = draw(&figure).map_err(refused)?;
        let csv = csv(&figure).map_err(refused)?;
        Ok(Published::new(Self::NAME, [("svg", svg), ("csv", csv)]))
    }
}
