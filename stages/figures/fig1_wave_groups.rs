//! Figure 1: a segment of the record with its envelope, its groups, and the joint density of all groups.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use crate::engine::arrow::{All, One, PiecesOf};
use crate::engine::error::Result;
use crate::engine::stage::{Here, Published, Select, Stage};
use crate::plot::wave_groups::{WaveGroups, csv, draw};
use crate::sea::envelope::Envelopes;
use crate::sea::spectrum::Sea;
use crate::sea::statistics::Statistics;
use crate::sea::wave_field::{Record, WaveFields};
use crate::sea::wave_group::Groups;
use crate::stages::axes::SEA;
use crate::stages::envelope::Envelope;
use crate::stages::figures::refusal::refused;
use crate::stages::figures::scenes::{Segment, density, find_field};
use crate::stages::group_detection::GroupDetection;
use crate::stages::group_statistics::GroupStatistics;
use crate::stages::wave_synthesis::WaveSynthesis;

/// Figure 1.
pub struct Fig1WaveGroups;

/// Parameters of the figure.
#[derive(Serialize, Deserialize)]
pub struct Params {
    case: Names,
    sea: Sea,
    record: Record,
    fig1_wave_groups: Segment,
}

/// The name of the sea.
#[derive(Serialize, Deserialize)]
pub struct Names {
    sea: String,
}

impl Stage for Fig1WaveGroups {
    const NAME: &'static str = "fig1_wave_groups";
    const PAPER: &'static str = "Fig. 1";
    const SELECTS: &'static [Select] = &[Select::At(SEA, "fig1_wave_groups.sea")];
    const ITEMS: &'static [(&'static str, &'static str, u64)] = &[("fig1_wave_groups.field", "record.fields", 1)];
    const SCHEMA: &'static str = Published::SCHEMA;
    type Params = Params;
    type Inputs = (
        All<WaveSynthesis>,
        All<Envelope>,
        All<GroupDetection>,
        One<GroupStatistics>,
    );
    type Output = Published;

    fn check(p: &Params) -> std::result::Result<(), String> {
        p.fig1_wave_groups
            .check(&p.record)
            .map_err(|why| format!("fig1_wave_groups.{why}"))
    }

    fn run(
        p: &Params,
        (waves, envelopes, groups, statistics): (
            PiecesOf<'_, WaveFields>,
            PiecesOf<'_, Envelopes>,
            PiecesOf<'_, Groups>,
            Arc<Statistics>,
        ),
        _: Here<'_>,
    ) -> Result<Published> {
        let segment = &p.fig1_wave_groups;
        let key = "fig1_wave_groups.field";
        let (waves, place) = find_field(waves.iter(), |piece| piece.phase.len(), segment.field, key)?;
        let (envelopes, _) = find_field(envelopes.iter(), |piece| piece.rho.len(), segment.field, key)?;
        let (groups, _) = find_field(groups.iter(), |piece| piece.fields.len(), segment.field, key)?;
        let figure = WaveGroups {
            sea: format!("{} {}", p.case.sea, p.sea.description()),
            t_p: waves.t_p,
            eta: segment.elevation(&p.record, &waves, place),
            rho: segment.cut(&envelopes.rho[place], envelopes.spacing, 1, waves.t_p),
            groups: segment.groups(&groups.fields[place], waves.t_p),
            density: density(&statistics.density),
        };
        let svg = draw(&figure).map_err(refused)?;
        Ok(Published::new(Self::NAME, [("svg", svg), ("csv", csv(&figure))]))
    }
}
