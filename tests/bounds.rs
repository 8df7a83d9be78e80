//! Every number of the parameter file at its extremes: refused with its name, or of a size that a run can hold.
//!
//! The first test asks the checks alone, of every number, in this process. The second runs the tiny profile with what the
//! checks let through, within limits of memory and time; it takes many minutes and is run by hand:
//! `cargo test --release accepted_extremes -- --ignored --nocapture`.

use std::collections::BTreeSet;
use std::path::Path;
use std::process::Command;

use encounter::engine::graph::Graph;
use encounter::engine::params::ParamsFile;
use encounter::engine::target::Target;
use encounter::stages::{CONTENTS, PIPELINE};
use toml::Value;

use crate::common::program::Program;

/// The bound of `engine::graph` on the pieces of a run.
const MOST_PIECES: usize = 250_000;

fn tiny() -> ParamsFile {
    let stages = Path::new(env!("CARGO_MANIFEST_DIR")).join("stages");
    let files = [stages.join("paper.toml"), stages.join("tiny.toml")];
    let files: Vec<&Path> = files.iter().map(std::path::PathBuf::as_path).collect();
    ParamsFile::read(&files, &[]).expect("the parameters are readable")
}

/// What a number may be replaced by.
fn extremes() -> Vec<Value> {
    let whole = [0, -1, 1, 2, 4_294_967_295, 4_294_967_296, i64::MAX, i64::MIN].map(Value::Integer);
    let broken = [0.0, -1.0, 1e300, -1e300, 1e-300, 1e12, 1e-12, f64::NAN, f64::INFINITY].map(Value::Float);
    whole.into_iter().chain(broken).collect()
}

/// A value with each of its numbers replaced by each extreme, and each of its lists emptied and made very long.
fn variants(value: &Value) -> Vec<Value> {
    match value {
        Value::Integer(_) | Value::Float(_) => extremes(),
        Value::Array(rows) => {
            let replaced = |i: usize, new: Value| {
                let mut rows = rows.clone();
                rows[i] = new;
                Value::Array(rows)
            };
            let inner = |(i, row): (usize, &Value)| {
                variants(row)
                    .into_iter()
                    .map(move |new| replaced(i, new))
                    .collect::<Vec<_>>()
            };
            let mut all: Vec<Value> = rows.iter().enumerate().flat_map(inner).collect();
            all.push(Value::Array(Vec::new()));
            if let Some(first) = rows.first() {
                all.push(Value::Array(vec![first.clone(); 5_000]));
                let ascending = (1..=5_000).map(|i| {
                    if first.is_float() {
                        Value::Float(f64::from(i))
                    } else {
                        Value::Integer(i64::from(i))
                    }
                });
                all.push(Value::Array(ascending.collect()));
            }
            all
        }
        Value::Table(table) => {
            let replaced = |key: &String, new: Value| {
                let mut table = table.clone();
                table.insert(key.clone(), new);
                Value::Table(table)
            };
            let inner = |(key, value): (&String, &Value)| {
                variants(value)
                    .into_iter()
                    .map(|new| replaced(key, new))
                    .collect::<Vec<_>>()
            };
            table.iter().flat_map(inner).collect()
        }
        _ => Vec::new(),
    }
}

/// Every assignment of an extreme to a key of the tiny profile: (path, assignment).
fn assignments() -> Vec<(String, String)> {
    let params = tiny();
    let mut all = Vec::new();
    for leaf in params.leaves() {
        let value = params.get(&leaf).expect("a leaf has a value");
        let of_leaf = variants(value)
            .into_iter()
            .map(|new| (leaf.to_string(), format!("{leaf}={new}")));
        all.extend(of_leaf);
    }
    all
}

/// The graph of everything, also of what runs on request alone.
fn graph(assignment: &str) -> Result<Graph, String> {
    let mut params = tiny();
    let targets: Result<Vec<Target>, _> = CONTENTS.iter().map(|node| Target::parse(node.name())).collect();
    params
        .set(assignment)
        .and_then(|()| Graph::new(&PIPELINE, &params, &targets?))
        .map_err(|error| error.to_string())
}

