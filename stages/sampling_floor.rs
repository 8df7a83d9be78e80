//! §4 What no unbiased estimate over (L, A), or with the control, can go below, from all responses of the pool.

use std::ops::Range;
use std::sync::Arc;

use serde::{Deserialize, Serialize};

use crate::design::floor::{Floors, floor};
use crate::design::quadrature::Quadrature;
use crate::design::response_pool::ResponsePool as Responses;
use crate::design::settings::Case;
use crate::engine::arrow::{All, One, PiecesOf};
use crate::engine::error::{Error, Result};
use crate::engine::stage::{Here, Select, Stage};
use crate::numerics::domain::{at_most, mesh};
use crate::numerics::elementary::ln;
use crate::ship::linear_response::LinearResponses;
use crate::stages::axes::SEA;
use crate::stages::linear_response::LinearResponse;
use crate::stages::response_pool::ResponsePool;

/// The floors of one case of Table 1.
pub struct SamplingFloor;

/// Parameters of the floors.
#[derive(Serialize, Deserialize)]
pub struct Params {
    vhgp_seq: Shared,
    sampling_floor: Settings,
}

/// The part of `[vhgp_seq]` that the floor is for.
#[derive(Serialize, Deserialize)]
pub struct Shared {
    /// The row of Table 1.
    case: Vec<Case>,
    /// Largest response that enters a model, rad.
    cap: f64,
}

/// The `[sampling_floor]` table.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Settings {
    /// Nodes along each coordinate.
    nodes: [u32; 2],
    /// Standard deviation of the kernels at the nodes, in (ln L/T_p, A/H_s).
    bandwidth: [f64; 2],
    /// The same in (z/θ_t, A/H_s).
    control_bandwidth: [f64; 2],
    /// Degree of the polynomials a method is to find.
    degree: u32,
}

/// Highest degree of the polynomials: 66 monomials.
const HIGHEST_DEGREE: u64 = 10;

impl Stage for SamplingFloor {
    const NAME: &'static str = "sampling_floor";
    const PAPER: &'static str = "§4";
    const SELECTS: &'static [Select] = &[Select::Rows(SEA, "vhgp_seq.case")];
    const SCHEMA: &'static str = "sampling-floors/1";
    type Params = Params;
    type Inputs = (One<ResponsePool>, All<LinearResponse>);
    type Output = Floors;

    fn check(p: &Params) -> std::result::Result<(), String> {
        let settings = &p.sampling_floor;
        mesh("sampling_floor.nodes", settings.nodes)?;
        let since = "the design is sought among all monomials up to it";
        at_most(
            "sampling_floor.degree",
            u64::from(settings.degree),
            HIGHEST_DEGREE,
            since,
        )?;
        if settings.nodes.iter().any(|n| *n < 2) {
            let nodes = settings.nodes;
            return Err(format!(
                "sampling_floor.nodes: expected whole numbers >= 2, found {nodes:?}"
            ));
        }
        for (key, bandwidth) in [
            ("bandwidth", settings.bandwidth),
            ("control_bandwidth", settings.control_bandwidth),
        ] {
            if !bandwidth.iter().all(|b| b.is_finite() && *b > 0.0) {
                return Err(format!(
                    "sampling_floor.{key}: expected numbers > 0, found {bandwidth:?}"
                ));
            }
        }
        Ok(())
    }

    fn check_output(_: &Params, _: Range<u64>, output: &Floors) -> std::result::Result<(), String> {
        output.check()
    }

    fn run(
        p: &Params,
        (responses, linear): (Arc<Responses>, PiecesOf<'_, LinearResponses>),
        _: Here<'_>,
    ) -> Result<Floors> {
        let row = p
            .vhgp_seq
            .case
            .first()
            .ok_or_else(|| Error::stage("no row of vhgp_seq.case names this sea"))?;
        let settings = &p.sampling_floor;
        let of = |x: &[[f64; 2]], bandwidth: [f64; 2]| {
            let quadrature = Quadrature::new(x, settings.nodes);
            let levels = (row.theta_t, p.vhgp_seq.cap);
            floor((x, &responses.r), levels, &quadrature, bandwidth, settings.degree)
        };
        let mut z = Vec::with_capacity(responses.r.len());
        for piece in linear.iter() {
            z.extend_from_slice(&piece?.z);
        }
        let groups: Vec<[f64; 2]> = responses.points.iter().map(|x| [ln(x[0]), x[1]]).collect();
        let control = responses.with_control(&z, row.theta_t).map_err(Error::stage)?;
        Ok(Floors {
            groups: of(&groups, settings.bandwidth),
            control: of(&control, settings.control_bandwidth),
        })
    }
}
