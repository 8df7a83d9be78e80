//! Reliability: kills, runs at once, full disks, rot, edits. What is asserted is always the same: nothing wrong is served,
//! and the next run gives what an undisturbed one gives.

mod child;
mod concurrency;
mod disk;
mod edits;
mod faults;
mod hostile;
mod kill;
mod model;
mod mutants;
mod order;
mod rot;
mod strangers;

use crate::common::House;
use serde_json::Value;
use std::fs;
use std::path::Path;

/// Everything in a store that is not what its name says, and every record without its object.
fn bad_entries(house: &House) -> Vec<String> {
    let mut bad = Vec::new();
    for object in house.files_in("store/objects") {
        let bytes = fs::read(&object).expect("an object can be read");
        if bytes.len() < 64 || object_id(&bytes) != hex_of(&object, "") {
            bad.push(format!("{} is torn", object.display()));
        }
    }
    for record in house.files_in("store/records") {
        let text = fs::read_to_string(&record).expect("a record can be read");
        let Some((body, check)) = text.rsplit_once(",\"check\":\"") else {
            bad.push(format!("{} is torn", record.display()));
            continue;
        };
        let whole = check == format!("{}\"}}\n", blake3::hash(body.as_bytes()).to_hex());
        let value: Value = serde_json::from_str(&text).unwrap_or_default();
        if !whole || value["key"] != hex_of(&record, ".json") {
            bad.push(format!("{} is damaged", record.display()));
        }
        let id = value["id"].as_str().unwrap_or("..");
        let object = house.path("store/objects").join(&id[..2]).join(&id[2..]);
        if value["evicted"] != true && !object.is_file() {
            bad.push(format!("{} has no object", record.display()));
        }
    }
    bad
}

/// BLAKE3 of codec, schema and payload.
fn object_id(bytes: &[u8]) -> String {
    let mut hasher = blake3::Hasher::new();
    hasher.update(&bytes[8..10]).update(&bytes[16..24]).update(&bytes[64..]);
    hasher.finalize().to_hex().to_string()
}

fn hex_of(path: &Path, suffix: &str) -> String {
    let name = |path: &Path| path.file_name().map(|name| name.to_string_lossy().into_owned());
    let folder = path.parent().and_then(name).unwrap_or_default();
    let name = name(path).unwrap_or_default();
    format!("{folder}{}", name.strip_suffix(suffix).unwrap_or(&name))
}
