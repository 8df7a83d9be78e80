//! Store: id -> bytes and key -> record, on disk. Only a verified read hands out bytes; only a rename publishes.
//!
//! An object without a record is garbage, never a lie; a record whose object is gone or torn is a miss. Synchronising a
//! file costs milliseconds, so cheap pieces share theirs: their records, and the locks on their keys, wait for at most 64
//! pieces or half a second. Who writes or reads holds `store.lock` shared, who collects garbage holds it alone.

use std::collections::BTreeSet;
use std::fs::{File, TryLockError};
use std::hash::{BuildHasher, RandomState};
use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use crate::engine::disk::{Disk, System};
use crate::engine::error::{Error, Result};
use crate::engine::flight::{Flight, Hold, KeyLock};
use crate::engine::id::{Id, Key};
use crate::engine::object;
use crate::engine::record::Record;

const SHARED_PIECES: usize = 64;
const SHARED_WAIT: Duration = Duration::from_millis(500);
const ALONE_SECONDS: f64 = 0.2;
/// How often a lock on the whole store is asked for again.
const PATIENCE: Duration = Duration::from_millis(50);

/// The folder of objects and records.
pub struct Store {
    root: PathBuf,
    disk: Arc<dyn Disk>,
    flight: Flight,
    pending: Mutex<Vec<Pending>>,
    temporaries: AtomicU64,
    /// Tells the temporary files of this process from those of any other, on this machine or another.
    tag: u64,
    /// Whether a folder of objects or records is new, its entry not synchronised.
    grown: AtomicBool,
    /// Held while this lives; none where there is no store yet, or a file system without locks.
    _shared: Option<File>,
}

struct Pending {
    object: Option<PathBuf>,
    record: PathBuf,
    text: String,
    since: Instant,
    /// Whoever else wants the key waits until the record can be read.
    lock: Option<KeyLock>,
}

/// What a verified read found.
pub(crate) enum Found {
    /// The payload.
    Bytes(Vec<u8>),
    /// No such object.
    Missing,
    /// Bytes that are not what their name says.
    Damaged(String),
}

impl Store {
    /// Opens a store for writing, making its folders where they are missing.
    ///
    /// # Errors
    /// A folder that cannot be made.
    pub fn open(root: &Path) -> Result<Self> {
        Self::open_on(root, Arc::new(System), &|| ())
    }

    /// The same on another disk; `waiting` is called once if garbage is being collected, which is waited for.
    ///
    /// # Errors
    /// A folder that cannot be made.
    pub fn open_on(root: &Path, disk: Arc<dyn Disk>, waiting: &dyn Fn()) -> Result<Self> {
        for folder in ["objects", "records", "locks", "tmp", "quarantine"] {
            let path = root.join(folder);
            disk.make_folder(&path)
                .map_err(Error::writing("make the store's folder", path, 0))?;
        }
        let path = root.join("store.lock");
        let file = disk.open_lock(&path, false);
        let file = file.map_err(Error::writing("make the store's lock", path, 0))?;
        Ok(Self::with(root, disk, Some(file), waiting))
    }

    /// Looks at a store without making anything; one that is not there is empty.
    pub fn look(root: &Path) -> Self {
        Self::look_on(root, Arc::new(System), &|| ())
    }

    /// The same on another disk; `waiting` is called once if garbage is being collected, which is waited for.
    pub fn look_on(root: &Path, disk: Arc<dyn Disk>, waiting: &dyn Fn()) -> Self {
        let file = disk.open_lock(&root.join("store.lock"), true).ok();
        Self::with(root, disk, file, waiting)
    }

    /// A store that takes no lock on the whole, for who holds it alone.
    pub(crate) fn unlocked(root: &Path) -> Self {
        Self::with(root, Arc::new(System), None, &|| ())
    }

    fn with(root: &Path, disk: Arc<dyn Disk>, lock: Option<File>, waiting: &dyn Fn()) -> Self {
        let shared = lock.as_ref().map(|file| wait_for(disk.as_ref(), file, false, waiting));
        Self {
            root: root.to_owned(),
            flight: Flight::new(root.join("locks"), Arc::clone(&disk), shared == Some(false)),
            disk,
            pending: Mutex::default(),
            temporaries: AtomicU64::new(0),
            tag: RandomState::new().hash_one(std::process::id()),
            grown: AtomicBool::new(true),
            _shared: lock,
        }
    }

    /// The store's folder.
    pub fn root(&self) -> &Path {
        &self.root
    }

