//! A store from a stranger: whatever stands in the place of its files and folders, nothing outside of it is read, written,
//! moved or deleted, no run waits for ever, and a run heals what it can or names the one thing to remove.
//!
//! The tests that run with all others take a share of the damages; `cargo test --release reliability::strangers --
//! --include-ignored` takes all of them: more than 1,000 damages, 700 errors under `gc`, 200 forged objects.
#![cfg(unix)]

use super::bad_entries;
use super::child::slow_house;
use super::disk::{Deed, watched};
use super::faults::Fuse;
use crate::common::{House, records};
use encounter::engine::audit::audit;
use encounter::engine::error::Error;
use encounter::engine::id::Id;
use encounter::engine::lock::Lock;
use encounter::engine::names::{Folder, Place};
use encounter::engine::store::Store;
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::io;
use std::os::unix::fs::{FileTypeExt, symlink};
use std::os::unix::net::UnixListener;
use std::path::{Path, PathBuf};
use std::process::Command;
use tempfile::TempDir;

const NOTHING: [&str; 0] = [];
const SECRET: &str = "a stranger's file\n";

/// A house whose store holds what two runs made, of which only the last is of use.
struct Origin {
    folder: TempDir,
    lock: Lock,
}

fn house_in(folder: &Path, pieces: usize) -> House {
    let mut house = slow_house(folder);
    house.set(&format!("phases.count={pieces}"));
    house.set("slow.milliseconds=0");
    house.set("slow.words=6");
    house.workers = 1;
    house
}

impl Origin {
    fn new(pieces: usize) -> Self {
        let folder = tempfile::tempdir().expect("a temporary folder can be made");
        let house = house_in(folder.path(), pieces);
        let lock = house.run().locked();
        Self { folder, lock }
    }

    /// A copy of the store in a folder of its own, beside a folder with what must not be touched.
    fn copy(&self, pieces: usize) -> (TempDir, House) {
        let folder = tempfile::tempdir().expect("a temporary folder can be made");
        copy_all(self.folder.path(), folder.path());
        let outside = folder.path().join("outside");
        fs::create_dir(&outside).expect("a folder can be made");
        for name in ["letter.txt", "1.json", "0000000000000000-1.json"] {
            fs::write(outside.join(name), SECRET).expect("a file can be written");
        }
        let house = house_in(folder.path(), pieces);
        (folder, house)
    }
}

fn copy_all(from: &Path, to: &Path) {
    for entry in fs::read_dir(from).expect("a folder").flatten() {
        let target = to.join(entry.file_name());
        if entry.path().is_dir() {
            fs::create_dir_all(&target).expect("a folder can be made");
            copy_all(&entry.path(), &target);
        } else {
            fs::copy(entry.path(), target).expect("a file can be copied");
        }
    }
}

/// What lies beside the store is as it was.
fn outside_is_untouched(folder: &Path) {
    let outside = folder.join("outside");
    let mut names: Vec<String> = fs::read_dir(&outside)
        .expect("the folder is there")
        .flatten()
        .map(|entry| entry.file_name().to_string_lossy().into_owned())
        .collect();
    names.sort();
    assert_eq!(names, ["0000000000000000-1.json", "1.json", "letter.txt"]);
    for name in names {
        let text = fs::read_to_string(outside.join(name)).expect("the file is there");
        assert_eq!(text, SECRET);
    }
    assert!(!folder.join("nowhere").exists(), "a dangling link was followed");
}

/// What is done to a file or folder of the store.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Damage {
    Empty,
    Cut,
    FlipFirst,
    FlipMiddle,
    FlipLast,
    Longer,
    Zeros,
    Swapped,
    Removed,
    EmptyFolder,
    FullFolder,
    DanglingLink,
    LinkOutside,
    LinkWithin,
    EndlessLink,
    HardLink,
    Pipe,
    Socket,
}

