//! §4 Random sampling: NIC on groups drawn at random, the yardstick of VHGP-Seq.

use std::ops::Range;
use std::sync::Arc;

use serde::{Deserialize, Serialize};

use crate::design::estimate::random_sampling;
use crate::design::response_pool::{RandomEstimates, ResponsePool as Responses};
use crate::design::settings::Case;
use crate::engine::arrow::One;
use crate::engine::error::{Error, Result};
use crate::engine::stage::{Here, Pieces, Select, Stage};
use crate::numerics::domain::at_most;
use crate::stages::axes::SEA;
use crate::stages::response_pool::ResponsePool;

/// The share of exceedances among groups drawn independently.
pub struct RandomSampling;

/// Parameters of random sampling.
#[derive(Serialize, Deserialize)]
pub struct Params {
    vhgp_seq: Total,
    random_sampling: Sizes,
}

/// The part of `[vhgp_seq]` that random sampling shares.
#[derive(Serialize, Deserialize)]
pub struct Total {
    /// Samples at the end, for Table 1.
    total: u32,
    /// The row of Table 1.
    case: Vec<Case>,
}

/// The `[random_sampling]` table.
#[derive(Serialize, Deserialize)]
pub struct Sizes {
    /// Numbers of samples at which Figure 5 is drawn, ascending.
    samples: Vec<u32>,
}

/// Most points of a line of Figure 5.
const MOST_SIZES: u64 = 1000;
/// Most groups drawn in one realisation.
const MOST_SAMPLES: u64 = 1_000_000;

impl Stage for RandomSampling {
    const NAME: &'static str = "random_sampling";
    const PAPER: &'static str = "§4";
    const PIECES: Pieces = Pieces::Counted("vhgp_seq.realisations");
    const SELECTS: &'static [Select] = &[Select::Rows(SEA, "vhgp_seq.case")];
    const SCHEMA: &'static str = "random-estimates/1";
    type Params = Params;
    type Inputs = (One<ResponsePool>,);
    type Output = RandomEstimates;

    fn check(p: &Params) -> std::result::Result<(), String> {
        let samples = &p.random_sampling.samples;
        let (number, largest) = (samples.len() as u64, u64::from(samples.last().copied().unwrap_or(0)));
        at_most(
            "random_sampling.samples",
            number,
            MOST_SIZES,
            "each is a point of Figure 5",
        )
        .map_err(|why| format!("{why} numbers"))?;
        at_most(
            "random_sampling.samples",
            largest,
            MOST_SAMPLES,
            "every realisation draws so many",
        )?;
        let total = u64::from(p.vhgp_seq.total);
        at_most("vhgp_seq.total", total, MOST_SAMPLES, "every realisation draws so many")?;
        let ascending = samples.windows(2).all(|pair| pair[0] < pair[1]);
        let ok = ascending && samples.first().is_some_and(|first| *first > 0);
        if ok {
            Ok(())
        } else {
            Err(format!(
                "random_sampling.samples: expected ascending numbers > 0, found {samples:?}"
            ))
        }
    }

    fn check_output(_: &Params, _: Range<u64>, output: &RandomEstimates) -> std::result::Result<(), String> {
        output.check()
    }

    fn run(p: &Params, (responses,): (Arc<Responses>,), here: Here<'_>) -> Result<RandomEstimates> {
        let row = p
            .vhgp_seq
            .case
            .first()
            .ok_or_else(|| Error::stage("no row of vhgp_seq.case names this sea"))?;
        let mut n_samples = p.random_sampling.samples.clone();
        n_samples.push(p.vhgp_seq.total);
        n_samples.sort_unstable();
        n_samples.dedup();
        let mut stream = here.stream(here.first);
        let respond = |group: usize| responses.r[group];
        let estimate = random_sampling(responses.r.len(), &n_samples, row.theta_t, respond, &mut stream);
        Ok(RandomEstimates { n_samples, estimate })
    }
}
