//! Audit: every byte of the store against its name. What is damaged goes to `quarantine/`, so that the next run makes it
//! again; what is orphaned or missing is told.
//!
//! | found | means |
//! |---|---|
//! | damaged | an object, record, part or manifest whose bytes do not hash to what they should |
//! | orphaned | an object that no record names, or a file that is none of the store's: garbage, never served |
//! | missing | a record's object is not there: made again when it is needed |
//!
//! Tested in `tests/cache/verify.rs`.

use std::collections::{BTreeMap, BTreeSet};
use std::fs::{self, File};
use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};

use rayon::iter::{IntoParallelRefIterator, ParallelIterator};
use serde::Serialize;

use crate::engine::disk::{Listed, files_in, read_regular, read_text};
use crate::engine::error::{Error, Result};
use crate::engine::id::Id;
use crate::engine::manifest;
use crate::engine::object;
use crate::engine::record::{Record, opened};
use crate::engine::store::path_in;
use crate::engine::threads::pool;

/// Bytes read at a time: a share of a second-level cache.
const BUFFER: usize = 256 << 10;

const STRAY: &str = "no file of the store";

/// What an audit found.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Audit {
    /// Objects looked at.
    pub objects: u64,
    /// Records looked at.
    pub records: u64,
    /// Parts (code tables and parameters that records name) looked at.
    pub parts: u64,
    /// Manifests (the pieces that a content consists of) looked at.
    pub manifests: u64,
    /// Bytes read.
    pub bytes: u64,
    /// Damaged files that could not be moved to `quarantine/`, such as those of a store that may only be read.
    #[serde(skip)]
    pub left: usize,
    /// Bytes that are not what their name says.
    pub damaged: Vec<Finding>,
    /// What no record names.
    pub orphaned: Vec<Finding>,
    /// What a record names but is not there.
    pub missing: Vec<Finding>,
}

/// One file of the store.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
pub struct Finding {
    /// Its path within the store.
    pub path: String,
    /// The node and the items of its piece, where a record tells.
    pub node: String,
    /// What is wrong with it.
    pub why: String,
}

/// What is heard while an audit goes on: bytes looked at, bytes in all.
pub type Heard<'a> = dyn Fn(u64, u64) + Sync + 'a;

/// One file looked at: bytes read, or what is wrong.
type Checked<T> = (T, std::result::Result<u64, String>);

/// Tells what is wrong with a file.
type Check<'a> = dyn Fn(&Path) -> std::result::Result<(), String> + Sync + 'a;

/// Rehashes every object, record, part and manifest of a store; moves the damaged ones to its `quarantine/`.
///
/// # Errors
/// A store that is not there, or a folder that cannot be read or written.
pub fn audit(root: &Path, workers: usize, heard: &Heard<'_>) -> Result<Audit> {
    fs::read_dir(root).map_err(Error::io("read the store", root))?;
    let pool = pool(workers)?;
    // A record is written after its object: listed first, none of them waits for an object yet to come.
    let records = files_in(&root.join("records"))?;
    let parts = files_in(&root.join("parts"))?;
    let manifests = files_in(&root.join("manifests"))?;
    let objects = files_in(&root.join("objects"))?;
    let total: u64 = [&records, &parts, &manifests, &objects]
        .into_iter()
        .flatten()
        // Sparse files may be as long as they say.
        .fold(0, |all, file| all.saturating_add(file.bytes));
    let done = AtomicU64::new(0);
    let look = |bytes: u64| heard(done.fetch_add(bytes, Ordering::Relaxed).saturating_add(bytes), total);
    heard(0, total);
    let mut audit = Audit {
        objects: objects.len() as u64,
        records: records.len() as u64,
        parts: parts.len() as u64,
        manifests: manifests.len() as u64,
        ..Audit::default()
    };
    let named = pool.install(|| audit.records(root, &records, &look));
    pool.install(|| audit.lists(root, &parts, &part, &look));
    pool.install(|| audit.lists(root, &manifests, &|path| list_of_pieces(root, path), &look));
    pool.install(|| audit.objects(root, &objects, &named, &look));
    for list in [&mut audit.damaged, &mut audit.orphaned, &mut audit.missing] {
        list.sort();
    }
    Ok(audit)
}

