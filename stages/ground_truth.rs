//! §3 Ground truth: the continuous roll of a ship along the whole record, and its response to every wave group, Eq. (1).
//!
//! All epsilon_1 of the ship roll on the same elevation while it is in cache; the series themselves are never kept.

use std::ops::Range;
use std::sync::Arc;

use serde::{Deserialize, Serialize};

use crate::engine::arrow::Each;
use crate::engine::error::Result;
use crate::engine::stage::{Here, Pieces, Stage};
use crate::numerics::fourier::WIDTH;
use crate::numerics::rows::Rows;
use crate::sea::wave_field::{Record, WaveFields};
use crate::sea::wave_group::Groups;
use crate::ship::continuous_roll::{Timing, continuous_record};
use crate::ship::exceedance::Exceedances;
use crate::ship::response::{Truth, Truths};
use crate::ship::roll_equation::Ship;
use crate::ship::sample::Selection;
use crate::ship::simulation::Simulation;
use crate::stages::group_detection::GroupDetection;
use crate::stages::resolution::{Waves, of_roll};
use crate::stages::wave_synthesis::WaveSynthesis;

/// (6) along the record.
pub struct GroundTruth;

/// Parameters of the ground truth.
#[derive(Serialize, Deserialize)]
pub struct Params {
    ship: Ship,
    sea: Waves,
    record: Record,
    truth: Truth,
    detection: Longest,
}

impl Params {
    /// Keeps a run from outlasting its field many times over.
    fn check_reach(&self) -> std::result::Result<(), String> {
        let periods = f64::from(self.record.periods_per_field);
        let longest = self.detection.longest / f64::from(self.record.envelope_samples_per_period);
        let most = periods / longest;
        if self.truth.window > most {
            let found = self.truth.window;
            return Err(format!(
                "truth.window: expected at most {most}, one field about the longest group, found {found}"
            ));
        }
        let most = 1000.0 * periods;
        if self.record.lead_in > most {
            let found = self.record.lead_in;
            return Err(format!("record.lead_in: expected at most {most} s, found {found}"));
        }
        Ok(())
    }
}

/// The part of `[detection]` that says how far past its field a segment may reach.
#[derive(Serialize, Deserialize)]
pub struct Longest {
    /// Longest group, envelope samples.
    longest: f64,
}

impl Stage for GroundTruth {
    const NAME: &'static str = "ground_truth";
    const PAPER: &'static str = "§3";
    const PIECES: Pieces = Pieces::AsUpstream;
    const SCHEMA: &'static str = "ground-truth/2";
    type Params = Params;
    type Inputs = (Each<WaveSynthesis>, Each<GroupDetection>);
    type Output = Truths;

    fn check(p: &Params) -> std::result::Result<(), String> {
        p.ship.check().map_err(|why| format!("ship.{why}"))?;
        p.truth.check().map_err(|why| format!("truth.{why}"))?;
        p.check_reach()
    }

    fn resolution(p: &Params) -> std::result::Result<Vec<String>, String> {
        of_roll(&p.ship, &p.truth, &p.sea.grid(&p.record))
    }

    fn check_output(p: &Params, items: Range<u64>, output: &Truths) -> std::result::Result<(), String> {
        // A block of sixteen steps leaves one angle.
        let steps = u64::from(p.record.samples_per_period / 2) * u64::from(p.record.periods_per_field);
        let fields = (items.end - items.start) as usize;
        output.check(&p.ship.epsilon_1, fields, &p.truth, steps.div_ceil(16))
    }

    fn run(p: &Params, (waves, groups): (Arc<WaveFields>, Arc<Groups>), _: Here<'_>) -> Result<Truths> {
        let samples = p.record.samples();
        let spacing = waves.t_p / f64::from(p.record.envelope_samples_per_period);
        let reach = p.truth.window * p.detection.longest * spacing;
        let timing = Timing::new(
            p.record.field_period(waves.t_p),
            samples as u32,
            p.record.lead_in,
            reach,
        );
        let simulation = Simulation::new(&p.ship, &p.truth, timing.h);
        let encounters = Selection::new(groups.parameters(), &[]).groups;
        let mut synthesis = p.record.synthesis();
        let mut eta = Rows::new(samples);
        let levels = p.truth.temporal_levels.values();
        let mut fields = vec![Vec::new(); p.ship.epsilon_1.len()];
        let mut temporal = vec![Exceedances::none(levels.len()); p.ship.epsilon_1.len()];
        for (block, encounters) in encounters.chunks(WIDTH).enumerate() {
            waves.elevation(block * WIDTH, &mut synthesis, &mut eta);
            let rolled = continuous_record(&simulation, &timing, &eta, encounters);
            for (e, (responses, angles)) in rolled.responses.into_iter().zip(rolled.angles).enumerate() {
                for (response, angles) in responses.iter().zip(&angles) {
                    if !response.dropped {
                        temporal[e].add_field(&levels, angles);
                    }
                }
                fields[e].extend(responses);
            }
        }
        Ok(Truths {
            epsilon_1: p.ship.epsilon_1.clone(),
            fields,
            temporal,
        })
    }
}
