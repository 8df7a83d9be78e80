//! §2 Envelope: rho = |eta + i H(eta)| of every field, on the envelope grid.

use std::ops::Range;
use std::sync::Arc;

use serde::{Deserialize, Serialize};

use crate::engine::arrow::Each;
use crate::engine::error::Result;
use crate::engine::stage::{Here, Keep, Pieces, Stage};
use crate::sea::envelope::Envelopes;
use crate::sea::wave_field::{Record, WaveFields};
use crate::stages::resolution::Waves;
use crate::stages::wave_synthesis::WaveSynthesis;

/// (E1).
pub struct Envelope;

/// Parameters of the envelope.
#[derive(Serialize, Deserialize)]
pub struct Params {
    sea: Waves,
    record: Record,
}

impl Stage for Envelope {
    const NAME: &'static str = "envelope";
    const PAPER: &'static str = "§2";
    const PIECES: Pieces = Pieces::AsUpstream;
    const KEEP: Keep = Keep::Evict;
    const SCHEMA: &'static str = "envelopes/1";
    type Params = Params;
    type Inputs = (Each<WaveSynthesis>,);
    type Output = Envelopes;

    fn check_output(p: &Params, items: Range<u64>, output: &Envelopes) -> std::result::Result<(), String> {
        let Waves {
            peak_period,
            significant_wave_height,
        } = p.sea;
        let fields = (items.end - items.start) as usize;
        output.check(peak_period, significant_wave_height, &p.record, fields)
    }

    fn run(p: &Params, (fields,): (Arc<WaveFields>,), _: Here<'_>) -> Result<Envelopes> {
        Ok(Envelopes::of(&fields, &p.record))
    }
}