/// What records say of one id: a node that has it, and whether its bytes were left out on purpose.
struct Named {
    node: String,
    evicted: bool,
}

impl Audit {
    /// Records that are whole: id -> what they say of it.
    fn records(&mut self, root: &Path, files: &[Listed], look: &(dyn Fn(u64) + Sync)) -> BTreeMap<Id, Named> {
        let read: Vec<(&Listed, std::result::Result<Record, String>)> = files
            .par_iter()
            .map(|file| {
                let record = record(root, &file.path);
                look(file.bytes);
                (file, record)
            })
            .collect();
        let mut named = BTreeMap::new();
        for (file, record) in read {
            let record = match record {
                Ok(record) => record,
                Err(_) if name(root, "records", &file.path).is_none() => {
                    self.orphaned.push(finding(root, &file.path, "", STRAY));
                    continue;
                }
                Err(why) => {
                    self.put_away(root, &file.path, "", why);
                    continue;
                }
            };
            self.bytes = self.bytes.saturating_add(file.bytes);
            let Some(id) = Id::parse(&record.id) else { continue };
            let node = told(&record);
            let evicted = record.evicted;
            let entry = named.entry(id).or_insert(Named { node, evicted });
            entry.evicted &= evicted;
        }
        named
    }

    /// Parts or manifests: what records or contents consist of.
    fn lists(&mut self, root: &Path, files: &[Listed], check: &Check<'_>, look: &(dyn Fn(u64) + Sync)) {
        let checked: Vec<Checked<&PathBuf>> = files
            .par_iter()
            .map(|Listed { path, bytes, .. }| {
                let found = check(path).map(|()| *bytes);
                look(*bytes);
                (path, found)
            })
            .collect();
        for (path, found) in checked {
            match found {
                Ok(bytes) => self.bytes = self.bytes.saturating_add(bytes),
                Err(_) if name(root, kind(root, path), path).is_none() => {
                    self.orphaned.push(finding(root, path, "", STRAY));
                }
                Err(why) => self.put_away(root, path, "", why),
            }
        }
    }

    fn objects(&mut self, root: &Path, files: &[Listed], named: &BTreeMap<Id, Named>, look: &(dyn Fn(u64) + Sync)) {
        let checked: Vec<Checked<(&PathBuf, Option<Id>)>> = files
            .par_iter()
            .map_init(
                || vec![0; BUFFER],
                |buffer, Listed { path, bytes, .. }| {
                    let id = name(root, "objects", path).and_then(|hex| Id::parse(&hex));
                    let found = id.map_or(Ok(0), |id| object(&id, path, buffer));
                    look(*bytes);
                    ((path, id), found)
                },
            )
            .collect();
        let mut present = BTreeSet::new();
        for ((path, id), found) in checked {
            let Some(id) = id else {
                self.orphaned.push(finding(root, path, "", STRAY));
                continue;
            };
            // A damaged one is told as such, not as missing too.
            present.insert(id);
            let node = named.get(&id).map_or("", |named| named.node.as_str());
            match found {
                Ok(bytes) => self.bytes = self.bytes.saturating_add(bytes),
                Err(why) => {
                    self.put_away(root, path, node, why);
                    continue;
                }
            }
            if !named.contains_key(&id) {
                self.orphaned.push(finding(root, path, "", "no record names it"));
            }
        }
        let gone = named
            .iter()
            .filter(|(id, named)| !named.evicted && !present.contains(id));
        for (id, named) in gone {
            let hex = id.to_string();
            let path = path_in(root, "objects", &hex, "");
            // Written since the objects were listed, or not there.
            if !path.is_file() {
                self.missing.push(finding(
                    root,
                    &path,
                    &named.node,
                    "its record is there, its bytes are not",
                ));
            }
        }
    }

    /// Notes a damaged file and moves it out of the way.
    fn put_away(&mut self, root: &Path, path: &Path, node: &str, mut why: String) {
        let folder = root.join("quarantine");
        let kind = kind(root, path);
        let name = name(root, kind, path).unwrap_or_else(|| leaf(path));
        let suffix = if is_json(kind) { ".json" } else { "" };
        let moved = fs::create_dir_all(&folder).and_then(|()| fs::rename(path, folder.join(name + suffix)));
        // A run that reads may have been faster.
        if let Some(refused) = moved.err().filter(|refused| refused.kind() != ErrorKind::NotFound) {
            self.left += 1;
            why = format!("{why}; it cannot be moved to quarantine: {refused}");
        }
        self.damaged.push(finding(root, path, node, &why));
    }
}

