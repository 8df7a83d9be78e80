//! §3 The groups that the three methods run on: drawn without replacement from all groups of the record.
//!
//! One sample per sea, shared by ships, methods and epsilon_1, so that their curves differ by method alone.

use std::ops::Range;

use serde::{Deserialize, Serialize};

use crate::engine::arrow::{All, PiecesOf};
use crate::engine::error::Result;
use crate::engine::stage::{Here, Stage};
use crate::numerics::random;
use crate::sea::wave_group::{Groups, Sample};
use crate::stages::group_detection::GroupDetection;

/// `[estimate] samples` groups of the record, or all if there are fewer.
pub struct GroupSample;

/// Parameters of the sample.
#[derive(Serialize, Deserialize)]
pub struct Params {
    estimate: Samples,
}

/// The part of `[estimate]` that the draw depends on.
#[derive(Serialize, Deserialize)]
pub struct Samples {
    /// Random groups per case for CIC, PIC and NIC.
    #[serde(deserialize_with = "crate::numerics::domain::count")]
    samples: u32,
}

impl Stage for GroupSample {
    const NAME: &'static str = "group_sample";
    const PAPER: &'static str = "§3";
    const SCHEMA: &'static str = "group-sample/1";
    type Params = Params;
    type Inputs = (All<GroupDetection>,);
    type Output = Sample;

    fn check_output(p: &Params, _: Range<u64>, output: &Sample) -> std::result::Result<(), String> {
        output.check(p.estimate.samples)
    }

    fn run(p: &Params, (groups,): (PiecesOf<'_, Groups>,), here: Here<'_>) -> Result<Sample> {
        let mut counts = Vec::new();
        for piece in groups.iter() {
            counts.extend(piece?.fields.iter().map(Vec::len));
        }
        let mut left = counts.iter().sum::<usize>();
        let mut wanted = left.min(p.estimate.samples as usize);
        let mut stream = here.stream(0);
        // Selection sampling: each group is taken with the share of those still wanted among those left.
        let mut take = |_: &u32| {
            let taken = (random::uniform(&mut stream) * left as f64) < wanted as f64;
            left -= 1;
            wanted -= usize::from(taken);
            taken
        };
        let fields = counts
            .into_iter()
            .map(|count| (0..count as u32).filter(&mut take).collect())
            .collect();
        Ok(Sample { fields })
    }
}