    /// Whether the file system refused a lock: two runs at once may then make the same thing twice.
    pub fn is_without_locks(&self) -> bool {
        self.flight.is_without_locks()
    }

    /// Takes a key, if nobody else is making it.
    pub(crate) fn hold(&self, key: &Key) -> Result<Hold> {
        self.flight.hold(key)
    }

    /// Waits until no other run has the lock of a name; none where the file system has no locks.
    ///
    /// # Errors
    /// A lock that cannot be made.
    pub(crate) fn wait_for_turn(&self, name: &str) -> Result<Option<File>> {
        let path = self.root.join("locks").join(name);
        let file = self.disk.open_lock(&path, false);
        let file = file.map_err(Error::writing("make the lock", path, 0))?;
        Ok(wait_for(self.disk.as_ref(), &file, true, &|| ()).then_some(file))
    }

    /// The record of a key, if there is an undamaged one.
    pub fn record(&self, key: &Key) -> Option<Record> {
        let path = self.path("records", &key.to_string(), ".json");
        let read = || String::from_utf8(self.disk.read(&path).ok()?).ok();
        let text = self.waiting(&path).or_else(read)?;
        let record = Record::parse(&text)?;
        (record.key == key.to_string()).then_some(record)
    }

    /// The text of a record that still waits for its synchronisation: equal cases share it within one run.
    fn waiting(&self, path: &Path) -> Option<String> {
        let pending = self.pending();
        let found = pending.iter().find(|pending| pending.record == path);
        found.map(|pending| pending.text.clone())
    }

    /// The file of an id.
    pub(crate) fn object(&self, id: &Id) -> PathBuf {
        self.path("objects", &id.to_string(), "")
    }

    /// Whether there is a file for an id; its bytes are verified when they are read.
    pub fn has(&self, id: &Id) -> bool {
        self.object(id).is_file()
    }

    /// Reads and verifies an object; a damaged one is moved to `quarantine/`.
    pub(crate) fn read(&self, id: &Id, schema: Option<u64>) -> Found {
        let found = self.peek(id, schema);
        // Sound, but of another type than asked for: the one who asked is wrong.
        if matches!(found, Found::Damaged(_)) && !matches!(self.peek(id, None), Found::Bytes(_)) {
            // A move that fails leaves the damaged file to be overwritten by the healed one.
            let _ = self
                .disk
                .rename(&self.object(id), &self.root.join("quarantine").join(id.to_string()));
        }
        found
    }

    /// The same, leaving everything where it is.
    pub(crate) fn peek(&self, id: &Id, schema: Option<u64>) -> Found {
        match self.disk.read(&self.object(id)) {
            Ok(file) => match object::verify(id, schema, &file) {
                Ok(()) => Found::Bytes(object::payload(file)),
                Err(why) => Found::Damaged(why),
            },
            Err(why) if why.kind() == ErrorKind::InvalidData => Found::Damaged(why.to_string()),
            Err(_) => Found::Missing,
        }
    }

    /// Publishes an output: the object first, the record last, both synchronised before they count. The lock on its key
    /// is let go of when they do.
    ///
    /// # Errors
    /// A write that fails; nothing half-written is left.
    pub(crate) fn publish(&self, schema: u64, payload: &[u8], record: &Record, lock: Option<KeyLock>) -> Result<()> {
        let (id, file) = object::seal(schema, payload);
        let object = if record.evicted {
            None
        } else {
            let path = self.object(&id);
            // Equal bytes under another key: what a record may already rest on is not torn open again.
            if !self.disk.read(&path).is_ok_and(|old| old == file) {
                self.put(lock.as_ref(), &path, &file, false)?;
            }
            Some(path)
        };
        let pending = Pending {
            object,
            record: self.path("records", &record.key, ".json"),
            text: record.text(),
            since: Instant::now(),
            lock,
        };
        self.pending().push(pending);
        if record.seconds >= ALONE_SECONDS || self.is_due() {
            self.flush()
        } else {
            Ok(())
        }
    }

    fn is_due(&self) -> bool {
        let queue = self.pending();
        queue.len() >= SHARED_PIECES || queue.first().is_some_and(|first| first.since.elapsed() >= SHARED_WAIT)
    }

    /// Puts back the file of an object that was lost or damaged.
    pub(crate) fn restore(&self, id: &Id, file: &[u8], lock: Option<&KeyLock>) -> Result<()> {
        self.put(lock, &self.object(id), file, true)
    }

    /// Synchronises what waits, if any of it has waited long enough.
    ///
    /// # Errors
    /// A write or synchronisation that fails.
    pub(crate) fn flush_due(&self) -> Result<()> {
        if self.is_due() { self.flush() } else { Ok(()) }
    }

