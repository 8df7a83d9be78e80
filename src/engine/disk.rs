//! Disk: the few file operations that the store is made of, behind a trait, so that a test can let any of them fail, count
//! them, or take a file system's locks away. Tested in `tests/reliability`.
//!
//! A store may come from a stranger. So every path is opened name by name below the store's root and no link is followed on
//! the way ([`cap_std`] opens a name relative to an open folder); only a regular file is read, and no more of it than an
//! object may hold; a file is only ever made, never written over, so that nothing is written through a link.

use std::ffi::OsString;
use std::fs::{self, File, TryLockError};
use std::io::{self, ErrorKind, Read, Write};
use std::path::{Path, PathBuf};
use std::time::SystemTime;

use cap_fs_ext::{DirExt, FollowSymlinks, OpenOptionsFollowExt, OpenOptionsMaybeDirExt, OpenOptionsSyncExt};
use cap_std::ambient_authority;
use cap_std::fs::{Dir, Metadata, OpenOptions};

use crate::engine::codec::LIMIT;
use crate::engine::names::At;

/// The file operations of a store. None of them follows a link.
pub trait Disk: Send + Sync {
    /// The store's folder, for messages.
    fn root(&self) -> &Path;

    /// All bytes of a regular file.
    ///
    /// # Errors
    /// The operating system's; `InvalidData` for what is no regular file, or is longer than an object may be.
    fn read(&self, at: &At) -> io::Result<Vec<u8>>;

    /// The length of a regular file.
    ///
    /// # Errors
    /// The operating system's; `InvalidData` for what is no regular file.
    fn length(&self, at: &At) -> io::Result<u64>;

    /// Makes a file that is not there yet and writes all its bytes.
    ///
    /// # Errors
    /// The operating system's; part of the bytes may have been written.
    fn write_new(&self, at: &At, bytes: &[u8]) -> io::Result<()>;

    /// Returns when the content of a file, or the entries of a folder, would survive a power cut.
    ///
    /// # Errors
    /// The operating system's.
    fn synchronise(&self, at: &At) -> io::Result<()>;

    /// Moves a file over another, at once.
    ///
    /// # Errors
    /// The operating system's.
    fn rename(&self, from: &At, to: &At) -> io::Result<()>;

    /// Makes a folder in one that is there; whether it is new.
    ///
    /// # Errors
    /// The operating system's; `InvalidData` for something else than a folder in its place.
    fn make_folder(&self, at: &At) -> io::Result<bool>;

    /// Removes a file.
    ///
    /// # Errors
    /// The operating system's.
    fn remove(&self, at: &At) -> io::Result<()>;

    /// What a folder holds, in no order.
    ///
    /// # Errors
    /// The operating system's.
    fn list(&self, folder: &At) -> io::Result<Vec<Entry>>;

    /// Opens a file to be locked, never to be written; makes it unless `existing`.
    ///
    /// # Errors
    /// The operating system's; `InvalidData` for what is no regular file.
    fn open_lock(&self, at: &At, existing: bool) -> io::Result<File>;

    /// Locks an open file if nobody is in the way; the kernel frees the lock when the file is closed or its holder dies.
    ///
    /// # Errors
    /// Somebody is in the way, or the file system has no locks.
    fn try_lock(&self, file: &File, exclusive: bool) -> std::result::Result<(), TryLockError>;
}

/// What a folder holds under one name.
#[derive(Clone, Debug)]
pub struct Entry {
    /// The name.
    pub name: OsString,
    /// Its length, bytes.
    pub bytes: u64,
    /// When its content was last written.
    pub modified: SystemTime,
    /// What it is.
    pub kind: Kind,
}

/// What is found under a name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// A regular file.
    File,
    /// A folder.
    Folder,
    /// A link.
    Link,
    /// A pipe, a socket or a device.
    Other,
}

/// Whether an error says that a store must not be written to, though it may be read.
pub(crate) fn is_read_only(why: &io::Error) -> bool {
    matches!(why.kind(), ErrorKind::ReadOnlyFilesystem | ErrorKind::PermissionDenied)
}

/// The operating system's own, below one folder.
pub struct System {
    root: PathBuf,
    /// None where there is no such folder, which is as good as an empty one.
    folder: Option<Dir>,
}

