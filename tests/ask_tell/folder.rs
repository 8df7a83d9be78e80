//! The folder of a sequence: moved, shared, linked, full, not ours; and the files in it.

use super::hostile::ends;
use super::{Stranger, begin, example};
use std::fs::{self, File};
use std::io::{BufRead, BufReader};
use std::os::unix::fs::{PermissionsExt, symlink};
use std::os::unix::process::CommandExt;
use std::path::Path;
use std::process::Command;

/// The files that the example reads or writes by a name of its own, and a call that meets each.
const OWN: [(&str, &[&str]); 6] = [
    ("state.toml", &["ask", "DIR"]),
    ("groups.csv", &["ask", "DIR"]),
    ("batch.csv", &["ask", "DIR"]),
    ("waves.csv", &["ask", "DIR"]),
    ("state.before.toml", &["tell", "DIR", "DIR/maxima.csv"]),
    ("estimate.csv", &["tell", "DIR", "DIR/maxima.csv"]),
];

/// A sequence with a batch to tell.
fn simulated() -> Stranger {
    let stranger = Stranger::new();
    stranger.said(&["ask", "DIR"]);
    stranger.simulate(stranger.batch());
    stranger
}

fn set_aside(path: &Path) {
    if path.exists() {
        fs::remove_file(path).expect("a file can be removed");
    }
}

#[test]
fn what_stands_in_place_of_a_file_is_named_and_neither_followed_nor_waited_for() {
    for (name, call) in OWN {
        for (kind, found) in [
            ("a link to a file", "a link"),
            ("a dangling link", "a link"),
            ("a folder", "a folder"),
            ("a pipe", "a pipe"),
        ] {
            let stranger = simulated();
            let path = stranger.path(name);
            let outside = tempfile::tempdir().expect("a folder can be made");
            let target = outside.path().join("target");
            if kind == "a link to a file" {
                fs::write(
                    &target,
                    if path.exists() {
                        stranger.text(name)
                    } else {
                        String::new()
                    },
                )
                .expect("a file");
            }
            set_aside(&path);
            match kind {
                "a folder" => fs::create_dir(&path).expect("a folder can be made"),
                "a pipe" => assert!(
                    Command::new("mkfifo")
                        .arg(&path)
                        .status()
                        .expect("mkfifo runs")
                        .success()
                ),
                _ => symlink(&target, &path).expect("a link can be made"),
            }
            let before = fs::read(&target).ok();
            let output = ends(&mut stranger.command(call));
            let why = String::from_utf8_lossy(&output.stderr).into_owned();
            assert_eq!(output.status.code(), Some(2), "{name}, {kind}: {why}");
            let says = format!("{name}: expected a regular file, found {found}");
            assert!(
                why.contains(&says) && why.contains("move it away"),
                "{name}, {kind}: {why}"
            );
            assert_eq!(
                fs::read(&target).ok(),
                before,
                "{name}, {kind}: nothing outside is touched"
            );
        }
    }
}

#[test]
fn a_hard_link_is_replaced_and_not_written_through() {
    for (name, call) in OWN {
        let stranger = simulated();
        let outside = tempfile::tempdir().expect("a folder can be made");
        let target = outside.path().join("target");
        let text = if stranger.path(name).exists() {
            stranger.text(name)
        } else {
            "mine".to_owned()
        };
        fs::write(&target, &text).expect("a file can be written");
        set_aside(&stranger.path(name));
        if fs::hard_link(&target, stranger.path(name)).is_err() {
            fs::copy(&target, stranger.path(name)).expect("a file can be copied");
        }
        stranger.said(call);
        stranger.said(&["tell", "DIR", "DIR/maxima.csv"]);
        assert_eq!(fs::read_to_string(&target).expect("it is there"), text, "{name}");
    }
}

