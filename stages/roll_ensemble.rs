//! §3.2 Pre-computed initial conditions: the states of continuous roll over `[pic] periods` of the record.
//!
//! States inside wave groups are in it: the paper's own explanation of why PIC overestimates.

use std::ops::Range;

use serde::{Deserialize, Serialize};

use crate::engine::arrow::{All, PiecesOf};
use crate::engine::error::Result;
use crate::engine::stage::{Here, Stage};
use crate::numerics::fourier::WIDTH;
use crate::numerics::rows::Rows;
use crate::sea::wave_field::{Record, WaveFields};
use crate::ship::continuous_roll::{Timing, continuous_states};
use crate::ship::initial_condition::{Ensemble, Pic, RollState};
use crate::ship::response::Truth;
use crate::ship::roll_equation::Ship;
use crate::ship::simulation::Simulation;
use crate::stages::resolution::{Waves, of_roll, of_states};
use crate::stages::wave_synthesis::WaveSynthesis;

/// (theta, theta_dot) at every envelope time of the first fields.
pub struct RollEnsemble;

/// Parameters of the ensemble.
#[derive(Serialize, Deserialize)]
pub struct Params {
    ship: Ship,
    sea: Waves,
    record: Record,
    truth: Truth,
    pic: Pic,
}

impl Stage for RollEnsemble {
    const NAME: &'static str = "roll_ensemble";
    const PAPER: &'static str = "§3.2";
    const SCHEMA: &'static str = "roll-ensemble/1";
    type Params = Params;
    type Inputs = (All<WaveSynthesis>,);
    type Output = Ensemble;

    fn resolution(p: &Params) -> std::result::Result<Vec<String>, String> {
        of_states(&p.record)?;
        of_roll(&p.ship, &p.truth, &p.sea.grid(&p.record))
    }

    fn check_output(p: &Params, _: Range<u64>, output: &Ensemble) -> std::result::Result<(), String> {
        output.check(&p.ship.epsilon_1, p.truth.capsize_angle)
    }

    fn check(p: &Params) -> std::result::Result<(), String> {
        p.ship.check().map_err(|why| format!("ship.{why}"))?;
        p.truth.check().map_err(|why| format!("truth.{why}"))?;
        let states = p.ship.epsilon_1.len() as u64 * u64::from(p.record.envelope_samples_per_period);
        let bytes = states * size_of::<RollState>() as u64;
        p.pic.check(bytes).map_err(|why| format!("pic.{why}"))
    }

    fn run(p: &Params, (record,): (PiecesOf<'_, WaveFields>,), _: Here<'_>) -> Result<Ensemble> {
        let samples = p.record.samples();
        let per_field = p.record.periods_per_field;
        let per_period = p.record.envelope_samples_per_period;
        let stride = p.record.samples_per_period / 2 / per_period;
        let mut synthesis = p.record.synthesis();
        let mut eta = Rows::new(samples);
        let mut states = vec![Vec::new(); p.ship.epsilon_1.len()];
        let mut field = 0;
        for piece in record.iter() {
            if p.pic.states_of_field(field, per_field, per_period) == 0 {
                break;
            }
            let waves = piece?;
            let timing = Timing::new(p.record.field_period(waves.t_p), samples as u32, p.record.lead_in, 0.0);
            let simulation = Simulation::new(&p.ship, &p.truth, timing.h);
            for first in (0..waves.phase.len()).step_by(WIDTH) {
                let used = WIDTH.min(waves.phase.len() - first);
                waves.elevation(first, &mut synthesis, &mut eta);
                let block = continuous_states(&simulation, &timing, &eta, used, stride);
                for column in 0..used {
                    let wanted = p.pic.states_of_field(field, per_field, per_period);
                    for (all, own) in states.iter_mut().zip(&block) {
                        all.extend(&own[column][..wanted]);
                    }
                    field += 1;
                }
                if p.pic.states_of_field(field, per_field, per_period) == 0 {
                    break;
                }
            }
        }
        Ok(Ensemble {
            epsilon_1: p.ship.epsilon_1.clone(),
            states,
        })
    }
}
