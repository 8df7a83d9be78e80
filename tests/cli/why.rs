//! `encounter why` on the real binary: the text a reader sees, the data, and changes of real files and crates.

use super::verbs::SMALL;
use crate::common::program::{Program, keys};
use crate::common::records;
use encounter::engine::params::ParamsFile;
use serde_json::{Value, json};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// A store with one ship and one sea in it, whose records say that each piece took as long as its stage's name.
fn lived_in() -> Program {
    let program = Program::new("tiny");
    let said = program.call(&[&["run"], SMALL.as_slice()].concat());
    assert_eq!(said.code, 0, "{}", said.stderr);
    for path in records::all(&program.path("store")) {
        records::edit(&path, |record| {
            let node = record["node"].as_str().expect("a name");
            record["seconds"] = json!(node.split('/').next().map_or(0, str::len));
        });
    }
    program
}

fn record_of(program: &Program, node: &str) -> PathBuf {
    let all = records::all(&program.path("store"));
    let found = all.into_iter().find(|path| records::read(path)["node"] == node);
    found.expect("the node has a record")
}

fn call(program: &Program, verb: &[&str], sets: &[&str]) -> String {
    let sets: Vec<&str> = sets.iter().flat_map(|set| ["--set", set]).collect();
    let said = program.call(&[verb, SMALL.as_slice(), &sets].concat());
    assert_eq!(said.code, 0, "{}", said.stderr);
    said.stdout
}

#[test]
fn the_terminal_tells_the_walk_to_the_root_and_the_plan() {
    let program = lived_in();
    let sets = ["ship.calibrated.alpha_1=0.07", "vhgp_seq.total=20"];
    let mut text = call(&program, &["why", "table1"], &sets);
    for part in [
        call(&program, &["why", "fig1_wave_groups"], &["sea.S1.bandwidth=0.025"]),
        call(&program, &["why", "wave_synthesis"], &sets[..1]),
        call(&program, &["why", "vhgp_seq"], &["vhgp_seq.realisations=3"]),
        call(&program, &["status"], &sets),
    ] {
        text = text + "---\n" + &part;
    }
    insta::assert_snapshot!(text);
}

#[test]
fn the_answer_as_data() {
    let program = lived_in();
    let ask = |node: &str, set: &str| {
        let arguments = [&["why", node], SMALL.as_slice(), &["--set", set]].concat();
        program.json(&arguments)
    };
    let answer = ask("table1/calibrated", "ship.calibrated.alpha_1=0.07");
    let expected = [
        "because", "besides", "cost", "format", "node", "pieces", "profile", "records", "stale", "state",
    ];
    assert_eq!(keys(&answer), expected);
    assert_eq!(
        (&answer["state"], &answer["node"]),
        (&json!("may_run"), &json!("table1/calibrated"))
    );
    let branch_keys = ["because", "cases", "cost", "node", "of", "pieces", "reasons", "state"];
    let mut branch = &answer["because"][0];
    while branch["because"].as_array().is_some_and(|below| !below.is_empty()) {
        assert_eq!(
            (keys(branch), branch["reasons"].as_array().map(Vec::len)),
            (branch_keys.to_vec(), Some(0))
        );
        branch = &branch["because"][0];
    }
    let root = json!([{
        "kind": "parameter", "name": "ship.calibrated.alpha_1", "old": "0.01", "new": "0.07", "origin": "--set",
    }]);
    assert_eq!(
        (&branch["node"], &branch["reasons"]),
        (&json!("nic/calibrated-S1"), &root)
    );
    assert_eq!(branch["cost"], json!({"certain": 3.0, "at_most": 3.0, "untimed": 0}));
    let cached = ask("nic/calibrated-S1", "vhgp_seq.total=20");
    assert_eq!((&cached["state"], &cached["because"]), (&json!("cached"), &json!([])));
    let record = &cached["records"][0];
    assert_eq!(
        record["reads"],
        json!(["wave_synthesis/S1", "group_detection/S1", "group_sample/S1"])
    );
    assert_eq!(record["inputs"].as_array().map(Vec::len), Some(3));
    assert_eq!(record["key"].as_str().map(str::len), Some(64));
}

#[test]
fn an_edited_file_and_another_version_of_a_crate() {
    let program = lived_in();
    let store = program.path("store");
    records::age(&record_of(&program, "ground_truth/calibrated-S1"), |record| {
        record["code"] = json!("1".repeat(64));
        record["parts"]["code"] = records::part(&store, &record["parts"]["code"], |part| {
            part["files"]["src/ship/roll_equation.rs"] = json!("another hash");
            part["crates"]["pxfm"][0]["version"] = json!("0.1.29");
        });
    });
    let answer = program.json(&[&["why", "truth"], SMALL.as_slice()].concat());
    let mut branch = &answer["because"][0];
    while branch["node"] != "ground_truth/calibrated-S1" {
        branch = &branch["because"][0];
    }
    let kinds: Vec<&Value> = branch["reasons"]
        .as_array()
        .expect("a list")
        .iter()
        .map(|it| &it["kind"])
        .collect();
    assert_eq!(kinds, ["file", "crate"]);
    let text = call(&program, &["why", "truth"], &[]);
    assert!(text.contains("`src/ship/roll_equation.rs` changed"), "{text}");
    assert!(text.contains("crate `pxfm` 0.1.29 -> 0.1.30"), "{text}");
    assert!(text.contains("truth  may run"), "{text}");
}

