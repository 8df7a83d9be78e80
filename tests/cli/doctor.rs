//! `encounter doctor` on the real binary.

use super::verify::object;
use crate::common::program::{Program, keys};
use std::fs;

#[test]
fn a_machine_is_told_what_it_has_and_what_a_run_needs() {
    let program = Program::new("tiny");
    let answer = program.json(&["doctor"]);
    let known = [
        "cores",
        "disk",
        "format",
        "left",
        "level",
        "memory",
        "minutes",
        "pace",
        "pieces",
        "problems",
        "profile",
        "same_bits",
        "store",
    ];
    assert_eq!(keys(&answer), known);
    assert!(answer["cores"].as_u64() > Some(0) && answer["minutes"].as_f64() > Some(0.0));
    assert_eq!(
        (&answer["same_bits"], &answer["store"]),
        (&true.into(), &serde_json::Value::Null)
    );
    assert_eq!(answer["left"], answer["pieces"]);
    let said = program.call(&["doctor"]).stdout;
    for wanted in [
        "the committed bits",
        "needs 0.25 GiB",
        "pieces from nothing",
        "none yet",
        "all is well",
    ] {
        assert!(said.contains(wanted), "{wanted}: {said}");
    }
    assert!(!program.path("store").exists(), "a look makes nothing");
}

#[test]
fn work_done_is_no_longer_expected_and_damage_is_a_problem() {
    let program = Program::new("tiny");
    assert_eq!(program.call(&["run", "groups"]).code, 0);
    let answer = program.json(&["doctor"]);
    assert!(answer["left"].as_u64() < answer["pieces"].as_u64());
    assert!(answer["store"]["objects"].as_u64() > Some(0));
    let object = object(&program, "group_statistics/S1");
    let mut bytes = fs::read(&object).expect("an object can be read");
    let last = bytes.last_mut().expect("an object is not empty");
    *last ^= 1;
    fs::write(&object, bytes).expect("an object can be written");
    let said = program.call(&["doctor"]);
    assert_eq!(said.code, 3, "{}", said.stdout);
    assert!(said.stdout.contains("problem  store: 1 damaged"), "{}", said.stdout);
}
