//! Figure 2: the flowchart of the three methods.

use serde::{Deserialize, Serialize};

use crate::engine::error::Result;
use crate::engine::stage::{Here, Published, Stage};
use crate::plot::flowchart::{csv, draw};
use crate::stages::figures::refusal::refused;

/// Figure 2.
pub struct Fig2Flowchart;

/// Parameters of the figure.
#[derive(Serialize, Deserialize)]
pub struct Params {
    nic: GroupsAhead,
}

/// The part of `[nic]` that the flowchart names.
#[derive(Serialize, Deserialize)]
pub struct GroupsAhead {
    groups_ahead: u32,
}

impl Stage for Fig2Flowchart {
    const NAME: &'static str = "fig2_flowchart";
    const PAPER: &'static str = "Fig. 2";
    const SCHEMA: &'static str = Published::SCHEMA;
    type Params = Params;
    type Inputs = ();
    type Output = Published;

    fn run(p: &Params, (): (), _: Here<'_>) -> Result<Published> {
        let svg = draw(p.nic.groups_ahead).map_err(refused)?;
        Ok(Published::new(
            Self::NAME,
            [("svg", svg), ("csv", csv(p.nic.groups_ahead))],
        ))
    }
}
