//! §3.2 Pre-computed initial condition (PIC): each reconstructed group, Eq. (5), is met in a state drawn from the ensemble
//! of continuous roll. Eq. (4).

use std::ops::Range;
use std::sync::Arc;

use serde::{Deserialize, Serialize};

use crate::engine::arrow::{Each, One};
use crate::engine::error::{Error, Result};
use crate::engine::stage::{Here, Pieces, Stage};
use crate::numerics::random;
use crate::sea::wave_field::Record;
use crate::sea::wave_group::{Groups, Sample};
use crate::ship::encounter::{Approach, GroupRun, max_roll_through_groups};
use crate::ship::initial_condition::{Ensemble, Estimate, RollState};
use crate::ship::response::Truth;
use crate::ship::roll_equation::Ship;
use crate::ship::sample::{SampledResponses, Selection};
use crate::ship::simulation::Simulation;
use crate::stages::group_detection::GroupDetection;
use crate::stages::group_sample::GroupSample;
use crate::stages::resolution::{Waves, of_roll};
use crate::stages::roll_ensemble::RollEnsemble;

/// R(a, l) by the ensemble.
pub struct Pic;

/// Parameters of PIC.
#[derive(Serialize, Deserialize)]
pub struct Params {
    ship: Ship,
    sea: Waves,
    record: Record,
    truth: Truth,
    estimate: Estimate,
}

impl Stage for Pic {
    const NAME: &'static str = "pic";
    const PAPER: &'static str = "§3.2";
    const PIECES: Pieces = Pieces::AsUpstream;
    const SCHEMA: &'static str = "sampled-responses/1";
    type Params = Params;
    type Inputs = (Each<GroupDetection>, One<GroupSample>, One<RollEnsemble>);
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

    fn run(
        p: &Params,
        (groups, sample, ensemble): (Arc<Groups>, Arc<Sample>, Arc<Ensemble>),
        here: Here<'_>,
    ) -> Result<SampledResponses> {
        let places = sample.of(here.first, &groups).map_err(Error::stage)?;
        let selection = Selection::new(groups.parameters(), places);
        let t_p = p.sea.peak_period;
        let approach = Approach::new(p.record.step_and_period(t_p), &p.truth, &p.estimate, 0);
        let runs: Vec<GroupRun> = selection.encounters().map(|group| approach.alone(group)).collect();
        let draws = draws(&selection, &here, ensemble.states[0].len());
        let initial: Vec<Vec<RollState>> = ensemble
            .states
            .iter()
            .map(|states| draws.iter().map(|draw| states[*draw]).collect())
            .collect();
        let simulation = Simulation::new(&p.ship, &p.truth, approach.h);
        let r = max_roll_through_groups(&simulation, t_p, &runs, &initial);
        Ok(selection.responses(&p.ship.epsilon_1, &r))
    }
}

/// A place in the ensemble for each sampled group. Every group of a field draws one, sampled or not, so that another
/// sample does not shuffle them; all epsilon_1 take the same place.
fn draws(selection: &Selection<'_>, here: &Here<'_>, ensemble: usize) -> Vec<usize> {
    let of_field =
        |(groups, mut stream): (usize, _)| (0..groups).map(move |_| random::below(&mut stream, ensemble)).collect();
    let counts = selection.groups.iter().map(Vec::len);
    let all: Vec<Vec<usize>> = counts.zip(here.streams()).map(of_field).collect();
    selection.sampled().map(|(field, place)| all[field][place]).collect()
}
