//! The folder of a sequence, held by one process at a time, and the files in it.
//!
//! The folder may come from a stranger. Its files are opened by their plain names, never through a link, and only if they
//! are regular files of a bounded size, so that neither a FIFO nor an endless device can hold a call up. A file is
//! written under a new name of its own and then renamed, so nothing that stands at its place is ever written through.

use crate::refusal::{Refusal, failed, refusal};
use std::ffi::OsStr;
use std::fs::{self, File, FileType, OpenOptions, TryLockError};
use std::io::{self, ErrorKind, Read, Write};
use std::path::{Path, PathBuf};

/// The names of temporary files begin and end so; between them stand `RANDOM` letters and digits.
const PREFIX: &str = ".ask_tell-";
const SUFFIX: &str = ".tmp";
const RANDOM: usize = 12;

/// A folder that no other call may touch while this value lives.
pub(crate) struct Folder {
    path: PathBuf,
    _lock: File,
}

impl Folder {
    /// Waits until no other call holds the folder, then holds it and removes what killed calls have left.
    pub(crate) fn hold(path: &Path) -> Result<Self, Refusal> {
        // The folder itself is locked, not a file in it: no file has to be created, and none can be a link.
        let lock = open_folder(path).map_err(|why| failed(path, "the folder of a sequence", &why))?;
        let locked = match lock.try_lock() {
            Ok(()) => Ok(()),
            Err(TryLockError::Error(why)) => Err(why),
            Err(TryLockError::WouldBlock) => {
                let _ = writeln!(io::stderr(), "waiting for another call that holds the folder");
                lock.lock()
            }
        };
        locked.map_err(|why| failed(path, "a lock on the folder", &why))?;
        let folder = Self {
            path: path.to_owned(),
            _lock: lock,
        };
        folder
            .sweep()
            .map_err(|why| failed(path, "a folder that can be listed", &why))?;
        Ok(folder)
    }

    pub(crate) fn place(&self, name: &str) -> PathBuf {
        self.path.join(name)
    }

    /// Whether the folder holds a file of this name; anything else of this name is refused.
    pub(crate) fn holds(&self, name: &str) -> Result<bool, Refusal> {
        let path = self.place(name);
        match fs::symlink_metadata(&path) {
            Ok(metadata) if metadata.is_file() => Ok(true),
            Ok(metadata) => {
                let next = "move it away and call again";
                Err(refusal(
                    path.display(),
                    "a regular file",
                    kind(metadata.file_type()),
                    next,
                ))
            }
            Err(why) if why.kind() == ErrorKind::NotFound => Ok(false),
            Err(why) => Err(failed(&path, "a regular file", &why)),
        }
    }

    /// A file of the folder, of at most so many bytes.
    pub(crate) fn read(&self, name: &str, most: u64) -> Result<Vec<u8>, Refusal> {
        let path = self.place(name);
        if !self.holds(name)? {
            return Err(failed(&path, "a regular file", &ErrorKind::NotFound.into()));
        }
        read(&path, open(&path, false), most)
    }

    /// Replaces a file in one step: after a crash it is the old one or the new one, whole.
    pub(crate) fn write(&self, name: &str, text: &str) -> Result<(), Refusal> {
        self.holds(name)?;
        let path = self.place(name);
        let written = || -> io::Result<()> {
            let mut file = self.temporary()?;
            file.write_all(text.as_bytes())?;
            file.as_file().sync_all()?;
            file.persist(&path)?;
            sync(&self.path)
        };
        written().map_err(|why| failed(&path, "to write it", &why))
    }

    /// A new file; its mode follows the umask, as that of any other file, and not the caution of temporary files.
    fn temporary(&self) -> io::Result<tempfile::NamedTempFile> {
        let mut builder = tempfile::Builder::new();
        builder.prefix(PREFIX).suffix(SUFFIX).rand_bytes(RANDOM);
        #[cfg(unix)]
        builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
        builder.tempfile_in(&self.path)
    }

    /// Removes the temporary files of calls that were killed: no other call writes while the folder is held.
    fn sweep(&self) -> io::Result<()> {
        for entry in fs::read_dir(&self.path)? {
            let entry = entry?;
            if is_temporary(&entry.file_name()) && entry.file_type()?.is_file() {
                fs::remove_file(entry.path())?;
            }
        }
        Ok(())
    }
}

/// A regular file that the user names, which may be a link to one, of at most so many bytes.
pub(crate) fn read_named(path: &Path, most: u64) -> Result<Vec<u8>, Refusal> {
    read(path, open(path, true), most)
}

fn read(path: &Path, file: io::Result<File>, most: u64) -> Result<Vec<u8>, Refusal> {
    let file = file.map_err(|why| failed(path, "a regular file", &why))?;
    let metadata = file.metadata().map_err(|why| failed(path, "a regular file", &why))?;
    if !metadata.is_file() {
        return Err(refusal(
            path.display(),
            "a regular file",
            kind(metadata.file_type()),
            "check the path and call again",
        ));
    }
    let mut bytes = Vec::new();
    if metadata.len() <= most {
        // The file may grow while it is read.
        let read = file.take(most + 1).read_to_end(&mut bytes);
        read.map_err(|why| failed(path, "a file that can be read", &why))?;
    }
    if metadata.len().max(bytes.len() as u64) > most {
        let expected = format!("at most {most} bytes, which is far more than such a file needs");
        return Err(refusal(path.display(), expected, "more", "check the path and the file"));
    }
    Ok(bytes)
}

fn is_temporary(name: &OsStr) -> bool {
    let name = name
        .to_str()
        .and_then(|name| name.strip_prefix(PREFIX)?.strip_suffix(SUFFIX));
    name.is_some_and(|random| random.len() == RANDOM && random.bytes().all(|b| b.is_ascii_alphanumeric()))
}

fn kind(of: FileType) -> &'static str {
    if of.is_symlink() {
        "a link"
    } else if of.is_dir() {
        "a folder"
    } else if of.is_file() {
        "a file"
    } else {
        "a pipe, socket or device"
    }
}

/// Opens for reading; without O_NONBLOCK, opening a FIFO would wait for a writer that may never come.
#[cfg(unix)]
fn open(path: &Path, through_links: bool) -> io::Result<File> {
    use rustix::fs::OFlags;
    let follow = if through_links {
        OFlags::empty()
    } else {
        OFlags::NOFOLLOW
    };
    with_flags(path, OFlags::NONBLOCK | follow)
}

#[cfg(unix)]
fn open_folder(path: &Path) -> io::Result<File> {
    with_flags(path, rustix::fs::OFlags::DIRECTORY)
}

#[cfg(unix)]
fn with_flags(path: &Path, flags: rustix::fs::OFlags) -> io::Result<File> {
    use std::os::unix::fs::OpenOptionsExt;
    OpenOptions::new()
        .read(true)
        .custom_flags(flags.bits().cast_signed())
        .open(path)
}

#[cfg(not(unix))]
fn open(path: &Path, _through_links: bool) -> io::Result<File> {
    OpenOptions::new().read(true).open(path)
}

#[cfg(not(unix))]
fn open_folder(path: &Path) -> io::Result<File> {
    OpenOptions::new().read(true).open(path)
}

/// A rename is on disk once its folder is.
fn sync(folder: &Path) -> io::Result<()> {
    open_folder(folder)?.sync_all()
}
