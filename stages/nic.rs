//! §3.3 Natural initial condition (NIC): the ship starts at rest two groups ahead, and its own waves bring it to the group
//! in the state they left it in. Eq. (4).
//!
//! With `[nic] input = "record"` those waves are the original elevation (Decision 7).

use std::ops::Range;
use std::sync::Arc;

use serde::{Deserialize, Serialize};

use crate::engine::arrow::{Each, One};
use crate::engine::error::{Error, Result};
use crate::engine::stage::{Here, Pieces, Stage};
use crate::numerics::fourier::WIDTH;
use crate::numerics::rows::Rows;
use crate::sea::wave_field::{Record, WaveFields};
use crate::sea::wave_group::{Groups, Sample};
use crate::ship::encounter::{Approach, RecordRun, max_roll_along_record, max_roll_through_groups};
use crate::ship::initial_condition::{Estimate, Nic as NicTable, NicInput, check_groups_ahead};
use crate::ship::response::Truth;
use crate::ship::roll_equation::Ship;
use crate::ship::sample::{SampledResponses, Selection};
use crate::ship::simulation::Simulation;
use crate::stages::group_detection::GroupDetection;
use crate::stages::group_sample::GroupSample;
use crate::stages::resolution::{Waves, of_roll};
use crate::stages::wave_synthesis::WaveSynthesis;

/// R(a, l) by nature.
pub struct Nic;

/// Parameters of NIC.
#[derive(Serialize, Deserialize)]
pub struct Params {
    ship: Ship,
    sea: Waves,
    record: Record,
    truth: Truth,
    estimate: Estimate,
    nic: NicTable,
}

impl Stage for Nic {
    const NAME: &'static str = "nic";
    const PAPER: &'static str = "§3.3";
    const PIECES: Pieces = Pieces::AsUpstream;
    const SCHEMA: &'static str = "sampled-responses/1";
    type Params = Params;
    type Inputs = (Each<WaveSynthesis>, Each<GroupDetection>, One<GroupSample>);
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

    fn run(
        p: &Params,
        (waves, groups, sample): (Arc<WaveFields>, Arc<Groups>, Arc<Sample>),
        here: Here<'_>,
    ) -> Result<SampledResponses> {
        let places = sample.of(here.first, &groups).map_err(Error::stage)?;
        let selection = Selection::new(groups.parameters(), places);
        let t_p = waves.t_p;
        let approach = Approach::new(p.record.step_and_period(t_p), &p.truth, &p.estimate, p.nic.groups_ahead);
        let simulation = Simulation::new(&p.ship, &p.truth, approach.h);
        let r = match p.nic.input {
            NicInput::Record => along_record(p, &waves, &selection, &approach, &simulation),
            NicInput::Groups => {
                let through = |(field, place): (usize, usize)| approach.through_groups(&selection.groups[field], place);
                let runs: Vec<_> = selection.sampled().map(through).collect();
                max_roll_through_groups(&simulation, t_p, &runs, &[])
            }
        };
        Ok(selection.responses(&p.ship.epsilon_1, &r))
    }
}

/// The responses along the record, eight fields at a time: (epsilon_1)(sampled group).
fn along_record(
    p: &Params,
    waves: &WaveFields,
    selection: &Selection<'_>,
    approach: &Approach,
    simulation: &Simulation<'_>,
) -> Vec<Vec<f64>> {
    let mut synthesis = p.record.synthesis();
    let mut eta = Rows::new(p.record.samples());
    let mut r = vec![Vec::new(); p.ship.epsilon_1.len()];
    for first in (0..selection.groups.len()).step_by(WIDTH) {
        let in_block = |(field, _): &(usize, usize)| (first..first + WIDTH).contains(field);
        let through = |(field, place): (usize, usize)| {
            approach.through_record((field - first) as u32, &selection.groups[field], place)
        };
        let runs: Vec<RecordRun> = selection.sampled().filter(in_block).map(through).collect();
        if runs.is_empty() {
            continue;
        }
        waves.elevation(first, &mut synthesis, &mut eta);
        for (all, own) in r.iter_mut().zip(max_roll_along_record(simulation, &eta, &runs)) {
            all.extend(own);
        }
    }
    r
}
