//! Full outputs, closed pipes, strange stores, leftovers of killed runs, interrupted rebuilds.

use super::verbs::SMALL;
use crate::common::program::Program;
use encounter::engine::lock::Lock;
use std::collections::BTreeSet;
use std::fs::{self, File};
use std::path::Path;
use std::process::{Command, Stdio};
use std::thread::sleep;
use std::time::Duration;

fn small(arguments: &[&'static str]) -> Vec<&'static str> {
    [arguments, SMALL.as_slice()].concat()
}

#[test]
fn an_answer_that_cannot_be_printed_is_an_error_and_a_reader_that_has_gone_is_none() {
    let program = Program::new("tiny");
    for verb in [
        &["status"] as &[&str],
        &["status", "--json"],
        &["graph", "--format", "dot"],
        &["status", "--help"],
    ] {
        let full = File::options().write(true).open("/dev/full").expect("a full device");
        let output = program.command(verb).stdout(full).output().expect("the binary runs");
        let told = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(5), "{verb:?}: {told}");
        assert!(
            told.contains("error: cannot print the answer to standard output: No space"),
            "{told}"
        );

        let mut command = program.command(verb);
        let mut child = command
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .expect("the binary runs");
        drop(child.stdout.take());
        let output = child.wait_with_output().expect("the process can be waited for");
        let told = String::from_utf8_lossy(&output.stderr);
        assert_eq!((output.status.code(), told.as_ref()), (Some(0), ""), "{verb:?}");
    }
}

#[test]
fn a_store_that_is_a_file_is_told_by_every_verb() {
    let program = Program::new("tiny");
    program.file("store", "a file");
    for verb in [
        &["run", "groups"] as &[&str],
        &["status"],
        &["why", "groups"],
        &["show", "groups"],
        &["graph", "--format", "dot"],
        &["verify"],
        &["gc"],
    ] {
        let said = program.call(verb);
        let store = program.path("store").display().to_string();
        assert!([2, 5].contains(&said.code), "{verb:?}: {} {}", said.code, said.stderr);
        assert!(said.stderr.contains(&store), "{verb:?}: {}", said.stderr);
        assert_eq!(said.stdout, "", "{verb:?}");
    }
    assert_eq!(
        fs::read_to_string(program.path("store")).expect("the file is there"),
        "a file"
    );
}

#[test]
fn gc_takes_no_parameter_that_a_run_would_refuse() {
    let program = Program::new("tiny");
    let said = program.call(&["gc", "--set", "sea.S1.bandwith=0.05"]);
    assert_eq!(said.code, 2, "{}", said.stderr);
    assert!(said.stderr.contains("nearest: `sea.S1.bandwidth`"), "{}", said.stderr);
    assert_eq!(program.call(&["gc", "--set", "sea.S1.bandwidth=0.05"]).code, 0);
}

#[test]
fn what_killed_runs_left_beside_figures_and_locks_goes_with_the_next() {
    let program = Program::new("tiny");
    let figures = program.path("figures");
    let folder = figures.display().to_string();
    let arguments = [&["run", "truth", "--figures", &folder], SMALL.as_slice()].concat();
    let said = program.call(&arguments);
    assert_eq!(said.code, 0, "{}", said.stderr);
    let left = [
        figures.join(".encounter-0123456789abcdef.tmp"),
        figures.join(".encounter-aB3dEfGhIjKlMnOp.tmp"),
    ];
    let held = figures.join(".encounter-00000000000000aa.tmp");
    let strange = [
        figures.join("notes.tmp"),
        figures.join("truth.csv.0123456789abcdef.tmp"),
        figures.join(".encounter-0123.tmp"),
        figures.join(".encounter-0123456789abcdef.tmp.txt"),
        program.path("store/tiny.lock.fedcba9876543210.tmp"),
        program.checkout("artifacts/notes.fedcba9876543210.tmp"),
    ];
    for path in left.iter().chain([&held]).chain(&strange) {
        fs::write(path, "half of a fig").expect("a file can be written");
    }
    let writer = File::options().write(true).open(&held).expect("the file is there");
    writer.try_lock().expect("nobody else has it");
    assert_eq!(program.call(&arguments).code, 0);
    assert!(left.iter().all(|path| !path.exists()), "{left:?}");
    // A living writer's, and what the program never wrote.
    assert!(held.exists() && strange.iter().all(|path| path.exists()), "{strange:?}");
    drop(writer);
    assert_eq!(program.call(&arguments).code, 0);
    assert!(!held.exists());
}

#[test]
fn an_interrupted_rebuild_leaves_no_temporary_folder() {
    let program = Program::new("quick");
    fs::create_dir(program.path("tmp")).expect("a folder can be made");
    program.commit_lock();
    let mut command = program.command(&["verify", "--rebuild", "-j", "2"]);
    let command = command
        .env("TMPDIR", program.path("tmp"))
        .stdout(Stdio::null())
        .stderr(Stdio::piped());
    let child = command.spawn().expect("the binary runs");
    let inside = || fs::read_dir(program.path("tmp")).expect("a folder").count();
    while inside() == 0 {
        sleep(Duration::from_millis(20));
    }
    // Long enough to be at work, not to be done.
    sleep(Duration::from_secs(1));
    let sent = Command::new("kill").args(["-INT", &child.id().to_string()]).status();
    assert!(sent.expect("kill runs").success());
    let output = child.wait_with_output().expect("the process can be waited for");
    let told = String::from_utf8_lossy(&output.stderr);
    assert_eq!((output.status.code(), inside()), (Some(130), 0), "{told}");
}

#[test]
fn what_cannot_be_set_aside_is_not_told_to_be() {
    let program = Program::new("tiny");
    let said = program.call(&small(&["run", "truth"]));
    assert_eq!(said.code, 0, "{}", said.stderr);
    let shown = program.json(&small(&["show", "truth"]));
    let id = shown["id"].as_str().expect("an id");
    let object = program.path("store/objects").join(&id[..2]).join(&id[2..]);
    fs::write(&object, "damaged").expect("an object can be damaged");
    let quarantine = program.path("store/quarantine");
    let _ = fs::remove_dir_all(&quarantine);
    fs::write(&quarantine, "no folder").expect("a file can be written");
    let said = program.call(&["verify"]);
    assert_eq!(said.code, 3, "{}", said.stderr);
    assert!(
        said.stderr.contains("1 file is damaged and cannot be set aside in "),
        "{}",
        said.stderr
    );
    assert!(object.exists());
}

#[test]
fn an_equal_case_lends_its_record_and_that_is_said() {
    let program = Program::new("tiny");
    let arguments = small(&["run", "group_statistics/S1"]);
    assert_eq!(program.call(&arguments).code, 0);
    let equal = ["--set", "sea.S2.bandwidth=0.02"];
    let said = program.call(&[&small(&["why", "group_statistics/S2"])[..], &equal].concat());
    assert_eq!(said.code, 0, "{}", said.stderr);
    assert!(
        said.stdout.starts_with("group_statistics/S2  cached  "),
        "{}",
        said.stdout
    );
    assert!(said.stdout.contains("  group_statistics/S1  items "), "{}", said.stdout);
    assert!(said.stdout.contains("(an equal case, made first)"), "{}", said.stdout);
    let own = program.call(&small(&["why", "group_statistics/S1"]));
    assert!(!own.stdout.contains("equal case"), "{}", own.stdout);
}

#[test]
fn a_piece_is_planned_and_run_alone() {
    let program = Program::new("tiny");
    let planned = program.json(&small(&["run", "envelope/S1/0", "--dry-run"]));
    let nodes = planned["nodes"].as_array().expect("a list").iter();
    let pieces = nodes.map(|node| node["pieces"].as_u64().expect("a number"));
    assert_eq!(pieces.collect::<Vec<_>>(), [1, 1], "{planned}");
    let ran = program.ran(&small(&["envelope/S1/0"]));
    assert_eq!(ran.values().map(BTreeSet::len).collect::<Vec<_>>(), [1, 1], "{ran:?}");
    let shown = program.json(&small(&["show", "envelope/S1/0"]));
    assert_eq!(shown["piece"], 0);
}

#[test]
fn a_lock_that_would_move_the_readers_cursor_is_refused_by_line() {
    let program = Program::new("tiny");
    let good = fs::read_to_string(program.commit_lock()).expect("the lock is committed");
    assert!(Lock::parse(&good).is_ok());
    program.file(
        "checkout/artifacts/tiny.lock",
        good.replacen("wave_synthesis", "wave\u{1b}[2Jsynthesis", 1),
    );
    let said = program.call(&["verify", "--lock"]);
    assert_eq!(said.code, 5, "{}", said.stderr);
    assert!(said.stderr.contains("tiny.lock, line "), "{}", said.stderr);
    assert!(!said.stderr.contains('\u{1b}'), "{}", said.stderr);
    program.file("checkout/artifacts/tiny.lock", good.replacen("keys 1", "keys 2", 1));
    let said = program.call(&["verify", "--lock"]);
    assert!(
        said.stderr.contains("head: expected keys 1, found 2"),
        "{}",
        said.stderr
    );
}

/// Puts a pipe that nobody writes to where a file is.
fn pipe(path: &Path) {
    let _ = fs::remove_file(path);
    let made = Command::new("mkfifo").arg(path).status();
    assert!(made.expect("mkfifo runs").success());
}

/// What a verb says within a minute; one that waits for a pipe's other end says nothing.
#[track_caller]
fn told_in_time(program: &Program, arguments: &[&str]) -> (i32, String) {
    let mut child = program.start(arguments);
    for _ in 0..600 {
        if child.try_wait().expect("a process can be asked").is_some() {
            let output = child.wait_with_output().expect("the process can be waited for");
            let told = String::from_utf8_lossy(&output.stderr).into_owned();
            return (output.status.code().expect("nobody kills it"), told);
        }
        sleep(Duration::from_millis(100));
    }
    child.kill().expect("a process can be killed");
    panic!("{arguments:?} waits");
}

#[test]
fn a_pipe_where_a_file_should_be_is_not_waited_for() {
    let program = Program::new("tiny");
    let run = small(&["run", "truth"]);
    let folder = program.folder_of(&program.json(&run));
    // What only tells our figures from others or protects from garbage collection is written anew.
    for path in [
        program.checkout("artifacts/published"),
        program.path("store/runs/99999.json"),
    ] {
        pipe(&path);
        assert_eq!(told_in_time(&program, &run), (0, String::new()), "{}", path.display());
    }
    // A pipe named like one of our temporary files is not opened, and stays.
    let temporary = folder.join(".encounter-0123456789abcdef.tmp");
    pipe(&temporary);
    assert_eq!(told_in_time(&program, &run), (0, String::new()));
    assert!(temporary.exists());
    let figure = folder.join("truth.csv");
    pipe(&figure);
    let (code, told) = told_in_time(&program, &run);
    assert_eq!(code, 5, "{told}");
    assert!(told.contains("truth.csv: it is no regular file"), "{told}");
    fs::remove_file(&figure).expect("a pipe can be deleted");
    pipe(&program.checkout("artifacts/tiny.lock"));
    assert_eq!(told_in_time(&program, &["verify", "--lock"]).0, 5);
    pipe(&program.path("store/store.lock"));
    let (code, told) = told_in_time(&program, &run);
    assert_eq!(code, 0, "{told}");
    assert!(
        told.starts_with("store: something that is not the store's stood at store.lock; moved to "),
        "{told}"
    );
}

#[test]
fn an_overlay_may_come_from_a_pipe_but_not_without_end() {
    let program = Program::new("tiny");
    let (code, told) = told_in_time(&program, &["status", "--overlay", "/dev/zero"]);
    assert_eq!(code, 2, "{told}");
    assert!(told.contains("found: more than 16777216 bytes"), "{told}");
    let overlay = program.path("overlay");
    pipe(&overlay);
    std::thread::scope(|scope| {
        scope.spawn(|| fs::write(&overlay, "[sea.S1]\nbandwidth = 0.05\n"));
        let said = program.call(&["status", "--overlay", &overlay.display().to_string()]);
        assert_eq!(said.code, 0, "{}", said.stderr);
    });
}

#[test]
fn the_columns_of_the_plan_stand_below_each_other() {
    let said = Program::new("tiny").call(&["status"]);
    let state = |line: &str| line.find("  will run").map(|bytes| line[..bytes].chars().count());
    let places: BTreeSet<usize> = said.stdout.lines().filter_map(state).collect();
    let count = said.stdout.matches("  will run").count();
    assert_eq!((places.len(), count > 100), (1, true), "{}", said.stdout);
}

#[test]
fn json_is_json_whatever_stands_in_a_folders_name() {
    let folder = tempfile::tempdir().expect("a temporary folder can be made");
    let hostile = folder.path().join("a\u{7f}\u{9b}31m\u{202e}");
    fs::create_dir_all(hostile.join("store/objects")).expect("a folder can be made");
    fs::write(hostile.join("store/encounter-store"), "").expect("a file can be written");
    let program = Program::in_folder("tiny", &hostile);
    let said = program.call(&["verify", "--json"]);
    let value: serde_json::Value = serde_json::from_str(&said.stdout).expect("the answer is JSON");
    let named = value["store"].as_str().expect("the store is named");
    assert!(named.contains("a\u{7f}\u{9b}31m\u{202e}"), "{named}");
    assert!(said.stdout.contains("a\\u007f\\u009b31m\\u202e"), "{}", said.stdout);
    assert!(
        !said.stdout.contains(['\u{7f}', '\u{9b}', '\u{202e}']),
        "{}",
        said.stdout
    );
}

/// Calls a verb in a shell that sets a limit first.
#[cfg(unix)]
fn limited(program: &Program, limit: &str, arguments: &[&str]) -> (Option<i32>, String) {
    let run = program.command(arguments);
    let said = Command::new("sh")
        .args(["-c", &format!("ulimit {limit} && exec \"$@\""), "sh"])
        .arg(run.get_program())
        .args(run.get_args())
        .current_dir(run.get_current_dir().expect("a program runs in its checkout"))
        .output()
        .expect("a shell runs");
    (said.status.code(), String::from_utf8_lossy(&said.stderr).into_owned())
}

#[cfg(unix)]
#[test]
fn a_limit_on_the_length_of_files_is_an_error_and_no_death() {
    let (code, told) = limited(&Program::new("tiny"), "-f 4", &["run", "groups"]);
    assert_eq!(code, Some(5), "{told}");
    assert!(told.contains("File too large"), "{told}");
}

#[cfg(unix)]
#[test]
fn few_open_files_are_enough() {
    let (code, told) = limited(&Program::new("tiny"), "-n 64", &["run"]);
    assert_eq!(code, Some(0), "{told}");
}

#[cfg(unix)]
#[test]
fn the_store_of_a_rebuild_that_was_killed_goes_with_the_next_one() {
    let program = Program::new("tiny");
    program.commit_lock();
    let folder = tempfile::tempdir().expect("a temporary folder can be made");
    let stores = || fs::read_dir(folder.path()).expect("a folder").count();
    let rebuild = || {
        let mut command = program.command(&["verify", "--rebuild", "truth"]);
        command.env("TMPDIR", folder.path());
        command
    };
    let is_marked = || {
        let mut entries = fs::read_dir(folder.path()).expect("a folder").flatten();
        entries.any(|entry| entry.path().join("store.lock").is_file())
    };
    let mut child = rebuild().stderr(Stdio::null()).spawn().expect("the binary runs");
    for _ in 0..2000 {
        if is_marked() {
            break;
        }
        sleep(Duration::from_millis(1));
    }
    child.kill().expect("a process can be killed");
    child.wait().expect("a process ends");
    assert_eq!(stores(), 1, "the killed one left its store");
    // What is no store of ours stays, whatever its name.
    fs::create_dir(folder.path().join("encounter-rebuild-thesis")).expect("a folder can be made");
    let said = rebuild().output().expect("the binary runs");
    assert!(
        said.status.code().is_some(),
        "{}",
        String::from_utf8_lossy(&said.stderr)
    );
    assert_eq!(stores(), 1);
    assert!(folder.path().join("encounter-rebuild-thesis").is_dir());
}
