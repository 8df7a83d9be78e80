//! Gc: what can be made again gives way when room is short. The disk is scanned; no index is believed.
//!
//! Roots: the locks beside the store, those in git, the last runs, and what was made since the last run ended (a killed
//! run's work). What no root reaches goes first; then, while more than the bound is left, the bytes of outputs that may
//! go, by bytes x age / seconds to make them again. Their records stay, so nothing below them runs again.

use std::collections::{BTreeMap, BTreeSet};
use std::ffi::OsStr;
use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};
use std::time::SystemTime;

use crate::engine::disk::{Disk, Listed, System, files_in, read_text};
use crate::engine::error::{Error, Result};
use crate::engine::id::Id;
use crate::engine::lock::Lock;
use crate::engine::manifest;
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
    /// What no lock and no run reaches: records, then objects, then the rest.
    garbage: Vec<PathBuf>,
    /// Objects among them.
    pub unreached: usize,
    /// Objects that only room takes, each with the records that name it.
    evicted: Vec<(PathBuf, Vec<Noted>)>,
    /// Bytes freed.
    pub freed: u64,
    /// What it took to make what goes, seconds.
    pub seconds: f64,
}

/// A record and where it lies.
#[derive(Clone, Debug)]
struct Noted {
    path: PathBuf,
    record: Record,
}

/// The store, which nobody else is reading or writing.
pub struct Alone {
    _lock: File,
}

impl Alone {
    /// Waits until no run lives; `waiting` is called once if one does.
    ///
    /// # Errors
    /// A store that cannot be locked.
    pub fn wait(root: &Path, waiting: &dyn Fn()) -> Result<Self> {
        let path = root.join("store.lock");
        let file = System.open_lock(&path, false);
        let file = file.map_err(Error::writing("make the store's lock", &path, 0))?;
        if wait_for(&System, &file, true, waiting) {
            return Ok(Self { _lock: file });
        }
        let no_locks = io::Error::new(io::ErrorKind::Unsupported, "this file system has no locks");
        Err(Error::io("keep runs out of the store by", path)(no_locks))
    }

    /// The same, or none if somebody is at work.
    pub fn now(root: &Path) -> Option<Self> {
        let file = System.open_lock(&root.join("store.lock"), false).ok()?;
        System.try_lock(&file, true).ok()?;
        Some(Self { _lock: file })
    }
}

/// The locks that lie beside the objects of a store: name and text.
///
/// # Errors
/// A lock that cannot be read as text.
pub fn locks_in(root: &Path) -> Result<Vec<(String, String)>> {
    let mut locks = Vec::new();
    for entry in fs::read_dir(root).into_iter().flatten().flatten() {
        let name = entry.file_name().to_string_lossy().into_owned();
        if entry.path().extension().is_some_and(|extension| extension == "lock") && name != "store.lock" {
            let text = read_text(&entry.path()).map_err(Error::io("read the lock", entry.path()))?;
            locks.push((name, text));
        }
    }
    locks.sort();
    Ok(locks)
}

/// The size of a store, without what belongs to the user, bytes.
///
/// # Errors
/// A folder that cannot be read.
pub fn bytes(root: &Path) -> Result<u64> {
    let folders = ["objects", "records", "parts", "manifests", "tmp", "locks", "quarantine"];
    folders.into_iter().try_fold(0, |all: u64, folder| {
        let files = files_in(&root.join(folder))?;
        Ok(files.iter().fold(all, |all, file| all.saturating_add(file.bytes)))
    })
}

/// Finds what can go: all that nothing reaches, then what may go until the store is within `bound`. `committed` are the
/// texts of locks elsewhere, such as in git; one that cannot be read is none.
///
/// # Errors
/// A lock beside the store that is damaged, or a folder that cannot be read, so that what they reach is not known.
pub fn plan(root: &Path, pipeline: &Pipeline, committed: &[String], bound: u64) -> Result<Sweep> {
    let mut locks = Vec::new();
    for (name, text) in locks_in(root)? {
        locks.push(Lock::parse_file(&root.join(name).display().to_string(), &text)?);
    }
    locks.extend(committed.iter().filter_map(|text| Lock::parse(text).ok()));
    let scan = Scan::new(root)?;
    let roots = Roots::new(root, &locks, &scan);
    let mut sweep = Sweep {
        bytes: bytes(root)?,
        ..Sweep::default()
    };
    sweep.take_garbage(&scan, &roots);
    sweep.take_evictable(&scan, &roots, pipeline, bound);
    Ok(sweep)
}

