//! A disk that tells of every operation before it is done, and lets whoever hears of it forbid it.

use encounter::engine::disk::{Disk, System};
use std::fs::{File, TryLockError};
use std::io;
use std::path::Path;

/// What the store asks of its disk.
#[derive(Clone, Copy)]
pub(super) enum Deed<'a> {
    Write(&'a Path, &'a [u8]),
    Synchronise(&'a Path),
    Rename(&'a Path, &'a Path),
    TryLock,
    /// Reading, making folders, removing, opening locks.
    Other,
}

/// The operating system's disk, watched.
pub(super) struct Watched<F>(pub(super) F);

impl<F: Fn(Deed<'_>) -> io::Result<()> + Send + Sync> Disk for Watched<F> {
    fn read(&self, path: &Path) -> io::Result<Vec<u8>> {
        (self.0)(Deed::Other)?;
        System.read(path)
    }
    fn write(&self, path: &Path, bytes: &[u8]) -> io::Result<()> {
        (self.0)(Deed::Write(path, bytes))?;
        System.write(path, bytes)
    }
    fn synchronise(&self, path: &Path) -> io::Result<()> {
        (self.0)(Deed::Synchronise(path))?;
        System.synchronise(path)
    }
    fn rename(&self, from: &Path, to: &Path) -> io::Result<()> {
        (self.0)(Deed::Rename(from, to))?;
        System.rename(from, to)
    }
    fn make_folder(&self, path: &Path) -> io::Result<()> {
        (self.0)(Deed::Other)?;
        System.make_folder(path)
    }
    fn remove(&self, path: &Path) -> io::Result<()> {
        (self.0)(Deed::Other)?;
        System.remove(path)
    }
    fn open_lock(&self, path: &Path, existing: bool) -> io::Result<File> {
        (self.0)(Deed::Other)?;
        System.open_lock(path, existing)
    }
    fn try_lock(&self, file: &File, exclusive: bool) -> Result<(), TryLockError> {
        (self.0)(Deed::TryLock).map_err(TryLockError::Error)?;
        System.try_lock(file, exclusive)
    }
}