const DAMAGES: [Damage; 18] = [
    Damage::Empty,
    Damage::Cut,
    Damage::FlipFirst,
    Damage::FlipMiddle,
    Damage::FlipLast,
    Damage::Longer,
    Damage::Zeros,
    Damage::Swapped,
    Damage::Removed,
    Damage::EmptyFolder,
    Damage::FullFolder,
    Damage::DanglingLink,
    Damage::LinkOutside,
    Damage::LinkWithin,
    Damage::EndlessLink,
    Damage::HardLink,
    Damage::Pipe,
    Damage::Socket,
];

/// Damages what lies at a path; `other` is a file of the same folder.
fn damage(folder: &Path, path: &Path, other: &Path, damage: Damage) {
    let is_folder = path.is_dir();
    let good = if is_folder {
        Vec::new()
    } else {
        fs::read(path).expect("the file is there")
    };
    let flipped = |at: usize| {
        let mut bytes = good.clone();
        if let Some(byte) = bytes.get_mut(at) {
            *byte ^= 4;
        }
        bytes
    };
    let write = |bytes: Vec<u8>| fs::write(path, bytes).expect("the file can be damaged");
    let outside = if is_folder {
        folder.join("outside")
    } else {
        folder.join("outside/letter.txt")
    };
    match damage {
        _ if is_folder => fs::remove_dir_all(path).expect("the folder can be removed"),
        Damage::Empty => return write(Vec::new()),
        Damage::Cut => return write(good[..good.len() / 2].to_vec()),
        Damage::FlipFirst => return write(flipped(0)),
        Damage::FlipMiddle => return write(flipped(good.len() / 2)),
        Damage::FlipLast => return write(flipped(good.len().saturating_sub(2))),
        Damage::Longer => return write([good.as_slice(), b"and more"].concat()),
        Damage::Zeros => return write(vec![0; good.len()]),
        Damage::Swapped => {
            fs::copy(other, path).expect("the file can be replaced");
            return;
        }
        _ => fs::remove_file(path).expect("the file can be removed"),
    }
    let made = match damage {
        Damage::EmptyFolder => fs::create_dir(path),
        Damage::FullFolder => fs::create_dir(path).and_then(|()| fs::write(path.join("mine"), SECRET)),
        Damage::DanglingLink => symlink(folder.join("nowhere"), path),
        Damage::LinkOutside => symlink(&outside, path),
        Damage::LinkWithin => symlink(other, path),
        Damage::EndlessLink => symlink("/dev/zero", path),
        Damage::HardLink => fs::hard_link(folder.join("outside/letter.txt"), path),
        Damage::Pipe => {
            let made = Command::new("mkfifo").arg(path).status().expect("mkfifo runs");
            assert!(made.success());
            Ok(())
        }
        // The path of a socket is short, so it is made where that is so.
        Damage::Socket => {
            let short = tempfile::tempdir().expect("a temporary folder can be made");
            let socket = short.path().join("s");
            drop(UnixListener::bind(&socket).expect("a socket can be made"));
            fs::rename(socket, path)
        }
        _ => Ok(()),
    };
    made.expect("the file can be replaced");
}

/// What may come of a run on a damaged store.
fn check_run(house: &House, lock: &Lock, what: &str, path: &Path, refusable: bool) -> bool {
    let done = house.run();
    match &done.outcome {
        Ok(()) => {
            assert_eq!(done.lock.as_ref(), Some(lock), "{what}");
            true
        }
        Err(error @ (Error::Usage(_) | Error::Io { .. })) if refusable => {
            let name = path.file_name().expect("a name").to_string_lossy();
            assert!(error.to_string().contains(&*name), "{what}: {error}");
            false
        }
        Err(error) => panic!("{what}: {error}"),
    }
}

/// The files and folders of a store, each with another file of its folder.
fn targets(store: &Path) -> Vec<(PathBuf, PathBuf)> {
    let mut all = Vec::new();
    let mut folders = vec![store.to_owned()];
    while let Some(folder) = folders.pop() {
        let mut entries: Vec<PathBuf> = fs::read_dir(&folder)
            .expect("a folder")
            .flatten()
            .map(|entry| entry.path())
            .collect();
        entries.sort();
        for (place, path) in entries.iter().enumerate() {
            let files: Vec<&PathBuf> = entries.iter().filter(|other| other.is_file()).collect();
            let other = files.get((place + 1) % files.len().max(1)).map_or(path, |other| *other);
            if path.is_dir() {
                folders.push(path.clone());
            }
            all.push((path.clone(), other.clone()));
        }
    }
    all.sort();
    all
}