impl System {
    /// The folder, which the user named and which may be reached by links.
    ///
    /// # Errors
    /// The operating system's, for a folder that is there but cannot be opened.
    pub fn look(root: &Path) -> io::Result<Self> {
        let folder = match Dir::open_ambient_dir(root, ambient_authority()) {
            Err(why) if why.kind() == ErrorKind::NotFound => None,
            folder => Some(folder?),
        };
        let root = root.to_owned();
        Ok(Self { root, folder })
    }

    /// The same, made with the folders above it where it is missing.
    ///
    /// # Errors
    /// The operating system's.
    pub fn make(root: &Path) -> io::Result<Self> {
        if !root.is_dir() {
            fs::create_dir_all(root)?;
        }
        Self::look(root)
    }

    /// A folder that holds nothing, whatever there is.
    pub(crate) fn nowhere(root: &Path) -> Self {
        let (root, folder) = (root.to_owned(), None);
        Self { root, folder }
    }

    fn folder(&self) -> io::Result<&Dir> {
        self.folder.as_ref().ok_or_else(|| ErrorKind::NotFound.into())
    }

    /// Opens a folder name by name.
    fn open_folder(&self, at: &At) -> io::Result<Dir> {
        let mut folder = self.folder()?.try_clone()?;
        for name in at.names() {
            folder = folder.open_dir_nofollow(name).map_err(|why| link(&folder, name, why))?;
        }
        Ok(folder)
    }

    /// Opens the folder of a file, and calls it with the file's own name.
    fn within<T>(&self, at: &At, act: impl FnOnce(&Dir, &str) -> io::Result<T>) -> io::Result<T> {
        let mut names = at.names();
        let last = names.next_back().ok_or(ErrorKind::InvalidInput)?;
        let Some(first) = names.next() else {
            return act(self.folder()?, last);
        };
        let above = self.folder()?;
        let mut folder = above.open_dir_nofollow(first).map_err(|why| link(above, first, why))?;
        for name in names {
            folder = folder.open_dir_nofollow(name).map_err(|why| link(&folder, name, why))?;
        }
        act(&folder, last)
    }

    /// Opens a file, which is a regular one.
    fn open(&self, at: &At, options: &OpenOptions) -> io::Result<cap_std::fs::File> {
        let mut options = options.clone();
        // To open a pipe must not be to wait for its other end.
        options.follow(FollowSymlinks::No).nonblock(true);
        self.within(at, |folder, name| {
            let file = folder
                .open_with(name, &options)
                .map_err(|why| link(folder, name, why))?;
            if file.metadata()?.is_file() {
                return Ok(file);
            }
            Err(io::Error::new(ErrorKind::InvalidData, NOT_REGULAR))
        })
    }
}

const NOT_REGULAR: &str = "it is no regular file";

fn kind(found: &Metadata) -> Kind {
    if found.is_file() {
        Kind::File
    } else if found.is_dir() {
        Kind::Folder
    } else if found.is_symlink() {
        Kind::Link
    } else {
        Kind::Other
    }
}

/// The error of a name that could not be opened: that it is a link says more than what the system makes of it.
fn link(folder: &Dir, name: &str, why: io::Error) -> io::Error {
    match folder.symlink_metadata(name) {
        Ok(found) if found.is_symlink() => io::Error::new(
            ErrorKind::InvalidData,
            format!("`{name}` is a link, and a store holds none: put in its place what it leads to, or remove it"),
        ),
        Ok(found) if !found.is_dir() && !found.is_file() => io::Error::new(ErrorKind::InvalidData, NOT_REGULAR),
        _ => why,
    }
}

impl Disk for System {
    fn root(&self) -> &Path {
        &self.root
    }

    fn read(&self, at: &At) -> io::Result<Vec<u8>> {
        let file = self.open(at, OpenOptions::new().read(true))?;
        let length = file.metadata()?.len();
        read_bounded(file, length)
    }

    fn length(&self, at: &At) -> io::Result<u64> {
        self.within(at, |folder, name| {
            let found = folder.symlink_metadata(name)?;
            if found.is_file() {
                return Ok(found.len());
            }
            Err(io::Error::new(ErrorKind::InvalidData, NOT_REGULAR))
        })
    }

    fn write_new(&self, at: &At, bytes: &[u8]) -> io::Result<()> {
        let mut file = self.open(at, OpenOptions::new().write(true).create_new(true))?;
        file.write_all(bytes)
    }

