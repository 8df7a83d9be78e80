//! Damage: nothing unverified is served, everything is made again with equal bytes.

use crate::common::{Done, House};
use std::fs;
use std::path::{Path, PathBuf};

const NOTHING: [&str; 0] = [];

/// A house whose next run reads the squares, and the object of one piece of them.
fn house_with_a_reader() -> (House, Done, PathBuf) {
    let mut house = House::new();
    let done = house.run();
    done.expect_success();
    let object = house.object(&done.known["squares/a/1"].1);
    house.set("total.modulo=900001");
    (house, done, object)
}

/// Damages the object of squares/a/1 in every given way; each time a reader must find it healed.
fn heals(damages: impl IntoIterator<Item = Vec<u8>>) {
    let (mut house, _, object) = house_with_a_reader();
    let good = fs::read(&object).expect("the object is there");
    let mut counted = 0;
    for (i, damaged) in damages.into_iter().enumerate() {
        assert_ne!(damaged, good);
        fs::write(&object, &damaged).expect("the object can be damaged");
        // Another modulus each time, so that the total is made anew and reads its squares.
        house.set(&format!("total.modulo={}", 910_000 + i));
        let done = house.run();
        done.expect_success();
        assert_eq!(done.healed(), ["squares/a/1"], "damage {i}");
        assert!(!done.ran().contains(&"squares/a/1".to_owned()));
        assert_eq!(fs::read(&object).expect("the object is there"), good, "damage {i}");
        counted += 1;
    }
    assert!(counted > 0);
    assert_eq!(house.files_in("store/quarantine").len(), 1);
    house.edits.clear();
    let done = house.run();
    assert_eq!((done.ran().len(), done.healed().len()), (0, 0));
}

fn good_object() -> Vec<u8> {
    let (_house, _, object) = house_with_a_reader();
    fs::read(object).expect("the object is there")
}

#[test]
fn a_flipped_bit_anywhere_is_healed() {
    let good = good_object();
    assert_eq!(good.len(), 64 + 8 + 10 * 8);
    heals((0..good.len()).step_by(5).chain([63, 64, good.len() - 1]).map(|byte| {
        let mut bytes = good.clone();
        bytes[byte] ^= 1 << (byte % 8);
        bytes
    }));
}

#[test]
fn a_truncated_or_longer_object_is_healed() {
    let good = good_object();
    let lengths = [0, 1, 8, 31, 63, 64, 65, 72, 100, good.len() - 1];
    let mut damages: Vec<Vec<u8>> = lengths.into_iter().map(|length| good[..length].to_vec()).collect();
    damages.push([good.as_slice(), b"x"].concat());
    damages.push(vec![0; good.len()]);
    heals(damages);
}

#[test]
fn an_object_swapped_with_another_is_healed() {
    let (house, done, object) = house_with_a_reader();
    let others = ["squares/a/0", "squares/b/1", "total/a/0"].map(|piece| house.object(&done.known[piece].1));
    heals(others.map(|other| fs::read(other).expect("the object is there")));
    assert!(object.is_file());
}

#[test]
fn a_deleted_object_is_made_again_and_counted() {
    let (house, before, object) = house_with_a_reader();
    fs::remove_file(&object).expect("the object can be deleted");
    let done = house.run();
    done.expect_success();
    assert_eq!(done.healed(), ["squares/a/1"]);
    assert_eq!(done.known["squares/a/1"], before.known["squares/a/1"]);
    assert!(object.is_file());
}

#[test]
fn a_deleted_output_is_left_until_somebody_needs_it() {
    let mut house = House::new();
    let before = house.run();
    let of = |piece: &str| house.object(&before.known[piece].1);
    let (squares, total) = (of("squares/a/1"), of("total/a/0"));
    for object in [&squares, &total] {
        fs::remove_file(object).expect("the object can be deleted");
    }
    let idle = house.run();
    idle.expect_success();
    assert_eq!((idle.ran(), idle.healed()), (Vec::new(), Vec::new()));
    assert!(idle.known == before.known && !squares.exists() && !total.exists());
    // The draws read the total, which is made from the squares; all come out as they were.
    house.set("draws.count=3");
    let done = house.run();
    assert_eq!(done.healed(), ["squares/a/1", "total/a/0"]);
    let ran = done.ran();
    let others = ran
        .iter()
        .filter(|piece| !piece.starts_with("draws") && !piece.starts_with("report"));
    // The evicted numbers are made for their reader alone.
    assert_eq!(others.collect::<Vec<_>>(), ["squares/a/1", "total/a/0"]);
    assert!(squares.is_file() && total.is_file());
}

