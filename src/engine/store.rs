//! Store: id -> bytes and key -> record, on disk. Only a verified read hands out bytes; only a rename publishes.
//!
//! An object without a record is garbage, never a lie; a record whose object is gone or torn is a miss. Synchronising a
//! file costs milliseconds, so cheap pieces share theirs: their records wait for at most 64 pieces or half a second.

use std::collections::BTreeSet;
use std::fs::{self, File};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use crate::engine::error::{Error, Result};
use crate::engine::id::{Id, Key};
use crate::engine::object;
use crate::engine::record::Record;

const SHARED_PIECES: usize = 64;
const SHARED_WAIT: Duration = Duration::from_millis(500);
const ALONE_SECONDS: f64 = 0.2;

/// The folder of objects and records.
pub struct Store {
    root: PathBuf,
    pending: Mutex<Vec<Pending>>,
    temporaries: AtomicU64,
}

struct Pending {
    object: Option<PathBuf>,
    record: PathBuf,
    text: String,
    since: Instant,
}

/// What a verified read found.
pub(crate) enum Found {
    /// The payload.
    Bytes(Vec<u8>),
    /// No such object.
    Missing,
    /// Bytes that are not what their name says; they were moved to `quarantine/`.
    Damaged(String),
}

impl Store {
    /// Opens a store for writing, making its folders where they are missing.
    ///
    /// # Errors
    /// A folder that cannot be made.
    pub fn open(root: &Path) -> Result<Self> {
        for folder in ["objects", "records", "tmp", "quarantine"] {
            let path = root.join(folder);
            fs::create_dir_all(&path).map_err(Error::io("make the store's folder", path))?;
        }
        Ok(Self::look(root))
    }

    /// Looks at a store without making anything; one that is not there is empty.
    pub fn look(root: &Path) -> Self {
        Self {
            root: root.to_owned(),
            pending: Mutex::new(Vec::new()),
            temporaries: AtomicU64::new(0),
        }
    }

    /// The store's folder.
    pub fn root(&self) -> &Path {
        &self.root
    }

    /// The record of a key, if there is an undamaged one.
    pub fn record(&self, key: &Key) -> Option<Record> {
        let path = self.path("records", &key.to_string(), ".json");
        let waiting = self.waiting(&path);
        let text = waiting.or_else(|| fs::read_to_string(&path).ok())?;
        let record = Record::parse(&text)?;
        (record.key == key.to_string()).then_some(record)
    }

    /// The text of a record that still waits for its synchronisation: equal cases share it within one run.
    fn waiting(&self, path: &Path) -> Option<String> {
        let pending = self.pending();
        let found = pending.iter().find(|pending| pending.record == path);
        found.map(|pending| pending.text.clone())
    }

    /// Whether there is a file for an id; its bytes are verified when they are read.
    pub fn has(&self, id: &Id) -> bool {
        self.path("objects", &id.to_string(), "").is_file()
    }

    /// Reads and verifies an object.
    pub(crate) fn read(&self, id: &Id, schema: Option<u64>) -> Found {
        let path = self.path("objects", &id.to_string(), "");
        let Ok(file) = fs::read(&path) else {
            return Found::Missing;
        };
        match object::open(id, schema, &file) {
            Ok(payload) => Found::Bytes(payload),
            Err(why) => {
                // A move that fails leaves the damaged file to be overwritten by the healed one.
                let _ = fs::rename(&path, self.root.join("quarantine").join(id.to_string()));
                Found::Damaged(why)
            }
        }
    }

    /// Publishes an output: the object first, the record last, both synchronised before they count.
    ///
    /// # Errors
    /// A write that fails; nothing half-written is left.
    pub(crate) fn publish(&self, schema: u64, payload: &[u8], record: &Record) -> Result<()> {
        let (id, file) = object::seal(schema, payload);
        let object = if record.evicted {
            None
        } else {
            let path = self.path("objects", &id.to_string(), "");
            self.write(&path, &file, false)?;
            Some(path)
        };
        let pending = Pending {
            object,
            record: self.path("records", &record.key, ".json"),
            text: record.text(),
            since: Instant::now(),
        };
        let due = {
            let mut queue = self.pending();
            queue.push(pending);
            let oldest = queue[0].since.elapsed();
            record.seconds >= ALONE_SECONDS || queue.len() >= SHARED_PIECES || oldest >= SHARED_WAIT
        };
        if due { self.flush() } else { Ok(()) }
    }

    /// Puts back the file of an object that was lost or damaged.
    pub(crate) fn restore(&self, id: &Id, file: &[u8]) -> Result<()> {
        self.write(&self.path("objects", &id.to_string(), ""), file, true)
    }

    /// Synchronises what waits and writes its records.
    ///
    /// # Errors
    /// A write or synchronisation that fails.
    pub fn flush(&self) -> Result<()> {
        let waiting = std::mem::take(&mut *self.pending());
        let mut folders = BTreeSet::new();
        for path in waiting.iter().filter_map(|pending| pending.object.as_ref()) {
            synchronise(path)?;
            folders.extend(path.parent().map(Path::to_owned));
        }
        for folder in std::mem::take(&mut folders) {
            synchronise(&folder)?;
        }
        for pending in &waiting {
            self.write(&pending.record, pending.text.as_bytes(), true)?;
            folders.extend(pending.record.parent().map(Path::to_owned));
        }
        for folder in folders {
            synchronise(&folder)?;
        }
        Ok(())
    }

    /// Writes a file by way of a temporary one and a rename.
    pub(crate) fn write(&self, path: &Path, bytes: &[u8], durable: bool) -> Result<()> {
        let folder = path.parent().expect("a file of the store lies in a folder");
        fs::create_dir_all(folder).map_err(Error::io("make the folder", folder))?;
        let number = self.temporaries.fetch_add(1, Ordering::Relaxed);
        let temporary = self.root.join("tmp").join(format!("{}-{number}", std::process::id()));
        let result = write_all(&temporary, bytes, durable)
            .and_then(|()| fs::rename(&temporary, path).map_err(Error::io("rename into place", path)));
        if result.is_err() {
            // The error to report is the first one.
            let _ = fs::remove_file(&temporary);
        }
        result
    }

    fn pending(&self) -> MutexGuard<'_, Vec<Pending>> {
        self.pending.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn path(&self, kind: &str, hex: &str, suffix: &str) -> PathBuf {
        self.root
            .join(kind)
            .join(&hex[..2])
            .join(format!("{}{suffix}", &hex[2..]))
    }
}

fn write_all(path: &Path, bytes: &[u8], durable: bool) -> Result<()> {
    let mut file = File::create(path).map_err(Error::io("write", path))?;
    file.write_all(bytes).map_err(Error::io("write", path))?;
    if durable {
        file.sync_all().map_err(Error::io("synchronise", path))?;
    }
    Ok(())
}

fn synchronise(path: &Path) -> Result<()> {
    let file = File::open(path).map_err(Error::io("open", path))?;
    file.sync_all().map_err(Error::io("synchronise", path))
}
