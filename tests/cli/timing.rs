//! `run --profile-time`: what each stage took, of a run and of the records.

use super::verbs::SMALL;
use crate::common::program::{Program, keys};
use serde_json::Value;

const STAGES: [&str; 5] = [
    "wave_synthesis",
    "envelope",
    "group_detection",
    "group_statistics",
    "groups",
];

fn call(program: &Program, more: &[&str]) -> String {
    let said = program.call(&[&["run", "groups", "--profile-time"], SMALL.as_slice(), more].concat());
    assert_eq!(said.code, 0, "{}", said.stderr);
    said.stdout
}

/// The lines from the head of the table to its sum.
fn table(text: &str) -> Vec<Vec<&str>> {
    let lines = text.lines().skip_while(|line| !line.starts_with("paper "));
    let lines: Vec<&str> = lines.collect();
    let sum = lines.iter().position(|line| line.trim_start().starts_with("all "));
    let lines = &lines[..=sum.expect("the table ends in a sum")];
    let width = |line: &str| line.chars().count();
    assert!(lines.iter().all(|line| width(line) == width(lines[0])), "{text}");
    lines.iter().map(|line| line.split_whitespace().collect()).collect()
}

#[test]
fn a_run_tells_what_ran_and_one_with_nothing_to_do_what_the_records_say() {
    let program = Program::new("tiny");
    let first = call(&program, &[]);
    assert!(
        first.contains(" of one core in ") && first.contains(" cores busy"),
        "{first}"
    );
    let second = call(&program, &[]);
    let plainly = "nothing had to run: ";
    assert!(!first.contains(plainly) && second.contains(plainly), "{second}");
    assert_eq!(table(&first), table(&second));
    let stages: Vec<&str> = table(&second).iter().map(|row| row[1]).collect();
    assert_eq!(stages[1..=STAGES.len()], STAGES, "{second}");
    let head = "paper stage nodes pieces seconds share MB pieces/s MB/s";
    assert_eq!(table(&second)[0].join(" "), head);
}

#[test]
fn without_being_asked_a_run_tells_it_in_short_and_its_json_not_at_all() {
    let program = Program::new("tiny");
    let arguments = [&["run", "groups"], SMALL.as_slice()].concat();
    let said = program.call(&arguments);
    assert!(!said.stdout.contains("pieces/s"), "{}", said.stdout);
    assert!(program.json(&arguments).get("profile_time").is_none());
}

#[test]
fn the_json_holds_the_same_numbers_unrounded() {
    let program = Program::new("tiny");
    let arguments = [&["run", "groups", "--profile-time"], SMALL.as_slice()].concat();
    let (ran, kept) = (program.json(&arguments), program.json(&arguments));
    let (run, records) = (&ran["profile_time"], &kept["profile_time"]);
    assert_eq!((&run["of"], &records["of"]), (&"run".into(), &"records".into()));
    assert_eq!(keys(run), ["bytes", "nodes", "of", "pieces", "seconds", "stages"]);
    assert_eq!(
        run["pieces"].as_u64(),
        ran["ran"].as_array().map(|ran| ran.len() as u64)
    );
    assert_eq!((&run["pieces"], &run["bytes"]), (&records["pieces"], &records["bytes"]));
    let stages = |times: &Value| times["stages"].as_array().expect("a list").clone();
    let columns = [
        "bytes",
        "bytes_per_second",
        "nodes",
        "paper",
        "pieces",
        "pieces_per_second",
        "seconds",
        "share",
        "stage",
    ];
    assert!(stages(run).iter().all(|of| keys(of) == columns), "{run}");
    let shares: f64 = stages(records).iter().filter_map(|of| of["share"].as_f64()).sum();
    assert!((shares - 1.0).abs() < 1e-9, "{shares}");
}

#[test]
fn a_dry_run_has_no_time_to_tell() {
    let program = Program::new("tiny");
    let said = program.call(&["run", "--dry-run", "--profile-time"]);
    assert_eq!(said.code, 2, "{}", said.stderr);
}
