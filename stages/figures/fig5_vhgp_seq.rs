//! Figure 5: the estimate against the number of samples, VHGP-Seq beside three other methods and their floor.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use crate::design::floor::Floor;
use crate::design::response_pool::RandomEstimates;
use crate::design::sequential::Realisation;
use crate::design::settings::Case;
use crate::engine::arrow::{All, One, PiecesOf};
use crate::engine::error::{Error, Result};
use crate::engine::stage::{Here, Published, Select, Stage};
use crate::numerics::sums::{mean, standard_deviation};
use crate::plot::convergence::{Convergence, Estimates, csv, draw};
use crate::ship::exceedance::Probabilities;
use crate::stages::axes::SEA;
use crate::stages::exceedance::Exceedance;
use crate::stages::figures::scenes::refused;
use crate::stages::random_sampling::RandomSampling;
use crate::stages::sampling_floor::SamplingFloor;
use crate::stages::vhgp_best::VhgpBest;
use crate::stages::vhgp_lhs::VhgpLhs;
use crate::stages::vhgp_seq::VhgpSeq;

/// Figure 5.
pub struct Fig5VhgpSeq;

/// Parameters of the figure.
#[derive(Serialize, Deserialize)]
pub struct Params {
    case: Names,
    vhgp_seq: Rows,
}

/// The names of ship and sea.
#[derive(Serialize, Deserialize)]
pub struct Names {
    ship: String,
    sea: String,
}

/// The part of `[vhgp_seq]` that the figure shows.
#[derive(Serialize, Deserialize)]
pub struct Rows {
    case: Vec<Case>,
    epsilon_1_index: u32,
}

impl Stage for Fig5VhgpSeq {
    const NAME: &'static str = "fig5_vhgp_seq";
    const PAPER: &'static str = "Fig. 5";
    const SELECTS: &'static [Select] = &[Select::At(SEA, "fig5_vhgp_seq.sea")];
    const SCHEMA: &'static str = Published::SCHEMA;
    type Params = Params;
    type Inputs = (
        All<VhgpSeq>,
        All<VhgpBest>,
        All<VhgpLhs>,
        All<RandomSampling>,
        One<SamplingFloor>,
        One<Exceedance>,
    );
    type Output = Published;

    fn run(
        p: &Params,
        (sequential, best, lhs, random, floor, truth): (
            PiecesOf<'_, Realisation>,
            PiecesOf<'_, Realisation>,
            PiecesOf<'_, Realisation>,
            PiecesOf<'_, RandomEstimates>,
            Arc<Option<Floor>>,
            Arc<Probabilities>,
        ),
        _: Here<'_>,
    ) -> Result<Published> {
        let row = p.vhgp_seq.case.iter().find(|row| row.sea == p.case.sea);
        let theta_t = row
            .map(|row| row.theta_t)
            .ok_or_else(|| Error::stage("no row of vhgp_seq.case names this sea"))?;
        let realisations = sequential.len() as u64;
        let random: Vec<(Vec<u32>, Vec<f64>)> = random
            .iter()
            .map(|piece| piece.map(|r| (r.n_samples.clone(), r.estimate.clone())))
            .collect::<Result<_>>()?;
        let index = p.vhgp_seq.epsilon_1_index as usize;
        // Without a probability where every field has left the statistics.
        let (counts, known) = (truth.counts.get(index), truth.at_table("truth", index));
        let figure = Convergence {
            ship: p.case.ship.clone(),
            spectrum: p.case.sea.clone(),
            theta_t,
            epsilon_1: counts.map_or(0.0, |counts| counts.epsilon_1),
            realisations,
            p_true: known.map(|(_, p_true, _)| p_true),
            sequential: of(&sequential)?,
            random: estimates(&random),
            best: of(&best)?,
            lhs: of(&lhs)?,
            floor: (*floor).map(|floor| floor.model),
        };
        let svg = draw(&figure).map_err(refused)?;
        Ok(Published::new(Self::NAME, [("svg", svg), ("csv", csv(&figure))]))
    }
}

/// The same of a design's realisations.
fn of(realisations: &PiecesOf<'_, Realisation>) -> Result<Estimates> {
    let lines: Vec<(Vec<u32>, Vec<f64>)> = realisations
        .iter()
        .map(|piece| piece.map(|r| (r.n_samples.clone(), r.estimate.clone())))
        .collect::<Result<_>>()?;
    Ok(estimates(&lines))
}

/// Mean and population standard deviation over the realisations at every number of samples that all of them reached.
fn estimates(realisations: &[(Vec<u32>, Vec<f64>)]) -> Estimates {
    let mut found = Estimates {
        n_samples: Vec::new(),
        mean: Vec::new(),
        std: Vec::new(),
    };
    let sizes = realisations.first().map_or(&[] as &[u32], |(n, _)| n.as_slice());
    for n in sizes {
        let at =
            |(sizes, estimate): &(Vec<u32>, Vec<f64>)| sizes.iter().position(|size| size == n).map(|i| estimate[i]);
        let values: Option<Vec<f64>> = realisations.iter().map(at).collect();
        if let Some(values) = values {
            found.n_samples.push(f64::from(*n));
            found.mean.push(mean(&values));
            found.std.push(standard_deviation(&values));
        }
    }
    found
}