/// Every damage to every file and folder of a store, in steps of `share`; how many there were.
fn every_damage(share: usize) -> usize {
    let pieces = 6;
    let origin = Origin::new(pieces);
    let other_lock = {
        let (folder, _) = origin.copy(pieces);
        let mut reader = house_in(folder.path(), pieces);
        reader.set("total.shift=1");
        reader.run().locked()
    };
    let root = origin.folder.path().join("store");
    let all: Vec<(PathBuf, PathBuf, Damage)> = targets(&root)
        .into_iter()
        .flat_map(|(path, other)| {
            let is_folder = path.is_dir();
            let fits = DAMAGES.iter().filter(move |damage| {
                !is_folder
                    || DAMAGES.iter().position(|known| known == *damage) >= Some(8) && **damage != Damage::HardLink
            });
            fits.map(move |damage| (path.clone(), other.clone(), *damage))
                .collect::<Vec<_>>()
        })
        .collect();
    let mut count = 0;
    for (path, other, kind) in all.iter().step_by(share) {
        count += 1;
        let (folder, house) = origin.copy(pieces);
        let inner = |path: &Path| {
            house
                .path("store")
                .join(path.strip_prefix(&root).expect("a file of the store"))
        };
        let (path, other) = (inner(path), inner(other));
        let what = format!(
            "{kind:?} of {}",
            path.strip_prefix(house.path("")).expect("it lies there").display()
        );
        damage(folder.path(), &path, &other, *kind);
        // A top folder that is a link, or a folder that lost the mark of a store, is refused by name.
        let is_top = path.parent() == Some(&house.path("store"));
        let name = path.file_name().expect("a name").to_string_lossy().into_owned();
        let is_link = path.is_symlink();
        let is_folder = is_link && Folder::ALL.iter().any(|folder| folder.name() == name);
        let is_marker = name == Place::Marker.at().text();
        let refusable = is_top && (is_folder || is_marker);
        if count % 3 == 0 {
            let before = house.files_in("store/objects");
            if let Err(error) = house.gc(u64::MAX, false) {
                let code = error.exit_code();
                assert!(code == 5 || (refusable && code == 2), "gc after {what}: {error}");
                assert_eq!(house.files_in("store/objects"), before, "gc after {what}");
            }
        }
        if check_run(&house, &origin.lock, &what, &path, refusable) {
            let again = house.run();
            assert_eq!(again.ran(), NOTHING, "{what}");
            assert_eq!(again.locked(), origin.lock, "{what}");
            // What reads every piece heals what no run has needed until now.
            let mut reader = house_in(folder.path(), pieces);
            reader.set("total.shift=1");
            if !check_run(&reader, &other_lock, &what, &path, refusable) {
                continue;
            }
            // What a stranger put into a folder of the store stays there.
            let bad: Vec<String> = bad_entries(&house)
                .into_iter()
                .filter(|bad| !bad.contains("/mine "))
                .collect();
            assert_eq!(bad, NOTHING, "{what}");
        }
        outside_is_untouched(folder.path());
    }
    count
}

#[test]
fn a_share_of_all_damages_is_healed_or_refused_by_name() {
    assert!(every_damage(19) > 40);
}

#[test]
#[ignore = "all damages: cargo test --release reliability::strangers -- --include-ignored"]
fn every_damage_is_healed_or_refused_by_name() {
    let count = every_damage(1);
    println!("{count} damages");
    assert!(count >= 1000, "{count}");
}

