//! Records and parts rewritten with their check, as another binary or another time would have left them.

use serde_json::Value;
use std::fs;
use std::path::{Path, PathBuf};

/// The check of an object, and its text with the check as last field.
pub(crate) fn sealed(mut value: Value) -> (String, String) {
    value.as_object_mut().expect("an object").remove("check");
    let json = value.to_string();
    let body = &json[..json.len() - 1];
    let check = blake3::hash(body.as_bytes()).to_hex().to_string();
    (check.clone(), format!("{body},\"check\":\"{check}\"}}\n"))
}

/// A record or part.
pub(crate) fn read(path: &Path) -> Value {
    serde_json::from_str(&fs::read_to_string(path).expect("the file is there")).expect("JSON")
}

/// Every record of a store.
pub(crate) fn all(store: &Path) -> Vec<PathBuf> {
    let files = |folder: &Path| -> Vec<PathBuf> {
        let entries = fs::read_dir(folder).expect("a folder").flatten();
        entries.map(|entry| entry.path()).collect()
    };
    let mut all: Vec<PathBuf> = files(&store.join("records"))
        .iter()
        .flat_map(|folder| files(folder))
        .collect();
    all.sort();
    all
}

/// Edits a record where it lies.
pub(crate) fn edit(path: &Path, edit: impl FnOnce(&mut Value)) {
    let mut record = read(path);
    edit(&mut record);
    fs::write(path, sealed(record).1).expect("the record can be written");
}

/// Makes a record one of the past: edited, under another key, its old place empty.
pub(crate) fn age(path: &Path, edit: impl FnOnce(&mut Value)) {
    let mut record = read(path);
    fs::remove_file(path).expect("the record can be deleted");
    edit(&mut record);
    let key = blake3::hash(record["key"].as_str().expect("a key").as_bytes()).to_hex();
    record["key"] = key.to_string().into();
    let records = path.ancestors().nth(2).expect("a record lies in a folder of records");
    let folder = records.join(&key[..2]);
    fs::create_dir_all(&folder).expect("a folder can be made");
    fs::write(folder.join(format!("{}.json", &key[2..])), sealed(record).1).expect("the record can be written");
}

/// Writes an edited copy of a part; gives its name.
pub(crate) fn part(store: &Path, name: &Value, edit: impl FnOnce(&mut Value)) -> Value {
    let folder = store.join("parts");
    let mut part = read(&folder.join(format!("{}.json", name.as_str().expect("a name"))));
    edit(&mut part);
    let (name, text) = sealed(part);
    fs::write(folder.join(format!("{name}.json")), text).expect("the part can be written");
    name.into()
}
