//! §4 The pool of the sequential design: every sampled group with the response that NIC found, and the density of groups.
//!
//! A query of the design is answered from here: NIC has run on each of these groups once, and running it again gives the
//! same bits.

use std::ops::Range;

use serde::{Deserialize, Serialize};

use crate::design::input_density::Grid;
use crate::design::response_pool::ResponsePool as Pool;
use crate::engine::arrow::{All, PiecesOf};
use crate::engine::error::{Error, Result};
use crate::engine::stage::{Here, Select, Stage};
use crate::numerics::fourier::WIDTH;
use crate::numerics::invariant;
use crate::sea::detection::Detection;
use crate::sea::detection::counts::Counts;
use crate::sea::envelope::Envelopes;
use crate::sea::spectrum::Sea;
use crate::sea::wave_field::{Record, WaveFields};
use crate::ship::sample::SampledResponses;
use crate::stages::axes::SEA;
use crate::stages::nic::Nic;

/// Groups and responses of one case of Table 1.
pub struct ResponsePool;

/// Parameters of the pool.
#[derive(Serialize, Deserialize)]
pub struct Params {
    ship: Excitations,
    sea: Sea,
    record: Record,
    detection: Detection,
    vhgp_seq: Input,
}

/// Fields that are looked at to say why there is no group.
const LOOKED_AT: u64 = WIDTH as u64;

impl Params {
    /// Why no group was detected: what the detection leaves, step by step, of a few fields drawn for this message alone.
    fn no_group(&self, here: &Here<'_>) -> String {
        let streams = (0..LOOKED_AT).map(|item| here.stream(item));
        let waves = WaveFields::draw(&self.sea, &self.record, streams);
        let counts = Counts::of(&Envelopes::of(&waves, &self.record), &self.detection);
        format!(
            "no wave group was detected, so nothing can be sampled: {counts}; {}",
            counts.remedy()
        )
    }
}

/// The part of the ship that the design chooses from.
#[derive(Serialize, Deserialize)]
pub struct Excitations {
    /// 1/(m s^2).
    epsilon_1: Vec<f64>,
}

/// The part of `[vhgp_seq]` about the design's input.
#[derive(Serialize, Deserialize)]
pub struct Input {
    /// Which value of the ship's epsilon_1 list.
    epsilon_1_index: u32,
    /// Box of (L/T_p, A/H_s).
    domain: [[f64; 2]; 2],
    /// Candidates along each.
    grid: [u32; 2],
    /// Bandwidth of the kernel density p.
    bandwidth: [f64; 2],
}

impl Stage for ResponsePool {
    const NAME: &'static str = "response_pool";
    const PAPER: &'static str = "§4";
    const SELECTS: &'static [Select] = &[Select::Rows(SEA, "vhgp_seq.case")];
    const SCHEMA: &'static str = "response-pool/2";
    type Params = Params;
    type Inputs = (All<Nic>,);
    type Output = Pool;

    fn check(p: &Params) -> std::result::Result<(), String> {
        let (index, count) = (p.vhgp_seq.epsilon_1_index, p.ship.epsilon_1.len());
        if (index as usize) < count {
            return Ok(());
        }
        Err(format!(
            "vhgp_seq.epsilon_1_index: expected a whole number below {count}, the length of `ship.epsilon_1`, found {index}"
        ))
    }

    fn check_output(p: &Params, _: Range<u64>, output: &Pool) -> std::result::Result<(), String> {
        let index = p.vhgp_seq.epsilon_1_index as usize;
        let expected = p.ship.epsilon_1.get(index).copied().unwrap_or_default();
        invariant::equal("epsilon_1", &output.epsilon_1, &expected)?;
        output.check(p.vhgp_seq.grid[0] as usize * p.vhgp_seq.grid[1] as usize)
    }

    fn run(p: &Params, (nic,): (PiecesOf<'_, SampledResponses>,), here: Here<'_>) -> Result<Pool> {
        let (mut epsilon_1, mut points, mut r) = (0.0, Vec::new(), Vec::new());
        for piece in nic.iter() {
            let piece = piece?;
            let index = p.vhgp_seq.epsilon_1_index as usize;
            let known = piece.epsilon_1.get(index).zip(piece.r.get(index));
            let (value, own) = known.ok_or_else(|| {
                let count = piece.epsilon_1.len();
                Error::stage(format!(
                    "vhgp_seq.epsilon_1_index: expected less than {count}, the length of the ship's list, found {index}"
                ))
            })?;
            epsilon_1 = *value;
            let sizes = piece.l.iter().flatten().zip(piece.a.iter().flatten());
            points.extend(sizes.map(|(l, a)| [l / p.sea.peak_period, a / p.sea.significant_wave_height]));
            r.extend(own.iter().flatten());
        }
        if points.is_empty() {
            return Err(Error::stage(p.no_group(&here)));
        }
        let grid = Grid {
            lower: p.vhgp_seq.domain.map(|range| range[0]),
            upper: p.vhgp_seq.domain.map(|range| range[1]),
            size: p.vhgp_seq.grid,
        };
        let density = grid.density(&points, p.vhgp_seq.bandwidth);
        Ok(Pool {
            epsilon_1,
            points,
            r,
            density,
        })
    }
}
