//! Faults: any file operation of the store fails, the disk is full or read-only. One clear error, nothing half-written,
//! and with the fault gone the next run gives what an undisturbed one gives.

use super::bad_entries;
use super::child::slow_house;
use super::disk::{Deed, watched};
use crate::cli::verbs::SMALL;
use crate::common::program::Program;
use crate::common::{House, Wrap};
use encounter::engine::disk::Disk;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use tempfile::TempDir;

const NOTHING: [&str; 0] = [];
const ENOENT: i32 = 2;
const EIO: i32 = 5;
const ENOSPC: i32 = 28;
const EROFS: i32 = 30;

/// Counts the operations of a disk down; the one that finds nothing left fails, and a write that fails has written half.
pub(super) struct Fuse {
    left: AtomicUsize,
    error: i32,
    /// Only writes are counted.
    writes: bool,
}

impl Fuse {
    pub(super) fn new(operation: usize, error: i32, writes: bool) -> Arc<Self> {
        let left = AtomicUsize::new(operation);
        Arc::new(Self { left, error, writes })
    }

    fn hear(&self, disk: &dyn Disk, deed: Deed<'_>) -> io::Result<()> {
        let written = match deed {
            Deed::Write(at, bytes) => Some((at, bytes)),
            _ if self.writes => return Ok(()),
            _ => None,
        };
        if self.left.fetch_sub(1, Ordering::Relaxed) > 0 {
            return Ok(());
        }
        if let Some((at, bytes)) = written {
            disk.write_new(at, &bytes[..bytes.len() / 2])?;
        }
        Err(io::Error::from_raw_os_error(self.error))
    }

    pub(super) fn has_blown(&self) -> bool {
        // The count wraps around.
        self.left.load(Ordering::Relaxed) > usize::MAX / 2
    }

    pub(super) fn disk(self: &Arc<Self>) -> Wrap {
        let fuse = Arc::clone(self);
        watched(move |disk, deed| fuse.hear(disk, deed))
    }
}

fn small_house(folder: &TempDir) -> House {
    let mut house = slow_house(folder.path());
    house.set("phases.count=2");
    house.set("slow.milliseconds=0");
    house.workers = 1;
    house
}

fn folder() -> TempDir {
    tempfile::tempdir().expect("a temporary folder can be made")
}

/// Lets every operation of a run fail in turn, with the error that `of` names; how many there were.
fn every_operation_fails(of: impl Fn(usize) -> i32) -> usize {
    let undisturbed = small_house(&folder()).run().locked();
    for operation in 0.. {
        let folder = folder();
        let mut house = small_house(&folder);
        let fuse = Fuse::new(operation, of(operation), false);
        house.disk = fuse.disk();
        let done = house.run();
        if !fuse.has_blown() {
            done.expect_success();
            return operation;
        }
        match &done.outcome {
            // A read that fails is a miss, a lock that fails is none.
            Ok(()) => assert_eq!(done.lock.as_ref(), Some(&undisturbed), "operation {operation}"),
            Err(error) => {
                assert_eq!(error.exit_code(), 5, "operation {operation}: {error}");
                assert!(
                    error.to_string().starts_with("cannot "),
                    "operation {operation}: {error}"
                );
            }
        }
        assert_eq!(bad_entries(&house), NOTHING, "operation {operation}");
        assert_eq!(
            house.files_in("store/tmp"),
            Vec::<PathBuf>::new(),
            "operation {operation}"
        );
        let after = small_house(&folder).run();
        assert_eq!(after.healed(), NOTHING, "operation {operation}");
        assert_eq!(after.locked(), undisturbed, "operation {operation}");
    }
    unreachable!("a run has an end")
}

#[test]
fn whichever_operation_fails_nothing_bad_is_left() {
    let errors = [ENOSPC, EIO, EROFS, ENOENT];
    let operations = every_operation_fails(|operation| errors[operation % errors.len()]);
    assert!(operations > 50, "{operations}");
}

#[test]
#[ignore = "the same with each error at each operation: cargo test --release whichever_error -- --ignored"]
fn whichever_error_an_operation_gives_nothing_bad_is_left() {
    for error in [ENOSPC, EIO, EROFS, ENOENT] {
        every_operation_fails(|_| error);
    }
}

#[test]
fn after_an_error_of_the_disk_nothing_new_is_begun() {
    let folder = folder();
    let mut house = slow_house(folder.path());
    house.workers = 1;
    house.disk = Fuse::new(8, ENOSPC, true).disk();
    let done = house.run();
    let error = done.outcome.as_ref().expect_err("the disk fails");
    assert!(error.to_string().contains("bytes needed"), "{error}");
    assert!(done.ran().len() < 24, "{:?}", done.ran());
    let begun = done
        .events
        .iter()
        .filter(|event| matches!(event, encounter::engine::event::Event::WillRun { .. }));
    assert!(begun.count() <= done.ran().len() + 1);
}

/// A small file system of its own, unmounted at the end.
struct Mount(TempDir);

impl Mount {
    /// None where mounting is not allowed, which is said; in CI it must be.
    fn new(size: &str) -> Option<Self> {
        let folder = folder();
        let mounted = root(
            &["mount", "-t", "tmpfs", "-o", &format!("size={size}"), "tmpfs"],
            folder.path(),
        );
        if mounted {
            return Some(Self(folder));
        }
        assert!(
            std::env::var_os("CI").is_none(),
            "CI must be allowed to mount a small tmpfs"
        );
        println!("skipped: mounting a small tmpfs is not allowed here");
        None
    }

