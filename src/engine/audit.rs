//! Audit: every byte of the store against its name. What is damaged goes to `quarantine/`, so that the next run makes it
//! again; what is orphaned or missing is told.
//!
//! | found | means |
//! |---|---|
//! | damaged | an object, record, part or manifest whose bytes do not hash to what they should |
//! | unreadable | the operating system does not hand out its bytes: it may be sound, and stays where it is |
//! | orphaned | an object that no record names, or a file that is none of the store's: never served |
//! | missing | a record's object is not there: made again when it is needed |
//!
//! Tested in `tests/cache/verify.rs`.

use std::collections::{BTreeMap, BTreeSet};
use std::io::{self, ErrorKind};
use std::sync::atomic::{AtomicU64, Ordering};

use rayon::iter::{IntoParallelRefIterator, ParallelIterator};
use serde::Serialize;

use crate::engine::error::{Error, Result};
use crate::engine::id::{Id, Key};
use crate::engine::listing::{Listed, listed};
use crate::engine::manifest;
use crate::engine::names::{At, Folder, Place};
use crate::engine::object;
use crate::engine::record::{Record, opened};
use crate::engine::store::Store;
use crate::engine::threads::pool;

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
    /// Files whose bytes cannot be had, so that nothing is known of them.
    pub unreadable: Vec<Finding>,
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

/// What is wrong with a file of the store.
enum Fault {
    Damaged(String),
    Unreadable(String),
    /// It has gone since it was listed: a run that works meanwhile moved it.
    Gone,
}

impl From<io::Error> for Fault {
    fn from(why: io::Error) -> Self {
        match why.kind() {
            ErrorKind::NotFound => Self::Gone,
            ErrorKind::InvalidData => Self::Damaged(why.to_string()),
            _ => Self::Unreadable(format!("it cannot be read: {why}")),
        }
    }
}

impl From<&str> for Fault {
    fn from(why: &str) -> Self {
        Self::Damaged(why.to_owned())
    }
}

/// What records say of one id: a node that has it, and whether its bytes were left out on purpose.
struct Named {
    node: String,
    evicted: bool,
}

/// Rehashes every object, record, part and manifest of a store; moves the damaged ones to its `quarantine/`.
///
/// # Errors
/// A folder that cannot be read.
pub fn audit(store: &Store, workers: usize, heard: &Heard<'_>) -> Result<Audit> {
    let pool = pool(workers)?;
    let root = store.files().list(&At::root());
    root.map_err(Error::io("read the store", store.root()))?;
    // A record is written after its object: listed first, none of them waits for an object yet to come.
    let folders = [Folder::Records, Folder::Parts, Folder::Manifests, Folder::Objects];
    let mut lists = Vec::new();
    for folder in folders {
        lists.push(listed(store, folder)?);
    }
    // Sparse files may be as long as they say.
    let total = lists
        .iter()
        .flatten()
        .fold(0, |all: u64, file| all.saturating_add(file.bytes));
    let done = AtomicU64::new(0);
    let look = |bytes: u64| heard(done.fetch_add(bytes, Ordering::Relaxed).saturating_add(bytes), total);
    heard(0, total);
    let mut audit = Audit::default();
    let mut named = BTreeMap::new();
    let mut present = BTreeSet::new();
    for (folder, files) in folders.into_iter().zip(&lists) {
        let count = files.len() as u64;
        match folder {
            Folder::Records => audit.records = count,
            Folder::Parts => audit.parts = count,
            Folder::Manifests => audit.manifests = count,
            _ => audit.objects = count,
        }
        for (file, record) in pool.install(|| checked(store, files, &look)) {
            audit.note(store, file, record, &mut named, &mut present);
        }
    }
    audit.note_missing(store, &named, &present);
    for list in [
        &mut audit.damaged,
        &mut audit.unreadable,
        &mut audit.orphaned,
        &mut audit.missing,
    ] {
        list.sort();
    }
    Ok(audit)
}

/// A file, and what was found: its record if it is one.
type Checked<'f> = (&'f Listed, std::result::Result<Option<Record>, Fault>);

