//! Calibration study, §3: fields and groups of its own in every sea, so that it needs no long record.

use std::ops::Range;

use serde::{Deserialize, Serialize};

use crate::calibration::bench::Fields;
use crate::engine::error::Result;
use crate::engine::stage::{Here, Keep, Pieces, Stage};
use crate::numerics::domain;
use crate::sea::detection::{self, Detection};
use crate::sea::envelope::Envelopes;
use crate::sea::resolution;
use crate::sea::spectrum::Sea;
use crate::sea::wave_field::{Record, WaveFields};

/// Phases and groups; the groups by two similarity thresholds.
pub struct CalibrationFields;

/// Parameters of the fields.
#[derive(Serialize, Deserialize)]
pub struct Params {
    sea: Sea,
    record: Record,
    detection: Detection,
    calibration: Threshold,
}

/// The part of `[calibration]` that the detection needs.
#[derive(Serialize, Deserialize)]
pub struct Threshold {
    /// The other C_thr, 0 to below 1.
    #[serde(deserialize_with = "domain::fraction")]
    other_similarity_threshold: f64,
}

impl Stage for CalibrationFields {
    const NAME: &'static str = "calibration_fields";
    const PAPER: &'static str = "study";
    const PIECES: Pieces = Pieces::Batches("calibration.fields", 240);
    const KEEP: Keep = Keep::Evict;
    const SCHEMA: &'static str = "calibration-fields/1";
    type Params = Params;
    type Inputs = ();
    type Output = Fields;

    fn check(p: &Params) -> std::result::Result<(), String> {
        p.sea.check().map_err(|why| format!("sea.{why}"))?;
        p.record.check().map_err(|why| format!("record.{why}"))?;
        let lead_in = p.record.check_lead_in(p.sea.peak_period);
        lead_in.map_err(|why| format!("record.{why}"))?;
        p.detection.check().map_err(|why| format!("detection.{why}"))?;
        let found = p.calibration.other_similarity_threshold;
        if (0.0..1.0).contains(&found) {
            return Ok(());
        }
        Err(format!(
            "calibration.other_similarity_threshold: expected 0 to below 1, found {found}"
        ))
    }

    fn resolution(p: &Params) -> std::result::Result<Vec<String>, String> {
        let spacing = p.sea.peak_period / f64::from(p.record.envelope_samples_per_period);
        let of_groups = resolution::of_detection(p.sea.bandwidth, spacing, &p.detection);
        let of_modes = resolution::of_modes(&p.sea, &p.record);
        Ok(of_modes.into_iter().chain(of_groups).collect())
    }

    fn check_output(p: &Params, items: Range<u64>, output: &Fields) -> std::result::Result<(), String> {
        let fields = (items.end - items.start) as usize;
        output.waves.check(&p.sea, &p.record, fields)?;
        let t_p = p.sea.peak_period;
        let longest = p.detection.longest * t_p / f64::from(p.record.envelope_samples_per_period);
        let mut lists = output.groups.iter();
        lists.try_for_each(|groups| groups.check(fields, p.record.field_period(t_p), longest))
    }

    fn run(p: &Params, (): (), here: Here<'_>) -> Result<Fields> {
        let waves = WaveFields::draw(&p.sea, &p.record, here.streams());
        let envelopes = Envelopes::of(&waves, &p.record);
        let other = Detection {
            similarity_threshold: p.calibration.other_similarity_threshold,
            ..p.detection.clone()
        };
        let groups = [&p.detection, &other].map(|d| detection::detect(&envelopes, d));
        Ok(Fields { waves, groups })
    }
}
