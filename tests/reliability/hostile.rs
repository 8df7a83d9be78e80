//! Bytes that somebody made to do harm, under a right hash: absurd lengths, deep nesting, another type, another's blob. They
//! give an error or a miss; no panic, no abort, and no more memory than the longest artifact may take.

use super::bad_entries;
use super::child::{SLOW, slow_house};
use crate::common::{House, records};
use encounter::engine::codec::{LIMIT, decode, encode};
use encounter::engine::id::{Id, Key};
use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::process::Command;

/// An artifact with everything in it that has a length.
#[derive(Debug, PartialEq, Serialize, Deserialize)]
struct Everything {
    numbers: Vec<f64>,
    rows: Vec<Vec<u32>>,
    text: String,
    names: BTreeMap<String, Option<u64>>,
    kind: Kind,
    flag: bool,
}

#[derive(Debug, PartialEq, Serialize, Deserialize)]
enum Kind {
    Nothing,
    One(f64),
}

fn everything() -> Everything {
    Everything {
        numbers: vec![1.0, -0.0],
        rows: vec![vec![1], vec![]],
        text: "é".to_owned(),
        names: BTreeMap::from([("a".to_owned(), Some(1)), ("b".to_owned(), None)]),
        kind: Kind::One(0.5),
        flag: true,
    }
}

/// Numbers that a length, a tag or a flag might be taken for.
const ABSURD: [u64; 9] = [
    3,
    255,
    1 << 20,
    1 << 27,
    (1 << 30) - 64,
    1 << 31,
    1 << 40,
    1 << 63,
    u64::MAX,
];

/// Every eight bytes of an encoded value replaced by every absurd number: decoded or refused.
#[test]
fn absurd_lengths_anywhere_are_refused() {
    let good = encode(&everything()).expect("a value");
    assert_eq!(decode::<Everything>(&good).expect("its own bytes"), everything());
    let mut refused = 0;
    for at in 0..good.len() - 8 {
        for number in ABSURD {
            let mut bytes = good.clone();
            bytes[at..at + 8].copy_from_slice(&number.to_le_bytes());
            refused += usize::from(decode::<Everything>(&bytes).is_err());
        }
    }
    assert!(refused > good.len(), "{refused}");
    for length in 0..good.len() {
        assert!(decode::<Everything>(&good[..length]).is_err());
    }
}

/// The same with little memory: a process that may have the limit and a little more.
#[test]
fn absurd_lengths_take_no_more_memory_than_the_limit() {
    let kilobytes = LIMIT / 1024 + 400 * 1024;
    let output = Command::new("sh")
        .args([
            "-c",
            "ulimit -v \"$1\" && shift && exec \"$@\"",
            "sh",
            &kilobytes.to_string(),
        ])
        .arg(std::env::current_exe().expect("the test binary has a path"))
        .args([
            "reliability::hostile::absurd_lengths_anywhere_are_refused",
            "--exact",
            "--test-threads=1",
        ])
        .env("MALLOC_ARENA_MAX", "1")
        .output()
        .expect("a shell runs");
    let told = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{:?}: {told}", output.status);
    assert!(String::from_utf8_lossy(&output.stdout).contains("1 passed"), "{told}");
}

/// A small complete store with the key and id of a piece that the total reads.
fn kept(folder: &Path) -> (House, Key, Id) {
    let mut house = slow_house(folder);
    for edit in ["phases.count=3", "slow.milliseconds=0", "slow.words=6"] {
        house.set(edit);
    }
    let done = house.run();
    done.expect_success();
    let (key, id) = done.known["slow/1"];
    (house, key, id)
}

/// Puts a payload into the store under its right hash, and lets the record of a key name it.
fn forge(house: &House, key: &Key, schema: &[u8], payload: &[u8]) -> Id {
    let mut hasher = blake3::Hasher::new();
    hasher.update(&1_u16.to_le_bytes()).update(schema).update(payload);
    let id = Id(*hasher.finalize().as_bytes());
    let length = (payload.len() as u64).to_le_bytes();
    let file = [
        b"ENCOUNT1",
        &1_u16.to_le_bytes()[..],
        &[0; 6],
        schema,
        &length,
        &id.0,
        payload,
    ]
    .concat();
    let path = house.object(&id);
    fs::create_dir_all(path.parent().expect("a folder")).expect("a folder can be made");
    fs::write(path, file).expect("an object can be written");
    records::edit(&house.record(key), |record| record["id"] = id.to_string().into());
    id
}

