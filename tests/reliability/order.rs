//! Order: what a power cut may leave. Nothing is written where it is read; an object and its folder are synchronised
//! before any record names it, and a record before it takes its place.

use super::child::slow_house;
use crate::common::House;
use encounter::engine::disk::{Disk, System};
use serde_json::Value;
use std::fs::{self, File, TryLockError};
use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};

/// A disk that remembers what was done, in order.
#[derive(Default)]
struct Remembering(Mutex<Vec<Deed>>);

#[derive(Clone, Debug, PartialEq)]
enum Deed {
    Wrote(PathBuf),
    Synchronised(PathBuf),
    Renamed(PathBuf, PathBuf),
}

impl Remembering {
    fn note(&self, deed: Deed) {
        self.0.lock().expect("no panic").push(deed);
    }
}

impl Disk for Remembering {
    fn read(&self, path: &Path) -> io::Result<Vec<u8>> {
        System.read(path)
    }
    fn write(&self, path: &Path, bytes: &[u8]) -> io::Result<()> {
        self.note(Deed::Wrote(path.to_owned()));
        System.write(path, bytes)
    }
    fn synchronise(&self, path: &Path) -> io::Result<()> {
        self.note(Deed::Synchronised(path.to_owned()));
        System.synchronise(path)
    }
    fn rename(&self, from: &Path, to: &Path) -> io::Result<()> {
        self.note(Deed::Renamed(from.to_owned(), to.to_owned()));
        System.rename(from, to)
    }
    fn make_folder(&self, path: &Path) -> io::Result<()> {
        System.make_folder(path)
    }
    fn remove(&self, path: &Path) -> io::Result<()> {
        System.remove(path)
    }
    fn open_lock(&self, path: &Path, existing: bool) -> io::Result<File> {
        System.open_lock(path, existing)
    }
    fn try_lock(&self, file: &File, exclusive: bool) -> Result<(), TryLockError> {
        System.try_lock(file, exclusive)
    }
}

/// What two workers did to the disk in a whole run; the house is for looking at it.
fn deeds(house: &mut House) -> Vec<Deed> {
    let disk = Arc::new(Remembering::default());
    house.disk = disk.clone();
    house.run().expect_success();
    let deeds = disk.0.lock().expect("no panic");
    deeds.clone()
}

/// The object that a record names, unless it was left out.
fn object_of(house: &House, record: &Path) -> Option<PathBuf> {
    let text = fs::read_to_string(record).expect("a record can be read");
    let value: Value = serde_json::from_str(&text).expect("a record is JSON");
    let id = value["id"].as_str().expect("an id");
    let object = house.path("store/objects").join(&id[..2]).join(&id[2..]);
    (value["evicted"] == false).then_some(object)
}

#[test]
fn only_a_rename_publishes_and_a_record_comes_last() {
    let folder = tempfile::tempdir().expect("a temporary folder can be made");
    let mut house = slow_house(folder.path());
    let deeds = deeds(&mut house);
    let temporary = house.path("store/tmp");
    let (mut records, mut objects) = (0, 0);
    for (now, deed) in deeds.iter().enumerate() {
        let before = |deed: &Deed| deeds[..now].iter().rposition(|done| done == deed);
        match deed {
            Deed::Wrote(path) => assert!(path.starts_with(&temporary), "{} is written in place", path.display()),
            Deed::Renamed(from, to) if to.starts_with(house.path("store/records")) => {
                let written = before(&Deed::Wrote(from.clone()));
                assert!(before(&Deed::Synchronised(from.clone())) > written, "{}", to.display());
                records += 1;
                let Some(object) = object_of(&house, to) else { continue };
                let is_object = |deed: &Deed| matches!(deed, Deed::Renamed(_, to) if *to == object);
                let published = deeds[..now].iter().rposition(is_object);
                assert!(published.is_some(), "{} before its object", to.display());
                let entry = object.parent().expect("a folder").to_owned();
                for path in [object.clone(), entry] {
                    let safe = before(&Deed::Synchronised(path.clone()));
                    assert!(safe > published, "{} before {} is safe", to.display(), path.display());
                }
                objects += 1;
            }
            _ => {}
        }
    }
    // Twelve evicted phases, twelve slow pieces, a figure; synchronised in groups.
    assert_eq!((records, objects), (25, 13));
}