/// Lets every operation of a collection fail in turn with each error; how many errors there were.
fn every_error_under_gc(errors: &[i32], share: usize) -> usize {
    let pieces = 14;
    let origin = Origin::new(pieces);
    // What a run with another parameter made and no run of the last three used is garbage.
    let mut other = house_in(origin.folder.path(), pieces);
    let runs = origin.folder.path().join("store/runs");
    other.set("total.shift=5");
    other.run().expect_success();
    for run in fs::read_dir(&runs).expect("runs").flatten() {
        let text = fs::read_to_string(run.path()).expect("a run can be read");
        let total = origin
            .lock
            .lines
            .iter()
            .find(|line| line.name == "total")
            .expect("a line");
        if !text.contains(&total.content.to_string()) {
            fs::remove_file(run.path()).expect("a run can be removed");
        }
    }
    std::thread::sleep(std::time::Duration::from_millis(20));
    // The run of use is written anew, so that nothing counts as made since.
    for run in fs::read_dir(&runs).expect("runs").flatten() {
        let text = fs::read(run.path()).expect("a run can be read");
        fs::write(run.path(), text).expect("a run can be written");
    }
    let kept = {
        let (_folder, house) = origin.copy(pieces);
        let sweep = house.gc(u64::MAX, false).expect("garbage is collected");
        assert!(sweep.unreached > 0, "{sweep:?}");
        names_in(&house)
    };
    let mut count = 0;
    for error in errors {
        for operation in (0..).step_by(share) {
            let (_folder, mut house) = origin.copy(pieces);
            let fuse = Fuse::new(operation, *error, false);
            house.disk = fuse.disk();
            let outcome = house.gc(u64::MAX, false);
            if !fuse.has_blown() {
                outcome.expect("nothing failed");
                break;
            }
            count += 1;
            if let Err(failed) = &outcome {
                assert_eq!(failed.exit_code(), 5, "error {error} at {operation}: {failed}");
            }
            let left = names_in(&house);
            let lost: Vec<&String> = kept.difference(&left).collect();
            assert!(lost.is_empty(), "error {error} at {operation}: {lost:?}");
            house.disk = Box::new(|disk| disk);
            let after = house.run();
            assert_eq!(
                (after.ran(), after.healed()),
                (Vec::new(), Vec::new()),
                "error {error} at {operation}"
            );
            assert_eq!(after.locked(), origin.lock);
        }
    }
    count
}

/// The names of a house's objects and records.
fn names_in(house: &House) -> BTreeSet<String> {
    let files = ["store/objects", "store/records"].map(|folder| house.files_in(folder));
    let name = |path: &PathBuf| {
        let inner = path.strip_prefix(house.path("store")).expect("a file of the store");
        inner.display().to_string()
    };
    files.iter().flatten().map(name).collect()
}

const ENOENT: i32 = 2;
const EIO: i32 = 5;
const EACCES: i32 = 13;
const ENOSPC: i32 = 28;
const EROFS: i32 = 30;
const EMFILE: i32 = 24;

#[test]
fn an_error_under_gc_takes_nothing_that_is_of_use() {
    assert!(every_error_under_gc(&[EIO, EACCES], 5) > 20);
}

#[test]
#[ignore = "every error at every operation: cargo test --release reliability::strangers -- --include-ignored"]
fn every_error_under_gc_takes_nothing_that_is_of_use() {
    let count = every_error_under_gc(&[EIO, EACCES, ENOENT, ENOSPC, EROFS, EMFILE], 1);
    println!("{count} errors under gc");
    assert!(count >= 700, "{count}");
}

/// Forged payloads of an object: whether they can be an output of the stage is left open.
fn forgeries(good: &[u8], other: &[u8]) -> BTreeMap<&'static str, Vec<u8>> {
    let with = |from: usize, number: u64| {
        let mut bytes = good.to_vec();
        for (byte, new) in bytes.iter_mut().skip(from).zip(number.to_le_bytes()) {
            *byte = new;
        }
        bytes
    };
    BTreeMap::from([
        ("nothing", Vec::new()),
        ("half", good[..good.len() / 2].to_vec()),
        ("one byte less", good[..good.len() - 1].to_vec()),
        ("one byte more", [good, &[7]].concat()),
        ("eight bytes more", [good, &[0; 8]].concat()),
        ("the longest length", with(0, u64::MAX)),
        ("a length at the limit", with(0, 1 << 30)),
        ("a length of a terabyte", with(0, 1 << 40)),
        ("zeros", vec![0; good.len()]),
        ("ones", vec![255; good.len()]),
        ("another flipped byte", with(good.len() / 3, 0x0102_0408_1020_4080)),
        ("another piece", other.to_vec()),
    ])
}