    fn synchronise(&self, at: &At) -> io::Result<()> {
        let mut options = OpenOptions::new();
        options
            .read(true)
            .maybe_dir(true)
            .nonblock(true)
            .follow(FollowSymlinks::No);
        if at.names().next().is_none() {
            return self.folder()?.open_with(".", &options)?.sync_all();
        }
        self.within(at, |folder, name| folder.open_with(name, &options)?.sync_all())
    }

    fn rename(&self, from: &At, to: &At) -> io::Result<()> {
        self.within(from, |source, old| {
            self.within(to, |target, new| source.rename(old, target, new))
        })
    }

    fn make_folder(&self, at: &At) -> io::Result<bool> {
        self.within(at, |folder, name| match folder.create_dir(name) {
            Err(why) if why.kind() == ErrorKind::AlreadyExists => {
                let opened = folder.open_dir_nofollow(name).map_err(|why| link(folder, name, why));
                opened.map(|_| false).map_err(|why| match why.kind() {
                    // A link says what it is.
                    _ if folder.symlink_metadata(name).is_ok_and(|found| found.is_symlink()) => why,
                    ErrorKind::NotADirectory | ErrorKind::InvalidData => io::Error::new(
                        ErrorKind::InvalidData,
                        format!("expected a folder, found something else: move `{name}` away and run again"),
                    ),
                    _ => why,
                })
            }
            made => made.map(|()| true),
        })
    }

    fn remove(&self, at: &At) -> io::Result<()> {
        self.within(at, |folder, name| folder.remove_file(name))
    }

    fn list(&self, folder: &At) -> io::Result<Vec<Entry>> {
        let mut listed = Vec::new();
        for entry in self.open_folder(folder)?.entries()? {
            let entry = entry?;
            match entry.metadata() {
                Ok(found) => listed.push(Entry {
                    name: entry.file_name(),
                    bytes: found.len(),
                    modified: found
                        .modified()
                        .map_or(SystemTime::UNIX_EPOCH, cap_std::time::SystemTime::into_std),
                    kind: kind(&found),
                }),
                // It has gone since it was listed: a run works meanwhile.
                Err(why) if why.kind() == ErrorKind::NotFound => {}
                Err(why) => return Err(why),
            }
        }
        Ok(listed)
    }

    fn open_lock(&self, at: &At, existing: bool) -> io::Result<File> {
        // Network file systems grant a shared lock only to who may read, and one held alone only to who may write.
        let mut options = OpenOptions::new();
        options.read(true).write(true);
        let made = match self.open(at, &options) {
            Err(why) if why.kind() == ErrorKind::NotFound && !existing => {
                match self.open(at, options.clone().create_new(true)) {
                    // Somebody else was faster.
                    Err(why) if why.kind() == ErrorKind::AlreadyExists => self.open(at, &options),
                    made => made,
                }
            }
            Err(why) if is_read_only(&why) => self.open(at, OpenOptions::new().read(true)),
            opened => opened,
        };
        made.map(cap_std::fs::File::into_std)
    }

    fn try_lock(&self, file: &File, exclusive: bool) -> std::result::Result<(), TryLockError> {
        if exclusive {
            file.try_lock()
        } else {
            file.try_lock_shared()
        }
    }
}

/// All bytes of a file that is as long as it says; the file may grow while it is read.
fn read_bounded(file: impl Read, length: u64) -> io::Result<Vec<u8>> {
    let too_long = |length: u64| {
        let why = format!("its {length} bytes are more than an object may have");
        Err(io::Error::new(ErrorKind::InvalidData, why))
    };
    if length > LONGEST_FILE {
        return too_long(length);
    }
    let mut bytes = Vec::with_capacity(length as usize + 1);
    file.take(LONGEST_FILE + 1).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > LONGEST_FILE {
        return too_long(bytes.len() as u64);
    }
    Ok(bytes)
}

/// All bytes of a regular file of the user's, no longer than an object may be.
///
/// # Errors
/// The operating system's; `InvalidData` for what is no regular file, or is too long.
pub(crate) fn read_regular(path: &Path) -> io::Result<Vec<u8>> {
    let found = fs::metadata(path)?;
    // To open a pipe would be to wait for its other end.
    if !found.is_file() {
        return Err(io::Error::new(ErrorKind::InvalidData, NOT_REGULAR));
    }
    read_bounded(File::open(path)?, found.len())
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

/// Bytes of the longest file that belongs to a store.
const LONGEST_FILE: u64 = LIMIT as u64 + 64;

/// Bytes of the longest text that a reader writes.
const LONGEST_TEXT: u64 = 16 << 20;