/// Takes away what a plan found.
///
/// # Errors
/// A file that cannot be written or removed.
pub fn carry_out(_: &Alone, root: &Path, sweep: &Sweep) -> Result<()> {
    // It would wait for us: the lock on the whole is held already.
    let store = Store::unlocked(root);
    for (object, records) in &sweep.evicted {
        for noted in records.iter().filter(|noted| !noted.record.evicted) {
            let mut record = noted.record.clone();
            record.evicted = true;
            store.write(&noted.path, record.text().as_bytes(), true)?;
        }
        remove(object)?;
    }
    sweep.garbage.iter().try_for_each(|path| remove(path))
}

fn remove(path: &Path) -> Result<()> {
    match fs::remove_file(path) {
        Err(why) if why.kind() != io::ErrorKind::NotFound => Err(Error::io("remove", path)(why)),
        _ => Ok(()),
    }
}

/// Everything in a store but what belongs to the user.
struct Scan {
    objects: BTreeMap<Id, Listed>,
    records: BTreeMap<Id, Vec<(Noted, SystemTime)>>,
    damaged: Vec<Listed>,
    parts: Vec<Listed>,
    manifests: Vec<Listed>,
    /// `tmp/`, `locks/`, `quarantine/`.
    rest: Vec<Listed>,
    record_bytes: BTreeMap<PathBuf, u64>,
}

impl Scan {
    fn new(root: &Path) -> Result<Self> {
        let named_objects = files_in(&root.join("objects"))?.into_iter();
        let objects = named_objects
            .filter_map(|item| Some((named(&item.path)?, item)))
            .collect();
        let mut records: BTreeMap<Id, Vec<(Noted, SystemTime)>> = BTreeMap::new();
        let (mut damaged, mut record_bytes) = (Vec::new(), BTreeMap::new());
        for item in files_in(&root.join("records"))?
            .into_iter()
            .filter(|item| is_record(&item.path))
        {
            let text = read_text(&item.path).unwrap_or_default();
            let record = Record::parse(&text);
            match record.and_then(|record| Some((Id::parse(&record.id)?, record))) {
                None => damaged.push(item),
                Some((id, record)) => {
                    record_bytes.insert(item.path.clone(), item.bytes);
                    let path = item.path;
                    let noted = Noted { path, record };
                    records.entry(id).or_default().push((noted, item.modified));
                }
            }
        }
        let mut rest = Vec::new();
        for folder in ["tmp", "locks", "quarantine"] {
            rest.extend(files_in(&root.join(folder))?);
        }
        // Only what the store names: a stranger's file is not ours to remove.
        rest.retain(|item| item.path.file_name().and_then(OsStr::to_str).is_some_and(is_ours));
        Ok(Self {
            objects,
            records,
            damaged,
            parts: files_in(&root.join("parts"))?,
            manifests: files_in(&root.join("manifests"))?,
            rest,
            record_bytes,
        })
    }

    /// What it took to make an output, seconds.
    fn seconds(&self, id: &Id) -> f64 {
        let records = self.records.get(id).into_iter().flatten();
        records
            .map(|(noted, _)| noted.record.seconds)
            .fold(0.0, |a, b| if b > a { b } else { a })
    }
}

/// What locks and runs reach.
struct Roots {
    ids: BTreeSet<Id>,
    contents: BTreeSet<Id>,
}

impl Roots {
    fn new(root: &Path, locks: &[Lock], scan: &Scan) -> Self {
        let mut roots = Self {
            ids: BTreeSet::new(),
            contents: BTreeSet::new(),
        };
        let mut unknown = BTreeSet::new();
        let (runs, ended) = runs::last(root);
        let locked = locks.iter().flat_map(|lock| &lock.lines);
        let locked = locked
            .filter(|line| line.pieces.is_some())
            .map(|line| (line.name.as_str(), Some(line.content)));
        let used = runs.iter().flat_map(|run| &run.contents);
        let used = used.map(|(name, content)| (name.as_str(), Id::parse(content)));
        for (name, content) in locked.chain(used) {
            let Some(content) = content else { continue };
            roots.contents.insert(content);
            match manifest::pieces(root, &content) {
                Some(ids) => roots.ids.extend(ids),
                None if scan.records.contains_key(&content) => drop(roots.ids.insert(content)),
                None => drop(unknown.insert(name.to_owned())),
            }
        }
        let pieces = runs.iter().flat_map(|run| run.pieces.values().flatten());
        roots.ids.extend(pieces.filter_map(|id| Id::parse(id)));
        for (id, records) in &scan.records {
            let is_recent = |modified: &SystemTime| ended.is_none_or(|ended| *modified > ended);
            // Whose pieces are not known keeps all that ever bore its name.
            let stays =
                |(noted, modified): &(Noted, SystemTime)| is_recent(modified) || unknown.contains(&noted.record.node);
            if records.iter().any(stays) {
                roots.ids.insert(*id);
            }
        }
        roots
    }
}

