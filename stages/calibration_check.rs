//! Calibration study, §3: the best of the searches, polished by least squares, rounded, and rolled on fields that none of
//! them has seen; with CIC, PIC, NIC, capsizes and the scatter about (L, A). One piece is one candidate.

use std::ops::Range;
use std::sync::Arc;

use crate::calibration::bench::Fields;
use crate::calibration::choice::{Checked, Found, chosen};
use crate::calibration::study::Part;
use crate::engine::arrow::{All, CaseOf, Cases, PiecesOf};
use crate::engine::case::Axis;
use crate::engine::error::{Error, Result};
use crate::engine::stage::{Here, Pieces, Select, Stage};
use crate::numerics::fourier::WIDTH;
use crate::stages::axes::{SEA, SHIP};
use crate::stages::calibration_fields::CalibrationFields;
use crate::stages::calibration_search::{CalibrationSearch, Params};

/// What of a candidate holds on other waves.
pub struct CalibrationCheck;

impl Stage for CalibrationCheck {
    const NAME: &'static str = "calibration_check";
    const PAPER: &'static str = "study";
    const PIECES: Pieces = Pieces::Counted("calibration.checks");
    const GATHERS: &'static [Axis] = &[SEA];
    const SELECTS: &'static [Select] = &[Select::At(SHIP, "calibration.ship")];
    // A set is checked on the fields that no search has seen: there must be some.
    const ITEMS: &'static [(&'static str, &'static str, u64)] =
        &[("calibration.polish_fields", "calibration.fields", WIDTH as u64)];
    const SCHEMA: &'static str = "calibration-check/1";
    type Params = Params;
    type Inputs = (All<CalibrationSearch>, Cases<CalibrationFields>);
    type Output = Option<Checked>;

    fn resolution(p: &Params) -> std::result::Result<Vec<String>, String> {
        p.resolution()
    }

    fn check_output(p: &Params, _: Range<u64>, output: &Option<Checked>) -> std::result::Result<(), String> {
        output.as_ref().map_or(Ok(()), |checked| checked.check(p.epsilons()))
    }

    fn run(
        p: &Params,
        (searches, seas): (PiecesOf<'_, Found>, Vec<CaseOf<'_, Fields>>),
        here: Here<'_>,
    ) -> Result<Option<Checked>> {
        let found: Vec<Arc<Found>> = searches.iter().collect::<Result<_>>()?;
        let chosen = chosen(p.settings(), p.printed(), found.iter().map(Arc::as_ref), here.first);
        let study = p.study(&seas)?;
        study.expect_groups(Part::Check).map_err(Error::stage)?;
        Ok(chosen.map(|chosen| study.check(&chosen, &mut here.stream(here.first))))
    }
}