    /// Synchronises what waits and writes its records.
    ///
    /// # Errors
    /// A write or synchronisation that fails.
    pub fn flush(&self) -> Result<()> {
        let waiting = std::mem::take(&mut *self.pending());
        if waiting.is_empty() {
            return Ok(());
        }
        let objects: BTreeSet<&Path> = waiting.iter().filter_map(|pending| pending.object.as_deref()).collect();
        for path in &objects {
            self.synchronise(path)?;
        }
        for folder in folders(objects.iter().copied()) {
            self.synchronise(folder)?;
        }
        for pending in &waiting {
            self.put(pending.lock.as_ref(), &pending.record, pending.text.as_bytes(), true)?;
        }
        for folder in folders(waiting.iter().map(|pending| pending.record.as_path())) {
            self.synchronise(folder)?;
        }
        if self.grown.swap(false, Ordering::Relaxed) {
            self.synchronise(&self.root.join("objects"))?;
            self.synchronise(&self.root.join("records"))?;
        }
        Ok(())
    }

    /// Writes a file by way of a temporary one and a rename.
    pub(crate) fn write(&self, path: &Path, bytes: &[u8], durable: bool) -> Result<()> {
        self.put(None, path, bytes, durable)
    }

    /// The temporary file of a locked key is its holder's: what a killed one left is overwritten by the next.
    fn put(&self, lock: Option<&KeyLock>, path: &Path, bytes: &[u8], durable: bool) -> Result<()> {
        let folder = path.parent().expect("a file of the store lies in a folder");
        if !folder.is_dir() {
            let made = self.disk.make_folder(folder);
            made.map_err(Error::writing("make the folder", folder, 0))?;
            self.grown.store(true, Ordering::Relaxed);
        }
        let name = match lock.filter(|lock| lock.is_exclusive()) {
            Some(lock) => lock.key().to_string(),
            None => format!("{:016x}-{}", self.tag, self.temporaries.fetch_add(1, Ordering::Relaxed)),
        };
        let temporary = self.root.join("tmp").join(name);
        let result = self.put_by(&temporary, path, bytes, durable);
        if result.is_err() {
            // The error to report is the first one.
            let _ = self.disk.remove(&temporary);
        }
        result
    }

    fn put_by(&self, temporary: &Path, path: &Path, bytes: &[u8], durable: bool) -> Result<()> {
        let length = bytes.len() as u64;
        let written = self.disk.write(temporary, bytes);
        written.map_err(Error::writing("write", path, length))?;
        if durable {
            let synchronised = self.disk.synchronise(temporary);
            synchronised.map_err(Error::writing("synchronise", path, length))?;
        }
        let renamed = self.disk.rename(temporary, path);
        renamed.map_err(Error::writing("rename into place", path, length))
    }

    fn synchronise(&self, path: &Path) -> Result<()> {
        let result = self.disk.synchronise(path);
        result.map_err(Error::writing("synchronise", path, 0))
    }

    fn pending(&self) -> MutexGuard<'_, Vec<Pending>> {
        self.pending.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn path(&self, kind: &str, hex: &str, suffix: &str) -> PathBuf {
        path_in(&self.root, kind, hex, suffix)
    }
}

/// Where a store keeps what a hash names: `KIND/ab/cdef..SUFFIX`.
pub(crate) fn path_in(root: &Path, kind: &str, hex: &str, suffix: &str) -> PathBuf {
    let mut path = PathBuf::with_capacity(root.as_os_str().len() + kind.len() + hex.len() + suffix.len() + 4);
    path.extend([root, Path::new(kind), Path::new(&hex[..2]), Path::new(&hex[2..])]);
    path.as_mut_os_string().push(suffix);
    path
}

fn folders<'p>(files: impl Iterator<Item = &'p Path>) -> BTreeSet<&'p Path> {
    files.filter_map(Path::parent).collect()
}

/// Waits for a lock on the whole store; false where the file system has none.
pub(crate) fn wait_for(disk: &dyn Disk, file: &File, exclusive: bool, waiting: &dyn Fn()) -> bool {
    let mut told = false;
    loop {
        match disk.try_lock(file, exclusive) {
            Ok(()) => return true,
            Err(TryLockError::Error(_)) => return false,
            Err(TryLockError::WouldBlock) => {
                if !told {
                    waiting();
                    told = true;
                }
                std::thread::sleep(PATIENCE);
            }
        }
    }
}