/// Every forgery of every object that a record names, in steps of `share`; how many there were.
fn every_forgery(share: usize) -> usize {
    let pieces = 15;
    let origin = Origin::new(pieces);
    let whole = house_in(origin.folder.path(), pieces);
    let known = whole.run().known;
    let objects: Vec<_> = known.values().filter(|(_, id)| whole.object(id).is_file()).collect();
    let mut all = Vec::new();
    for (place, (key, id)) in objects.iter().enumerate() {
        let good = fs::read(whole.object(id)).expect("the object is there");
        let (_, other) = objects[(place + 1) % objects.len()];
        let other = fs::read(whole.object(other)).expect("the object is there");
        for (name, payload) in forgeries(&good[64..], &other[64..]) {
            all.push((*key, good[..64].to_vec(), name, payload));
        }
        // The whole object of another stage, and headers that no stage writes.
        let mut schema = good[..64].to_vec();
        schema[16] ^= 1;
        all.push((*key, schema, "another layout", good[64..].to_vec()));
        let mut codec = good[..64].to_vec();
        codec[8] = 9;
        all.push((*key, codec, "another codec", good[64..].to_vec()));
    }
    let mut count = 0;
    for (key, head, name, payload) in all.iter().step_by(share) {
        count += 1;
        let (_folder, house) = origin.copy(pieces);
        let (codec, schema) = (u16::from_le_bytes([head[8], head[9]]), &head[16..24]);
        let schema = schema.iter().rev().fold(0, |all, byte| (all << 8) | u64::from(*byte));
        let id = Id::of(codec, schema, payload);
        let mut file = head.clone();
        file[24..32].copy_from_slice(&(payload.len() as u64).to_le_bytes());
        file[32..64].copy_from_slice(&id.0);
        file.extend(payload);
        let path = house.object(&id);
        fs::create_dir_all(path.parent().expect("a folder")).expect("a folder can be made");
        fs::write(&path, file).expect("an object can be forged");
        let length = payload.len();
        records::edit(&house.record(key), |record| {
            record["id"] = id.to_string().into();
            record["bytes"] = length.into();
        });
        let done = house.run();
        let code = done.outcome.as_ref().err().map_or(0, Error::exit_code);
        let told = done.outcome.as_ref().err().map(ToString::to_string).unwrap_or_default();
        // A forgery that decodes is believed, or makes a stage that reads it fail: the committed lock tells.
        assert!([0, 1].contains(&code), "{name}: {told}");
        let is_lie = [
            "half",
            "one byte less",
            "one byte more",
            "another layout",
            "another codec",
        ]
        .contains(name);
        if is_lie {
            assert_eq!(done.lock.as_ref(), Some(&origin.lock), "{name}");
        }
        let again = house.run();
        assert_eq!(
            again.outcome.as_ref().err().map_or(0, Error::exit_code),
            code,
            "{name}, again"
        );
    }
    count
}

#[test]
fn a_forged_object_that_no_stage_can_have_made_is_made_again() {
    assert!(every_forgery(7) > 10);
}

#[test]
#[ignore = "all forgeries: cargo test --release reliability::strangers -- --include-ignored"]
fn every_forged_object_is_made_again_or_told_by_the_lock() {
    let count = every_forgery(1);
    println!("{count} forged objects");
    assert!(count >= 200, "{count}");
}

