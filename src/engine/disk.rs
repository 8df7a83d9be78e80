//! Disk: the few file operations that the store is made of, behind a trait, so that a test can let any of them fail, count
//! them, or take a file system's locks away. Tested in `tests/reliability`.

use std::fs::{self, File, OpenOptions, TryLockError};
use std::io::{self, Read};
use std::path::{Path, PathBuf};
use std::time::SystemTime;

use crate::engine::codec::LIMIT;
use crate::engine::error::{Error, Result};

/// The file operations of the store.
pub trait Disk: Send + Sync {
    /// All bytes of a file.
    ///
    /// # Errors
    /// The operating system's.
    fn read(&self, path: &Path) -> io::Result<Vec<u8>>;

    /// Makes a file, or empties the one that is there, and writes all its bytes.
    ///
    /// # Errors
    /// The operating system's; part of the bytes may have been written.
    fn write(&self, path: &Path, bytes: &[u8]) -> io::Result<()>;

    /// Returns when the content of a file, or the entries of a folder, would survive a power cut.
    ///
    /// # Errors
    /// The operating system's.
    fn synchronise(&self, path: &Path) -> io::Result<()>;

    /// Moves a file over another, at once.
    ///
    /// # Errors
    /// The operating system's.
    fn rename(&self, from: &Path, to: &Path) -> io::Result<()>;

    /// Makes a folder and those above it.
    ///
    /// # Errors
    /// The operating system's.
    fn make_folder(&self, path: &Path) -> io::Result<()>;

    /// Removes a file.
    ///
    /// # Errors
    /// The operating system's.
    fn remove(&self, path: &Path) -> io::Result<()>;

    /// Opens a file to be locked; makes it unless `existing`, which needs no right to write.
    ///
    /// # Errors
    /// The operating system's.
    fn open_lock(&self, path: &Path, existing: bool) -> io::Result<File>;

    /// Locks an open file if nobody is in the way; the kernel frees the lock when the file is closed or its holder dies.
    ///
    /// # Errors
    /// Somebody is in the way, or the file system has no locks.
    fn try_lock(&self, file: &File, exclusive: bool) -> std::result::Result<(), TryLockError>;
}

/// All bytes of a regular file no longer than an object may be: a pipe in a store is not waited for, a huge file not held.
///
/// # Errors
/// The operating system's; `InvalidData` for what is no regular file, or is too long.
pub(crate) fn read_regular(path: &Path) -> io::Result<Vec<u8>> {
    let length = regular(path)?;
    if length > LONGEST_FILE {
        let why = format!("its {length} bytes are more than an object may have");
        return Err(io::Error::new(io::ErrorKind::InvalidData, why));
    }
    fs::read(path)
}

/// The length of a regular file.
///
/// # Errors
/// The operating system's; `InvalidData` for what is no regular file: to open a pipe is to wait for its other end.
pub(crate) fn regular(path: &Path) -> io::Result<u64> {
    let found = fs::metadata(path)?;
    if found.is_file() {
        return Ok(found.len());
    }
    Err(io::Error::new(io::ErrorKind::InvalidData, "it is no regular file"))
}

/// The same as text.
///
/// # Errors
/// Those of [`read_regular`]; bytes that are no text.
pub(crate) fn read_text(path: &Path) -> io::Result<String> {
    String::from_utf8(read_regular(path)?).map_err(|why| io::Error::new(io::ErrorKind::InvalidData, why))
}

/// The text of a file that need not be a regular one (a shell hands over a pipe for `<(command)`), as long as it ends.
///
/// # Errors
/// The operating system's; `InvalidData` for bytes that are no text or too many.
pub(crate) fn read_stream(path: &Path) -> io::Result<String> {
    let mut text = String::new();
    File::open(path)?.take(LONGEST_TEXT + 1).read_to_string(&mut text)?;
    if text.len() as u64 > LONGEST_TEXT {
        let why = format!("more than {LONGEST_TEXT} bytes");
        return Err(io::Error::new(io::ErrorKind::InvalidData, why));
    }
    Ok(text)
}

/// A file that was found in a folder.
pub(crate) struct Listed {
    pub(crate) path: PathBuf,
    pub(crate) bytes: u64,
    pub(crate) modified: SystemTime,
}

/// Every file below a folder, sorted; none if there is no such folder.
///
/// # Errors
/// A folder that cannot be read: what lies in it is not known.
pub(crate) fn files_in(folder: &Path) -> Result<Vec<Listed>> {
    let mut listed = Vec::new();
    let entries = match fs::read_dir(folder) {
        Err(why) if why.kind() == io::ErrorKind::NotFound => return Ok(listed),
        entries => entries.map_err(Error::io("read the folder", folder))?,
    };
    for entry in entries {
        let entry = entry.map_err(Error::io("read the folder", folder))?;
        let path = entry.path();
        match entry.metadata() {
            Ok(found) if found.is_dir() => listed.extend(files_in(&path)?),
            Ok(found) => {
                let (bytes, modified) = (found.len(), found.modified().unwrap_or(SystemTime::UNIX_EPOCH));
                listed.push(Listed { path, bytes, modified });
            }
            // Gone since it was listed: a run that works meanwhile.
            Err(why) if why.kind() == io::ErrorKind::NotFound => {}
            Err(why) => return Err(Error::io("look at", path)(why)),
        }
    }
    listed.sort_by(|a, b| a.path.cmp(&b.path));
    Ok(listed)
}

/// Bytes of the longest file that belongs to a store.
const LONGEST_FILE: u64 = LIMIT as u64 + 64;

/// Bytes of the longest text that a reader writes.
const LONGEST_TEXT: u64 = 16 << 20;

/// The operating system's own.
pub struct System;

impl Disk for System {
    fn read(&self, path: &Path) -> io::Result<Vec<u8>> {
        read_regular(path)
    }

    fn write(&self, path: &Path, bytes: &[u8]) -> io::Result<()> {
        fs::write(path, bytes)
    }

    fn synchronise(&self, path: &Path) -> io::Result<()> {
        File::open(path)?.sync_all()
    }

    fn rename(&self, from: &Path, to: &Path) -> io::Result<()> {
        fs::rename(from, to)
    }

    fn make_folder(&self, path: &Path) -> io::Result<()> {
        fs::create_dir_all(path)
    }

    fn remove(&self, path: &Path) -> io::Result<()> {
        fs::remove_file(path)
    }

    fn open_lock(&self, path: &Path, existing: bool) -> io::Result<File> {
        match regular(path) {
            Err(why) if why.kind() == io::ErrorKind::InvalidData => return Err(why),
            _ if existing => return File::open(path),
            _ => {}
        }
        OpenOptions::new().write(true).create(true).truncate(false).open(path)
    }

    fn try_lock(&self, file: &File, exclusive: bool) -> std::result::Result<(), TryLockError> {
        if exclusive {
            file.try_lock()
        } else {
            file.try_lock_shared()
        }
    }
}
