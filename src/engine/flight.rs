//! Flight: who makes what, so that each key is made once. Within a process a set of keys says so, between processes a
//! lock that the kernel holds on `locks/KEY` and frees when its holder dies: there is nothing to unlock after a crash.
//!
//! A lock is never what correctness rests on. Where a file system has none, two runs may make the same thing twice; what
//! they publish is whole either way, since a rename publishes.

use std::collections::BTreeSet;
use std::fs::{File, TryLockError};
use std::io;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use crate::engine::disk::Disk;
use crate::engine::id::Key;
use crate::engine::names::Place;

/// The keys that are being made.
pub(crate) struct Flight {
    disk: Arc<dyn Disk>,
    held: Arc<Held>,
    without_locks: AtomicBool,
}

#[derive(Default)]
struct Held(Mutex<BTreeSet<Key>>);

/// Whether a key is ours to make.
pub(crate) enum Hold {
    /// Nobody else makes it while this is held.
    Ours(KeyLock),
    /// Another worker of this process makes it.
    InThisProcess,
    /// Another process makes it.
    Elsewhere,
}

/// A key that is ours to make, until dropped.
pub(crate) struct KeyLock {
    key: Key,
    /// None where the file system has no locks.
    file: Option<File>,
    held: Arc<Held>,
}

impl Flight {
    pub(crate) fn new(disk: Arc<dyn Disk>) -> Self {
        Self {
            disk,
            held: Arc::default(),
            without_locks: AtomicBool::new(false),
        }
    }

    /// Takes note that the file system has no locks.
    pub(crate) fn go_without_locks(&self) {
        self.without_locks.store(true, Ordering::Relaxed);
    }

    /// Whether a lock was asked for that the file system could not give.
    pub(crate) fn is_without_locks(&self) -> bool {
        self.without_locks.load(Ordering::Relaxed)
    }

    /// Takes a key, if nobody else has it; never waits.
    ///
    /// # Errors
    /// A lock file that cannot be made.
    pub(crate) fn hold(&self, key: &Key) -> io::Result<Hold> {
        if !self.held.keys().insert(*key) {
            return Ok(Hold::InThisProcess);
        }
        let mut lock = KeyLock {
            key: *key,
            file: None,
            held: Arc::clone(&self.held),
        };
        let file = self.disk.open_lock(&Place::KeyLock(*key).at(), false)?;
        match self.disk.try_lock(&file, true) {
            Ok(()) => lock.file = Some(file),
            Err(TryLockError::WouldBlock) => return Ok(Hold::Elsewhere),
            Err(TryLockError::Error(_)) => self.without_locks.store(true, Ordering::Relaxed),
        }
        Ok(Hold::Ours(lock))
    }
}

impl Held {
    fn keys(&self) -> MutexGuard<'_, BTreeSet<Key>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Drop for KeyLock {
    fn drop(&mut self) {
        // The file lock is released before the key is free in this process. Otherwise another thread would see the key as
        // free here while the file still says that somebody holds it.
        self.file.take();
        self.held.keys().remove(&self.key);
    }
}
