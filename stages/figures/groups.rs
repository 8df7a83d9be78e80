//! groups.csv: the groups of every sea.

use serde::{Deserialize, Serialize};

use crate::engine::arrow::{CaseOf, Cases};
use crate::engine::case::Axis;
use crate::engine::error::Result;
use crate::engine::stage::{Here, Published, Stage};
use crate::plot::csv::{GroupsRow, groups};
use crate::sea::statistics::Statistics;
use crate::stages::axes::SEA;
use crate::stages::group_statistics::GroupStatistics;

/// groups.csv.
pub struct Groups;

/// No parameters.
#[derive(Serialize, Deserialize)]
pub struct Params {}

impl Stage for Groups {
    const NAME: &'static str = "groups";
    const PAPER: &'static str = "§2";
    const GATHERS: &'static [Axis] = &[SEA];
    const SCHEMA: &'static str = Published::SCHEMA;
    type Params = Params;
    type Inputs = (Cases<GroupStatistics>,);
    type Output = Published;

    fn run(_: &Params, (seas,): (Vec<CaseOf<'_, Statistics>>,), _: Here<'_>) -> Result<Published> {
        let mut rows = Vec::new();
        for sea in &seas {
            let known = sea.get()?;
            // A number that takes more groups than there are is none.
            let from = |least: u64, number: f64| (known.groups >= least).then_some(number);
            rows.push(GroupsRow {
                spectrum: sea.case.value(SEA).unwrap_or_default().to_owned(),
                fields: known.fields,
                groups_per_tp: known.groups_per_tp,
                l_over_tp_mean: from(1, known.l_over_tp[0]),
                l_over_tp_sd: from(2, known.l_over_tp[1]),
                a_over_hs_mean: from(1, known.a_over_hs[0]),
                a_over_hs_sd: from(2, known.a_over_hs[1]),
                // Two groups always lie on a line.
                correlation: from(3, known.correlation),
                share_a_over_hs_gt_1: from(1, known.share_a_over_hs_gt_1),
            });
        }
        Ok(Published::new(Self::NAME, [("csv", groups(&rows))]))
    }
}