#[test]
fn a_folder_of_somebody_else_is_refused_before_anything_is_written() {
    for name in ["thesis.tex", "yarn.lock", ".git", "objects", "figures"] {
        let folder = tempfile::tempdir().expect("a temporary folder can be made");
        let store = folder.path().join("store");
        fs::create_dir(&store).expect("a folder can be made");
        fs::write(store.join(name), SECRET).expect("a file can be written");
        let house = house_in(folder.path(), 2);
        let error = house.run().outcome.expect_err("a stranger's folder");
        assert_eq!(error.exit_code(), 2, "{error}");
        assert!(error.to_string().contains(name), "{error}");
        assert_eq!(house.gc(0, false).expect_err("a stranger's folder").exit_code(), 2);
        assert_eq!(fs::read_dir(&store).expect("the folder").count(), 1, "{name}");
        assert_eq!(fs::read_to_string(store.join(name)).expect("the file"), SECRET);
    }
}

#[test]
fn an_empty_folder_and_a_checkout_with_its_locks_become_stores() {
    let folder = tempfile::tempdir().expect("a temporary folder can be made");
    let house = house_in(folder.path(), 2);
    let store = folder.path().join("store");
    fs::create_dir(&store).expect("a folder can be made");
    fs::write(store.join("toy.lock"), "encounter-lock 1  profile toy\n").expect("a file can be written");
    fs::create_dir(store.join("figures")).expect("a folder can be made");
    fs::write(store.join("store.lock"), "").expect("a file can be written");
    house.run().expect_success();
    assert!(store.join("encounter-store").is_file());
    let tag = fs::read_to_string(store.join("CACHEDIR.TAG")).expect("the tag is there");
    assert!(tag.starts_with("Signature: 8a477f597d28d172789f06886806bc55"));
}

#[test]
fn what_may_not_be_read_is_neither_damage_nor_garbage() {
    let origin = Origin::new(3);
    let (_folder, mut house) = origin.copy(3);
    let before = names_in(&house);
    house.disk = watched(|_, deed| match deed {
        Deed::Read(at) if at.text().starts_with("objects/") => Err(io::ErrorKind::PermissionDenied.into()),
        _ => Ok(()),
    });
    let found = audit(&house.store(), 1, &|_, _| ()).expect("the store can be listed");
    assert_eq!((found.damaged.len(), found.unreadable.len()), (0, 4), "{found:?}");
    house.disk = watched(|_, deed| match deed {
        Deed::Read(at) if at.text().starts_with("records/") => Err(io::ErrorKind::PermissionDenied.into()),
        _ => Ok(()),
    });
    let error = house.gc(0, false).expect_err("what the records name is not known");
    assert_eq!(error.exit_code(), 5, "{error}");
    assert_eq!(names_in(&house), before);
}

#[test]
fn what_stands_in_the_way_is_moved_to_quarantine_and_said() {
    let origin = Origin::new(2);
    let (_folder, house) = origin.copy(2);
    // The published output is read by every run.
    let total = origin.lock.lines.iter().find(|line| line.name == "total");
    let object = house.object(&total.expect("a line of the lock").content);
    fs::remove_file(&object).expect("an object can be removed");
    fs::create_dir(&object).expect("a folder can be made");
    fs::write(object.join("mine"), SECRET).expect("a file can be written");
    let lock = house.path("store/store.lock");
    fs::remove_file(&lock).expect("the lock can be removed");
    drop(UnixListener::bind(&lock).expect("a socket can be made"));
    let store = Store::open(&house.path("store")).expect("a store can be opened");
    let aside = store.put_aside();
    let [(path, kept)] = aside.as_slice() else {
        panic!("{aside:?}")
    };
    assert_eq!(path, "store.lock");
    assert!(fs::symlink_metadata(kept).expect("it is kept").file_type().is_socket());
    drop(store);
    assert_eq!(house.run().locked(), origin.lock);
    // It is somebody else's: no collection takes it.
    house.gc(0, false).expect("garbage is collected");
    let files = house.files_in("store/quarantine");
    assert!(
        files
            .iter()
            .any(|file| fs::read_to_string(file).is_ok_and(|text| text == SECRET)),
        "{files:?}"
    );
}