#[test]
fn a_pipe_a_folder_or_nothing_where_the_user_names_a_file_ends_the_call() {
    let stranger = simulated();
    let pipe = stranger.path("pipe");
    assert!(
        Command::new("mkfifo")
            .arg(&pipe)
            .status()
            .expect("mkfifo runs")
            .success()
    );
    for (call, says) in [
        (
            &["tell", "DIR", "DIR/pipe"][..],
            "pipe: expected a regular file, found a pipe",
        ),
        (&["tell", "DIR", "DIR"], "expected a regular file, found a folder"),
        (&["ask", "DIR/pipe"], "pipe: expected the folder of a sequence"),
        (
            &["tell", "DIR/pipe", "DIR/maxima.csv"],
            "pipe: expected the folder of a sequence",
        ),
        (
            &["ask", "DIR/maxima.csv"],
            "maxima.csv: expected the folder of a sequence",
        ),
    ] {
        let output = ends(&mut stranger.command(call));
        let why = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(output.status.code() == Some(2) && why.contains(says), "{call:?}: {why}");
    }
    let mut call = begin("36");
    (call[1], call[3]) = ("DIR/other", "DIR/pipe");
    assert!(!ends(&mut stranger.command(&call)).status.success());
    (call[1], call[3]) = ("DIR/pipe", "DIR/groups.csv");
    assert!(!ends(&mut stranger.command(&call)).status.success());
    // A link that the user names himself is his own affair.
    symlink(stranger.path("maxima.csv"), stranger.path("link.csv")).expect("a link can be made");
    stranger.said(&["tell", "DIR", "DIR/link.csv"]);
}

#[test]
fn a_sequence_goes_on_wherever_its_folder_is_moved() {
    let (whole, moved) = (Stranger::new(), Stranger::without_sequence());
    whole.to_the_end();
    let mut call = begin("36");
    call[1] = "DIR/first/place";
    moved.said(&call);
    fs::remove_file(moved.path("groups.csv")).expect("the folder has its own groups");
    let state = moved.text("first/place/state.toml");
    let here = moved.folder.path().display().to_string();
    assert!(!state.contains(&here) && !state.contains('/'), "{state}");
    for i in 0..20 {
        let place = format!("DIR/place {i}");
        let path = |place: &str| moved.path(place.strip_prefix("DIR/").expect("a place in the folder"));
        let before = if i == 0 {
            "DIR/first/place".to_owned()
        } else {
            format!("DIR/place {}", i - 1)
        };
        fs::rename(path(&before), path(&place)).expect("a folder can be renamed");
        for name in ["state.toml", "groups.csv"] {
            // As some version controls do on the way to another machine.
            let file = path(&place).join(name);
            let text = fs::read_to_string(&file)
                .expect("the file is there")
                .replace("\r\n", "\n");
            fs::write(&file, text.replace('\n', "\r\n")).expect("a file can be written");
        }
        moved.said(&["ask", &place]);
        fs::copy(path(&place).join("batch.csv"), moved.path("batch.csv")).expect("the batch is there");
        moved.simulate(moved.batch());
        if moved.said(&["tell", &place, "DIR/maxima.csv"]).contains("done") {
            let estimate = fs::read_to_string(path(&place).join("estimate.csv")).expect("an estimate");
            assert_eq!(estimate, whole.text("estimate.csv"));
            return;
        }
    }
    panic!("36 samples are told in at most 20 batches");
}

#[test]
fn of_several_that_begin_a_sequence_at_once_one_does_and_the_others_are_refused() {
    let stranger = Stranger::without_sequence();
    let spawned = (0..6).map(|seed| {
        let mut call = begin("36");
        let seed = seed.to_string();
        call.extend(["--seed", &seed]);
        stranger.command(&call).spawn().expect("the example runs")
    });
    let children: Vec<_> = spawned.collect();
    let mut begun = Vec::new();
    for (seed, child) in children.into_iter().enumerate() {
        let output = child.wait_with_output().expect("a child ends");
        let why = String::from_utf8_lossy(&output.stderr).into_owned();
        if output.status.success() {
            begun.push(seed);
        } else {
            assert!(why.contains("state.toml: expected no sequence yet, found one"), "{why}");
        }
    }
    assert_eq!(begun.len(), 1, "{begun:?}");
    assert!(
        stranger
            .text("state.toml")
            .contains(&format!("\nseed = {}\n", begun[0]))
    );
    stranger.said(&["ask", "DIR"]);
}

