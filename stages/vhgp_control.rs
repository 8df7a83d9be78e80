//! §4 Sequential sampling with a control: beside its amplitude each group is known by what linear oscillators do about it.
//!
//! The look-ahead design in the coordinates (z/θ_t, A/H_s): z knows the waves that (L, A) leaves out, and costs no run. A
//! group's length adds less than its amplitude once z is known. Points are recorded as (z, A/H_s).

use std::ops::Range;
use std::sync::Arc;

use serde::{Deserialize, Serialize};

use crate::design::pool::{Pool, Used};
use crate::design::quadrature::Quadrature;
use crate::design::response_pool::ResponsePool as Responses;
use crate::design::sequential::{Input, Realisation, sequential};
use crate::design::settings::{LookAhead, Shared};
use crate::engine::arrow::{All, One, PiecesOf};
use crate::engine::error::{Error, Result};
use crate::engine::stage::{Here, Pieces, Select, Stage};
use crate::ship::linear_response::LinearResponses;
use crate::stages::axes::SEA;
use crate::stages::linear_response::LinearResponse;
use crate::stages::response_pool::ResponsePool;

/// The look-ahead design on groups and their linear responses, for one case of Table 1.
pub struct VhgpControl;

/// Parameters of the design.
#[derive(Serialize, Deserialize)]
pub struct Params {
    vhgp_seq: Shared,
    vhgp_control: LookAhead,
}

impl Stage for VhgpControl {
    const NAME: &'static str = "vhgp_control";
    const PAPER: &'static str = "§4";
    const PIECES: Pieces = Pieces::Counted("vhgp_seq.realisations");
    const SELECTS: &'static [Select] = &[Select::Rows(SEA, "vhgp_seq.case")];
    const SCHEMA: &'static str = "realisation/1";
    type Params = Params;
    type Inputs = (One<ResponsePool>, All<LinearResponse>);
    type Output = Realisation;

    fn check(p: &Params) -> std::result::Result<(), String> {
        p.vhgp_seq.check().map_err(|why| format!("vhgp_seq.{why}"))?;
        let own = p.vhgp_control.check(&p.vhgp_seq);
        own.map_err(|why| format!("vhgp_control.{why}"))
    }

    fn check_output(p: &Params, _: Range<u64>, output: &Realisation) -> std::result::Result<(), String> {
        output.check(p.vhgp_seq.total)
    }

    fn run(
        p: &Params,
        (responses, linear): (Arc<Responses>, PiecesOf<'_, LinearResponses>),
        here: Here<'_>,
    ) -> Result<Realisation> {
        let row = p
            .vhgp_seq
            .case
            .first()
            .ok_or_else(|| Error::stage("no row of vhgp_seq.case names this sea"))?;
        let mut z = Vec::with_capacity(responses.r.len());
        for piece in linear.iter() {
            z.extend_from_slice(&piece?.z);
        }
        let points = responses.with_control(&z, row.theta_t).map_err(Error::stage)?;
        let input = Input::on_nodes(Quadrature::new(&points, p.vhgp_control.quadrature));
        let pool = Pool::new(&points);
        let mut used = Used::default();
        let respond = |query: [f64; 2], stream: &mut _| {
            let index = pool.draw(&query, p.vhgp_seq.neighbours, &mut used, stream)?;
            Some((pool.point(index), responses.r[index as usize]))
        };
        let design = p.vhgp_control.design(&p.vhgp_seq, row.theta_t);
        let mut stream = here.stream(here.first);
        let mut realisation = sequential(&design, &input, row.theta_t, respond, &mut stream);
        for x in &mut realisation.points {
            x[0] *= row.theta_t;
        }
        Ok(realisation)
    }
}
