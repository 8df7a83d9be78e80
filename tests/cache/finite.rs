//! A number that is none is refused before it is stored, and told by node, path and place.

use crate::common::House;
use encounter::engine::error::Result;
use encounter::engine::finite::check;
use encounter::engine::node::node;
use encounter::engine::pipeline::Pipeline;
use encounter::engine::stage::{Here, Pieces, Stage};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

const PIPELINE: Pipeline = Pipeline {
    axes: &[],
    contents: &[node::<Spoilt>()],
    optional: &[],
    on_request: &[],
};

struct Spoilt;

#[derive(Serialize, Deserialize)]
struct Params {
    spoilt: Table,
}

#[derive(Serialize, Deserialize)]
struct Table {
    at: u64,
}

#[derive(Debug, PartialEq, Serialize, Deserialize)]
struct Peaks {
    count: u32,
    peaks: Vec<Peak>,
}

#[derive(Debug, PartialEq, Serialize, Deserialize)]
struct Peak {
    t: f64,
    r: Option<f64>,
}

impl Stage for Spoilt {
    const NAME: &'static str = "spoilt";
    const PAPER: &'static str = "§1";
    const PIECES: Pieces = Pieces::Counted("spoilt.count");
    const SCHEMA: &'static str = "spoilt-peaks/1";
    type Params = Params;
    type Inputs = ();
    type Output = Peaks;

    fn run(p: &Params, (): (), here: Here<'_>) -> Result<Peaks> {
        let peak = |i: u64| Peak {
            t: i as f64,
            r: (i > 1).then_some(if here.first == 1 && i == p.spoilt.at {
                f64::NAN
            } else {
                0.5
            }),
        };
        Ok(Peaks {
            count: 5,
            peaks: (0..5).map(peak).collect(),
        })
    }
}

#[test]
fn a_stage_that_makes_nan_fails_with_its_place_and_stores_nothing() {
    let mut house = House::new();
    house.pipeline = PIPELINE;
    house.text = "[run]\nseed = 1\n[spoilt]\ncount = 3\nat = 3\n".to_owned();
    let done = house.run();
    assert_eq!(done.failed(), ["spoilt/1"]);
    let error = done.outcome.expect_err("a stage failed");
    assert_eq!(error.exit_code(), 1);
    let told = error.to_string();
    let expected = "spoilt/1 failed: peaks[3].r of its output is NaN: expected a finite number; nothing was stored";
    assert!(told.starts_with(expected), "{told}");
    // The two sound pieces are equal, so they are one object; the third is nowhere.
    assert_eq!(house.files_in("store/records").len(), 2);
    assert_eq!(house.files_in("store/objects").len(), 1);
    house.set("spoilt.at=9");
    house.run().expect_success();
}

#[derive(Serialize)]
enum Shape {
    Nothing,
    One(f64),
    Pair(f64, f32),
    Named { low: f64 },
}

#[derive(Serialize)]
struct Wrapped(f64);

/// What is said of every shape in which serde can hold a number, with one in it.
fn shapes(x: f64) -> Vec<(&'static str, Result<()>)> {
    vec![
        ("value", check(&x)),
        ("value", check(&(x as f32))),
        ("value", check(&Wrapped(x))),
        ("value", check(&Some(x))),
        ("[1]", check(&[1.0, x])),
        ("[2]", check(&vec![1.0, 2.0, x])),
        ("[1]", check(&("text", x, true))),
        ("One", check(&Shape::One(x))),
        ("Pair[1]", check(&Shape::Pair(1.0, x as f32))),
        ("Named.low", check(&Shape::Named { low: x })),
        ("b[0]", check(&BTreeMap::from([("a", vec![]), ("b", vec![x])]))),
    ]
}

#[test]
fn no_shape_hides_a_number_that_is_not_finite() {
    for x in [f64::NAN, -f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        for (path, checked) in shapes(x) {
            let told = checked.expect_err("a refusal").to_string();
            assert!(told.contains(&format!("{path} of its output is {x:?}")), "{told}");
        }
    }
    for x in [0.0, -0.0, f64::MIN_POSITIVE / 4.0, 1e38, -1e38] {
        for (path, checked) in shapes(x) {
            assert!(checked.is_ok(), "{path} {x}");
        }
    }
    assert!(check(&(Shape::Nothing, "NaN", 'c', i64::MIN, [0_u8; 3], None::<f64>, ())).is_ok());
}
