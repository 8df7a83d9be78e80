//! Store: id -> bytes and key -> record, on disk. Only a verified read hands out bytes; only a rename publishes.
//!
//! An object without a record is of no use, and `gc` removes it. If the object of a record is missing or damaged, the piece is
//! made again. Synchronising a file costs milliseconds, so cheap pieces share theirs: their records, and the locks on their
//! keys, wait for at most 64 pieces or half a second. A process that reads or writes the store holds `store.lock` shared; `gc`
//! holds it alone.
//!
//! If something else (a folder, a socket, a link) occupies the path of a file or folder of the store, it is moved to
//! `quarantine/`, and the run says where it went. A link in place of one of the top folders is refused by name:
//! it may be meant, and following it would write, move and delete outside the store.

use std::collections::BTreeSet;
use std::fs::{File, TryLockError};
use std::hash::{BuildHasher, RandomState};
use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use crate::engine::claim;
use crate::engine::disk::{Disk, Kind, System, is_read_only};
use crate::engine::error::{Error, Result};
use crate::engine::flight::{Flight, Hold, KeyLock};
use crate::engine::id::{Id, Key};
use crate::engine::names::{At, Folder, Place};
use crate::engine::object;
use crate::engine::record::Record;

const SHARED_PIECES: usize = 64;
/// Files that a process has open beside the locks on the keys of its pieces.
const OTHER_FILES: u64 = 48;
const SHARED_WAIT: Duration = Duration::from_millis(500);
const ALONE_SECONDS: f64 = 0.2;
/// How often a lock on the whole store is asked for again.
const PATIENCE: Duration = Duration::from_millis(50);
/// The folders that a new store gets at once.
/// Quarantine comes first: what stands in the place of another folder is moved there.
const FIRST: [Folder; 8] = [
    Folder::Temporary,
    Folder::Quarantine,
    Folder::Objects,
    Folder::Records,
    Folder::Parts,
    Folder::Manifests,
    Folder::Runs,
    Folder::Locks,
];

/// The folder of objects and records.
pub struct Store {
    disk: Arc<dyn Disk>,
    flight: Flight,
    pending: Mutex<Vec<Pending>>,
    numbers: AtomicU64,
    /// How many pieces may wait for one synchronisation: each holds a file open.
    shared_pieces: usize,
    /// Tells the temporary files of this process from those of any other, on this machine or another.
    tag: u64,
    /// Whether a folder of objects or records is new, its entry not synchronised.
    grown: AtomicBool,
    /// What was moved to quarantine since it was last asked for: what it stood for, and where it is now.
    put_aside: Mutex<Vec<(String, PathBuf)>>,
    /// Held while this lives; none where there is no store yet, or a file system without locks.
    shared: Option<File>,
}

struct Pending {
    object: Option<Id>,
    record: Place,
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
    /// Bytes that are not what their name says, or that cannot be read.
    Damaged(String),
}

impl Store {
    /// Opens a store for writing, making its folders where they are missing.
    ///
    /// # Errors
    /// A folder that is somebody else's, or that cannot be made.
    pub fn open(root: &Path) -> Result<Self> {
        Self::open_on(Self::disk(root)?, &|| ())
    }

    /// The disk of a folder, which is made where it is missing.
    ///
    /// # Errors
    /// A folder that cannot be made.
    pub fn disk(root: &Path) -> Result<Arc<dyn Disk>> {
        let disk = System::make(root).map_err(Error::writing("make the store's folder", root, 0))?;
        Ok(Arc::new(disk))
    }

    /// The disk of a folder, which need not be there.
    ///
    /// # Errors
    /// A folder that cannot be opened.
    pub fn look_at(root: &Path) -> Result<Arc<dyn Disk>> {
        let disk = System::look(root).map_err(Error::io("look into the store", root))?;
        Ok(Arc::new(disk))
    }

