//! Figure 5: the estimate against the number of samples, VHGP-Seq beside four other methods and their floor.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use crate::design::convergence::{Convergence as Spreads, Spread};
use crate::design::settings::Case;
use crate::engine::arrow::One;
use crate::engine::error::{Error, Result};
use crate::engine::stage::{Here, Published, Select, Stage};
use crate::plot::convergence::{Convergence, Estimates, csv, draw};
use crate::ship::exceedance::Probabilities;
use crate::stages::axes::SEA;
use crate::stages::convergence::Convergence as Methods;
use crate::stages::exceedance::Exceedance;
use crate::stages::figures::refusal::refused;

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
    type Inputs = (One<Methods>, One<Exceedance>);
    type Output = Published;

    fn run(p: &Params, (methods, truth): (Arc<Spreads>, Arc<Probabilities>), _: Here<'_>) -> Result<Published> {
        let row = p.vhgp_seq.case.iter().find(|row| row.sea == p.case.sea);
        let theta_t = row
            .map(|row| row.theta_t)
            .ok_or_else(|| Error::stage("no row of vhgp_seq.case names this sea"))?;
        let index = p.vhgp_seq.epsilon_1_index as usize;
        // Without a probability where every field has left the statistics.
        let (counts, known) = (truth.counts.get(index), truth.at_table("truth", index));
        let figure = Convergence {
            ship: p.case.ship.clone(),
            spectrum: p.case.sea.clone(),
            theta_t,
            epsilon_1: counts.map_or(0.0, |counts| counts.epsilon_1),
            realisations: methods.realisations,
            p_true: known.map(|(_, p_true, _)| p_true),
            sequential: estimates(&methods, &methods.sequential),
            random: estimates(&methods, &methods.random),
            best: estimates(&methods, &methods.best),
            control: estimates(&methods, &methods.control),
            lhs: estimates(&methods, &methods.lhs),
            floor: methods.floors.groups.map(|floor| floor.model),
        };
        let svg = draw(&figure).map_err(refused)?;
        Ok(Published::new(Self::NAME, [("svg", svg), ("csv", csv(&figure))]))
    }
}

/// A method as the figure takes it.
fn estimates(methods: &Spreads, spread: &Spread) -> Estimates {
    Estimates {
        n_samples: spread.n_samples.iter().map(|n| f64::from(*n)).collect(),
        mean: spread.mean.clone(),
        std: spread.std.iter().map(|std| methods.deviation(*std)).collect(),
    }
}
