//! Figures: the file operations of folders that hold published files. Nothing is written through a link, nothing but a
//! regular file is opened, and only what is provably ours is removed.
//!
//! Tested in `tests/cache/publish.rs` and `tests/cli/figures.rs`.

use std::fs::{self, File, OpenOptions};
use std::io::{self, ErrorKind, Read, Write};
use std::path::{Path, PathBuf};

use tempfile::{Builder, NamedTempFile};

use crate::engine::error::{Error, Result};

/// The endings of published files.
pub const EXTENSIONS: [&str; 5] = ["svg", "csv", "md", "tex", "html"];

/// Bytes of the longest published file.
const LONGEST: u64 = 1 << 30;

const HEAD: &str = ".encounter-";
const TAIL: &str = ".tmp";
const DIGITS: usize = 16;

/// Whether a name is one component that is no more than a name on every file system.
pub(crate) fn is_plain(name: &str) -> bool {
    let is_allowed = |c: char| c.is_ascii_alphanumeric() || matches!(c, '_' | '-' | '.');
    !name.is_empty() && name.len() <= 128 && !name.starts_with('.') && name.chars().all(is_allowed)
}

/// Whether a stage may publish a file of this name: its own name, or one that begins with it and `_`, and a known ending.
pub(crate) fn may_publish(stage: &str, name: &str) -> bool {
    let Some((stem, extension)) = name.rsplit_once('.') else {
        return false;
    };
    let is_own = stem
        .strip_prefix(stage)
        .is_some_and(|rest| rest.is_empty() || rest.starts_with('_'));
    is_plain(name) && !stem.contains('.') && is_own && EXTENSIONS.contains(&extension)
}

/// The parts of a path within a figures folder: at most one folder and a name, each plain.
pub(crate) fn parts(path: &str) -> Option<(&str, &str)> {
    let (folder, name) = path.rsplit_once('/').unwrap_or(("", path));
    ((folder.is_empty() || is_plain(folder)) && is_plain(name)).then_some((folder, name))
}

/// Opens a regular file for reading, following no link and waiting for no pipe.
///
/// # Errors
/// The operating system's; `InvalidData` for what is no regular file.
pub(crate) fn open_regular(path: &Path) -> io::Result<File> {
    let refuse = || {
        io::Error::new(
            ErrorKind::InvalidData,
            "it is no regular file: move it away and run again",
        )
    };
    if !fs::symlink_metadata(path)?.is_file() {
        return Err(refuse());
    }
    let mut options = OpenOptions::new();
    options.read(true);
    // Between the look and the opening somebody may have put a pipe or a link there.
    #[cfg(unix)]
    {
        use std::os::unix::fs::OpenOptionsExt;
        let flags = rustix::fs::OFlags::NOFOLLOW | rustix::fs::OFlags::NONBLOCK;
        options.custom_flags(flags.bits() as i32);
    }
    let file = options.open(path)?;
    if file.metadata()?.is_file() {
        Ok(file)
    } else {
        Err(refuse())
    }
}

/// The bytes of such a file.
///
/// # Errors
/// Those of [`open_regular`]; `InvalidData` for a file that is longer than any that is published.
pub(crate) fn read(path: &Path) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    open_regular(path)?.take(LONGEST + 1).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > LONGEST {
        let why = format!("more than {LONGEST} bytes");
        return Err(io::Error::new(ErrorKind::InvalidData, why));
    }
    Ok(bytes)
}

/// Whether something is a link; nothing is none.
pub(crate) fn is_link(path: &Path) -> bool {
    path.symlink_metadata().is_ok_and(|found| found.is_symlink())
}

/// Refuses a link in place of one of the folders between `base`, which the user chose, and a folder below it.
///
/// # Errors
/// The link, by name.
pub(crate) fn refuse_links(base: &Path, folder: &Path) -> Result<()> {
    let Ok(below) = folder.strip_prefix(base) else {
        return Ok(());
    };
    let mut path = base.to_owned();
    for part in below.components() {
        path.push(part);
        if is_link(&path) {
            return Err(Error::Usage(format!(
                "{}: expected a folder, found a link, through which nothing is written; remove it and run again",
                path.display()
            )));
        }
    }
    Ok(())
}

