//! A system that gives no thread, or fewer than wanted. The limit counts for all users but root, so root runs as nobody.

#![cfg(target_os = "linux")]

use std::fs::{self, Permissions};
use std::os::unix::fs::{MetadataExt, PermissionsExt};
use std::process::{Command, Output};

use crate::common::program::Program;

/// Users who own no other process; each test has one, since the limit counts for the user.
const NOBODIES: [&str; 2] = ["65534", "65533"];

fn is_root() -> bool {
    fs::metadata("/proc/self").is_ok_and(|own| own.uid() == 0)
}

/// Calls a verb as a user who may have so many threads in all; none where the system has no tool for it.
fn limited(program: &Program, user: usize, threads: u32, arguments: &[&str]) -> Option<Output> {
    let run = program.command(arguments);
    let mut command = Command::new("prlimit");
    command.arg(format!("--nproc={threads}"));
    if is_root() {
        command.args(["setpriv", "--reuid", NOBODIES[user], "--clear-groups"]);
    }
    command.arg(run.get_program()).args(run.get_args());
    command.current_dir(run.get_current_dir().expect("a program runs in its checkout"));
    let said = command.output().ok()?;
    // 127: a tool is missing; 126: nobody may not run the binary.
    (!matches!(said.status.code(), Some(126 | 127))).then_some(said)
}

fn open_to_all(program: &Program) {
    for folder in [program.path(""), program.checkout(""), program.checkout("artifacts")] {
        fs::create_dir_all(&folder).expect("a folder can be made");
        fs::set_permissions(folder, Permissions::from_mode(0o777)).expect("rights can be given");
    }
}

#[test]
fn a_system_without_threads_is_exit_5_and_says_so() {
    let program = Program::new("tiny");
    open_to_all(&program);
    for arguments in [
        &["run", "fig2_flowchart"] as &[&str],
        &["run", "wave_synthesis/S1", "-j", "8"],
    ] {
        let Some(said) = limited(&program, 0, 1, arguments) else {
            return;
        };
        let text = String::from_utf8_lossy(&said.stderr).into_owned();
        assert_eq!(said.status.code(), Some(5), "{text}");
        assert!(text.contains("error: cannot start a thread: "), "{text}");
        assert!(text.contains("ulimit -u"), "{text}");
        assert!(!text.contains("panicked"), "{text}");
    }
    // What needs no thread is served.
    let Some(said) = limited(&program, 0, 1, &["status", "fig2_flowchart"]) else {
        return;
    };
    assert_eq!(said.status.code(), Some(0), "{}", String::from_utf8_lossy(&said.stderr));
}

#[test]
fn a_system_with_few_threads_runs_on_those() {
    if !is_root() {
        // The other threads of this user would count, and nobody knows how many they are.
        return;
    }
    let program = Program::new("tiny");
    open_to_all(&program);
    let Some(said) = limited(&program, 1, 5, &["run", "wave_synthesis/S1", "-j", "64"]) else {
        return;
    };
    assert_eq!(said.status.code(), Some(0), "{}", String::from_utf8_lossy(&said.stderr));
}