    /// Opens the store on a disk; `waiting` is called once if garbage is being collected, which is waited for.
    ///
    /// # Errors
    /// A folder that is somebody else's, or that cannot be made.
    pub fn open_on(disk: Arc<dyn Disk>, waiting: &dyn Fn()) -> Result<Self> {
        claim::check(disk.root())?;
        claim::mark(disk.as_ref())?;
        let mut store = Self::with(disk);
        for folder in FIRST {
            store.make_folder(&folder.at())?;
        }
        let at = Place::StoreLock.at();
        let file = store.disk.open_lock(&at, false).or_else(|why| {
            store.clear(&at, why)?;
            store.disk.open_lock(&at, false)
        });
        store.lock_shared(file.map_err(store.writing("make the store's lock", &at, 0))?, waiting);
        Ok(store)
    }

    /// Looks at a store without making anything; one that is not there is empty.
    pub fn look(root: &Path) -> Self {
        // What cannot be opened holds nothing that could be used; verbs that need it say so.
        let disk = System::look(root).unwrap_or_else(|_| System::nowhere(root));
        Self::look_on(Arc::new(disk), &|| ())
    }

    /// The same on another disk; `waiting` is called once if garbage is being collected, which is waited for.
    pub fn look_on(disk: Arc<dyn Disk>, waiting: &dyn Fn()) -> Self {
        let mut store = Self::with(disk);
        if let Ok(file) = store.disk.open_lock(&Place::StoreLock.at(), true) {
            store.lock_shared(file, waiting);
        }
        store
    }

    /// A store that takes no lock on the whole, for who holds it alone.
    pub(crate) fn unlocked(disk: Arc<dyn Disk>) -> Self {
        Self::with(disk)
    }

    fn with(disk: Arc<dyn Disk>) -> Self {
        Self {
            flight: Flight::new(Arc::clone(&disk)),
            disk,
            pending: Mutex::default(),
            numbers: AtomicU64::new(0),
            shared_pieces: shared_pieces(),
            tag: RandomState::new().hash_one(std::process::id()),
            grown: AtomicBool::new(true),
            put_aside: Mutex::default(),
            shared: None,
        }
    }

    fn lock_shared(&mut self, file: File, waiting: &dyn Fn()) {
        if !wait_for(self.disk.as_ref(), &file, false, waiting) {
            self.flight.go_without_locks();
        }
        self.shared = Some(file);
    }

    /// The store's folder.
    pub fn root(&self) -> &Path {
        self.disk.root()
    }

    /// What its files are read and written by.
    pub(crate) fn files(&self) -> &Arc<dyn Disk> {
        &self.disk
    }

    /// Whether the file system refused a lock: two runs at once may then make the same thing twice.
    pub fn is_without_locks(&self) -> bool {
        self.flight.is_without_locks()
    }

    /// What was moved to quarantine since this was last asked: what it stood for, and where it is now.
    pub fn put_aside(&self) -> Vec<(String, PathBuf)> {
        std::mem::take(&mut *self.put_aside.lock().unwrap_or_else(PoisonError::into_inner))
    }

    /// Takes a key, if nobody else is making it.
    pub(crate) fn hold(&self, key: &Key) -> Result<Hold> {
        let at = Place::KeyLock(*key).at();
        self.flight.hold(key).or_else(|why| {
            // Pieces that wait for their synchronisation hold their locks: so many open files may be all there are.
            if is_out_of_files(&why) {
                self.flush()?;
            } else {
                self.clear(&at, why).map_err(self.writing("make the lock", &at, 0))?;
            }
            self.flight.hold(key).map_err(self.writing("make the lock", &at, 0))
        })
    }

    /// Waits until no other run writes to `runs/`; none where the file system has no locks.
    ///
    /// # Errors
    /// A lock that cannot be made.
    pub(crate) fn wait_for_runs(&self) -> Result<Option<File>> {
        let at = Place::RunsLock.at();
        let file = self.disk.open_lock(&at, false).or_else(|why| {
            self.clear(&at, why)?;
            self.disk.open_lock(&at, false)
        });
        let file = file.map_err(self.writing("make the lock", &at, 0))?;
        Ok(wait_for(self.disk.as_ref(), &file, true, &|| ()).then_some(file))
    }