fn checked<'f>(store: &Store, files: &'f [Listed], look: &(dyn Fn(u64) + Sync)) -> Vec<Checked<'f>> {
    let check = |file: &'f Listed| {
        let found = file.place.as_ref().map_or(Ok(None), |place| check(store, place));
        look(file.bytes);
        (file, found)
    };
    files.par_iter().map(check).collect()
}

/// Compares the bytes of a file with its name.
fn check(store: &Store, place: &Place) -> std::result::Result<Option<Record>, Fault> {
    match place {
        Place::Record(key) => record(store, place, key).map(Some),
        Place::Object(id) => {
            let file = store.read_file(place)?;
            object::verify(id, None, &file).map_err(Fault::Damaged)?;
            Ok(None)
        }
        // A part is named by the BLAKE3 of its bytes before the check, which is its last field.
        Place::Part(hash) => {
            let text = store.read_text(place)?;
            let (check, _) = opened(&text).ok_or("its check does not hold")?;
            if check == hash.to_string() {
                Ok(None)
            } else {
                Err("the bytes do not hash to the name".into())
            }
        }
        Place::Manifest(content) => {
            manifest::read(store, content)?;
            Ok(None)
        }
        _ => Ok(None),
    }
}

fn record(store: &Store, place: &Place, key: &Key) -> std::result::Result<Record, Fault> {
    let record = Record::parse(&store.read_text(place)?).ok_or("its check does not hold")?;
    if record.key != key.to_string() {
        return Err("it is the record of another key".into());
    }
    if Id::parse(&record.id).is_none() {
        return Err("it names no id".into());
    }
    Ok(record)
}

impl Audit {
    fn note(
        &mut self,
        store: &Store,
        file: &Listed,
        found: std::result::Result<Option<Record>, Fault>,
        named: &mut BTreeMap<Id, Named>,
        present: &mut BTreeSet<Id>,
    ) {
        let Some(place) = &file.place else {
            self.orphaned.push(finding(&file.path, "", "no file of the store"));
            return;
        };
        let mut node = String::new();
        if let Place::Object(id) = place {
            // A damaged one is told as such, not as missing too.
            present.insert(*id);
            node = named.get(id).map(|named| named.node.clone()).unwrap_or_default();
            if found.is_ok() && !named.contains_key(id) {
                self.orphaned.push(finding(&file.path, "", "no record names it"));
            }
        }
        match found {
            Ok(record) => {
                self.bytes = self.bytes.saturating_add(file.bytes);
                let id = record.as_ref().and_then(|record| Id::parse(&record.id));
                if let (Some(record), Some(id)) = (record, id) {
                    let (node, evicted) = (told(&record), record.evicted);
                    let entry = named.entry(id).or_insert(Named { node, evicted });
                    entry.evicted &= evicted;
                }
            }
            Err(Fault::Damaged(why)) => self.put_away(store, place, &file.path, &node, why),
            Err(Fault::Unreadable(why)) => self.unreadable.push(finding(&file.path, &node, &why)),
            Err(Fault::Gone) => {}
        }
    }

    fn note_missing(&mut self, store: &Store, named: &BTreeMap<Id, Named>, present: &BTreeSet<Id>) {
        let gone = named
            .iter()
            .filter(|(id, named)| !named.evicted && !present.contains(id));
        for (id, named) in gone {
            // It may have been written since the objects were listed.
            if !store.has(id) {
                let path = Place::Object(*id).at();
                let why = "its record is there, its bytes are not";
                self.missing.push(finding(path.text(), &named.node, why));
            }
        }
    }

    /// Notes a damaged file and moves it out of the way.
    fn put_away(&mut self, store: &Store, place: &Place, path: &str, node: &str, mut why: String) {
        let moved = store.set_aside(place);
        // A run that reads may have been faster.
        if let Some(refused) = moved.err().filter(|refused| refused.kind() != ErrorKind::NotFound) {
            self.left += 1;
            why = format!("{why}; it cannot be moved to quarantine: {refused}");
        }
        self.damaged.push(finding(path, node, &why));
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

fn finding(path: &str, node: &str, why: &str) -> Finding {
    Finding {
        path: path.to_owned(),
        node: node.to_owned(),
        why: why.to_owned(),
    }
}