#[test]
fn beginning_beside_a_tell_loses_nothing() {
    let stranger = simulated();
    let tell = stranger
        .command(&["tell", "DIR", "DIR/maxima.csv"])
        .spawn()
        .expect("the example runs");
    for _ in 0..4 {
        stranger.command(&begin("40")).output().expect("the example runs");
    }
    assert!(tell.wait_with_output().expect("a child ends").status.success());
    assert!(stranger.said(&["ask", "DIR"]).contains("30 of 36 told"));
    // A sequence whose state is lost is not begun over either, as long as the one before is there.
    fs::remove_file(stranger.path("state.toml")).expect("a state can be removed");
    let why = stranger.refused(&begin("36"));
    assert!(
        why.contains("state.before.toml: expected no sequence yet, found one"),
        "{why}"
    );
    let why = stranger.refused(&["ask", "DIR"]);
    assert!(
        why.contains("state.toml: expected a sequence, found none; copy state.before.toml"),
        "{why}"
    );
}

#[test]
fn every_call_waits_while_another_holds_the_folder_and_says_so() {
    let stranger = simulated();
    let (ask, tell, new) = (
        &["ask", "DIR"][..],
        &["tell", "DIR", "DIR/maxima.csv"][..],
        &begin("36")[..],
    );
    for call in [ask, tell, new] {
        let held = File::open(stranger.folder.path()).expect("a folder can be opened");
        held.lock().expect("the folder can be locked");
        let mut child = stranger.command(call).spawn().expect("the example runs");
        let mut said = String::new();
        let errors = child.stderr.take().expect("messages are piped");
        let mut errors = BufReader::new(errors);
        errors.read_line(&mut said).expect("a message");
        assert_eq!(said, "waiting for another call that holds the folder\n", "{call:?}");
        assert!(child.try_wait().expect("a child can be waited for").is_none());
        drop(held);
        let code = child.wait().expect("a child ends").code();
        assert_eq!(code, Some(if call == new { 2 } else { 0 }), "{call:?}");
    }
}

#[test]
fn only_temporary_files_of_the_example_are_removed() {
    let stranger = simulated();
    let kept = [
        ".ask_tell-mine.tmp",
        "notes.tmp",
        ".ask_tell-AbcdefGhijk1.csv",
        ".ask_tell-Abcdef/hijk1.tmp",
    ];
    fs::create_dir(stranger.path(".ask_tell-Abcdef")).expect("a folder can be made");
    for name in kept {
        stranger.file(name, "mine");
    }
    let (link, folder) = (
        stranger.path(".ask_tell-AbcdefGhijk2.tmp"),
        stranger.path(".ask_tell-AbcdefGhijk3.tmp"),
    );
    symlink(stranger.path("notes.tmp"), &link).expect("a link can be made");
    fs::create_dir(&folder).expect("a folder can be made");
    stranger.file(".ask_tell-AbcdefGhijk4.tmp", "left by a call that was killed");
    stranger.said(&["ask", "DIR"]);
    assert!(kept.iter().all(|name| stranger.text(name) == "mine"));
    assert!(link.is_symlink() && folder.is_dir());
    assert!(!stranger.path(".ask_tell-AbcdefGhijk4.tmp").exists());
}

#[test]
fn a_folder_with_other_groups_is_not_taken() {
    let stranger = Stranger::without_sequence();
    fs::create_dir(stranger.path("other")).expect("a folder can be made");
    stranger.file("other/groups.csv", "field,t_c,l,a\n0,50,20,5\n");
    let mut call = begin("36");
    call[1] = "DIR/other";
    let why = stranger.refused(&call);
    assert!(
        why.contains("other/groups.csv: expected the same groups or no such file"),
        "{why}"
    );
    assert_eq!(stranger.text("other/groups.csv"), "field,t_c,l,a\n0,50,20,5\n");
}