    /// The record of a key, if there is an undamaged one.
    pub fn record(&self, key: &Key) -> Option<Record> {
        let place = Place::Record(*key);
        let text = self.waiting(&place).or_else(|| self.read_text(&place).ok())?;
        let record = Record::parse(&text)?;
        (record.key == key.to_string()).then_some(record)
    }

    /// Whether there is a file where the record of a key lies.
    pub(crate) fn has_record(&self, key: &Key) -> bool {
        self.disk.length(&Place::Record(*key).at()).is_ok()
    }

    /// The text of a record that still waits for its synchronisation: equal cases share it within one run.
    fn waiting(&self, place: &Place) -> Option<String> {
        let pending = self.pending();
        let found = pending.iter().find(|pending| pending.record == *place);
        found.map(|pending| pending.text.clone())
    }

    /// The bytes of a file of the store.
    ///
    /// # Errors
    /// The operating system's; `InvalidData` for what is no regular file.
    pub(crate) fn read_file(&self, place: &Place) -> io::Result<Vec<u8>> {
        self.disk.read(&place.at())
    }

    /// The same as text.
    ///
    /// # Errors
    /// Those of [`Self::read_file`]; `InvalidData` for bytes that are no text.
    pub(crate) fn read_text(&self, place: &Place) -> io::Result<String> {
        String::from_utf8(self.read_file(place)?).map_err(|why| io::Error::new(ErrorKind::InvalidData, why))
    }

    /// The file of an id, for messages.
    pub(crate) fn path(&self, place: &Place) -> PathBuf {
        self.root().join(place.at().text())
    }

    /// Whether there is a file for an id; its bytes are verified when they are read.
    pub fn has(&self, id: &Id) -> bool {
        self.disk.length(&Place::Object(*id).at()).is_ok()
    }

    /// Whether an object of this id was damaged and set aside.
    pub(crate) fn was_set_aside(&self, id: &Id) -> bool {
        self.disk.length(&Place::Quarantined(id.to_string(), None).at()).is_ok()
    }

    /// Reads and verifies an object; a damaged one is moved to `quarantine/`.
    pub(crate) fn read(&self, id: &Id, schema: Option<u64>) -> Found {
        let found = self.peek(id, schema);
        // An object that is whole as the output of another stage stays where it is: the caller asked for the wrong type.
        if matches!(found, Found::Damaged(_)) && !matches!(self.peek(id, None), Found::Bytes(_)) {
            // A move that fails leaves the damaged file to be overwritten by the healed one.
            let _ = self.set_aside(&Place::Object(*id));
        }
        found
    }

    /// The same, leaving everything where it is.
    pub(crate) fn peek(&self, id: &Id, schema: Option<u64>) -> Found {
        match self.read_file(&Place::Object(*id)) {
            Ok(file) => match object::verify(id, schema, &file) {
                Ok(()) => Found::Bytes(object::payload(file)),
                Err(why) => Found::Damaged(why),
            },
            Err(why) if why.kind() == ErrorKind::NotFound => Found::Missing,
            Err(why) => Found::Damaged(why.to_string()),
        }
    }

