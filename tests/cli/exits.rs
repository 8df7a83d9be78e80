//! Exit codes: what went wrong, and what is kept or repaired.

use super::verbs::SMALL;
use crate::common::program::Program;
use std::fs;

#[test]
fn a_stage_that_fails_is_exit_1_and_listed() {
    let program = Program::new("tiny");
    let no_groups = ["--set", "detection.smallest_amplitude=1000"];
    let arguments = [
        &["run", "table1", "truth", "--json"],
        SMALL.as_slice(),
        no_groups.as_slice(),
    ]
    .concat();
    let said = program.call(&arguments);
    assert_eq!(said.code, 1, "{}", said.stderr);
    let failed = &said.json()["failed"];
    assert!(
        failed[0]
            .as_str()
            .is_some_and(|text| text.starts_with("response_pool/calibrated-S1/0: ")),
        "{failed}"
    );
    assert!(said.stderr.contains("no wave group was detected"), "{}", said.stderr);
    let blamed =
        "0 passed the pre-check, 0 the fit and the post-check, and 0 the removal of overlaps; expected a lower";
    assert!(said.stderr.contains(blamed), "{}", said.stderr);
    assert!(
        said.stderr.contains("`detection.smallest_amplitude`"),
        "{}",
        said.stderr
    );
    assert!(
        said.stderr.contains("nodes are not done; the others are kept"),
        "{}",
        said.stderr
    );
    // The truth is kept: asked for alone, it needs nothing more.
    let again = program.ran(&[&["truth"], SMALL.as_slice(), no_groups.as_slice()].concat());
    assert!(again.is_empty(), "{again:?}");
}

#[test]
fn a_damaged_object_is_healed_and_counted() {
    let program = Program::new("tiny");
    let arguments = [&["groups"], SMALL.as_slice()].concat();
    assert_eq!(program.call(&[&["run"], arguments.as_slice()].concat()).code, 0);
    let shown = program.json(&[&["show"], arguments.as_slice()].concat());
    let id = shown["id"].as_str().expect("an id");
    let object = program.path("store/objects").join(&id[..2]).join(&id[2..]);
    let good = fs::read(&object).expect("the object is there");
    fs::write(&object, &good[..good.len() - 1]).expect("the object can be damaged");
    let run = program.json(&[&["run"], arguments.as_slice()].concat());
    assert_eq!(run["healed"].as_array().map(Vec::len), Some(1), "{run}");
    assert_eq!(run["ran"].as_array().map(Vec::len), Some(0));
    assert_eq!(fs::read(&object).expect("the object is there"), good);
}

#[test]
fn a_stage_that_is_not_reproducible_is_exit_4() {
    let program = Program::new("tiny");
    let node = "wave_synthesis/S1";
    assert_eq!(program.call(&["run", node]).code, 0);
    let shown = program.json(&["show", node]);
    let (key, id) = (
        shown["key"].as_str().expect("a key"),
        shown["id"].as_str().expect("an id"),
    );
    let record = program
        .path("store/records")
        .join(&key[..2])
        .join(format!("{}.json", &key[2..]));
    let text = fs::read_to_string(&record).expect("the record is there");
    let (body, _) = text.rsplit_once(",\"check\":\"").expect("a record ends in its check");
    let body = body.replace(id, &"0".repeat(64));
    let forged = format!("{body},\"check\":\"{}\"}}\n", blake3::hash(body.as_bytes()).to_hex());
    fs::write(&record, forged).expect("the record can be written");
    let said = program.call(&["run", "envelope/S1"]);
    assert_eq!(said.code, 4, "{}", said.stderr);
    assert!(
        said.stderr
            .contains("wave_synthesis/S1 is not reproducible: recorded 000"),
        "{}",
        said.stderr
    );
}

#[test]
fn a_store_that_cannot_be_a_folder_is_exit_5() {
    let program = Program::new("tiny");
    program.file("store", "a file");
    let said = program.call(&["run", "groups"]);
    assert_eq!(said.code, 5, "{}", said.stderr);
    assert!(
        said.stderr.contains("cannot make the store's folder"),
        "{}",
        said.stderr
    );
}

#[test]
fn bad_options_are_exit_2() {
    let program = Program::new("tiny");
    let bad: [&[&str]; 7] = [
        &["run", "-j", "0"],
        &["run", "-j", "many"],
        &["run", "--no-such-option"],
        &["walk"],
        &["show"],
        &["verify", "--lock", "--rebuild"],
        &["verify", "--lock", "table1"],
    ];
    for arguments in bad {
        assert_eq!(program.call(arguments).code, 2, "{arguments:?}");
    }
    assert!(!program.path("store").exists());
}

#[test]
fn two_runs_at_once_both_succeed() {
    let program = Program::new("tiny");
    let arguments = [&["run", "truth"], SMALL.as_slice()].concat();
    std::thread::scope(|scope| {
        let runs = [(); 2].map(|()| scope.spawn(|| program.call(&arguments)));
        for run in runs {
            let said = run.join().expect("no panic");
            assert_eq!(said.code, 0, "{}", said.stderr);
        }
    });
    let again = program.ran(&arguments[1..]);
    assert!(again.is_empty(), "{again:?}");
}
