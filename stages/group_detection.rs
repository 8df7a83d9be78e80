//! §2 Wave groups: where, how long and how high the Gaussian groups of every envelope are, by (2).

use std::ops::Range;
use std::sync::Arc;

use serde::{Deserialize, Serialize};

use crate::engine::arrow::Each;
use crate::engine::error::Result;
use crate::engine::stage::{Here, Pieces, Stage};
use crate::numerics::domain;
use crate::sea::detection::{self, Detection};
use crate::sea::envelope::Envelopes;
use crate::sea::resolution;
use crate::sea::wave_group::Groups;
use crate::stages::envelope::Envelope;

/// Scale space, refinement, similarity fit, removal of overlaps.
pub struct GroupDetection;

/// Parameters of the detection.
#[derive(Serialize, Deserialize)]
pub struct Params {
    sea: Peak,
    record: Grid,
    detection: Detection,
}

/// The part of `[sea.NAME]` that says how long its groups are.
#[derive(Serialize, Deserialize)]
pub struct Peak {
    /// T_p, s.
    #[serde(deserialize_with = "domain::positive")]
    peak_period: f64,
    /// K, rad/s; of a Gaussian sea alone.
    #[serde(default)]
    bandwidth: Option<f64>,
}

/// The part of `[record]` that says how long a field and a sample of its envelope are.
#[derive(Serialize, Deserialize)]
pub struct Grid {
    /// Length of a field, T_p.
    #[serde(deserialize_with = "domain::power_of_two")]
    periods_per_field: u32,
    /// Samples of the envelope per T_p.
    #[serde(deserialize_with = "domain::power_of_two")]
    envelope_samples_per_period: u32,
}

impl Params {
    /// Time between samples of the envelope, s.
    fn spacing(&self) -> f64 {
        self.sea.peak_period / f64::from(self.record.envelope_samples_per_period)
    }

    /// The period T_f of a field, s.
    fn field_period(&self) -> f64 {
        self.sea.peak_period * f64::from(self.record.periods_per_field)
    }
}

impl Stage for GroupDetection {
    const NAME: &'static str = "group_detection";
    const PAPER: &'static str = "§2";
    const PIECES: Pieces = Pieces::AsUpstream;
    const SCHEMA: &'static str = "wave-groups/1";
    type Params = Params;
    type Inputs = (Each<Envelope>,);
    type Output = Groups;

    fn check(p: &Params) -> std::result::Result<(), String> {
        p.detection.check().map_err(|why| format!("detection.{why}"))
    }

    fn resolution(p: &Params) -> std::result::Result<Vec<String>, String> {
        let warning = resolution::of_detection(p.sea.bandwidth, p.spacing(), &p.detection);
        Ok(warning.into_iter().collect())
    }

    fn check_output(p: &Params, items: Range<u64>, output: &Groups) -> std::result::Result<(), String> {
        let longest = p.detection.longest * p.spacing();
        output.check((items.end - items.start) as usize, p.field_period(), longest)
    }

    fn run(p: &Params, (envelopes,): (Arc<Envelopes>,), _: Here<'_>) -> Result<Groups> {
        Ok(detection::detect(&envelopes, &p.detection))
    }
}
