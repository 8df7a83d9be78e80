//! §2 Wave field: modes and random phases of every field of the record; never the series, which regenerate from these.
//!
//! Gaussian seas (W1) and JONSWAP (W2) share the phases of a field: rows of Table 1 are correlated.

use std::ops::Range;

use serde::{Deserialize, Serialize};

use crate::engine::error::Result;
use crate::engine::stage::{Here, Keep, Pieces, Stage};
use crate::sea::resolution;
use crate::sea::spectrum::Sea;
use crate::sea::wave_field::{Record, WaveFields};

/// (W1)-(W4): one random stream per field.
pub struct WaveSynthesis;

/// Parameters of the wave field.
#[derive(Serialize, Deserialize)]
pub struct Params {
    sea: Sea,
    record: Record,
}

impl Stage for WaveSynthesis {
    const NAME: &'static str = "wave_synthesis";
    const PAPER: &'static str = "§2";
    const PIECES: Pieces = Pieces::Batches("record.fields", 240);
    const KEEP: Keep = Keep::Evict;
    const SCHEMA: &'static str = "wave-fields/1";
    type Params = Params;
    type Inputs = ();
    type Output = WaveFields;

    fn check(p: &Params) -> std::result::Result<(), String> {
        p.sea.check().map_err(|why| format!("sea.{why}"))?;
        p.record.check().map_err(|why| format!("record.{why}"))?;
        let lead_in = p.record.check_lead_in(p.sea.peak_period);
        lead_in.map_err(|why| format!("record.{why}"))
    }

    fn resolution(p: &Params) -> std::result::Result<Vec<String>, String> {
        Ok(resolution::of_modes(&p.sea, &p.record))
    }

    fn check_output(p: &Params, items: Range<u64>, output: &WaveFields) -> std::result::Result<(), String> {
        output.check(&p.sea, &p.record, (items.end - items.start) as usize)
    }

    fn run(p: &Params, (): (), here: Here<'_>) -> Result<WaveFields> {
        Ok(WaveFields::draw(&p.sea, &p.record, here.streams()))
    }
}
