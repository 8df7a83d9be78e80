//! The index makes nothing-to-do quick, and can do nothing else, whatever is in it.

use std::fs;
use std::path::{Path, PathBuf};
use std::time::Duration;

use encounter::engine::event::Event;
use encounter::engine::idle::{self, Traces};
use encounter::engine::index::{Belief, Index};
use encounter::engine::run::Run;

use crate::common::House;
use crate::common::toy::SCALE;

const HEAD: usize = 24;
const ROW: usize = 128;
const RACY: Belief = Belief::All { rehashed: true };
const CALM: Belief = Belief::All { rehashed: false };

/// Something asked of a walk that knows nothing yet.
fn ask<T>(house: &House, question: impl FnOnce(&Run<'_>, &Index) -> T) -> T {
    let graph = house.graph(&[]).expect("the parameters are in order");
    let store = house.store();
    let silent = |_: &Event| {};
    let index = Index::read(&house.path("store"), "toy");
    question(&Run::new(&graph, &store, &silent), &index)
}

fn believe(house: &House) -> Belief {
    ask(house, |run, index| index.believe(run))
}

fn is_idle(house: &House) -> bool {
    let values = ["small".to_owned(), "large".to_owned()];
    let figures = house.path("figures");
    let traces = Traces {
        axis: SCALE,
        values: &values,
        figures: &figures,
        lock: None,
    };
    ask(house, |run, index| idle::is_idle(run, index, &traces))
}

/// Runs, then writes the index.
fn run_and_note(house: &House) {
    house.run().expect_success();
    ask(house, |run, index| {
        encounter::engine::schedule::execute(run, 1).expect("nothing is left to do");
        index.renew(run).expect("the index can be written");
    });
}

/// A house whose index is old enough to be believed.
fn settled() -> House {
    let house = House::new();
    run_and_note(&house);
    std::thread::sleep(Duration::from_millis(2_100));
    run_and_note(&house);
    house
}

fn edit(index: &Path, how: impl FnOnce(&mut Vec<u8>)) {
    let mut bytes = fs::read(index).expect("there is an index");
    bytes.truncate(bytes.len() - 32);
    how(&mut bytes);
    let check = *blake3::hash(&bytes).as_bytes();
    bytes.extend(check);
    fs::write(index, bytes).expect("the index can be written");
}

#[test]
fn without_an_index_nothing_is_believed_and_one_run_makes_it() {
    let house = House::lived_in(&[]);
    assert_eq!(believe(&house), Belief::Not);
    run_and_note(&house);
    assert!(matches!(believe(&house), Belief::All { .. }));
    assert!(is_idle(&house));
    fs::remove_file(house.path("store/index.toy")).expect("there is an index");
    assert!(!is_idle(&house));
    assert!(house.run().ran().is_empty());
}

#[test]
fn objects_as_young_as_the_index_are_hashed_again() {
    let house = House::new();
    run_and_note(&house);
    assert_eq!(believe(&house), RACY);
    std::thread::sleep(Duration::from_millis(2_100));
    // Nothing touched the objects meanwhile, but the index is as old as they are.
    assert_eq!(believe(&house), RACY);
    run_and_note(&house);
    assert_eq!(believe(&house), CALM);
}

#[test]
fn an_edited_parameter_and_an_edited_figure_are_no_idleness() {
    let mut house = settled();
    assert!(is_idle(&house));
    fs::write(house.path("figures/report.csv"), "mine").expect("a figure can be edited");
    assert!(!is_idle(&house));
    house.run().expect_success();
    assert!(is_idle(&house));
    house.set("witness.shift=1");
    assert!(!is_idle(&house));
}

#[test]
fn a_flipped_bit_under_restored_times_is_seen() {
    let house = settled();
    let done = house.run();
    let object = house.object(&done.known["squares/a/1"].1);
    let good = fs::read(&object).expect("the object is there");
    let times = fs::metadata(&object)
        .and_then(|found| found.modified())
        .expect("files have times");
    let mut bytes = good.clone();
    bytes[80] ^= 1;
    fs::write(&object, bytes).expect("the object can be damaged");
    let file = fs::File::options()
        .append(true)
        .open(&object)
        .expect("the object can be opened");
    file.set_modified(times).expect("times can be set back");
    assert_eq!(believe(&house), Belief::Not);
    // A look moves nothing; the run that follows heals what nobody reads, too.
    assert!(object.is_file());
    run_and_note(&house);
    assert_eq!(fs::read(&object).expect("the object is there"), good);
}

#[test]
fn a_damaged_index_is_none() {
    let house = settled();
    let path = house.path("store/index.toy");
    let good = fs::read(&path).expect("there is an index");
    let shorter = (0..good.len()).step_by(37).map(|length| good[..length].to_vec());
    let flipped = (0..good.len()).step_by(41).map(|byte| {
        let mut bytes = good.clone();
        bytes[byte] ^= 1 << (byte % 8);
        bytes
    });
    for damaged in shorter.chain(flipped) {
        fs::write(&path, damaged).expect("the index can be damaged");
        assert_eq!(believe(&house), Belief::Not);
        assert!(!is_idle(&house));
    }
    fs::write(&path, good).expect("the index can be put back");
    assert_eq!(believe(&house), CALM);
}

#[test]
fn a_hostile_index_serves_nothing_and_changes_nothing() {
    let house = settled();
    let locked = house.run().locked();
    let path = house.path("store/index.toy");
    let good = fs::read(&path).expect("there is an index");
    let rows = (good.len() - HEAD - 32) / ROW;
    assert!(rows > 10);
    for row in 0..rows {
        // The output of one key under another: right hashes, right stat, wrong claim.
        edit(&path, |bytes| {
            let other = (row + 1) % rows;
            let stolen = bytes[HEAD + other * ROW + 32..HEAD + (other + 1) * ROW].to_vec();
            bytes[HEAD + row * ROW + 32..HEAD + (row + 1) * ROW].copy_from_slice(&stolen);
        });
        let figures = house.files_in("figures");
        let before: Vec<_> = figures
            .iter()
            .map(fs::read)
            .map(|read| read.expect("a figure"))
            .collect();
        is_idle(&house);
        let after: Vec<_> = figures
            .iter()
            .map(fs::read)
            .map(|read| read.expect("a figure"))
            .collect();
        assert_eq!(before, after);
        let done = house.run();
        assert_eq!((done.ran().len(), done.healed().len()), (0, 0), "row {row}");
        assert_eq!(done.locked(), locked);
        fs::write(&path, &good).expect("the index can be put back");
    }
}

#[test]
fn an_index_without_order_or_with_absurd_numbers_is_harmless() {
    let house = settled();
    let path = house.path("store/index.toy");
    edit(&path, |bytes| bytes[HEAD..].reverse());
    assert_eq!(believe(&house), Belief::Not);
    edit(&path, |bytes| bytes[8..].fill(0xff));
    assert_eq!(believe(&house), Belief::Not);
    run_and_note(&house);
    assert!(is_idle(&house));
}

#[test]
fn what_was_racy_is_not_believed_by_a_later_index_of_another_graph() {
    let mut house = House::new();
    run_and_note(&house);
    assert_eq!(believe(&house), RACY);
    std::thread::sleep(Duration::from_millis(2_100));
    // Another graph's run carries the rows of the first along, and none of them was verified since.
    house.set("run.seed=8");
    run_and_note(&house);
    house.edits.clear();
    assert_eq!(believe(&house), Belief::Not);
    run_and_note(&house);
    assert_eq!(believe(&house), CALM);
}

#[test]
fn an_output_that_was_not_there_is_believed_while_its_record_is_and_it_is_not() {
    let house = settled();
    let done = house.run();
    let (key, id) = done.known["total/a/0"];
    let object = house.object(&id);
    let good = fs::read(&object).expect("the object is there");
    fs::remove_file(&object).expect("the object can be deleted");
    assert_eq!(believe(&house), Belief::Not);
    run_and_note(&house);
    assert_eq!(believe(&house), CALM);
    fs::write(&object, &good[..70]).expect("an object can be written");
    assert_eq!(believe(&house), Belief::Not);
    fs::write(&object, &good).expect("an object can be written");
    assert_eq!(believe(&house), RACY);
    fs::remove_file(&object).expect("the object can be deleted");
    fs::remove_file(house.record(&key)).expect("the record can be deleted");
    assert_eq!(believe(&house), Belief::Not);
}

#[test]
fn a_record_that_is_lost_or_damaged_behind_a_good_index_is_made_again() {
    let house = settled();
    let records: Vec<PathBuf> = house.files_in("store/records");
    assert!(records.len() > 5);
    for (i, record) in records.iter().enumerate() {
        let whole = fs::read(record).expect("a record");
        if i % 2 == 0 {
            fs::remove_file(record).expect("a record can be deleted");
        } else {
            let mut bytes = whole.clone();
            bytes[i % whole.len()] ^= 1;
            fs::write(record, bytes).expect("a record can be written");
        }
        assert!(!is_idle(&house), "{}", record.display());
        run_and_note(&house);
        assert!(record.is_file(), "{}", record.display());
    }
    std::thread::sleep(Duration::from_millis(2_100));
    run_and_note(&house);
    assert!(is_idle(&house));
}
