//! Difference: two artifacts of one type compared value by value, by path, bits and distance.

use encounter::engine::codec;
use encounter::engine::difference::{Difference, ulp_distance};
use encounter::engine::error::{Error, Result};
use encounter::engine::node::node;
use encounter::engine::stage::{Here, Published, Stage};
use encounter::text::count::thousands;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// An artifact with every shape that serde knows.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct Shapes {
    maxima: Vec<Maximum>,
    ends: Vec<End>,
    by_name: BTreeMap<String, [f64; 2]>,
    label: String,
    pair: (u32, i64),
    maybe: Option<f64>,
    sure: bool,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct Maximum {
    r: f64,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
enum End {
    Upright,
    Capsized { at: f64 },
}

/// Makes nothing; lends its type of output.
struct Shaped;
/// The same for published files.
struct Printed;

#[derive(Serialize, Deserialize)]
struct NoParams {}

impl Stage for Shaped {
    const NAME: &'static str = "shaped";
    const PAPER: &'static str = "§1";
    const SCHEMA: &'static str = "shapes/1";
    type Params = NoParams;
    type Inputs = ();
    type Output = Shapes;

    fn run(_: &NoParams, (): (), _: Here<'_>) -> Result<Shapes> {
        Err(Error::stage("never run"))
    }
}

impl Stage for Printed {
    const NAME: &'static str = "printed";
    const PAPER: &'static str = "§1";
    const SCHEMA: &'static str = Published::SCHEMA;
    type Params = NoParams;
    type Inputs = ();
    type Output = Published;

    fn run(_: &NoParams, (): (), _: Here<'_>) -> Result<Published> {
        Err(Error::stage("never run"))
    }
}

fn shapes() -> Shapes {
    Shapes {
        maxima: (0..2000).map(|i| Maximum { r: 0.25 + f64::from(i) }).collect(),
        ends: vec![End::Upright, End::Capsized { at: 3.5 }],
        by_name: BTreeMap::from([("S1".to_owned(), [1.0, 2.0]), ("S2".to_owned(), [3.0, 4.0])]),
        label: "calm".to_owned(),
        pair: (7, -7),
        maybe: None,
        sure: true,
    }
}

/// The difference between the shapes and edited ones.
fn edited(edit: impl Fn(&mut Shapes)) -> Option<Difference> {
    let mut later = shapes();
    edit(&mut later);
    let bytes = |shapes: &Shapes| codec::encode(shapes).expect("shapes can be encoded");
    let difference = node::<Shaped>().difference(&bytes(&shapes()), &bytes(&later));
    difference.expect("both decode")
}

#[track_caller]
fn reads(edit: impl Fn(&mut Shapes), expected: &str) {
    assert_eq!(edited(edit).expect("they differ").to_string(), expected);
}

/// 2000 maxima, 2 ends, 4 in the map, label, pair, option, truth.
const ALL: &str = "2,011";

#[test]
fn the_first_value_that_differs_is_named_with_its_distance() {
    assert_eq!(edited(|_| ()), None);
    let next = |x: f64| f64::from_bits(x.to_bits() + 1);
    reads(
        |it| {
            it.maxima[1042].r = next(1042.25);
            it.maxima[1044].r = next(next(1044.25));
            it.maxima[1999].r = next(1999.25);
        },
        &format!("maxima[1042].r  1042.25 / 1042.2500000000002 (1 ULP); 3 of {ALL} differ, at most 2 ULP"),
    );
    let difference = edited(|it| it.maxima[7].r = -7.25).expect("they differ");
    assert_eq!(
        (difference.path.as_str(), difference.ulp),
        ("maxima[7].r", Some(2 * 7.25_f64.to_bits()))
    );
    assert_eq!(difference.largest_ulp, difference.ulp);
}

#[test]
fn every_shape_has_its_path() {
    let one = format!("1 of {ALL} differ");
    reads(
        |it| it.ends[1] = End::Capsized { at: 4.0 },
        &format!("ends[1].Capsized.at  3.5 / 4.0 (1.1e15 ULP); {one}, at most 1.1e15 ULP"),
    );
    reads(
        |it| it.ends[1] = End::Upright,
        &format!("ends[1]  Capsized of 1 field / Upright; {one}"),
    );
    reads(
        |it| it.ends[0] = End::Capsized { at: 0.0 },
        &format!("ends[0]  Upright / Capsized of 1 field; {one}"),
    );
    reads(|it| it.label.push('!'), &format!("label  `calm` / `calm!`; {one}"));
    reads(|it| it.pair.1 = 7, &format!("pair[1]  -7 / 7; {one}"));
    reads(|it| it.maybe = Some(1.5), &format!("maybe  nothing / 1.5; {one}"));
    reads(|it| it.sure = false, &format!("sure  true / false; {one}"));
    let other_key = |it: &mut Shapes| {
        it.by_name.remove("S1");
        it.by_name.insert("S3".to_owned(), [1.0, 2.0]);
    };
    reads(other_key, "by_name.S1  2 entries / nothing; 4 of 2,013 differ");
}

#[test]
fn a_list_of_another_length_says_so_and_counts_what_is_left_over() {
    reads(
        |it| it.maxima.truncate(1990),
        &format!("maxima  2,000 entries / 1,990 entries; 10 of {ALL} differ"),
    );
    reads(
        |it| it.maxima.push(Maximum { r: 0.0 }),
        "maxima  2,000 entries / 2,001 entries; 1 of 2,012 differ",
    );
}

#[test]
fn bits_are_compared_not_values() {
    let mut zeros = (shapes(), shapes());
    (zeros.0.maxima[3].r, zeros.1.maxima[3].r) = (0.0, -0.0);
    let bytes = |shapes: &Shapes| codec::encode(shapes).expect("shapes can be encoded");
    let difference = node::<Shaped>()
        .difference(&bytes(&zeros.0), &bytes(&zeros.1))
        .expect("both decode");
    let text = difference.expect("they differ").to_string();
    assert_eq!(
        text,
        format!("maxima[3].r  0.0 / -0.0 (0 ULP); 1 of {ALL} differ, at most 0 ULP")
    );
    zeros.1.maxima[3].r = f64::NAN;
    let difference = node::<Shaped>()
        .difference(&bytes(&zeros.0), &bytes(&zeros.1))
        .expect("both decode");
    let text = difference.expect("they differ").to_string();
    assert_eq!(text, format!("maxima[3].r  0.0 / NaN; 1 of {ALL} differ"));
}

#[test]
fn the_distance_counts_the_doubles_between() {
    let mut x = 1.0_f64 - 3.0 * f64::EPSILON;
    let mut steps = 0;
    // The slow twin: step from double to double, across a power of two.
    while x < 1.0 + 3.0 * f64::EPSILON {
        x = f64::from_bits(x.to_bits() + 1);
        steps += 1;
        assert_eq!(ulp_distance(1.0 - 3.0 * f64::EPSILON, x), Some(steps));
    }
    let least = f64::from_bits(1);
    assert_eq!(ulp_distance(-least, least), Some(2));
    assert_eq!(ulp_distance(0.0, -0.0), Some(0));
    assert_eq!(ulp_distance(f64::MAX, f64::INFINITY), Some(1));
    assert_eq!(ulp_distance(f64::NAN, 1.0), None);
    assert_eq!(
        ulp_distance(f64::NEG_INFINITY, f64::INFINITY),
        Some(2 * f64::INFINITY.to_bits())
    );
    assert_eq!(
        [0, 12, 999, 1000, 5812, 1_234_567].map(thousands),
        ["0", "12", "999", "1,000", "5,812", "1,234,567"]
    );
}

#[test]
fn published_text_differs_in_a_line_of_a_file() {
    let files = |csv: &str, svg: &str| {
        codec::encode(&Published::new(
            "printed",
            [("csv", csv.to_owned()), ("svg", svg.to_owned())],
        ))
        .expect("text")
    };
    let told = |a: &[u8], b: &[u8]| {
        let difference = node::<Printed>().difference(a, b).expect("both decode");
        difference.map(|difference| difference.to_string())
    };
    let old = files("theta_t,p\n0.1,0.5\n0.2,0.25\n", "<svg>\n</svg>\n");
    assert_eq!(told(&old, &old), None);
    let new = files("theta_t,p\n0.1,0.5\n0.2,0.26\n", "<svg>\n</svg>\n");
    assert_eq!(
        told(&old, &new).as_deref(),
        Some("printed.csv, line 3  `0.2,0.25` / `0.2,0.26`; 1 of 7 differ")
    );
    let longer = files("theta_t,p\n0.1,0.5\n0.2,0.25\n", "<svg>\n<g/>\n</svg>\n");
    assert_eq!(
        told(&old, &longer).as_deref(),
        Some("printed.svg, line 2  `</svg>` / `<g/>`; 3 of 8 differ")
    );
    let ends = files("theta_t,p\r\n0.1,0.5\n0.2,0.25\n", "<svg>\n</svg>\n");
    assert!(told(&old, &ends).is_some_and(|told| told.starts_with("printed.csv, line 1  ")));
    // A long line is cut to where it begins to differ.
    let long = |digit: char| {
        files(
            "a\n",
            &format!("<path d=\"{}{digit}{}\"/>\n", "1 ".repeat(500), "2 ".repeat(500)),
        )
    };
    let told = told(&long('3'), &long('4')).expect("they differ");
    assert!(
        told.starts_with("printed.svg, line 1  `..1 1 ") && told.len() < 220,
        "{told}"
    );
    assert!(told.contains(" 32 2 ") && told.contains(" 42 2 "), "{told}");
}

#[test]
fn bytes_of_another_type_are_an_error_not_a_difference() {
    let good = codec::encode(&shapes()).expect("shapes can be encoded");
    assert!(node::<Shaped>().difference(&good, &good[1..]).is_err());
    assert!(node::<Shaped>().difference(b"", &good).is_err());
}
