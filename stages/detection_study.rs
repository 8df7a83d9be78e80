//! §4 (outlook) What the detection decides: the probability by groups and by time, for several similarity thresholds.
//!
//! The first fields of one sea are detected and rolled once for each threshold; the share of time above a level is that of
//! the roll alone, and beside it stands the part that the groups' segments hold.

use std::ops::Range;

use serde::{Deserialize, Serialize};

use crate::engine::arrow::{All, PiecesOf};
use crate::engine::error::Result;
use crate::engine::stage::{Here, Select, Stage};
use crate::numerics::domain::at_most;
use crate::numerics::fourier::WIDTH;
use crate::numerics::rows::Rows;
use crate::sea::detection::{Detection, detect};
use crate::sea::envelope::Envelopes;
use crate::sea::wave_field::{Record, WaveFields};
use crate::ship::continuous_roll::{Timing, continuous_record};
use crate::ship::exceedance::{Curve, Exceedances};
use crate::ship::response::Truth;
use crate::ship::roll_equation::Ship;
use crate::ship::sample::Selection;
use crate::ship::simulation::Simulation;
use crate::ship::temporal::{Counts, DetectionStudy, StudiedDetection};
use crate::stages::axes::SEA;
use crate::stages::resolution::{Waves, of_roll};
use crate::stages::wave_synthesis::WaveSynthesis;

/// Most similarity thresholds of the study.
const MOST_THRESHOLDS: u64 = 32;

/// Probability by groups and by time against the similarity threshold.
pub struct DetectionVaried;

/// Parameters of the study.
#[derive(Serialize, Deserialize)]
pub struct Params {
    ship: Ship,
    sea: Waves,
    record: Record,
    truth: Truth,
    detection: Detection,
    detection_study: Thresholds,
}

/// The `[detection_study]` table, but for the sea.
#[derive(Serialize, Deserialize)]
pub struct Thresholds {
    /// Fields looked at, from the first.
    fields: u32,
    /// C_thr of each detection.
    similarity_thresholds: Vec<f64>,
}

impl Stage for DetectionVaried {
    const NAME: &'static str = "detection_study";
    const PAPER: &'static str = "§4";
    const SELECTS: &'static [Select] = &[Select::At(SEA, "detection_study.sea")];
    const SCHEMA: &'static str = "detection-study/1";
    type Params = Params;
    type Inputs = (All<WaveSynthesis>,);
    type Output = DetectionStudy;

    fn check(p: &Params) -> std::result::Result<(), String> {
        p.ship.check().map_err(|why| format!("ship.{why}"))?;
        p.truth.check().map_err(|why| format!("truth.{why}"))?;
        let thresholds = &p.detection_study.similarity_thresholds;
        let since = "the record is detected and rolled anew for each";
        at_most(
            "detection_study.similarity_thresholds",
            thresholds.len() as u64,
            MOST_THRESHOLDS,
            since,
        )?;
        if p.detection_study.fields == 0 {
            return Err("detection_study.fields: expected a whole number >= 1, found 0".to_owned());
        }
        if thresholds.is_empty() {
            return Err("detection_study.similarity_thresholds: expected at least one number, found none".to_owned());
        }
        thresholds.iter().try_for_each(|threshold| {
            let detection = p.with_threshold(*threshold);
            detection
                .check()
                .map_err(|why| format!("detection_study.similarity_thresholds: {why}"))
        })
    }

    fn resolution(p: &Params) -> std::result::Result<Vec<String>, String> {
        of_roll(&p.ship, &p.truth, &p.sea.grid(&p.record))
    }

    fn check_output(p: &Params, _: Range<u64>, output: &DetectionStudy) -> std::result::Result<(), String> {
        let (levels, epsilons) = (p.truth.temporal_levels.values(), p.ship.epsilon_1.len());
        output.check(&p.detection_study.similarity_thresholds, epsilons, &levels)
    }

    fn run(p: &Params, (record,): (PiecesOf<'_, WaveFields>,), _: Here<'_>) -> Result<DetectionStudy> {
        let levels = p.truth.temporal_levels.values();
        let thresholds = &p.detection_study.similarity_thresholds;
        let mut counts = vec![Counts::none(levels.len(), p.ship.epsilon_1.len()); thresholds.len()];
        let mut left = p.detection_study.fields as usize;
        for piece in record.iter() {
            let mut waves = WaveFields::clone(&*piece?);
            waves.phase.truncate(left);
            left -= waves.phase.len();
            for (threshold, counts) in thresholds.iter().zip(&mut counts) {
                p.count(&waves, *threshold, &levels, counts);
            }
            if left == 0 {
                break;
            }
        }
        let curves = |counts: &[Exceedances], method: &str| -> Vec<Curve> {
            let own = counts.iter().zip(&p.ship.epsilon_1);
            own.map(|(counts, epsilon_1)| counts.curve(method, *epsilon_1, &levels))
                .collect()
        };
        let detection = |(threshold, counts): (&f64, &Counts)| StudiedDetection {
            similarity_threshold: *threshold,
            by_groups: curves(&counts.by_groups, "truth"),
            within_groups: curves(&counts.within_groups, "within_groups"),
        };
        Ok(DetectionStudy {
            fields: u64::from(p.detection_study.fields) - left as u64,
            // The roll knows no groups: every detection leaves the same.
            temporal: curves(&counts[0].by_time, "temporal"),
            detections: thresholds.iter().zip(&counts).map(detection).collect(),
        })
    }
}

impl Params {
    fn with_threshold(&self, similarity_threshold: f64) -> Detection {
        Detection {
            similarity_threshold,
            ..self.detection.clone()
        }
    }

    /// Detects the groups of some fields, lets the ship roll along them and counts.
    fn count(&self, waves: &WaveFields, similarity_threshold: f64, levels: &[f64], counts: &mut Counts) {
        let detection = self.with_threshold(similarity_threshold);
        let groups = detect(&Envelopes::of(waves, &self.record), &detection);
        let encounters = Selection::new(groups.parameters(), &[]).groups;
        let spacing = waves.t_p / f64::from(self.record.envelope_samples_per_period);
        let samples = self.record.samples();
        let reach = self.truth.window * detection.longest * spacing;
        let period = self.record.field_period(waves.t_p);
        let timing = Timing::new(period, samples as u32, self.record.lead_in, reach);
        let simulation = Simulation::new(&self.ship, &self.truth, timing.h);
        let mut synthesis = self.record.synthesis();
        let mut eta = Rows::new(samples);
        for (block, encounters) in encounters.chunks(WIDTH).enumerate() {
            waves.elevation(block * WIDTH, &mut synthesis, &mut eta);
            let rolled = continuous_record(&simulation, &timing, &eta, encounters);
            counts.add(&rolled, encounters, levels, self.truth.window, period);
        }
    }
}