impl Sweep {
    /// Objects that only room takes.
    pub fn evicted(&self) -> usize {
        self.evicted.len()
    }

    fn take(&mut self, item: &Listed) {
        self.garbage.push(item.path.clone());
        self.freed = self.freed.saturating_add(item.bytes);
    }

    fn take_garbage(&mut self, scan: &Scan, roots: &Roots) {
        let mut named_parts = String::new();
        for (id, records) in &scan.records {
            for (noted, _) in records {
                if roots.ids.contains(id) {
                    named_parts.push_str(&noted.record.text());
                } else {
                    let bytes = scan.record_bytes.get(&noted.path).copied().unwrap_or(0);
                    self.freed = self.freed.saturating_add(bytes);
                    self.garbage.push(noted.path.clone());
                }
            }
        }
        for (id, item) in scan.objects.iter().filter(|(id, _)| !roots.ids.contains(id)) {
            self.take(item);
            self.unreached += 1;
            self.seconds += scan.seconds(id);
        }
        let stem = |item: &Listed| item.path.file_stem().map(|stem| stem.to_string_lossy().into_owned());
        let words: BTreeSet<&str> = named_parts.split('"').filter(|word| word.len() == 64).collect();
        let unnamed = |item: &&Listed| stem(item).is_none_or(|stem| !words.contains(stem.as_str()));
        let unused = |item: &&Listed| named(&item.path).is_none_or(|content| !roots.contents.contains(&content));
        for item in scan.parts.iter().filter(unnamed) {
            self.take(item);
        }
        for item in scan.manifests.iter().filter(unused) {
            self.take(item);
        }
        for item in scan.damaged.iter().chain(&scan.rest) {
            self.take(item);
        }
    }

    fn take_evictable(&mut self, scan: &Scan, roots: &Roots, pipeline: &Pipeline, bound: u64) {
        let now = SystemTime::now();
        let mut worth: Vec<(f64, &Id, &Listed)> = Vec::new();
        for (id, item) in scan.objects.iter().filter(|(id, _)| roots.ids.contains(id)) {
            let records = scan.records.get(id).map_or(&[][..], Vec::as_slice);
            if records.is_empty() || !records.iter().all(|(noted, _)| may_go(&noted.record, pipeline)) {
                continue;
            }
            let age = now.duration_since(item.modified).map_or(0.0, |age| age.as_secs_f64());
            let seconds = scan.seconds(id) + 1e-6;
            worth.push((item.bytes as f64 * (age + 1.0) / seconds, id, item));
        }
        worth.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(b.1)));
        for (_, id, item) in worth {
            if self.bytes.saturating_sub(self.freed) <= bound {
                return;
            }
            let records = scan.records[id].iter().map(|(noted, _)| noted.clone()).collect();
            self.evicted.push((item.path.clone(), records));
            self.freed = self.freed.saturating_add(item.bytes);
            self.seconds += scan.seconds(id);
        }
    }
}

/// Whether the bytes of an output may go: this program can make them again, and nobody reads them as a file.
fn may_go(record: &Record, pipeline: &Pipeline) -> bool {
    let stage = record.node.split('/').next().unwrap_or_default();
    let node = pipeline.place(stage).map(|place| pipeline.contents[place]);
    node.is_some_and(|node| node.keep() != Keep::Always && !node.is_published())
}

/// Whether a temporary, locked or quarantined file has a name that the store gives: hexadecimal, with what follows a dash,
/// or that of the one other lock.
fn is_ours(name: &str) -> bool {
    let hex = name.split(['-', '.']).next().unwrap_or_default();
    name == runs::TURN || (hex.len() >= 16 && hex.bytes().all(|byte| byte.is_ascii_hexdigit()))
}

fn is_record(path: &Path) -> bool {
    path.extension().is_some_and(|extension| extension == "json") && named(&path.with_extension("")).is_some()
}

fn named(path: &Path) -> Option<Id> {
    let (name, folder) = (path.file_name()?, path.parent()?.file_name()?);
    Id::parse(&format!("{}{}", folder.to_str()?, name.to_str()?))
}
