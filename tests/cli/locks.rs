//! Committed locks: who changes them, what a run says of them, and whose they are.

use crate::cli::verbs::SMALL;
use crate::common::program::{Program, keys};
use serde_json::Value;
use std::fs;
use std::process::Command;

fn lock_of(answer: &Value) -> (u64, u64, usize) {
    let lock = &answer["lock"];
    assert_eq!(keys(lock), ["differ", "equal", "lines", "path", "readable"]);
    let number = |key: &str| lock[key].as_u64().expect("a number");
    let differ = lock["differ"].as_array().expect("a list").len();
    (number("lines"), number("equal"), differ)
}

#[test]
fn a_lock_is_changed_by_update_lock_alone_and_every_run_says_how_its_lines_stand() {
    let program = Program::new("tiny");
    let lock = program.checkout("artifacts/tiny.lock");
    let accept = "encounter run --profile tiny --update-lock";
    // There is none yet: a run says how to make one, and makes none.
    let first = program.exits(0, &["run"]);
    assert!(first.stdout.contains("no lock yet: "), "{}", first.stdout);
    assert!(first.stdout.contains(accept), "{}", first.stdout);
    assert!(!lock.exists());
    assert_eq!(program.exits(5, &["run", "--locked"]).stdout, "");
    let answer = program.json(&["run"]);
    let (lines, equal, differ) = lock_of(&answer);
    assert_eq!((equal, differ), (0, lines as usize));
    assert_eq!(answer["lock"]["path"], "artifacts/tiny.lock");

    let made = program.exits(0, &["run", "--update-lock"]);
    assert!(
        made.stdout.contains("artifacts/tiny.lock: written, "),
        "{}",
        made.stdout
    );
    let text = program.lock_text();
    for arguments in [&["run"] as &[&str], &["run", "--locked"], &["run", "--update-lock"]] {
        let said = program.exits(0, arguments);
        let sentence = format!("artifacts/tiny.lock: {lines} lines as committed\n");
        assert!(said.stdout.ends_with(&sentence), "{}", said.stdout);
        assert_eq!(program.lock_text(), text);
    }
    assert_eq!(lock_of(&program.json(&["run", "--locked"])), (lines, lines, 0));

    // A line that differs, as after an edited parameter: told, not written.
    let line = text
        .lines()
        .find(|line| line.starts_with("cic/printed-S2 "))
        .expect("a line");
    let content = line.split_whitespace().nth(3).expect("its content");
    let other = text.replacen(content, &"0".repeat(64), 1);
    fs::write(&lock, &other).expect("a lock can be written");
    let sentence =
        format!("1 of {lines} lines differ from artifacts/tiny.lock: first cic/printed-S2; accept them with: ");
    let said = program.exits(0, &["run"]);
    assert!(
        said.stdout.contains(&sentence) && said.stdout.contains(accept),
        "{}",
        said.stdout
    );
    let said = program.exits(3, &["run", "--locked"]);
    assert!(
        said.stderr.contains(&sentence) && said.stderr.contains(accept),
        "{}",
        said.stderr
    );
    let answer = program.json(&["run"]);
    assert_eq!(lock_of(&answer), (lines, lines - 1, 1));
    assert_eq!(answer["lock"]["differ"][0], "cic/printed-S2");
    assert_eq!(program.lock_text(), other);
    program.exits(0, &["run", "--update-lock"]);
    assert_eq!(program.lock_text(), text);

    // A lock that cannot be read stops a run only where it is asked for.
    fs::write(&lock, "<<<<<<< ours\n").expect("a lock can be written");
    let said = program.exits(0, &["run"]);
    assert!(
        said.stderr.contains("artifacts/tiny.lock, line 1 is damaged"),
        "{}",
        said.stderr
    );
    program.exits(5, &["run", "--locked"]);
    assert_eq!(program.lock_text(), "<<<<<<< ours\n");
    program.exits(0, &["run", "--update-lock"]);
    assert_eq!(program.lock_text(), text);
}

#[test]
fn a_what_if_and_single_targets_have_no_lock_to_update_or_to_keep() {
    let program = Program::new("tiny");
    for option in ["--update-lock", "--locked"] {
        let said = program.exits(2, &[&["run", option], SMALL.as_slice()].concat());
        assert!(said.stderr.contains("a what-if has none"), "{}", said.stderr);
        let said = program.exits(2, &["run", "truth", option]);
        assert!(said.stderr.contains("found the target `truth`"), "{}", said.stderr);
        program.exits(2, &["run", option, "--dry-run"]);
    }
    program.exits(2, &["run", "--update-lock", "--locked"]);
    assert!(!program.path("store").exists());
    let answer = program.json(&[&["run", "truth"], SMALL.as_slice()].concat());
    assert_eq!(answer["lock"], Value::Null);
}

#[test]
fn a_run_in_one_checkout_leaves_the_lock_and_figures_of_another_as_they_are_though_they_share_a_store() {
    let (mine, theirs) = (Program::new("tiny"), Program::new("tiny"));
    mine.exits(0, &["run", "--update-lock"]);
    let call = |arguments: &[&str]| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_encounter"));
        command.current_dir(theirs.path("checkout")).args(arguments);
        command.args(["--profile", "tiny", "--store"]).arg(mine.path("store"));
        let output = command.output().expect("the binary runs");
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        String::from_utf8(output.stdout).expect("text")
    };
    let before = mine.lock_text();
    let said = call(&["run", "--update-lock"]);
    assert!(said.contains("ran 0 pieces"), "{said}");
    assert_eq!(theirs.lock_text(), before);
    call(&["run", "--set", "ship.printed.alpha_1=0.02", "--name", "heavy"]);
    assert!(theirs.checkout("artifacts/figures/heavy/table1.csv").is_file());
    fs::write(theirs.checkout("artifacts/figures/tiny/table1.csv"), "mine").expect("a figure can be edited");
    call(&["run"]);
    assert_eq!(
        fs::read_dir(theirs.checkout("artifacts/edited"))
            .expect("a folder")
            .count(),
        1
    );
    assert_eq!(mine.lock_text(), before);
    mine.exits(0, &["verify", "--lock"]);
    // Nothing of a checkout lies in the store.
    for name in ["figures", "edited", "published", "tiny.lock"] {
        assert!(!mine.path("store").join(name).exists(), "{name}");
    }
    assert!(!mine.checkout("artifacts/edited").exists());
}