#[test]
fn files_follow_the_umask() {
    for (umask, mode) in [("022", 0o644), ("002", 0o664), ("077", 0o600)] {
        let stranger = Stranger::without_sequence();
        let here = stranger.folder.path().display().to_string();
        let under = |call: &[&str]| {
            let words = call.iter().map(|word| word.replace("DIR", &here));
            let mut shell = Command::new("sh");
            shell
                .args(["-c", &format!("umask {umask}; exec \"$@\""), "sh"])
                .arg(example())
                .args(words);
            assert!(shell.output().expect("sh runs").status.success(), "{call:?}");
        };
        let mut new = begin("36");
        new[1] = "DIR/own";
        under(&new);
        under(&["ask", "DIR/own"]);
        fs::copy(stranger.path("own/batch.csv"), stranger.path("batch.csv")).expect("the batch is there");
        stranger.simulate(stranger.batch());
        under(&["tell", "DIR/own", "DIR/maxima.csv"]);
        for (name, _) in OWN {
            let metadata = fs::metadata(stranger.path("own").join(name)).expect("the file is written");
            assert_eq!(metadata.permissions().mode() & 0o777, mode, "{name} under {umask}");
        }
    }
}

#[test]
fn an_error_of_rights_is_not_told_as_one_of_room() {
    let stranger = simulated();
    let here = stranger.folder.path();
    let set =
        |path: &Path, mode| fs::set_permissions(path, fs::Permissions::from_mode(mode)).expect("a mode can be set");
    // Rights do not bind root: as root, the call is made by nobody, with a copy of the program that he can reach.
    let program = here.join("program");
    fs::copy(example(), &program).expect("the example can be copied");
    set(&program, 0o755);
    let is_root = std::os::unix::fs::MetadataExt::uid(&fs::metadata(&program).expect("it is there")) == 0;
    let call = |words: &[&str]| {
        let mut command = Command::new(&program);
        command.args(words).arg(here);
        if is_root {
            command.uid(65534).gid(65534);
        }
        let output = command.output().expect("the example runs");
        assert_eq!(output.status.code(), Some(2));
        String::from_utf8_lossy(&output.stderr).into_owned()
    };
    set(here, 0o555);
    let why = call(&["ask"]);
    set(&stranger.path("state.toml"), 0o000);
    let unreadable = call(&["ask"]);
    set(here, 0o755);
    assert!(
        why.contains("waves.csv: expected to write it, found Permission denied"),
        "{why}"
    );
    assert!(
        unreadable.contains("state.toml: expected a regular file, found Permission denied"),
        "{unreadable}"
    );
    for why in [why, unreadable] {
        assert!(
            why.contains("the right to read and write") && !why.contains("room"),
            "{why}"
        );
    }
}

#[test]
fn a_file_that_does_not_fit_asks_for_room_and_leaves_the_old_one() {
    let stranger = simulated();
    let (state, waves) = (stranger.text("state.toml"), stranger.text("waves.csv"));
    let mut shell = Command::new("sh");
    // Blocks of 512 bytes; without the trap the system ends the process with a signal.
    shell
        .args(["-c", "trap '' 25; ulimit -f 8; exec \"$@\"", "sh"])
        .arg(example())
        .arg("ask")
        .arg(stranger.folder.path());
    let output = shell.output().expect("sh runs");
    let why = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.code() == Some(2), "{:?} {why}", output.status);
    assert!(
        why.contains("waves.csv: expected to write it, found File too large"),
        "{why}"
    );
    assert!(why.contains("make room and call again"), "{why}");
    assert_eq!(
        (stranger.text("state.toml"), stranger.text("waves.csv")),
        (state, waves)
    );
    assert!(!stranger.has_leftovers());
}