#[test]
fn a_deleted_store_of_objects_is_made_again_from_records() {
    let house = House::new();
    let before = house.run().locked();
    fs::remove_dir_all(house.path("store/objects")).expect("the objects can be deleted");
    let done = house.run();
    // What is published is read, and all that leads to it; aside, echo and witness lead nowhere.
    assert_eq!(done.healed().len(), 15);
    assert_eq!(done.healed(), done.ran());
    assert_eq!(done.locked(), before);
}

#[test]
fn a_damaged_published_object_never_reaches_the_figures() {
    let house = House::new();
    let done = house.run();
    let object = house.object(&done.known["report/small/0"].1);
    let mut bytes = fs::read(&object).expect("the object is there");
    let last = bytes.len() - 1;
    bytes[last] ^= 0x20;
    fs::write(&object, bytes).expect("the object can be damaged");
    let again = house.run();
    assert_eq!(
        (again.healed(), again.written()),
        (vec!["report/small/0".to_owned()], Vec::new())
    );
    assert_eq!(again.locked(), done.locked());
}

#[test]
fn a_damaged_record_is_a_miss() {
    let house = House::new();
    let before = house.run();
    let record = house.record(&before.known["squares/a/1"].0);
    let good = fs::read(&record).expect("the record is there");
    let other = fs::read(house.record(&before.known["squares/a/0"].0)).expect("the record is there");
    let mut damages = vec![
        Vec::new(),
        good[..good.len() / 2].to_vec(),
        good[..good.len() - 1].to_vec(),
        other,
    ];
    damages.push(b"\xff\xfe not UTF-8".to_vec());
    damages.push(b"{}\n".to_vec());
    damages.extend((0..good.len()).step_by(41).map(|byte| {
        let mut bytes = good.clone();
        bytes[byte] ^= 1;
        bytes
    }));
    for damaged in damages {
        fs::write(&record, &damaged).expect("the record can be damaged");
        let done = house.run();
        done.expect_success();
        assert_eq!(done.ran(), ["squares/a/1"], "{}", String::from_utf8_lossy(&damaged));
        assert_eq!(done.known, before.known);
    }
    fs::remove_file(&record).expect("the record can be deleted");
    assert_eq!(house.run().ran(), ["squares/a/1"]);
    assert_eq!(house.run().ran(), NOTHING);
}

/// Rewrites a record so that it names another id, check included.
fn forge(record: &Path, id: &str, other: &str) {
    let text = fs::read_to_string(record).expect("the record is there");
    let (body, _) = text.rsplit_once(",\"check\":\"").expect("a record ends in its check");
    let body = body.replace(id, other);
    let text = format!("{body},\"check\":\"{}\"}}\n", blake3::hash(body.as_bytes()).to_hex());
    fs::write(record, text).expect("the record can be written");
}

#[test]
fn an_evicted_output_is_made_again_when_needed() {
    let mut house = House::new();
    let before = house.run();
    assert!(!house.object(&before.known["numbers/0"].1).exists());
    house.set("base.a.offset=5");
    let done = house.run();
    let ran = done.ran();
    assert!(ran.contains(&"squares/a/0".to_owned()) && !ran.contains(&"numbers/0".to_owned()));
    let fresh = House::lived_in(&["base.a.offset=5"]);
    assert_eq!(done.locked(), fresh.run().locked());
}

#[test]
fn an_evicted_output_made_again_is_checked_against_its_record() {
    let house = House::new();
    let before = house.run();
    let (key, id) = before.known["numbers/0"];
    let other = before.known["numbers/1"].1;
    forge(&house.record(&key), &id.to_string(), &other.to_string());
    let error = house
        .run()
        .outcome
        .expect_err("the numbers differ from the forged record");
    assert_eq!(error.exit_code(), 4);
    let text = error.to_string();
    let (first, note) = text.split_once('\n').expect("a note below");
    assert_eq!(
        first,
        format!("numbers/0 is not reproducible: recorded {other}, made again {id}")
    );
    assert!(note.contains("made once more, it came out the same"), "{note}");
}

#[test]
fn a_store_that_is_no_folder_is_an_error_of_the_store() {
    let house = House::new();
    fs::write(house.path("store"), "a file").expect("a file can be written");
    let error = encounter::engine::store::Store::open(&house.path("store"))
        .err()
        .expect("a refusal");
    assert_eq!(error.exit_code(), 5);
}
