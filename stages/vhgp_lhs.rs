//! §4 The surrogate of VHGP-Seq on one Latin hypercube: what choosing the samples one after the other gains.

use std::ops::Range;
use std::sync::Arc;

use serde::{Deserialize, Serialize};

use crate::design::pool::{Pool, Used};
use crate::design::quadrature::Quadrature;
use crate::design::response_pool::ResponsePool as Responses;
use crate::design::sequential::{Design, Input, Realisation, sequential};
use crate::design::settings::VhgpSeq as Settings;
use crate::engine::arrow::One;
use crate::engine::error::{Error, Result};
use crate::engine::stage::{Here, Pieces, Select, Stage};
use crate::stages::axes::SEA;
use crate::stages::response_pool::ResponsePool;

/// (Q2) from a Latin hypercube on the groups of one case of Table 1.
pub struct VhgpLhs;

/// Parameters: those of the sequential design.
#[derive(Serialize, Deserialize)]
pub struct Params {
    vhgp_seq: Settings,
}

impl Stage for VhgpLhs {
    const NAME: &'static str = "vhgp_lhs";
    const PAPER: &'static str = "§4";
    const PIECES: Pieces = Pieces::Counted("vhgp_seq.realisations");
    const SELECTS: &'static [Select] = &[Select::Rows(SEA, "vhgp_seq.case")];
    const SCHEMA: &'static str = "realisation/1";
    type Params = Params;
    type Inputs = (One<ResponsePool>,);
    type Output = Realisation;

    fn check(p: &Params) -> std::result::Result<(), String> {
        p.vhgp_seq.check().map_err(|why| format!("vhgp_seq.{why}"))
    }

    fn check_output(p: &Params, _: Range<u64>, output: &Realisation) -> std::result::Result<(), String> {
        output.check(p.vhgp_seq.total)
    }

    fn run(p: &Params, (responses,): (Arc<Responses>,), here: Here<'_>) -> Result<Realisation> {
        let settings = &p.vhgp_seq;
        let row = settings
            .case
            .first()
            .ok_or_else(|| Error::stage("no row of vhgp_seq.case names this sea"))?;
        // What is asked next does not hang on the model: it is fitted as often as its line in Figure 5 has points.
        let design = Design {
            batch: settings.initial,
            ..settings.hypercube()
        };
        let quadrature = Quadrature::new(&responses.points, settings.quadrature);
        let input = Input::new(settings.candidates(), responses.density.clone(), quadrature);
        let pool = Pool::new(&responses.points);
        let mut used = Used::default();
        let respond = |query: [f64; 2], stream: &mut _| {
            let index = pool.draw(&query, settings.neighbours, &mut used, stream)?;
            Some((pool.point(index), responses.r[index as usize]))
        };
        Ok(sequential(
            &design,
            &input,
            row.theta_t,
            respond,
            &mut here.stream(here.first),
        ))
    }
}
