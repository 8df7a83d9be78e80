//! §3.3 NIC on reconstructed groups: the same start as NIC, but the waves on the way are the Gaussian groups themselves on a
//! common carrier, as Eq. (5) says. Figure 3 shows it dashed.

use std::ops::Range;
use std::sync::Arc;

use serde::{Deserialize, Serialize};

use crate::engine::arrow::{Each, One};
use crate::engine::error::{Error, Result};
use crate::engine::stage::{Here, Pieces, Stage};
use crate::sea::wave_field::Record;
use crate::sea::wave_group::{Groups, Sample};
use crate::ship::encounter::{Approach, GroupRun, max_roll_through_groups};
use crate::ship::initial_condition::{Estimate, check_groups_ahead};
use crate::ship::response::Truth;
use crate::ship::roll_equation::Ship;
use crate::ship::sample::{SampledResponses, Selection};
use crate::ship::simulation::Simulation;
use crate::stages::group_detection::GroupDetection;
use crate::stages::group_sample::GroupSample;
use crate::stages::resolution::{Waves, of_roll};

/// R(a, l) by the groups ahead.
pub struct NicGroups;

/// Parameters of NIC on groups.
#[derive(Serialize, Deserialize)]
pub struct Params {
    ship: Ship,
    sea: Waves,
    record: Record,
    truth: Truth,
    estimate: Estimate,
    nic: GroupsAhead,
}

/// The part of `[nic]` that both inputs share.
#[derive(Serialize, Deserialize)]
pub struct GroupsAhead {
    /// How many groups earlier a run starts.
    #[serde(deserialize_with = "crate::numerics::domain::count")]
    groups_ahead: u32,
}

impl Stage for NicGroups {
    const NAME: &'static str = "nic_groups";
    const PAPER: &'static str = "§3.3";
    const PIECES: Pieces = Pieces::AsUpstream;
    const SCHEMA: &'static str = "sampled-responses/1";
    type Params = Params;
    type Inputs = (Each<GroupDetection>, One<GroupSample>);
    type Output = SampledResponses;

    fn resolution(p: &Params) -> std::result::Result<Vec<String>, String> {
        of_roll(&p.ship, &p.truth, &p.sea.grid(&p.record))
    }

    fn check_output(p: &Params, items: Range<u64>, output: &SampledResponses) -> std::result::Result<(), String> {
        output.check(
            &p.ship.epsilon_1,
            (items.end - items.start) as usize,
            p.truth.capsize_angle,
        )
    }

    fn check(p: &Params) -> std::result::Result<(), String> {
        p.ship.check().map_err(|why| format!("ship.{why}"))?;
        p.truth.check().map_err(|why| format!("truth.{why}"))?;
        p.estimate.check().map_err(|why| format!("estimate.{why}"))?;
        check_groups_ahead(p.nic.groups_ahead).map_err(|why| format!("nic.{why}"))
    }

    fn run(p: &Params, (groups, sample): (Arc<Groups>, Arc<Sample>), here: Here<'_>) -> Result<SampledResponses> {
        let places = sample.of(here.first, &groups).map_err(Error::stage)?;
        let selection = Selection::new(groups.parameters(), places);
        let t_p = p.sea.peak_period;
        let approach = Approach::new(p.record.step_and_period(t_p), &p.truth, &p.estimate, p.nic.groups_ahead);
        let through = |(field, place): (usize, usize)| approach.through_groups(&selection.groups[field], place);
        let runs: Vec<GroupRun> = selection.sampled().map(through).collect();
        let simulation = Simulation::new(&p.ship, &p.truth, approach.h);
        let r = max_roll_through_groups(&simulation, t_p, &runs, &[]);
        Ok(selection.responses(&p.ship.epsilon_1, &r))
    }
}
