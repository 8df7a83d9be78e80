//! `verify` on the real binary: each way of it, what it says, and its exit codes.

use crate::common::program::{Program, keys};
use encounter::engine::lock::Lock;
use serde_json::Value;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::LazyLock;

/// What is run where a whole run would only take longer.
const GROUPS: [&str; 2] = ["run", "groups"];

/// The file that holds a node's only piece.
pub(super) fn object(program: &Program, node: &str) -> PathBuf {
    let shown = program.json(&["show", node]);
    let id = shown["id"].as_str().expect("an id");
    program.path("store/objects").join(&id[..2]).join(&id[2..])
}

#[test]
fn verify_alone_compares_the_lock_and_says_that_nothing_was_recomputed() {
    let program = Program::new("tiny");
    lock_with(&program, str::to_owned);
    let verify = |arguments: &[&str]| {
        let output = Command::new(env!("CARGO_BIN_EXE_encounter"))
            .current_dir(program.path("checkout"))
            .args(["verify", "--profile", "tiny"])
            .args(arguments)
            .output()
            .expect("the binary runs");
        let said = String::from_utf8_lossy(&output.stdout).into_owned();
        (output.status.code(), said)
    };
    let (code, said) = verify(&[]);
    assert_eq!(code, Some(0), "{said}");
    assert!(said.contains(" lines, all equal"), "{said}");
    assert!(said.contains("nothing was recomputed"), "{said}");
    assert!(said.contains("`encounter verify --rebuild`"), "{said}");
    assert_eq!(verify(&["--lock"]), (code, said));
    lock_with(&program, |text| {
        with_word(text, "wave_synthesis/S1", 2, &"0".repeat(64))
    });
    assert_eq!(verify(&[]).0, Some(3));
    let help = program.call(&["verify", "--help"]);
    assert_eq!(help.code, 0);
    for said in [
        "Exit code:",
        "3    something differs",
        "4    a stage is not reproducible",
        "(1 ULP)",
    ] {
        assert!(help.stdout.contains(said), "{said}: {}", help.stdout);
    }
}

#[test]
fn a_damaged_store_is_told_quarantined_and_repaired_by_a_run() {
    let program = Program::new("tiny");
    // Nothing was made yet: an error of the store, which stays unmade.
    assert_eq!(program.call(&["verify"]).code, 5);
    assert!(!program.path("store").exists());

    assert_eq!(program.call(&GROUPS).code, 0);
    let sound = program.json(&["verify"]);
    let expected = [
        "bytes",
        "damaged",
        "differences",
        "format",
        "manifests",
        "missing",
        "objects",
        "orphaned",
        "parts",
        "records",
        "seconds",
        "store",
        "unreadable",
    ];
    assert_eq!(keys(&sound), expected);
    let count = |answer: &Value, what: &str| answer[what].as_array().map(Vec::len);
    for what in ["damaged", "missing", "orphaned", "unreadable", "differences"] {
        assert_eq!(count(&sound, what), Some(0), "{sound}");
    }
    assert!(sound["objects"].as_u64() > Some(0) && sound["bytes"].as_u64() > Some(0));

    let path = object(&program, "groups");
    let mut bytes = fs::read(&path).expect("the object is there");
    bytes[64] ^= 1;
    fs::write(&path, &bytes).expect("the object can be damaged");
    let said = program.call(&["verify"]);
    assert_eq!(said.code, 3, "{}", said.stderr);
    assert!(
        said.stderr.contains("1 file is damaged and set aside in "),
        "{}",
        said.stderr
    );
    let first = said.stdout.lines().next().expect("a line");
    assert!(first.starts_with("damaged    objects/"), "{first}");
    assert!(
        first.ends_with(" (groups): the bytes do not hash to the name"),
        "{first}"
    );
    assert!(
        said.stdout.contains("1 damaged, 0 missing, 0 orphaned"),
        "{}",
        said.stdout
    );
    let quarantine = program.path("store/quarantine");
    let kept: Vec<Vec<u8>> = fs::read_dir(quarantine)
        .expect("a folder")
        .map(|entry| fs::read(entry.expect("an entry").path()).expect("a file"))
        .collect();
    assert_eq!(kept, [bytes]);

    // Now it is missing, which a run makes good.
    let again = program.json(&["verify"]);
    assert_eq!((count(&again, "damaged"), count(&again, "missing")), (Some(0), Some(1)));
    assert_eq!(again["missing"][0]["node"], "groups");
    assert_eq!(program.call(&GROUPS).code, 0);
    // A record made again tells its own seconds, in a digit more or less: bytes are not compared.
    let healed = program.json(&["verify", "-j", "1"]);
    assert_eq!(
        (count(&healed, "damaged"), count(&healed, "missing")),
        (Some(0), Some(0))
    );
    assert_eq!(
        (&healed["objects"], &healed["records"]),
        (&sound["objects"], &sound["records"])
    );
}

