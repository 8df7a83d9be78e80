//! §4 The estimates of every method over the number of samples: what Figure 5 and Table 1 show.

use std::ops::Range;
use std::sync::Arc;

use serde::{Deserialize, Serialize};

use crate::design::convergence::{Convergence as Methods, Spread};
use crate::design::floor::Floors;
use crate::design::response_pool::RandomEstimates;
use crate::design::sequential::Realisation;
use crate::engine::arrow::{All, One, PiecesOf};
use crate::engine::error::Result;
use crate::engine::stage::{Here, Select, Stage};
use crate::stages::axes::SEA;
use crate::stages::random_sampling::RandomSampling;
use crate::stages::sampling_floor::SamplingFloor;
use crate::stages::vhgp_best::VhgpBest;
use crate::stages::vhgp_control::VhgpControl;
use crate::stages::vhgp_lhs::VhgpLhs;
use crate::stages::vhgp_seq::VhgpSeq;

/// Means and standard deviations over the realisations, for one case of Table 1.
pub struct Convergence;

/// It has no parameters.
#[derive(Serialize, Deserialize)]
pub struct Params {}

impl Stage for Convergence {
    const NAME: &'static str = "convergence";
    const PAPER: &'static str = "§4";
    const SELECTS: &'static [Select] = &[Select::Rows(SEA, "vhgp_seq.case")];
    const SCHEMA: &'static str = "convergence/2";
    type Params = Params;
    type Inputs = (
        All<VhgpSeq>,
        All<VhgpBest>,
        All<VhgpControl>,
        All<VhgpLhs>,
        All<RandomSampling>,
        One<SamplingFloor>,
    );
    type Output = Methods;

    fn check_output(_: &Params, _: Range<u64>, output: &Methods) -> std::result::Result<(), String> {
        output.check()
    }

    fn run(
        _: &Params,
        (sequential, best, control, lhs, random, floors): (
            PiecesOf<'_, Realisation>,
            PiecesOf<'_, Realisation>,
            PiecesOf<'_, Realisation>,
            PiecesOf<'_, Realisation>,
            PiecesOf<'_, RandomEstimates>,
            Arc<Floors>,
        ),
        _: Here<'_>,
    ) -> Result<Methods> {
        let random: Result<Vec<_>> = random
            .iter()
            .map(|piece| piece.map(|r| (r.n_samples.clone(), r.estimate.clone())))
            .collect();
        Ok(Methods {
            realisations: sequential.len() as u64,
            sequential: spread(&sequential)?,
            best: spread(&best)?,
            control: spread(&control)?,
            lhs: spread(&lhs)?,
            random: Spread::of(&random?),
            floors: *floors,
        })
    }
}

fn spread(realisations: &PiecesOf<'_, Realisation>) -> Result<Spread> {
    let lines: Result<Vec<_>> = realisations
        .iter()
        .map(|piece| piece.map(|r| (r.n_samples.clone(), r.estimate.clone())))
        .collect();
    Ok(Spread::of(&lines?))
}