    /// Publishes an output: the object first, the record last, both synchronised before they count. The lock on its key
    /// is let go of when they do.
    ///
    /// # Errors
    /// A write that fails; nothing half-written is left.
    pub(crate) fn publish(&self, schema: u64, payload: &[u8], record: &Record, lock: Option<KeyLock>) -> Result<()> {
        let (id, file) = object::seal(schema, payload);
        let key = Key::parse(&record.key).expect("the record of an output that was just made names its key");
        if !record.evicted {
            let place = Place::Object(id);
            // An object that is there with the same bytes is not written again, because another record may rest on it.
            if !self.read_file(&place).is_ok_and(|old| old == file) {
                self.write(&place, &file, false)?;
            }
        }
        let pending = Pending {
            object: (!record.evicted).then_some(id),
            record: Place::Record(key),
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
        queue.len() >= self.shared_pieces || queue.first().is_some_and(|first| first.since.elapsed() >= SHARED_WAIT)
    }

    /// Puts back the file of an object that was lost or damaged.
    pub(crate) fn restore(&self, id: &Id, file: &[u8]) -> Result<()> {
        self.write(&Place::Object(*id), file, true)
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
        let objects: BTreeSet<Id> = waiting.iter().filter_map(|pending| pending.object).collect();
        let objects: Vec<At> = objects.into_iter().map(|id| Place::Object(id).at()).collect();
        for at in &objects {
            if let Err(error) = self.synchronise(at) {
                // After a synchronisation that failed nobody knows what the medium holds, though a read still finds the
                // bytes: the next run must not take them for written.
                let _ = self.disk.remove(at);
                return Err(error);
            }
        }
        self.synchronise_folders(Folder::Objects, &objects)?;
        for pending in &waiting {
            self.write(&pending.record, pending.text.as_bytes(), true)?;
        }
        let records: Vec<At> = waiting.iter().map(|pending| pending.record.at()).collect();
        self.synchronise_folders(Folder::Records, &records)?;
        self.grown.store(false, Ordering::Relaxed);
        // The locks on the keys are let go of now that the records can be read.
        for pending in waiting {
            drop(pending.lock);
        }
        Ok(())
    }

    /// Synchronises the folders that files lie in, and the one above if a folder in it may be new.
    fn synchronise_folders(&self, above: Folder, files: &[At]) -> Result<()> {
        let folders: BTreeSet<At> = files.iter().map(At::parent).collect();
        folders.iter().try_for_each(|folder| self.synchronise(folder))?;
        if self.grown.load(Ordering::Relaxed) {
            self.synchronise(&above.at())?;
        }
        Ok(())
    }

    /// Writes a file by way of a temporary one of its own and a rename.
    ///
    /// # Errors
    /// A write that fails; nothing half-written is left.
    pub(crate) fn write(&self, place: &Place, bytes: &[u8], durable: bool) -> Result<()> {
        let at = place.at();
        let parent = at.parent();
        if parent != At::root() {
            if parent.names().count() > 1 {
                self.make_folder(&parent.parent())?;
            }
            self.make_folder(&parent)?;
        }
        let number = self.numbers.fetch_add(1, Ordering::Relaxed);
        let temporary = Place::Temporary(self.tag, number).at();
        let result = self.write_by(&temporary, &at, bytes, durable);
        if result.is_err() {
            // The error to report is the first one.
            let _ = self.disk.remove(&temporary);
        }
        result
    }

    fn write_by(&self, temporary: &At, at: &At, bytes: &[u8], durable: bool) -> Result<()> {
        let length = bytes.len() as u64;
        let written = self.disk.write_new(temporary, bytes).or_else(|why| match why.kind() {
            // Copies of a store may lack the folders that were empty.
            ErrorKind::NotFound => {
                self.disk.make_folder(&temporary.parent())?;
                self.disk.write_new(temporary, bytes)
            }
            _ => Err(why),
        });
        written.map_err(self.writing("write", at, length))?;
        if durable {
            let synchronised = self.disk.synchronise(temporary);
            synchronised.map_err(self.writing("synchronise", at, length))?;
        }
        let renamed = self.disk.rename(temporary, at).or_else(|why| {
            self.clear(at, why)?;
            self.disk.rename(temporary, at)
        });
        renamed.map_err(self.writing("rename into place", at, length))
    }

    /// Makes a folder of the store, unless it is there.
    fn make_folder(&self, at: &At) -> Result<()> {
        let made = self.disk.make_folder(at).or_else(|why| {
            self.clear(at, why)?;
            self.disk.make_folder(at)
        });
        match made {
            Ok(true) => self.grown.store(true, Ordering::Relaxed),
            Ok(false) => {}
            // A store that may only be read has the folders that it needs.
            Err(why) if is_read_only(&why) && self.disk.list(at).is_ok() => {}
            Err(why) => return Err(self.writing("make the folder", at, 0)(why)),
        }
        Ok(())
    }

    /// After an operation on a path failed, this moves what does not belong at that path to quarantine. If nothing of the
    /// kind is there, it returns the error of the operation. A link in place of a top folder stays, and the error names it.
    fn clear(&self, at: &At, why: io::Error) -> io::Result<()> {
        let listed = self.disk.list(&at.parent())?;
        let name = at.names().next_back().unwrap_or_default();
        let found = listed.iter().find(|entry| entry.name == *name).map(|entry| entry.kind);
        let is_top_folder = Folder::ALL.iter().any(|folder| folder.at() == *at);
        let is_folder = is_top_folder
            || at.names().count() == 2 && Folder::ALL.iter().any(|f| f.division(name).as_ref() == Some(at));
        match found {
            Some(Kind::Link) if !is_top_folder => {}
            Some(Kind::Other) => {}
            Some(Kind::Folder) if !is_folder => {}
            Some(Kind::File) if is_folder => {}
            _ => return Err(why),
        }
        let kept = self.move_aside(at)?;
        let mut put_aside = self.put_aside.lock().unwrap_or_else(PoisonError::into_inner);
        put_aside.push((at.text().to_owned(), self.root().join(kept.text())));
        Ok(())
    }

    /// Moves a damaged file to quarantine; gives where it is now.
    ///
    /// # Errors
    /// The operating system's.
    pub(crate) fn set_aside(&self, place: &Place) -> io::Result<PathBuf> {
        let at = place.at();
        let to = Place::Quarantined(at.flat(), None).at();
        // A store that was only looked at may lack the folder; if it cannot be made, the move says so.
        let _ = self.disk.make_folder(&Folder::Quarantine.at());
        match self.disk.rename(&at, &to) {
            Ok(()) => Ok(self.root().join(to.text())),
            Err(why) if why.kind() == ErrorKind::NotFound => Err(why),
            // What an earlier stranger left under that name stays as well.
            Err(_) => Ok(self.root().join(self.move_aside(&at)?.text())),
        }
    }

    /// Moves whatever it is to a name in quarantine that nothing else has.
    fn move_aside(&self, at: &At) -> io::Result<At> {
        let tag = self.tag.wrapping_add(self.numbers.fetch_add(1, Ordering::Relaxed));
        let to = Place::Quarantined(at.flat(), Some(tag)).at();
        let quarantine = Folder::Quarantine.at();
        if *at == quarantine {
            // It stands where it is to be moved to.
            let between = Place::Temporary(tag, 0).at();
            self.disk.rename(at, &between)?;
            self.disk.make_folder(&quarantine)?;
            self.disk.rename(&between, &to)?;
        } else {
            // If it cannot be made, the move says so.
            let _ = self.disk.make_folder(&quarantine);
            self.disk.rename(at, &to)?;
        }
        Ok(to)
    }

    fn synchronise(&self, at: &At) -> Result<()> {
        let result = self.disk.synchronise(at);
        result.map_err(self.writing("synchronise", at, 0))
    }

    /// The error of a write below this store.
    fn writing(&self, action: &'static str, at: &At, needed: u64) -> impl FnOnce(io::Error) -> Error + use<> {
        Error::writing(action, self.root().join(at.text()), needed)
    }

    fn pending(&self) -> MutexGuard<'_, Vec<Pending>> {
        self.pending.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// How many pieces may share a synchronisation, so that their locks leave room for other open files.
#[cfg(unix)]
fn shared_pieces() -> usize {
    let limit = rustix::process::getrlimit(rustix::process::Resource::Nofile).current;
    let room = limit.map_or(u64::MAX, |limit| limit.saturating_sub(OTHER_FILES) / 2);
    room.clamp(1, SHARED_PIECES as u64) as usize
}

#[cfg(not(unix))]
fn shared_pieces() -> usize {
    SHARED_PIECES
}

/// Whether an error says that the process has as many files open as it may.
fn is_out_of_files(why: &io::Error) -> bool {
    const EMFILE: i32 = 24;
    const ENFILE: i32 = 23;
    cfg!(unix) && matches!(why.raw_os_error(), Some(EMFILE | ENFILE))
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