    fn remount(&self, options: &str) {
        assert!(root(&["mount", "-o", &format!("remount,{options}")], self.0.path()));
    }
}

impl Drop for Mount {
    fn drop(&mut self) {
        root(&["umount"], self.0.path());
    }
}

/// Calls a tool that only root may use.
fn root(arguments: &[&str], path: &Path) -> bool {
    [&[][..], &["sudo", "-n"]].iter().any(|before| {
        let words = [before, arguments].concat();
        let output = Command::new(words[0]).args(&words[1..]).arg(path).output();
        output.is_ok_and(|output| output.status.success())
    })
}

#[test]
fn a_full_disk_is_one_clear_error_and_with_room_the_run_goes_on() {
    let Some(mount) = Mount::new("3m") else { return };
    let house = || {
        let mut house = slow_house(mount.0.path());
        house.set("slow.words=60000");
        house
    };
    let done = house().run();
    let error = done.outcome.as_ref().expect_err("4 MB do not fit into 3");
    assert_eq!(error.exit_code(), 5);
    let message = error.to_string();
    assert!(message.contains("480072 bytes needed"), "{message}");
    assert_eq!(bad_entries(&house()), NOTHING);
    assert_eq!(house().files_in("store/tmp"), Vec::<PathBuf>::new());
    let kept = done.ran().len();
    assert!(kept > 3, "{:?}", done.ran());

    mount.remount("size=30m");
    let after = house().run();
    assert!(after.ran().len() < 25);
    let fresh = folder();
    let mut oracle = slow_house(fresh.path());
    oracle.set("slow.words=60000");
    assert_eq!(after.locked(), oracle.run().locked());
}

#[test]
fn the_binary_on_a_full_disk_says_what_it_needs_and_what_gc_could_free() {
    let Some(mount) = Mount::new("400k") else { return };
    let program = Program::in_folder("tiny", mount.0.path());
    let arguments = [&["run", "truth", "fig3_exceedance"], SMALL.as_slice()].concat();
    let said = program.call(&arguments);
    assert_eq!(said.code, 5, "{}", said.stderr);
    let errors: Vec<&str> = said.stderr.lines().filter(|line| line.starts_with("error: ")).collect();
    let [error] = errors.as_slice() else {
        panic!("{}", said.stderr)
    };
    assert!(error.contains("; `encounter gc --max 0` could free "), "{error}");
    mount.remount("size=50m");
    assert_eq!(program.call(&arguments).code, 0);
}

#[test]
fn a_full_disk_that_gc_frees_nothing_on_is_not_said_to_be_helped_by_it() {
    let Some(mount) = Mount::new("16k") else { return };
    let program = Program::new("tiny");
    let figures = mount.0.path().join("figures").display().to_string();
    let said = program.call(&[&["run", "fig3_exceedance", "--figures", &figures], SMALL.as_slice()].concat());
    assert_eq!(said.code, 5, "{}", said.stderr);
    assert!(said.stderr.ends_with(" bytes needed\n"), "{}", said.stderr);
}

#[test]
fn a_read_only_store_serves_what_it_has_and_no_more() {
    let Some(mount) = Mount::new("30m") else { return };
    let program = Program::in_folder("tiny", mount.0.path());
    let arguments = [&["groups"], SMALL.as_slice()].concat();
    let figures = tempfile::tempdir().expect("a temporary folder can be made");
    let elsewhere = figures.path().display().to_string();
    let run = [&["run", "--figures", &elsewhere], arguments.as_slice()].concat();
    assert_eq!(program.call(&run).code, 0);
    mount.remount("ro");
    let status = program.json(&[&["status"], arguments.as_slice()].concat());
    let nodes = status["nodes"].as_array().expect("a list");
    assert!(nodes.iter().all(|node| node["cached"] == node["pieces"]), "{status}");
    assert_eq!(program.call(&[&["show"], arguments.as_slice()].concat()).code, 0);
    // With everything cached a run has nothing to write into the store.
    let served = program.call(&run);
    assert_eq!(served.code, 0, "{}", served.stderr);
    let said = program.call(&[run.as_slice(), &["--set", "run.seed=5"]].concat());
    assert_eq!(said.code, 5, "{}", said.stderr);
    assert!(said.stderr.contains("Read-only file system"), "{}", said.stderr);
}

#[test]
fn figures_that_cannot_be_written_are_refused_before_the_work() {
    let program = Program::new("tiny");
    let file = program.file("figures", "a file, no folder");
    let said = program.call(&[&["run", "truth", "--figures", &file], SMALL.as_slice()].concat());
    assert_eq!(said.code, 5, "{}", said.stderr);
    assert!(
        said.stderr.starts_with("error: cannot write figures to "),
        "{}",
        said.stderr
    );
    assert_eq!(said.stderr.lines().count(), 1);
    let made = |folder: &str| fs::read_dir(program.path("store").join(folder)).map_or(0, Iterator::count);
    assert_eq!((made("objects"), made("records")), (0, 0), "nothing is run for nothing");
}