/// The schema in the header of an object.
fn schema_of(house: &House, id: &Id) -> Vec<u8> {
    fs::read(house.object(id)).expect("the object is there")[16..24].to_vec()
}

#[test]
fn a_forged_object_that_its_stage_cannot_have_made_is_set_aside_and_made_again() {
    let folder = tempfile::tempdir().expect("a temporary folder can be made");
    let (mut house, key, id) = kept(folder.path());
    let schema = schema_of(&house, &id);
    // A list that says it has more numbers than there are bytes, in so many ways.
    for (i, length) in ABSURD.into_iter().enumerate() {
        forge(&house, &key, &schema, &[&length.to_le_bytes()[..], &[0; 16]].concat());
        house.set(&format!("total.shift={}", i + 1));
        let done = house.run();
        done.expect_success();
        assert_eq!(done.known["slow/1"], (key, id), "{length}");
    }
    // The blob of the figure in place of the numbers.
    let text = encode(&"a figure".to_owned()).expect("a text");
    forge(&house, &key, &[7; 8], &text);
    house.set("total.shift=100");
    let done = house.run();
    done.expect_success();
    assert_eq!(done.known["slow/1"], (key, id));
    assert_eq!(bad_entries(&house), [""; 0]);
}

#[test]
fn a_sound_object_of_the_right_type_from_another_piece_shows_at_the_rebuild() {
    let folder = tempfile::tempdir().expect("a temporary folder can be made");
    let (mut house, key, id) = kept(folder.path());
    let done = house.run();
    let lock = house.run().locked();
    let other = done.known["slow/2"].1;
    assert_ne!(id, other);
    records::edit(&house.record(&key), |record| record["id"] = other.to_string().into());
    house.set("total.shift=1");
    house.run().expect_success();
    house.edits.pop();
    // No hash can tell: the record was written by whoever may write into the store. The lock can.
    let found = house.against_store(&lock);
    assert!(
        found.iter().any(|line| line.starts_with("slow: the lock says ")),
        "{found:?}"
    );
}

/// JSON nested so deeply that a reader that recurses would leave its stack, and JSON of another shape, each with its check.
#[test]
fn records_parts_and_runs_of_another_shape_are_none() {
    let folder = tempfile::tempdir().expect("a temporary folder can be made");
    let (house, key, _) = kept(folder.path());
    let locked = house.run().locked();
    let deep = format!("{{\"format\":{}{}}}", "[".repeat(200_000), "]".repeat(200_000));
    let shapes = [deep.as_str(), "{}", "{\"format\":1,\"key\":[]}", "{\"format\":-1e999}"];
    let files = ["store/records", "store/parts", "store/runs"].map(|folder| house.files_in(folder));
    for path in files.concat() {
        let good = fs::read(&path).expect("the file is there");
        for shape in shapes {
            let body = &shape[..shape.len() - 1];
            let check = blake3::hash(body.as_bytes()).to_hex();
            fs::write(&path, format!("{body},\"check\":\"{check}\"}}\n")).expect("a file can be written");
            assert_eq!(house.plan(|plan, _| plan.nodes()).len(), SLOW.contents.len());
            house.gc(0, true).expect("a plan");
            assert_eq!(house.run().locked(), locked, "{}", path.display());
        }
        fs::write(&path, good).expect("the file can be put back");
    }
    let record = records::read(&house.record(&key));
    assert_eq!(record["node"], Value::from("slow"));
}

#[test]
fn a_record_that_names_no_id_is_made_again() {
    let folder = tempfile::tempdir().expect("a temporary folder can be made");
    let (house, key, id) = kept(folder.path());
    for strange in ["", "/etc/passwd", "../../locks", "\u{1b}[2J"] {
        records::edit(&house.record(&key), |record| record["id"] = strange.into());
        let slow = house.plan_of("slow");
        assert_eq!((slow.cached, slow.will_run), (2, 1), "{strange}");
        assert_eq!(slow.reason, "record damaged: it names no id");
        let error = house.run().outcome.expect_err("two contents of one key");
        assert!(error.to_string().contains("slow/1 is not reproducible"), "{error}");
    }
    fs::remove_file(house.record(&key)).expect("the record can be deleted");
    assert_eq!(house.run().known["slow/1"], (key, id));
}
