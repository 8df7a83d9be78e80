//! Figure 6: a segment of the JONSWAP sea and its detected groups.

use serde::{Deserialize, Serialize};

use crate::engine::arrow::{All, PiecesOf};
use crate::engine::error::Result;
use crate::engine::stage::{Here, Published, Select, Stage};
use crate::plot::jonswap_groups::{JonswapGroups, csv, draw};
use crate::sea::spectrum::Sea;
use crate::sea::wave_field::{Record, WaveFields};
use crate::sea::wave_group::Groups;
use crate::stages::axes::SEA;
use crate::stages::figures::refusal::refused;
use crate::stages::figures::scenes::{Segment, find_field};
use crate::stages::group_detection::GroupDetection;
use crate::stages::wave_synthesis::WaveSynthesis;

/// Figure 6.
pub struct Fig6JonswapGroups;

/// Parameters of the figure.
#[derive(Serialize, Deserialize)]
pub struct Params {
    case: Names,
    sea: Sea,
    record: Record,
    fig6_jonswap_groups: Segment,
}

/// The name of the sea.
#[derive(Serialize, Deserialize)]
pub struct Names {
    sea: String,
}

impl Stage for Fig6JonswapGroups {
    const NAME: &'static str = "fig6_jonswap_groups";
    const PAPER: &'static str = "Fig. 6";
    const SELECTS: &'static [Select] = &[Select::At(SEA, "fig6_jonswap_groups.sea")];
    const ITEMS: &'static [(&'static str, &'static str, u64)] = &[("fig6_jonswap_groups.field", "record.fields", 1)];
    const SCHEMA: &'static str = Published::SCHEMA;
    type Params = Params;
    type Inputs = (All<WaveSynthesis>, All<GroupDetection>);
    type Output = Published;

    fn check(p: &Params) -> std::result::Result<(), String> {
        p.fig6_jonswap_groups
            .check(&p.record)
            .map_err(|why| format!("fig6_jonswap_groups.{why}"))
    }

    fn run(
        p: &Params,
        (waves, groups): (PiecesOf<'_, WaveFields>, PiecesOf<'_, Groups>),
        _: Here<'_>,
    ) -> Result<Published> {
        let segment = &p.fig6_jonswap_groups;
        let key = "fig6_jonswap_groups.field";
        let (waves, place) = find_field(waves.iter(), |piece| piece.phase.len(), segment.field, key)?;
        let (groups, _) = find_field(groups.iter(), |piece| piece.fields.len(), segment.field, key)?;
        let figure = JonswapGroups {
            sea: format!("{} {}", p.case.sea, p.sea.description()),
            t_p: waves.t_p,
            eta: segment.elevation(&p.record, &waves, place),
            groups: segment.groups(&groups.fields[place], waves.t_p),
        };
        let svg = draw(&figure).map_err(refused)?;
        Ok(Published::new(Self::NAME, [("svg", svg), ("csv", csv(&figure))]))
    }
}
