//! Figure 3: exceedance probability against threshold, a row per sea and a column per epsilon_1, by every method.

use serde::{Deserialize, Serialize};

use crate::engine::arrow::{CaseOf, Cases};
use crate::engine::case::Axis;
use crate::engine::error::Result;
use crate::engine::stage::{Here, Published, Stage};
use crate::plot::exceedance::{Exceedance as Figure, Row, csv, draw};
use crate::sea::statistics::Statistics;
use crate::ship::exceedance::Probabilities;
use crate::stages::axes::SEA;
use crate::stages::exceedance::Exceedance;
use crate::stages::figures::panels::cells;
use crate::stages::figures::refusal::refused;
use crate::stages::figures::scenes::density;
use crate::stages::group_statistics::GroupStatistics;

/// Figure 3.
pub struct Fig3Exceedance;

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

impl Stage for Fig3Exceedance {
    const NAME: &'static str = "fig3_exceedance";
    const PAPER: &'static str = "Fig. 3";
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
            let spectrum = probabilities.case.value(SEA).unwrap_or_default();
            rows.push(row(spectrum, &*statistics.get()?, &*probabilities.get()?));
        }
        let figure = Figure {
            ship: p.case.ship.clone(),
            rows,
        };
        let svg = draw(&figure).map_err(refused)?;
        Ok(Published::new(Self::NAME, [("svg", svg), ("csv", csv(&[&figure]))]))
    }
}

fn row(spectrum: &str, statistics: &Statistics, probabilities: &Probabilities) -> Row {
    Row {
        spectrum: spectrum.to_owned(),
        description: statistics.description.clone(),
        density: density(&statistics.density),
        cells: cells(probabilities),
    }
}