#[test]
fn every_parameter_is_told_under_the_name_that_the_reader_wrote() {
    let program = lived_in();
    let stages = Path::new(env!("CARGO_MANIFEST_DIR")).join("stages");
    let files = [stages.join("paper.toml"), stages.join("tiny.toml")];
    let files: Vec<&Path> = files.iter().map(PathBuf::as_path).collect();
    let params = ParamsFile::read(&files, &[]).expect("the parameters are readable");
    let leaves: Vec<String> = params.leaves().iter().map(ToString::to_string).collect();
    let mut told = 0;
    for entry in fs::read_dir(program.path("store/parts")).expect("a folder").flatten() {
        let part = records::read(&entry.path());
        let (Some(values), Some(shape)) = (part["values"].as_object(), part["shape"].as_object()) else {
            continue;
        };
        // What a stage takes as optional is null where the reader wrote nothing.
        let written = values.iter().chain(shape).filter(|(_, value)| !value.is_null());
        for (name, _) in written {
            let leaf = name.split('[').next().expect("a first part");
            assert!(leaves.iter().any(|known| known == leaf), "{name}");
            told += 1;
        }
    }
    assert!(told > 100, "{told}");
}

#[test]
fn a_dry_run_is_the_status_and_its_what_if_is_certain_where_it_can_be() {
    let program = lived_in();
    let set = ["--set", "ship.calibrated.alpha_1=0.07"];
    let dry = program.json(&[&["run", "--dry-run"], SMALL.as_slice(), &set].concat());
    let node = |name: &str| {
        let nodes = dry["nodes"].as_array().expect("a list").iter();
        nodes
            .clone()
            .find(|node| node["node"] == name)
            .expect("the node is there")
            .clone()
    };
    let truth = node("ground_truth/calibrated-S1");
    assert_eq!(truth["reason"], "parameter `ship.calibrated.alpha_1` 0.01 -> 0.07");
    assert_eq!(
        (&truth["seconds"], &truth["seconds_certain"]),
        (&json!(12.0), &json!(12.0))
    );
    let table = node("table1/calibrated");
    assert_eq!(
        (&table["will_run"], &table["may_run"], &table["seconds"]),
        (&json!(0), &json!(1), &json!(6.0))
    );
    assert_eq!(table["seconds_certain"], json!(0.0));
    let sum = |key: &str| {
        let nodes = dry["nodes"].as_array().expect("a list").iter();
        nodes.filter_map(|node| node[key].as_f64()).sum::<f64>()
    };
    assert_eq!(dry["cost"]["at_most"].as_f64(), Some(sum("seconds")));
    assert_eq!(dry["cost"]["certain"].as_f64(), Some(sum("seconds_certain")));
    let affected = [
        "fig3_exceedance/calibrated",
        "fig4_response_moments/calibrated-S1",
        "table1/calibrated",
        "truth",
    ];
    assert!(affected.iter().all(|figure| {
        dry["figures"]
            .as_array()
            .is_some_and(|all| all.contains(&json!(figure)))
    }));
    let status = program.json(&[&["status"], SMALL.as_slice(), &set].concat());
    assert_eq!(dry, status);
}

#[test]
fn a_name_that_is_no_node_is_refused_with_the_nearest() {
    let program = Program::new("tiny");
    for (node, part) in [
        ("tabel1", "nearest: `table1`"),
        ("nic/calibrated-S9", "nearest: `calibrated-S"),
        ("nic/calibrated-S1/7", "expected a piece from 0 to 0, found 7"),
    ] {
        let said = program.call(&["why", node]);
        assert_eq!((said.code, said.stdout.as_str()), (2, ""), "{node}");
        assert!(said.stderr.contains(part), "{node}: {}", said.stderr);
    }
}

#[test]
fn a_binary_older_than_its_sources_says_so() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let tree = tempfile::tempdir().expect("a temporary folder can be made");
    for name in ["Cargo.lock", "Cargo.toml", "src", "stages"] {
        copy(&root.join(name), &tree.path().join(name));
    }
    let status = |json: &[&str]| {
        let mut program = Command::new(env!("CARGO_BIN_EXE_encounter"));
        program
            .current_dir(tree.path())
            .args(["status", "--profile", "tiny"])
            .args(json);
        String::from_utf8(program.output().expect("the binary runs").stdout).expect("text")
    };
    let stale = || serde_json::from_str::<Value>(&status(&["--json"])).expect("JSON")["stale"].clone();
    assert_eq!(stale(), json!([]));
    assert!(!status(&[]).contains("older"));
    let edited = tree.path().join("src/ship/roll_equation.rs");
    let text = fs::read_to_string(&edited).expect("the file is there");
    fs::write(&edited, text + "// Later.\n").expect("the file can be written");
    assert_eq!(stale(), json!(["src/ship/roll_equation.rs"]));
    let sentence = "this binary is older than its sources (src/ship/roll_equation.rs): build it again";
    assert!(status(&[]).contains(sentence));
}

fn copy(from: &Path, to: &Path) {
    if !from.is_dir() {
        fs::copy(from, to).expect("the file can be copied");
        return;
    }
    fs::create_dir(to).expect("a folder can be made");
    for entry in fs::read_dir(from).expect("a folder").flatten() {
        copy(&entry.path(), &to.join(entry.file_name()));
    }
}
