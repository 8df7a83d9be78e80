//! §3.1 Constant initial condition (CIC): the ship meets each reconstructed group, Eq. (5), at rest. Eq. (3).

use std::ops::Range;
use std::sync::Arc;

use serde::{Deserialize, Serialize};

use crate::engine::arrow::{Each, One};
use crate::engine::error::{Error, Result};
use crate::engine::stage::{Here, Pieces, Stage};
use crate::sea::wave_field::Record;
use crate::sea::wave_group::{Groups, Sample};
use crate::ship::encounter::{Approach, GroupRun, max_roll_through_groups};
use crate::ship::initial_condition::Estimate;
use crate::ship::response::Truth;
use crate::ship::roll_equation::Ship;
use crate::ship::sample::{SampledResponses, Selection};
use crate::ship::simulation::Simulation;
use crate::stages::group_detection::GroupDetection;
use crate::stages::group_sample::GroupSample;
use crate::stages::resolution::{Waves, of_roll};

/// r(a, l): a number, since nothing about the encounter is random.
pub struct Cic;

/// Parameters of CIC.
#[derive(Serialize, Deserialize)]
pub struct Params {
    ship: Ship,
    sea: Waves,
    record: Record,
    truth: Truth,
    estimate: Estimate,
}

impl Stage for Cic {
    const NAME: &'static str = "cic";
    const PAPER: &'static str = "§3.1";
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
        p.estimate.check().map_err(|why| format!("estimate.{why}"))
    }

    fn run(p: &Params, (groups, sample): (Arc<Groups>, Arc<Sample>), here: Here<'_>) -> Result<SampledResponses> {
        let places = sample.of(here.first, &groups).map_err(Error::stage)?;
        let selection = Selection::new(groups.parameters(), places);
        let t_p = p.sea.peak_period;
        let approach = Approach::new(p.record.step_and_period(t_p), &p.truth, &p.estimate, 0);
        let runs: Vec<GroupRun> = selection.encounters().map(|group| approach.alone(group)).collect();
        let simulation = Simulation::new(&p.ship, &p.truth, approach.h);
        let r = max_roll_through_groups(&simulation, t_p, &runs, &[]);
        Ok(selection.responses(&p.ship.epsilon_1, &r))
    }
}
