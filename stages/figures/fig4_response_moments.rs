//! Figure 4: mean and standard deviation of R(a, l) against epsilon_1, by every method.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use crate::engine::arrow::One;
use crate::engine::error::Result;
use crate::engine::stage::{Here, Published, Select, Stage};
use crate::plot::response_moments::{Moments, ResponseMoments as Figure, Shape, csv, draw};
use crate::plot::style::Method;
use crate::ship::response::Point;
use crate::stages::axes::SEA;
use crate::stages::figures::refusal::refused;
use crate::stages::response_moments::ResponseMoments;

/// Figure 4.
pub struct Fig4ResponseMoments;

/// Parameters of the figure.
#[derive(Serialize, Deserialize)]
pub struct Params {
    case: Names,
}

/// The names of ship and sea.
#[derive(Serialize, Deserialize)]
pub struct Names {
    ship: String,
    sea: String,
}

impl Stage for Fig4ResponseMoments {
    const NAME: &'static str = "fig4_response_moments";
    const PAPER: &'static str = "Fig. 4";
    const SELECTS: &'static [Select] = &[Select::At(SEA, "moments.sea")];
    const SCHEMA: &'static str = Published::SCHEMA;
    type Params = Params;
    type Inputs = (One<ResponseMoments>,);
    type Output = Published;

    fn run(p: &Params, (points,): (Arc<Vec<Point>>,), _: Here<'_>) -> Result<Published> {
        let mut shapes: Vec<Shape> = Vec::new();
        for point in points.iter() {
            let [l_over_tp, a_over_hs] = point.group;
            let known = shapes
                .iter()
                .position(|shape| [shape.l_over_tp, shape.a_over_hs] == point.group);
            let place = known.unwrap_or(shapes.len());
            if known.is_none() {
                shapes.push(Shape {
                    l_over_tp,
                    a_over_hs,
                    groups: 0,
                    moments: Vec::new(),
                });
            }
            add(&mut shapes[place], point);
        }
        let figure = Figure {
            ship: p.case.ship.clone(),
            spectrum: p.case.sea.clone(),
            shapes,
        };
        let svg = draw(&figure).map_err(refused)?;
        Ok(Published::new(Self::NAME, [("svg", svg), ("csv", csv(&figure))]))
    }
}

/// Adds a point to its method's line; an empty bin adds nothing.
fn add(shape: &mut Shape, point: &Point) {
    let (Some(method), Some(moments)) = (Method::named(&point.method), point.moments) else {
        return;
    };
    if method == Method::Truth {
        shape.groups = moments.n;
    }
    let known = shape.moments.iter().position(|line| line.method == method);
    let place = known.unwrap_or(shape.moments.len());
    if known.is_none() {
        shape.moments.push(Moments {
            method,
            epsilon_1: Vec::new(),
            mean: Vec::new(),
            std: Vec::new(),
            n: Vec::new(),
        });
    }
    let line = &mut shape.moments[place];
    line.epsilon_1.push(point.epsilon_1);
    line.mean.push(moments.mean);
    line.std.push(moments.standard_deviation);
    line.n.push(moments.n);
}
