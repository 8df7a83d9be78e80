//! What of the parameter file counts, and what is refused.

use crate::common::toy::BASE;
use crate::common::{House, PARAMS};
use encounter::engine::case::Case;
use encounter::engine::key_path::KeyPath;
use encounter::engine::params::ParamsFile;
use encounter::engine::target::Target;

const NOTHING: [&str; 0] = [];

#[test]
fn comments_order_and_the_spelling_of_numbers_do_not_count() {
    let mut house = House::lived_in(&[]);
    let (head, tail) = PARAMS.split_once("[total]").expect("the table stands in the text");
    house.text = format!("[total]{tail}\n# The rest.\n{head}").replace("span = 1000", "span = 1_000.0 # spelt");
    assert_eq!(house.run().ran(), NOTHING);
}

#[test]
fn a_later_layer_wins_key_by_key() {
    let mut params = House::new().params().expect("the parameters are in order");
    params
        .layer("over.toml", "[base.a]\noffset = 3\n[base.d]\noffset = 4")
        .expect("TOML");
    params.set("base.a.offset=5").expect("an assignment");
    let get = |path: &str| params.get(&KeyPath::of(path)).and_then(toml::Value::as_integer);
    assert_eq!(
        (get("base.a.offset"), get("base.d.offset"), get("base.b.offset")),
        (Some(5), Some(4), Some(2))
    );
    let place = |path: &str| params.refuse(&KeyPath::of(path), "no").to_string();
    assert_eq!(place("base.a.offset"), "--set: base.a.offset: no");
    assert_eq!(place("base.d.offset"), "over.toml:4: base.d.offset: no");
    assert_eq!(place("base.b.offset"), "toy.toml:13: base.b.offset: no");
    assert_eq!(place("draws.row[1].level"), "toy.toml:23: draws.row[1].level: no");
}

#[test]
fn who_has_no_axis_sees_its_tables_in_force_by_name() {
    let mut params = House::new().params().expect("the parameters are in order");
    let names = |params: &ParamsFile, case: &Case| {
        let view = params.view(&["base"], &[BASE], case, &[], &[]);
        let table = view["base"].as_table().expect("a table").clone();
        table.keys().cloned().collect::<Vec<_>>()
    };
    let list = params.list(BASE).expect("a list");
    assert!(list.len() > 1);
    let mut all = names(&params, &Case::default());
    params.set("base.d.offset=4").expect("an assignment");
    assert_eq!(names(&params, &Case::default()), all, "d is not in force");
    let only = format!("run.{}=[\"{}\"]", BASE.list, list[1]);
    params.set(&only).expect("an assignment");
    assert_eq!(names(&params, &Case::default()), [list[1].clone()]);
    // With the axis, a case's own table alone.
    assert!(names(&params, &Case::default().with(BASE, &list[0])).contains(&"offset".to_owned()));
    all.sort();
    let mut list = list;
    list.sort();
    assert_eq!(all, list);
}

#[test]
fn every_refusal_names_place_key_expected_found_and_nearest() {
    let cases = [
        (
            "base.a.ofset=1",
            "--set: base.a.ofset: expected a known key, found an unknown one; nearest: `base.a.offset`",
        ),
        (
            "bass.a.offset=1",
            "--set: bass.a.offset: expected a known key, found an unknown one; nearest: `base.a.offset`",
        ),
        (
            "case.base=b",
            "--set: case.base: expected a known key, found an unknown one; nearest: `pinned.base`",
        ),
        (
            "base.a.offset=1.5",
            "--set: base.a.offset: expected a whole number, found floating point `1.5`",
        ),
        (
            "base.a.offset=no",
            "--set: base.a.offset: expected a whole number, found string \"no\"",
        ),
        (
            "numbers.count=0",
            "--set: numbers.count: expected a whole number from 1 to 100000000, found 0",
        ),
        ("run.seed=-1", "--set: run.seed: expected a whole number >= 0, found -1"),
        (
            "run.bases=[]",
            "--set: run.bases: expected a list of names of [base.*] tables (a, b, c), found an empty list",
        ),
        (
            "pinned.base=aa",
            "--set: pinned.base: expected the name of a [base.*] table (a, b, c), found \"aa\"; nearest: `a`",
        ),
        (
            "pinned.item=30",
            "--set: pinned.item: expected a whole number below numbers.count = 30, found 30",
        ),
        (
            "numbers.count=3",
            "toy.toml:26: pinned.item: expected a whole number below numbers.count = 3, found 3",
        ),
        (
            "draws.row=[{base=\"a\",levle=1}]",
            "--set: draws.row[0].levle: expected `base` or `level`, found `levle`; nearest: `level`",
        ),
        (
            "draws.row=[{base=\"cc\",level=1}]",
            "--set: draws.row: row 0: expected base = the name of a [base.*] table (a, b, c), found \"cc\"; nearest: `c`",
        ),
    ];
    for (edit, expected) in cases {
        let mut house = House::new();
        house.set(edit);
        assert_eq!(house.refusal(), expected);
        assert!(!house.path("store").exists());
    }
}

#[test]
fn an_empty_unknown_table_is_refused_too() {
    let mut house = House::new();
    house.text += "\n[bases]\n";
    assert_eq!(
        house.refusal(),
        "toy.toml:39: bases: expected a known key, found an unknown one; nearest: `base`"
    );
}

#[test]
fn a_key_that_is_missing_is_named_at_its_table() {
    let mut house = House::new();
    house.text += "\n[base.d]\n";
    assert_eq!(
        house.refusal(),
        "toy.toml:39: base.d.offset: expected a value, found none"
    );
}

#[test]
fn targets_are_parsed_or_refused() {
    let parse = |text: &str| Target::parse(text).map(|target| (target.stage, target.case, target.piece));
    let some = |text: &str| Some(text.to_owned());
    assert_eq!(parse("a").expect("a stage"), ("a".to_owned(), None, None));
    assert_eq!(parse("a/3").expect("a piece"), ("a".to_owned(), None, Some(3)));
    assert_eq!(parse("a/b-c").expect("a case"), ("a".to_owned(), some("b-c"), None));
    assert_eq!(parse("a/b/3").expect("a piece"), ("a".to_owned(), some("b"), Some(3)));
    for bad in ["a/b/c", "a/b/3/4", "a/b/-1", "a/b/"] {
        assert_eq!(parse(bad).expect_err("a refusal").exit_code(), 2, "{bad}");
    }
}

#[test]
fn targets_that_do_not_exist_are_refused_with_the_nearest_name() {
    let house = House::new();
    for (target, part) in [
        ("repart", "nearest: `report`"),
        (
            "squares/d",
            "expected a case of squares (a, b, c), found none of them; nearest: `",
        ),
        (
            "squares/a/3",
            "target `squares/a/3`: expected a piece from 0 to 2, found 3",
        ),
        ("aside/1", "expected a piece from 0 to 0, found 1"),
        ("", "expected the name of a stage or output"),
    ] {
        let message = house.graph(&[target]).err().expect("a refusal").to_string();
        assert!(message.contains(part), "{target}: {message}");
    }
}
