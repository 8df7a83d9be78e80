//! Gc: what can be made again gives way when room is short. The disk is scanned; no index is believed.
//!
//! Roots: the committed locks of the checkout, the last runs of every checkout that uses the store, and what was made since
//! the last run ended (a killed run's work). What no root reaches goes first. Then, while the store is larger than the bound,
//! outputs that can be made again go, those first that take the least time for their bytes. Their records stay, so nothing
//! below them runs again.
//!
//! If the operating system cannot read a file that decides what is kept, the collection stops before anything is removed. A
//! file with damaged content does not stop it: a damaged record counts as absent, and a damaged list of pieces keeps every
//! object of its node. What stood in the place of a file of the store and was moved to quarantine is somebody else's: it stays.
//! Only files whose names a store gives are ever removed ([`Place`]). Tested in `tests/cache/gc.rs`, `tests/reliability`.

use std::collections::{BTreeMap, BTreeSet};
use std::fs::File;
use std::io::{self, ErrorKind};
use std::sync::Arc;
use std::time::SystemTime;

use crate::engine::claim;
use crate::engine::disk::Disk;
use crate::engine::error::{Error, Result};
use crate::engine::id::{Id, Key};
use crate::engine::listing::listed;
use crate::engine::lock::Lock;
use crate::engine::manifest;
use crate::engine::names::{Folder, Place};
use crate::engine::pipeline::Pipeline;
use crate::engine::record::Record;
use crate::engine::runs;
use crate::engine::stage::Keep;
use crate::engine::store::{Store, wait_for};

/// The bound of a store nobody gave another, bytes.
pub const BOUND: u64 = 8 << 30;

/// What can go, and what that costs.
#[derive(Debug, Default)]
pub struct Sweep {
    /// The store's size before, bytes.
    pub bytes: u64,
    /// Files that no committed lock and no remembered run needs.
    garbage: Vec<Place>,
    /// Objects among them.
    pub unreached: usize,
    /// Objects that are still of use and go because the store is over its bound, each with the records that name it.
    evicted: Vec<(Id, Vec<Record>)>,
    /// What lies in the store's folders and is none of its files: it stays.
    pub foreign: Vec<String>,
    /// Bytes freed.
    pub freed: u64,
    /// What it took to make what goes, seconds.
    pub seconds: f64,
}

/// The store, which nobody else is reading or writing.
pub struct Alone {
    store: Store,
    _lock: File,
}

impl Alone {
    /// Waits until no run lives; `waiting` is called once if one does. None where there is no store yet.
    ///
    /// # Errors
    /// A folder that is somebody else's, or that cannot be locked.
    pub fn wait(disk: Arc<dyn Disk>, waiting: &dyn Fn()) -> Result<Option<Self>> {
        claim::check(disk.root())?;
        if !claim::is_marked(disk.root()) {
            return Ok(None);
        }
        let lock = open_lock(disk.as_ref())?;
        if wait_for(disk.as_ref(), &lock, true, waiting) {
            return Ok(Some(Self::with(disk, lock)));
        }
        let no_locks = io::Error::new(ErrorKind::Unsupported, "this file system has no locks");
        Err(Error::io("keep runs out of the store", disk.root())(no_locks))
    }

    /// The same, or none if somebody is at work.
    pub fn now(disk: Arc<dyn Disk>) -> Option<Self> {
        let lock = open_lock(disk.as_ref())
            .ok()
            .filter(|_| claim::is_marked(disk.root()))?;
        disk.try_lock(&lock, true).ok()?;
        Some(Self::with(disk, lock))
    }

    fn with(disk: Arc<dyn Disk>, lock: File) -> Self {
        let store = Store::unlocked(disk);
        Self { store, _lock: lock }
    }

    /// The store, which must not take the lock on the whole: it is held already.
    pub fn store(&self) -> &Store {
        &self.store
    }

    /// Takes away what a plan found.
    ///
    /// # Errors
    /// A file that cannot be written or removed.
    pub fn carry_out(&self, sweep: &Sweep) -> Result<()> {
        for (id, records) in &sweep.evicted {
            for record in records.iter().filter(|record| !record.evicted) {
                let key = Key::parse(&record.key).expect("a scanned record names its key");
                let mut record = record.clone();
                record.evicted = true;
                self.store.write(&Place::Record(key), record.text().as_bytes(), true)?;
            }
            self.remove(&Place::Object(*id))?;
        }
        // Records are removed before their objects, so a process killed half-way leaves unused objects and never a record
        // without its object.
        sweep.garbage.iter().rev().try_for_each(|place| self.remove(place))
    }

