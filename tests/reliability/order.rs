//! Order: what a power cut may leave. Nothing is written where it is read; an object and its folder are synchronised
//! before any record names it, and a record before it takes its place.

use super::child::slow_house;
use super::disk::{Deed, watched};
use crate::common::House;
use encounter::engine::names::At;
use serde_json::Value;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};

/// What was done to the disk, in order.
#[derive(Clone, Debug, PartialEq)]
enum Done {
    Wrote(PathBuf),
    Synchronised(PathBuf),
    Renamed(PathBuf, PathBuf),
}

/// What two workers did to the disk in a whole run; the house is for looking at it.
fn deeds(house: &mut House) -> Vec<Done> {
    let deeds = Arc::new(Mutex::new(Vec::new()));
    let noted = Arc::clone(&deeds);
    let store = house.path("store");
    let path = move |at: &At| store.join(at.text());
    house.disk = watched(move |_, deed| {
        let done = match deed {
            Deed::Write(at, _) => Done::Wrote(path(at)),
            Deed::Synchronise(at) => Done::Synchronised(path(at)),
            Deed::Rename(from, to) => Done::Renamed(path(from), path(to)),
            _ => return Ok(()),
        };
        noted.lock().expect("no panic").push(done);
        Ok(())
    });
    house.run().expect_success();
    let deeds = deeds.lock().expect("no panic");
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
        let before = |deed: &Done| deeds[..now].iter().rposition(|done| done == deed);
        match deed {
            Done::Wrote(path) => {
                // What says that a folder is a store is written once, into a folder that is empty.
                let is_mark = ["encounter-store", "CACHEDIR.TAG"]
                    .iter()
                    .any(|name| path.ends_with(name));
                assert!(
                    is_mark || path.starts_with(&temporary),
                    "{} is written in place",
                    path.display()
                );
            }
            Done::Renamed(from, to) if to.starts_with(house.path("store/records")) => {
                let written = before(&Done::Wrote(from.clone()));
                assert!(before(&Done::Synchronised(from.clone())) > written, "{}", to.display());
                records += 1;
                let Some(object) = object_of(&house, to) else { continue };
                let is_object = |deed: &Done| matches!(deed, Done::Renamed(_, to) if *to == object);
                let published = deeds[..now].iter().rposition(is_object);
                assert!(published.is_some(), "{} before its object", to.display());
                let entry = object.parent().expect("a folder").to_owned();
                for path in [object.clone(), entry] {
                    let safe = before(&Done::Synchronised(path.clone()));
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

#[test]
fn the_folders_above_new_objects_are_safe_before_any_record_is_written() {
    let folder = tempfile::tempdir().expect("a temporary folder can be made");
    let mut house = slow_house(folder.path());
    let deeds = deeds(&mut house);
    let records = house.path("store/records");
    let first = |is_it: &dyn Fn(&Done) -> bool| deeds.iter().position(is_it);
    let recorded = first(&|deed| matches!(deed, Done::Renamed(_, to) if to.starts_with(&records)));
    let synchronised = first(&|deed| *deed == Done::Synchronised(house.path("store/objects")));
    assert!(
        synchronised.is_some() && synchronised < recorded,
        "{synchronised:?}, {recorded:?}"
    );
}

#[test]
fn an_object_whose_synchronisation_failed_is_not_taken_for_written() {
    let folder = tempfile::tempdir().expect("a temporary folder can be made");
    let mut house = slow_house(folder.path());
    house.workers = 1;
    let failed = Arc::new(Mutex::new(None));
    let noted = Arc::clone(&failed);
    house.disk = watched(move |_, deed| match deed {
        Deed::Synchronise(at) if at.text().starts_with("objects/") && at.text().len() > 40 => {
            *noted.lock().expect("no panic") = Some(at.text().to_owned());
            Err(io::ErrorKind::Other.into())
        }
        _ => Ok(()),
    });
    let error = house.run().outcome.expect_err("a medium that fails");
    assert_eq!(error.exit_code(), 5, "{error}");
    let object = failed
        .lock()
        .expect("no panic")
        .clone()
        .expect("an object was synchronised");
    assert!(!house.path("store").join(&object).exists(), "{object}");
    house.disk = Box::new(|disk| disk);
    let fresh = tempfile::tempdir().expect("a temporary folder can be made");
    assert_eq!(house.run().locked(), slow_house(fresh.path()).run().locked());
}