/// `ground_truth/calibrated-S1, items 4080 to 4319`.
fn told(record: &Record) -> String {
    let node = &record.node;
    match (record.first, record.items) {
        (0, 1) => node.clone(),
        (first, 1) => format!("{node}, item {first}"),
        (first, items) => format!(
            "{node}, items {first} to {}",
            first.saturating_add(items.saturating_sub(1))
        ),
    }
}

fn finding(root: &Path, path: &Path, node: &str, why: &str) -> Finding {
    Finding {
        path: within(root, path),
        node: node.to_owned(),
        why: why.to_owned(),
    }
}

fn within(root: &Path, path: &Path) -> String {
    let parts = path.strip_prefix(root).unwrap_or(path).iter();
    let parts: Vec<_> = parts.map(|part| part.to_string_lossy()).collect();
    parts.join("/")
}

/// The folder of the store that a file lies in.
fn kind<'p>(root: &Path, path: &'p Path) -> &'p str {
    let inner = path.strip_prefix(root).ok().and_then(|inner| inner.iter().next());
    inner.and_then(|kind| kind.to_str()).unwrap_or_default()
}

fn is_json(kind: &str) -> bool {
    kind == "records" || kind == "parts"
}

fn leaf(path: &Path) -> String {
    path.file_name()
        .map(|name| name.to_string_lossy().into_owned())
        .unwrap_or_default()
}

/// The hexadecimal name that a path within a folder of the store stands for.
fn name(root: &Path, kind: &str, path: &Path) -> Option<String> {
    let inner = path.strip_prefix(root.join(kind)).ok()?;
    let parts: Option<Vec<&str>> = inner.iter().map(|part| part.to_str()).collect();
    let hex = parts?.concat();
    let hex = if is_json(kind) {
        hex.strip_suffix(".json")?
    } else {
        hex.as_str()
    };
    // Parse and print: one spelling a name.
    Id::parse(hex).map(|id| id.to_string()).filter(|one| one == hex)
}

fn object(id: &Id, path: &Path, buffer: &mut [u8]) -> std::result::Result<u64, String> {
    let unread = |why: std::io::Error| format!("it cannot be read: {why}");
    if !fs::metadata(path).map_err(unread)?.is_file() {
        return Err("it is no regular file".to_owned());
    }
    let file = File::open(path).map_err(unread)?;
    object::check(id, file, buffer)
}

fn record(root: &Path, path: &Path) -> std::result::Result<Record, String> {
    let text = read_regular(path).map_err(|why| format!("it cannot be read: {why}"))?;
    let text = String::from_utf8(text).map_err(|_| "it is no text".to_owned())?;
    let record = Record::parse(&text).ok_or("its check does not hold")?;
    if name(root, "records", path).as_deref() != Some(record.key.as_str()) {
        return Err("it is the record of another key".to_owned());
    }
    if Id::parse(&record.id).is_none() {
        return Err("it names no id".to_owned());
    }
    Ok(record)
}

/// A part is named by the BLAKE3 of its bytes before the check, which is its last field.
fn part(path: &Path) -> std::result::Result<(), String> {
    let text = read_text(path).map_err(|why| format!("it cannot be read: {why}"))?;
    let (check, _) = opened(&text).ok_or("its check does not hold")?;
    if leaf(path) != format!("{check}.json") {
        return Err("the bytes do not hash to the name".to_owned());
    }
    Ok(())
}

fn list_of_pieces(root: &Path, path: &Path) -> std::result::Result<(), String> {
    let content = name(root, "manifests", path)
        .and_then(|hex| Id::parse(&hex))
        .ok_or(STRAY)?;
    let bytes = read_regular(path).map_err(|why| format!("it cannot be read: {why}"))?;
    let ids = manifest::parse(&content, &bytes);
    ids.map(|_| ())
        .ok_or_else(|| "its ids do not hash to the name".to_owned())
}