#[test]
fn every_number_at_its_extremes_is_refused_by_name_or_of_a_size_that_can_be_held() {
    let (mut refused, mut accepted, mut wrong) = (BTreeSet::new(), 0, Vec::new());
    for (path, assignment) in assignments() {
        match graph(&assignment) {
            Err(why) => {
                let key = path.rsplit('.').next().expect("a last key");
                let told =
                    why.contains(key) && why.contains("expected ") && why.contains("found ") && why.len() < 2_000;
                if !told {
                    wrong.push(why);
                }
                refused.insert(path);
            }
            Ok(graph) => {
                let pieces: usize = graph.nodes.iter().map(|node| node.pieces.len()).sum();
                assert!(pieces <= MOST_PIECES, "{assignment}: {pieces}");
                accepted += 1;
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    let with_numbers: BTreeSet<String> = assignments().into_iter().map(|(path, _)| path).collect();
    let never_refused: Vec<&String> = with_numbers.difference(&refused).collect();
    assert!(never_refused.is_empty(), "{never_refused:?}");
    assert!(accepted > 100, "{accepted}");
}

#[test]
fn a_count_that_is_too_large_names_the_number_that_fits() {
    for (key, most) in [
        ("vhgp_seq.realisations", 100_000_000_i64),
        ("record.fields", 100_000_000),
    ] {
        let why = graph(&format!("{key}={most}")).err().expect("a refusal");
        let fits = why
            .split("expected at most ")
            .nth(1)
            .and_then(|rest| rest.split(',').next());
        let fits: u64 = fits.and_then(|number| number.parse().ok()).expect("a number that fits");
        assert!(why.starts_with(&format!("--set: {key}: ")), "{why}");
        assert!(graph(&format!("{key}={fits}")).is_ok(), "{key}={fits}");
        let more = graph(&format!("{key}={}", fits + 1_000));
        assert!(more.is_err_and(|why| why.contains(key)), "{key}");
    }
}

#[test]
fn sizes_that_never_ended_or_aborted_are_refused_with_the_reason() {
    for (assignment, reason) in [
        (
            "vhgp_seq.neighbours=4294967295",
            "since every draw sorts so many groups",
        ),
        (
            "nic.groups_ahead=4294967295",
            "since every run goes through all of them",
        ),
        (
            "vhgp_seq.grid=[4000000000, 4000000000]",
            "since the model is asked at every node",
        ),
        (
            "vhgp_seq.quadrature=[1, 1000000]",
            "since the model is asked at every node",
        ),
        (
            "vhgp_best.quadrature=[100000, 100000]",
            "since the model is asked at every node",
        ),
        (
            "estimate.window=1e7",
            "since a group has no waves so far from its centre",
        ),
        (
            "estimate.samples=4294967295",
            "since all sampled groups are held in memory",
        ),
        ("vhgp_seq.fit.restarts=100000", "since each is a fit of its own"),
        ("vhgp_seq.fit.memory=4294967295", "since every pair of vectors is kept"),
        (
            "vhgp_seq.total=4294967295",
            "since the time of every fit grows with the cube",
        ),
        ("pic.periods=4294967295", "since the ensemble takes"),
        (
            "sampling_floor.degree=4294967295",
            "since the design is sought among all monomials",
        ),
        (
            "random_sampling.samples=[4294967295]",
            "since every realisation draws so many",
        ),
        ("calibration.fields=10000000", "in 4 seas, are held in memory at once"),
        ("record.fields=900000", "the sizes of all groups"),
    ] {
        let why = graph(assignment)
            .err()
            .unwrap_or_else(|| panic!("{assignment}: expected a refusal"));
        assert!(why.contains(reason), "{assignment}: {why}");
    }
}

#[test]
fn a_lead_in_is_bounded_in_steps_of_the_roll() {
    let refusal = |t_p: &str| {
        let mut params = tiny();
        params.set("record.lead_in=200000.0").expect("an assignment");
        params.set(&format!("sea.S1.peak_period={t_p}")).expect("an assignment");
        Graph::new(&PIPELINE, &params, &[]).err().map(|error| error.to_string())
    };
    assert_eq!(refusal("15.0"), None);
    let why = refusal("0.1").expect("a refusal");
    assert!(why.starts_with("--set: record.lead_in: expected at most 156"), "{why}");
}

/// Runs the tiny profile with what the checks let through: no abort, no panic, no end that does not come.
#[test]
#[ignore = "runs the program some hundred times"]
fn accepted_extremes_run_to_an_end_within_four_gigabytes_and_a_minute() {
    let mut bad = Vec::new();
    let mut tried = BTreeSet::new();
    for (path, assignment) in assignments() {
        if assignment.len() > 4_000 || graph(&assignment).is_err() || !tried.insert(assignment.clone()) {
            continue;
        }
        let program = Program::new("tiny");
        let run = program.command(&[
            "run",
            "-j",
            "1",
            "--set",
            "run.seas=[\"S1\",\"S2\"]",
            "--set",
            &assignment,
        ]);
        let mut limited = Command::new("sh");
        limited
            .args(["-c", "ulimit -v 4000000; exec timeout 60 \"$0\" \"$@\""])
            .arg(run.get_program())
            .args(run.get_args());
        let said = limited.output().expect("the binary runs");
        let text = String::from_utf8_lossy(&said.stderr).into_owned();
        let ended = matches!(said.status.code(), Some(0..=3 | 5));
        let panicked = text.contains("panicked");
        println!(
            "{:?} {path}: {}",
            said.status.code(),
            assignment.chars().take(120).collect::<String>()
        );
        if !ended || panicked {
            bad.push(format!("{:?} {assignment}: {text}", said.status));
        }
    }
    assert!(bad.is_empty(), "{}", bad.join("\n"));
}
