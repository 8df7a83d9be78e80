//! §4 What no unbiased estimate over (L, A) can go below, from all responses of the pool.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use crate::design::floor::{Floor, floor};
use crate::design::quadrature::Quadrature;
use crate::design::response_pool::ResponsePool as Responses;
use crate::design::settings::Case;
use crate::engine::arrow::One;
use crate::engine::error::{Error, Result};
use crate::engine::stage::{Here, Select, Stage};
use crate::numerics::elementary::ln;
use crate::stages::axes::SEA;
use crate::stages::response_pool::ResponsePool;

/// The floor of one case of Table 1; none where no group exceeds the threshold.
pub struct SamplingFloor;

/// Parameters of the floor.
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
    /// Nodes along ln L/T_p and A/H_s.
    nodes: [u32; 2],
    /// Standard deviation of the kernels at the nodes, in (ln L/T_p, A/H_s).
    bandwidth: [f64; 2],
    /// Degree of the polynomials a method is to find.
    degree: u32,
}

impl Stage for SamplingFloor {
    const NAME: &'static str = "sampling_floor";
    const PAPER: &'static str = "§4";
    const SELECTS: &'static [Select] = &[Select::Rows(SEA, "vhgp_seq.case")];
    const SCHEMA: &'static str = "sampling-floor/1";
    type Params = Params;
    type Inputs = (One<ResponsePool>,);
    type Output = Option<Floor>;

    fn check(p: &Params) -> std::result::Result<(), String> {
        let Settings { nodes, bandwidth, .. } = &p.sampling_floor;
        if nodes.iter().any(|n| *n < 2) {
            return Err(format!(
                "sampling_floor.nodes: expected whole numbers >= 2, found {nodes:?}"
            ));
        }
        if bandwidth.iter().all(|b| b.is_finite() && *b > 0.0) {
            return Ok(());
        }
        Err(format!(
            "sampling_floor.bandwidth: expected numbers > 0, found {bandwidth:?}"
        ))
    }

    fn run(p: &Params, (responses,): (Arc<Responses>,), _: Here<'_>) -> Result<Option<Floor>> {
        let row = p
            .vhgp_seq
            .case
            .first()
            .ok_or_else(|| Error::stage("no row of vhgp_seq.case names this sea"))?;
        let Settings {
            nodes,
            bandwidth,
            degree,
        } = p.sampling_floor;
        let x: Vec<[f64; 2]> = responses.points.iter().map(|x| [ln(x[0]), x[1]]).collect();
        let quadrature = Quadrature::new(&x, nodes);
        let levels = (row.theta_t, p.vhgp_seq.cap);
        Ok(floor((&x, &responses.r), levels, &quadrature, bandwidth, degree))
    }
}