/// Makes a folder below one that the user chose; none of the folders between may be a link.
///
/// # Errors
/// A link, or a folder that cannot be made.
pub(crate) fn make_folder(base: &Path, folder: &Path) -> Result<()> {
    refuse_links(base, folder)?;
    let there = folder.ancestors().find(|path| path.symlink_metadata().is_ok());
    if let Some(other) = there.filter(|there| !there.is_dir()) {
        return Err(Error::Usage(format!(
            "{}: expected a folder, found something else; move it away and run again",
            other.display()
        )));
    }
    fs::create_dir_all(folder).map_err(Error::writing("make the folder", folder, 0))
}

/// A text in a temporary file beside its place, synchronised; whoever drops it removes it.
pub(crate) struct Written {
    file: NamedTempFile,
    path: PathBuf,
}

impl Written {
    /// Writes the temporary file, with the permissions that the user's mask leaves.
    ///
    /// # Errors
    /// A folder or file that cannot be written.
    pub(crate) fn beside(path: &Path, text: &[u8]) -> Result<Self> {
        let folder = path.parent().expect("a published file lies in a folder");
        let written = temporary(folder).and_then(|mut file| {
            file.write_all(text)?;
            file.as_file().sync_all()?;
            Ok(file)
        });
        let file = written.map_err(Error::writing("write", path, text.len() as u64))?;
        let path = path.to_owned();
        Ok(Self { file, path })
    }

    /// Moves it into its place; a link that stands there is replaced, its target is left alone.
    ///
    /// # Errors
    /// What cannot be replaced, such as a folder.
    pub(crate) fn put(self) -> Result<()> {
        let Self { file, path } = self;
        let put = file.persist(&path).map_err(|error| error.error);
        put.map(|_| ()).map_err(Error::writing("write", path, 0))
    }
}

/// A temporary file of a name that only this program gives, made exclusively and locked while it lives.
fn temporary(folder: &Path) -> io::Result<NamedTempFile> {
    let mut builder = Builder::new();
    builder.prefix(HEAD).suffix(TAIL).rand_bytes(DIGITS);
    // The user's mask takes from these what it takes from any new file.
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    // An empty folder is this one.
    let folder = if folder.as_os_str().is_empty() {
        Path::new(".")
    } else {
        folder
    };
    let file = builder.tempfile_in(folder)?;
    // Where the file system has no locks, nothing is taken for a dead run's either.
    let _ = file.as_file().try_lock();
    Ok(file)
}

/// Writes one text that people read by way of a temporary file and a rename; on an error nothing is left.
///
/// # Errors
/// A folder or file that cannot be written.
pub fn write(path: &Path, text: &str) -> Result<()> {
    let folder = path.parent().expect("a published file lies in a folder");
    fs::create_dir_all(folder).map_err(Error::writing("make the folder", folder, 0))?;
    Written::beside(path, text.as_bytes())?.put()
}

/// Makes sure that files can be made in a folder, or in the nearest one above it that is there; `action` is what an error
/// says was tried.
///
/// # Errors
/// A folder in which no file can be made.
pub fn probe(action: &'static str, folder: &Path) -> Result<()> {
    // Without the slash at its end, which hides a file of the same name.
    let folder: PathBuf = folder.components().collect();
    let there = folder.ancestors().find(|path| path.symlink_metadata().is_ok());
    let made = temporary(there.unwrap_or(Path::new("."))).and_then(|file| match file.close() {
        // Another run took it for a dead one's between its making and its lock.
        Err(why) if why.kind() == ErrorKind::NotFound => Ok(()),
        closed => closed,
    });
    made.map_err(Error::io(action, folder))
}

/// Removes the temporary files that killed runs left in a folder: regular, of a name that only we give, and unlocked.
pub(crate) fn clear(folder: &Path) {
    for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
        if entry.file_name().to_str().is_some_and(is_temporary) {
            let is_abandoned = open_regular(&entry.path()).is_ok_and(|file| file.try_lock().is_ok());
            if is_abandoned {
                // It is in nobody's way.
                let _ = fs::remove_file(entry.path());
            }
        }
    }
}

fn is_temporary(name: &str) -> bool {
    let tag = name.strip_prefix(HEAD).and_then(|rest| rest.strip_suffix(TAIL));
    tag.is_some_and(|tag| tag.len() == DIGITS && tag.bytes().all(|byte| byte.is_ascii_alphanumeric()))
}

/// Waits until nobody else publishes into a folder; none where folders cannot be locked.
pub(crate) fn turn(folder: &Path) -> Option<File> {
    // To open a pipe would be to wait for its other end.
    let file = folder.is_dir().then(|| File::open(folder))?.ok()?;
    file.lock().is_ok().then_some(file)
}
