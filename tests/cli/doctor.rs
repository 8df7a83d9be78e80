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

#[test]
fn a_store_or_a_figures_folder_in_which_no_file_can_be_made_is_a_problem_that_is_named() {
    let program = Program::new("tiny");
    assert_eq!(program.call(&["run", "groups"]).code, 0);
    program.exits(0, &["doctor"]);
    let figures = program.path("figures");
    fs::write(&figures, "a file").expect("a file can be written");
    let figures = figures.display().to_string();
    // Not even the superuser makes a file in /proc.
    for folder in ["/proc/figures", figures.as_str()] {
        let said = program.exits(3, &["doctor", "--figures", folder]);
        let told = format!("problem  figures: cannot write figures to {folder}");
        assert!(said.stdout.contains(&told), "{}", said.stdout);
        assert!(
            said.stdout.contains("with --figures") && !said.stdout.contains("all is well"),
            "{}",
            said.stdout
        );
    }
    let store = std::process::Command::new(env!("CARGO_BIN_EXE_encounter"))
        .current_dir(program.path("checkout"))
        .args(["doctor", "--profile", "tiny", "--store", "/proc/store"])
        .output()
        .expect("the binary runs");
    let said = String::from_utf8_lossy(&store.stdout).into_owned();
    assert_eq!(store.status.code(), Some(3), "{said}");
    assert!(said.contains("problem  store: cannot write to /proc/store"), "{said}");
    let tmp = program.path("store/tmp");
    fs::remove_dir_all(&tmp).expect("the folder can be deleted");
    fs::write(&tmp, "a file").expect("a file can be written");
    let said = program.exits(3, &["doctor"]);
    assert!(
        said.stdout.contains("problem  store: cannot write to "),
        "{}",
        said.stdout
    );
    // What was tried leaves nothing.
    let left = fs::read_dir(program.path("store")).expect("a folder").flatten();
    assert!(
        left.into_iter()
            .all(|entry| !entry.file_name().to_string_lossy().starts_with(".encounter-"))
    );
}