/// The lock of a complete run, which all tests share.
static LOCK: LazyLock<String> = LazyLock::new(|| {
    let program = Program::new("tiny");
    assert_eq!(program.call(&["run", "--update-lock"]).code, 0);
    program.lock_text()
});

/// Puts the lock of a complete run into this program's checkout, edited.
fn lock_with(program: &Program, edit: impl Fn(&str) -> String) {
    fs::write(program.checkout("artifacts/tiny.lock"), edit(&LOCK)).expect("a lock can be written");
}

/// A lock whose line of a node has another word at a place.
fn with_word(text: &str, node: &str, place: usize, word: &str) -> String {
    let line = text
        .lines()
        .find(|line| line.starts_with(&format!("{node} ")))
        .expect("a line");
    let old = line.split_whitespace().nth(place).expect("a word");
    text.replace(line, &line.replace(old, word))
}

#[test]
fn a_rebuild_of_a_node_agrees_or_says_what_differs() {
    let program = Program::new("tiny");
    lock_with(&program, str::to_owned);
    let node = "group_statistics/S1";
    let equal = program.json(&["verify", "--rebuild", node]);
    let expected = [
        "differences",
        "downstream",
        "first",
        "format",
        "lines",
        "lock",
        "seconds",
        "toolchains",
    ];
    assert_eq!(keys(&equal), expected);
    assert_eq!(
        (equal["differences"].as_array().map(Vec::len), &equal["first"]),
        (Some(0), &Value::Null)
    );

    // What is not asked for is not compared.
    lock_with(&program, |text| {
        with_word(text, "group_statistics/S2", 3, &"0".repeat(64))
    });
    assert_eq!(program.call(&["verify", "--rebuild", node]).code, 0);
    let said = program.call(&["verify", "--rebuild", "group_statistics/S2", "--json"]);
    assert_eq!(said.code, 3, "{}", said.stderr);
    let first = &said.json()["first"];
    assert_eq!(
        keys(first),
        ["difference", "earlier", "later", "node", "reproducible", "verdict"]
    );
    assert_eq!(
        (&first["node"], &first["reproducible"]),
        (&"group_statistics/S2".into(), &true.into())
    );
    assert!(said.stderr.contains("it came out the same"), "{}", said.stderr);
}

#[test]
fn a_recorded_output_is_compared_value_by_value() {
    let program = Program::new("tiny");
    lock_with(&program, str::to_owned);
    let node = "group_detection/S1";
    // What was made of a lower sea is recorded under the key of the paper's: the same key, other values.
    assert_eq!(program.call(&["run", node]).code, 0);
    let ours = program.json(&["show", node]);
    let other = ["--set", "sea.S1.significant_wave_height=11.5"];
    assert_eq!(program.call(&[&["run", node] as &[&str], &other].concat()).code, 0);
    let theirs = program.json(&[&["show", node] as &[&str], &other].concat());
    let text = |value: &Value, what: &str| value[what].as_str().expect("text").to_owned();
    assert_ne!(text(&ours, "id"), text(&theirs, "id"));
    let key = text(&ours, "key");
    let record = program
        .path("store/records")
        .join(&key[..2])
        .join(format!("{}.json", &key[2..]));
    let body = fs::read_to_string(&record).expect("a record");
    let body = body.rsplit_once(",\"check\":\"").expect("a record ends in its check").0;
    let body = body.replace(&text(&ours, "id"), &text(&theirs, "id"));
    let check = blake3::hash(body.as_bytes()).to_hex();
    fs::write(&record, format!("{body},\"check\":\"{check}\"}}\n")).expect("the record can be written");
    lock_with(&program, |lock| with_word(lock, node, 3, &text(&theirs, "id")));

    let said = program.call(&["verify", "--rebuild", node]);
    assert_eq!(said.code, 4, "{}", said.stderr);
    assert!(
        said.stderr
            .contains("group_detection/S1 is not reproducible: recorded "),
        "{}",
        said.stderr
    );
    assert!(
        said.stderr.contains(" differ, at most ") && said.stderr.contains(" ULP)"),
        "{}",
        said.stderr
    );
    assert!(
        said.stderr.contains("recorded otherwise by the same compiler"),
        "{}",
        said.stderr
    );
}