    fn remove(&self, place: &Place) -> Result<()> {
        match self.store.files().remove(&place.at()) {
            Err(why) if why.kind() != ErrorKind::NotFound => Err(Error::io("remove", self.store.path(place))(why)),
            _ => Ok(()),
        }
    }
}

/// Opens the lock on the whole of a store.
fn open_lock(disk: &dyn Disk) -> Result<File> {
    let at = Place::StoreLock.at();
    let file = disk.open_lock(&at, false);
    file.map_err(Error::writing("make the store's lock", disk.root().join(at.text()), 0))
}

/// The size of a store without what is not its own, bytes.
///
/// # Errors
/// A folder that cannot be read.
pub fn bytes(store: &Store) -> Result<u64> {
    Folder::ALL.into_iter().try_fold(0, |all: u64, folder| {
        let files = listed(store, folder)?;
        let ours = files.iter().filter(|file| file.place.is_some());
        Ok(ours.fold(all, |all, file| all.saturating_add(file.bytes)))
    })
}

/// Finds what can go: all that nothing reaches, then what may go until the store is within `bound`. `locks` are the
/// committed ones.
///
/// # Errors
/// Anything that cannot be read, so that what it reaches is not known.
pub fn plan(store: &Store, pipeline: &Pipeline, locks: &[Lock], bound: u64) -> Result<Sweep> {
    let scan = Scan::new(store)?;
    let roots = Roots::new(store, locks, &scan)?;
    let mut sweep = Sweep {
        bytes: scan
            .files
            .values()
            .fold(0, |all, (bytes, _)| all.saturating_add(*bytes)),
        foreign: scan.foreign.clone(),
        ..Sweep::default()
    };
    sweep.take_garbage(&scan, &roots);
    sweep.take_evictable(&scan, &roots, pipeline, bound);
    Ok(sweep)
}

/// Everything in a store.
struct Scan {
    /// Every file of the store: its length and when it was last written.
    files: BTreeMap<Place, (u64, SystemTime)>,
    /// Undamaged records by the id they name.
    records: BTreeMap<Id, Vec<(Key, Record)>>,
    foreign: Vec<String>,
}

impl Scan {
    fn new(store: &Store) -> Result<Self> {
        let mut scan = Self {
            files: BTreeMap::new(),
            records: BTreeMap::new(),
            foreign: Vec::new(),
        };
        for folder in Folder::ALL {
            for file in listed(store, folder)? {
                match file.place {
                    Some(place) => drop(scan.files.insert(place, (file.bytes, file.modified))),
                    None => scan.foreign.push(file.path),
                }
            }
        }
        for place in scan.files.keys() {
            let Place::Record(key) = place else { continue };
            let record = match store.read_text(place) {
                Err(why) if why.kind() != ErrorKind::InvalidData => {
                    return Err(Error::io("read the record", store.path(place))(why));
                }
                text => text.ok().and_then(|text| Record::parse(&text)),
            };
            // A record that is damaged is a miss: whatever it named is as good as never made.
            let record = record.filter(|record| record.key == key.to_string());
            if let Some((id, record)) = record.and_then(|record| Some((Id::parse(&record.id)?, record))) {
                scan.records.entry(id).or_default().push((*key, record));
            }
        }
        Ok(scan)
    }

    /// What it took to make an output, seconds.
    fn seconds(&self, id: &Id) -> f64 {
        let records = self.records.get(id).into_iter().flatten();
        let seconds = records.map(|(_, record)| record.seconds);
        seconds.fold(0.0, |a, b| if b > a { b } else { a })
    }
}

/// What locks and runs reach.
struct Roots {
    ids: BTreeSet<Id>,
    contents: BTreeSet<Id>,
}

