//! A disk that tells of every operation before it is done, and lets whoever hears of it forbid it.

use crate::common::Wrap;
use encounter::engine::disk::{Disk, Entry};
use encounter::engine::names::At;
use std::fs::{File, TryLockError};
use std::io;
use std::path::Path;
use std::sync::Arc;

/// What the store asks of its disk.
#[derive(Clone, Copy)]
pub(super) enum Deed<'a> {
    Write(&'a At, &'a [u8]),
    Synchronise(&'a At),
    Rename(&'a At, &'a At),
    TryLock,
    Read(&'a At),
    /// Looking, making folders, removing, opening locks.
    Other,
}

/// A disk, watched: whoever hears of an operation gets the disk itself, too.
pub(super) struct Watched<F> {
    disk: Arc<dyn Disk>,
    hear: F,
}

/// What makes a watched disk of another.
pub(super) fn watched<F>(hear: F) -> Wrap
where
    F: Fn(&dyn Disk, Deed<'_>) -> io::Result<()> + Clone + Send + Sync + 'static,
{
    Box::new(move |disk| {
        let hear = hear.clone();
        Arc::new(Watched { disk, hear })
    })
}

impl<F: Fn(&dyn Disk, Deed<'_>) -> io::Result<()> + Send + Sync> Watched<F> {
    fn tell(&self, deed: Deed<'_>) -> io::Result<()> {
        (self.hear)(self.disk.as_ref(), deed)
    }
}

impl<F: Fn(&dyn Disk, Deed<'_>) -> io::Result<()> + Send + Sync> Disk for Watched<F> {
    fn root(&self) -> &Path {
        self.disk.root()
    }
    fn read(&self, at: &At) -> io::Result<Vec<u8>> {
        self.tell(Deed::Read(at))?;
        self.disk.read(at)
    }
    fn length(&self, at: &At) -> io::Result<u64> {
        self.tell(Deed::Other)?;
        self.disk.length(at)
    }
    fn write_new(&self, at: &At, bytes: &[u8]) -> io::Result<()> {
        self.tell(Deed::Write(at, bytes))?;
        self.disk.write_new(at, bytes)
    }
    fn synchronise(&self, at: &At) -> io::Result<()> {
        self.tell(Deed::Synchronise(at))?;
        self.disk.synchronise(at)
    }
    fn rename(&self, from: &At, to: &At) -> io::Result<()> {
        self.tell(Deed::Rename(from, to))?;
        self.disk.rename(from, to)
    }
    fn make_folder(&self, at: &At) -> io::Result<bool> {
        self.tell(Deed::Other)?;
        self.disk.make_folder(at)
    }
    fn remove(&self, at: &At) -> io::Result<()> {
        self.tell(Deed::Other)?;
        self.disk.remove(at)
    }
    fn list(&self, folder: &At) -> io::Result<Vec<Entry>> {
        self.tell(Deed::Other)?;
        self.disk.list(folder)
    }
    fn open_lock(&self, at: &At, existing: bool) -> io::Result<File> {
        self.tell(Deed::Other)?;
        self.disk.open_lock(at, existing)
    }
    fn try_lock(&self, file: &File, exclusive: bool) -> Result<(), TryLockError> {
        self.tell(Deed::TryLock).map_err(TryLockError::Error)?;
        self.disk.try_lock(file, exclusive)
    }
}
