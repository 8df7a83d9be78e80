//! Calibration study: the sets that were checked, every search, and what the data identify, as table and figure.

use serde::{Deserialize, Serialize};

use crate::calibration::candidate::{NAMES, Reading};
use crate::calibration::choice::{self, Checked, Found};
use crate::engine::arrow::{CaseOf, Cases};
use crate::engine::case::Axis;
use crate::engine::error::Result;
use crate::engine::stage::{Here, Published, Stage};
use crate::plot::calibration::{InSea, Search, Set, Study, draw};
use crate::plot::calibration_table::{csv, markdown, searches_csv};
use crate::stages::axes::SHIP;
use crate::stages::calibration_check::CalibrationCheck;
use crate::stages::calibration_search::CalibrationSearch;
use crate::stages::figures::refusal::refused;

/// calibration.svg, .csv, .md.
pub struct Calibration;

/// Parameters of the figure.
#[derive(Serialize, Deserialize)]
pub struct Params {
    calibration: Limits,
}

/// The part of `[calibration]` that is drawn.
#[derive(Serialize, Deserialize)]
pub struct Limits {
    accepted: f64,
}

impl Stage for Calibration {
    const NAME: &'static str = "calibration";
    const PAPER: &'static str = "study";
    const GATHERS: &'static [Axis] = &[SHIP];
    const SCHEMA: &'static str = Published::SCHEMA;
    type Params = Params;
    type Inputs = (Cases<CalibrationSearch>, Cases<CalibrationCheck>);
    type Output = Published;

    fn run(
        p: &Params,
        (searches, checks): (Vec<CaseOf<'_, Found>>, Vec<CaseOf<'_, Option<Checked>>>),
        _: Here<'_>,
    ) -> Result<Published> {
        let mut study = Study {
            names: NAMES.map(str::to_owned).to_vec(),
            accepted_below: p.calibration.accepted,
            searches: Vec::new(),
            sets: Vec::new(),
            accepted: Vec::new(),
        };
        for found in searches.iter().flat_map(|case| case.pieces.iter()) {
            let found = found?;
            study.searches.push(search(&found));
            study
                .accepted
                .extend(found.accepted.iter().map(|it| (it.candidate.x.to_vec(), it.ranking)));
        }
        for checked in checks.iter().flat_map(|case| case.pieces.iter()) {
            study.sets.extend((*checked?).as_ref().map(set));
        }
        let texts = [
            ("svg", draw(&study).map_err(refused)?),
            ("csv", csv(&study)),
            ("md", markdown(&study)),
        ];
        let mut published = Published::new(Self::NAME, texts);
        published
            .files
            .insert("calibration_searches.csv".to_owned(), searches_csv(&study));
        Ok(published)
    }
}

fn search(found: &Found) -> Search {
    let names: Vec<&str> = found.search.free.iter().map(|i| NAMES[*i as usize]).collect();
    Search {
        free: names.join(" "),
        changes: names.len() as u32,
        reading: found.search.reading.name().to_owned(),
        is_plain: found.search.reading == Reading::Plain,
        size: found.best.candidate.size(),
        misfit: found.best.misfit,
        ranking: found.best.ranking,
        evaluations: found.evaluations,
        accepted: found.accepted.len() as u64,
    }
}

fn set(checked: &Checked) -> Set {
    Set {
        name: checked.name.clone(),
        reading: checked.candidate.reading.name().to_owned(),
        values: checked.values.to_vec(),
        changed: checked.candidate.x.iter().map(|x| *x != 0.0).collect(),
        size: checked.candidate.size(),
        misfit: checked.misfit,
        fields: checked.fields,
        seas: checked.seas.iter().map(in_sea).collect(),
    }
}

fn in_sea(sea: &choice::InSea) -> InSea {
    InSea {
        sea: sea.target.sea.clone(),
        theta_t: sea.target.theta_t,
        paper: sea.target.p_true,
        p_true: sea.p_true.clone(),
        standard_error: sea.standard_error,
        cic: sea.methods.cic.clone(),
        pic: sea.methods.pic.clone(),
        nic: sea.methods.nic.clone(),
        method_groups: sea.methods.groups,
        capsizes_per_field: sea.capsizes_per_field,
        spread: sea.spread,
    }
}