impl Roots {
    fn new(store: &Store, locks: &[Lock], scan: &Scan) -> Result<Self> {
        let (ids, contents) = (BTreeSet::new(), BTreeSet::new());
        let mut roots = Self { ids, contents };
        let mut unknown: BTreeSet<&str> = BTreeSet::new();
        for line in locks
            .iter()
            .flat_map(|lock| &lock.lines)
            .filter(|line| line.pieces.is_some())
        {
            // An output that was never made in this store has no list of pieces here, so there is nothing to keep for it.
            if roots.reach(store, line.content)? == Pieces::Damaged {
                unknown.insert(&line.name);
            }
        }
        let (runs, ended) = runs::all(store)?;
        for run in &runs {
            for (node, content) in &run.contents {
                let Some(content) = Id::parse(content) else { continue };
                // A run wrote the list of every content in pieces.
                if roots.reach(store, content)? != Pieces::Known && !scan.records.contains_key(&content) {
                    unknown.insert(node);
                }
            }
            let pieces = run.pieces.values().flatten();
            roots.ids.extend(pieces.filter_map(|id| Id::parse(id)));
        }
        let is_recent = |key: &Key| {
            let (_, written) = &scan.files[&Place::Record(*key)];
            ended.is_none_or(|ended| *written > ended)
        };
        for (id, records) in &scan.records {
            // If the list of a node's pieces is damaged, every object that a record of that node names is kept.
            let stays = |(key, record): &(Key, Record)| is_recent(key) || unknown.contains(&*record.node);
            if records.iter().any(stays) {
                roots.ids.insert(*id);
            }
        }
        Ok(roots)
    }

    /// Takes a content and its pieces.
    fn reach(&mut self, store: &Store, content: Id) -> Result<Pieces> {
        self.contents.insert(content);
        self.ids.insert(content);
        match manifest::read(store, &content) {
            Ok(ids) => self.ids.extend(ids),
            Err(why) if why.kind() == ErrorKind::NotFound => return Ok(Pieces::NoList),
            Err(why) if why.kind() == ErrorKind::InvalidData => return Ok(Pieces::Damaged),
            Err(why) => {
                return Err(Error::io("read the manifest", store.path(&Place::Manifest(content)))(
                    why,
                ));
            }
        }
        Ok(Pieces::Known)
    }
}

/// What is known of the pieces of a content.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Pieces {
    Known,
    /// There is no list of them.
    NoList,
    /// Their list does not hash to its name.
    Damaged,
}

impl Sweep {
    /// The number of objects that are still of use and go because the store is over its bound.
    pub fn evicted(&self) -> usize {
        self.evicted.len()
    }

    fn take_garbage(&mut self, scan: &Scan, roots: &Roots) {
        let kept = |id: &Id| roots.ids.contains(id);
        let mut records = BTreeSet::new();
        let mut parts = BTreeSet::new();
        for (key, record) in scan
            .records
            .iter()
            .filter(|(id, _)| kept(id))
            .flat_map(|(_, records)| records)
        {
            records.insert(*key);
            let names = record
                .parts
                .iter()
                .flat_map(|parts| [&parts.code, &parts.params, &parts.inputs]);
            parts.extend(names.filter_map(|name| Id::parse(name)));
        }
        for (place, (bytes, _)) in &scan.files {
            let stays = match place {
                Place::Object(id) => kept(id),
                Place::Record(key) => records.contains(key),
                Place::Part(hash) => parts.contains(hash),
                Place::Manifest(content) => roots.contents.contains(content),
                // What stood in the way got a name of its own in quarantine: this program did not make it.
                Place::Run(..) | Place::Quarantined(_, Some(_)) => true,
                _ => false,
            };
            if stays {
                continue;
            }
            if let Place::Object(id) = place {
                self.unreached += 1;
                self.seconds += scan.seconds(id);
            }
            self.freed = self.freed.saturating_add(*bytes);
            self.garbage.push(place.clone());
        }
    }

    fn take_evictable(&mut self, scan: &Scan, roots: &Roots, pipeline: &Pipeline, bound: u64) {
        let mut worth: Vec<(f64, Id, u64)> = Vec::new();
        for id in &roots.ids {
            let records = scan.records.get(id).map_or(&[][..], Vec::as_slice);
            let may_go = !records.is_empty() && records.iter().all(|(_, record)| may_go(record, pipeline));
            if let Some((bytes, _)) = scan.files.get(&Place::Object(*id)).filter(|_| may_go) {
                worth.push((scan.seconds(id) / (*bytes as f64), *id, *bytes));
            }
        }
        worth.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        for (_, id, bytes) in worth {
            if self.bytes.saturating_sub(self.freed) <= bound {
                return;
            }
            let records = scan.records[&id].iter().map(|(_, record)| record.clone());
            self.evicted.push((id, records.collect()));
            self.freed = self.freed.saturating_add(bytes);
            self.seconds += scan.seconds(&id);
        }
    }
}

/// Whether the bytes of an output may go: this program can make them again, and nobody reads them as a file.
fn may_go(record: &Record, pipeline: &Pipeline) -> bool {
    let stage = record.node.split('/').next().unwrap_or_default();
    let node = pipeline.place(stage).map(|place| pipeline.contents[place]);
    node.is_some_and(|node| node.keep() != Keep::Always && !node.is_published())
}
