//! §2 Wave groups: where, how long and how high the Gaussian groups of every envelope are, by (2).

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use crate::engine::arrow::Each;
use crate::engine::error::Result;
use crate::engine::stage::{Here, Pieces, Stage};
use crate::sea::detection::{self, Detection};
use crate::sea::envelope::Envelopes;
use crate::sea::wave_group::Groups;
use crate::stages::envelope::Envelope;

/// Scale space, refinement, similarity fit, removal of overlaps.
pub struct GroupDetection;

/// Parameters of the detection.
#[derive(Serialize, Deserialize)]
pub struct Params {
    detection: Detection,
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

    fn run(p: &Params, (envelopes,): (Arc<Envelopes>,), _: Here<'_>) -> Result<Groups> {
        Ok(detection::detect(&envelopes, &p.detection))
    }
}
