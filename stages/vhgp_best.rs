//! §4 Sequential sampling that looks ahead: each sample where it lowers the variance of the estimate most.
//!
//! The paper's surrogate and numbers of samples; what differs is the coordinate ln L, the first samples from the density
//! of the groups, the acquisition, a noise that changes slowly, and a roll cut a little above θ_t and seen on its square
//! root. README.md says how these were chosen. Points are recorded as (L/T_p, A/H_s).

use std::ops::Range;
use std::sync::Arc;

use serde::{Deserialize, Serialize};

use crate::design::pool::{Pool, Used};
use crate::design::quadrature::Quadrature;
use crate::design::response_pool::ResponsePool as Responses;
use crate::design::sequential::{Input, Realisation, sequential};
use crate::design::settings::{LookAhead, Shared};
use crate::engine::arrow::One;
use crate::engine::error::{Error, Result};
use crate::engine::stage::{Here, Pieces, Select, Stage};
use crate::numerics::elementary::{exp, ln};
use crate::stages::axes::SEA;
use crate::stages::response_pool::ResponsePool;

/// The look-ahead design on the groups of one case of Table 1.
pub struct VhgpBest;

/// Parameters of the look-ahead design.
#[derive(Serialize, Deserialize)]
pub struct Params {
    vhgp_seq: Shared,
    vhgp_best: LookAhead,
}

impl Stage for VhgpBest {
    const NAME: &'static str = "vhgp_best";
    const PAPER: &'static str = "§4";
    const PIECES: Pieces = Pieces::Counted("vhgp_seq.realisations");
    const SELECTS: &'static [Select] = &[Select::Rows(SEA, "vhgp_seq.case")];
    const SCHEMA: &'static str = "realisation/1";
    type Params = Params;
    type Inputs = (One<ResponsePool>,);
    type Output = Realisation;

    fn check(p: &Params) -> std::result::Result<(), String> {
        p.vhgp_seq.check().map_err(|why| format!("vhgp_seq.{why}"))?;
        let own = p.vhgp_best.check(&p.vhgp_seq);
        own.map_err(|why| format!("vhgp_best.{why}"))
    }

    fn check_output(p: &Params, _: Range<u64>, output: &Realisation) -> std::result::Result<(), String> {
        output.check(p.vhgp_seq.total)
    }

    fn run(p: &Params, (responses,): (Arc<Responses>,), here: Here<'_>) -> Result<Realisation> {
        let row = p
            .vhgp_seq
            .case
            .first()
            .ok_or_else(|| Error::stage("no row of vhgp_seq.case names this sea"))?;
        let points: Vec<[f64; 2]> = responses.points.iter().map(|x| [ln(x[0]), x[1]]).collect();
        let input = Input::on_nodes(Quadrature::new(&points, p.vhgp_best.quadrature));
        let pool = Pool::new(&points);
        let mut used = Used::default();
        let respond = |query: [f64; 2], stream: &mut _| {
            let index = pool.draw(&query, p.vhgp_seq.neighbours, &mut used, stream)?;
            Some((pool.point(index), responses.r[index as usize]))
        };
        let design = p.vhgp_best.design(&p.vhgp_seq, row.theta_t);
        let mut stream = here.stream(here.first);
        let mut realisation = sequential(&design, &input, row.theta_t, respond, &mut stream);
        for x in &mut realisation.points {
            x[0] = exp(x[0]);
        }
        Ok(realisation)
    }
}