#[test]
fn another_version_of_an_outside_crate_and_another_compiler_are_named() {
    let program = Program::new("tiny");
    let zeros = "0".repeat(64);
    let other = |text: &str| {
        let text = with_word(text, "wave_synthesis/S1", 2, &zeros);
        let now = format!("pxfm {}", version_of("pxfm"));
        assert!(text.contains(&now), "the lock lists crates");
        let code = text
            .split("wave_synthesis ")
            .nth(1)
            .and_then(|rest| rest.get(..16))
            .expect("the stage's code");
        let text = text.replace(code, "0123456789abcdef").replace(&now, "pxfm 0.1.29");
        text.replacen("made-with rustc ", "made-with rustc 1.0.0 once ", 1)
    };
    lock_with(&program, other);
    let said = program.call(&["verify", "--lock"]);
    assert_eq!(said.code, 3, "{}", said.stderr);
    let named = format!(
        "wave_synthesis/S1: outside crates: pxfm 0.1.29 -> {}",
        version_of("pxfm")
    );
    assert!(said.stderr.contains(&named), "{}", said.stderr);
    assert!(
        said.stderr.contains("the lock was made with rustc 1.0.0 once "),
        "{}",
        said.stderr
    );
    // The compiler alone is no difference.
    lock_with(&program, |text| {
        text.replacen("made-with rustc ", "made-with rustc 1.0.0 once ", 1)
    });
    let said = program.call(&["verify", "--lock"]);
    assert_eq!((said.code, said.stderr.as_str()), (0, ""));
}

#[test]
fn the_lock_of_the_paper_reads_back_as_it_was_written() {
    let lock = Lock::parse(&LOCK).expect("our own lock");
    assert_eq!(lock.text(), *LOCK);
    assert!(lock.crates.contains_key("pxfm") && lock.code.contains_key("ground_truth"));
    assert!(lock.code.values().all(|hash| hash.len() == 16));
    assert!(LOCK.lines().all(|line| line.len() < 240));
}

#[test]
fn a_lock_that_leaves_something_out_is_told() {
    let program = Program::new("tiny");
    let without = |start: &str| {
        let lines = LOCK.lines().filter(|line| !line.starts_with(start));
        lines.collect::<Vec<_>>().join("\n") + "\n"
    };
    for (text, expected) in [
        (
            without("file printed/"),
            "file printed/fig1_wave_groups.* and 12 more: expected a published file",
        ),
        (without("file table1."), "file table1.*: expected a published file"),
        (
            LOCK.replacen("seed 2022", "seed 7", 1),
            "head: expected seed 2022, found 7",
        ),
        (
            LOCK.replacen("profile tiny", "profile paper", 1),
            "head: expected profile tiny, found paper",
        ),
    ] {
        lock_with(&program, |_| text.clone());
        let said = program.call(&["verify", "--lock"]);
        assert_eq!(said.code, 3, "{}", said.stderr);
        assert!(said.stderr.contains(expected), "{}", said.stderr);
    }
}

#[test]
fn files_that_are_not_here_are_not_said_to_be_equal() {
    let program = Program::new("tiny");
    lock_with(&program, str::to_owned);
    let lines = LOCK.lines().filter(|line| line.starts_with("file ")).count();
    let said = program.call(&["verify", "--lock"]);
    assert_eq!(said.code, 0, "{}", said.stderr);
    let told = format!(" lines, all equal; {lines} files not here to compare\n");
    assert!(said.stdout.contains(&told), "{}", said.stdout);
    let told = program.json(&["verify", "--lock"]);
    let number = |key: &str| told[key].as_u64().expect("a number") as usize;
    assert_eq!(number("lines") - number("compared"), lines);
}

/// The locked version of a crate.
fn version_of(name: &str) -> String {
    let lock = fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("Cargo.lock")).expect("a lock");
    let entry = lock
        .split("[[package]]")
        .find(|entry| entry.contains(&format!("name = \"{name}\"\n")));
    let version = entry
        .and_then(|entry| entry.split("version = \"").nth(1))
        .expect("the crate is locked");
    version.split('"').next().expect("a version").to_owned()
}
