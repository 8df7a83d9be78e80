//! Claim: whether a folder is a store, may become one, or is somebody else's.
//!
//! A store says that it is one by a file of its own, the marker, which is the first thing written into it. A folder without
//! the marker that holds anything is refused before anything is written, so that no run and no `gc` ever touches a folder
//! that was named by mistake. A folder that holds committed lock files, such as a checkout's `artifacts/`, may also hold
//! `figures`, `edited` and `published`: they lie beside the default store.

use std::fs::{self, DirEntry};
use std::io::{ErrorKind, Read};
use std::path::Path;

use crate::engine::disk::Disk;
use crate::engine::error::{Error, Result};
use crate::engine::names::{At, Place};

/// What the marker says.
const MARKER: &str =
    "encounter store 1: outputs that `encounter` has made and can make again; `encounter gc` makes room in it\n";

/// The tag by which programs that make backups know a cache (<https://bford.info/cachedir/>).
const CACHE_TAG: &str = "Signature: 8a477f597d28d172789f06886806bc55
# This folder is a store of `encounter`: all of it can be made again.
";

/// The first bytes of a committed lock.
const LOCK: &[u8] = b"encounter-lock ";

/// What a checkout keeps beside its committed locks.
const BESIDE_LOCKS: [&str; 3] = ["figures", "edited", "published"];

/// Refuses a folder that is neither a store nor free to become one; a folder that is not there is free.
///
/// # Errors
/// A folder that cannot be read, or that somebody else uses.
pub(crate) fn check(root: &Path) -> Result<()> {
    let entries = match fs::read_dir(root) {
        Err(why) if why.kind() == ErrorKind::NotFound => return Ok(()),
        entries => entries.map_err(Error::io("use as a store", root))?,
    };
    let entries: Vec<DirEntry> = entries
        .collect::<std::io::Result<_>>()
        .map_err(Error::io("use as a store", root))?;
    if is_marked(root) {
        return Ok(());
    }
    let marker = root.join(Place::Marker.at().text());
    if marker.symlink_metadata().is_ok() {
        return Err(Error::Usage(format!(
            "--store {}: expected the marker `{}` to be a regular file, found something else; nothing was written. Remove it; if \
             the folder is a store, make an empty file of that name",
            root.display(),
            Place::Marker.at()
        )));
    }
    // The lock on the whole, which holds nothing, may be all that was left of a store.
    let is_left = |entry: &&DirEntry| {
        entry.file_name() == *Place::StoreLock.at().text()
            && entry.metadata().is_ok_and(|found| found.is_file() && found.len() == 0)
    };
    let entries = entries.iter().filter(|entry| !is_left(entry));
    let (locks, others): (Vec<&DirEntry>, Vec<&DirEntry>) = entries.partition(|entry| is_lock(entry));
    let is_beside =
        |entry: &&&DirEntry| !locks.is_empty() && BESIDE_LOCKS.iter().any(|name| entry.file_name() == *name);
    let mut foreign: Vec<String> = others
        .iter()
        .filter(|entry| !is_beside(entry))
        .map(|entry| entry.file_name().to_string_lossy().into_owned())
        .collect();
    foreign.sort();
    match foreign.as_slice() {
        [] => Ok(()),
        [first, rest @ ..] => Err(Error::Usage(format!(
            "--store {store}: expected an empty folder or a store (a folder with the file `{marker}`), found `{first}`{}; nothing \
             was written. Choose another folder; if this is a store that lost its marker, restore it: `touch {store}/{marker}`",
            match rest.len() {
                0 => String::new(),
                more => format!(" and {more} more"),
            },
            store = root.display(),
            marker = Place::Marker.at(),
        ))),
    }
}

/// Whether a folder holds the marker.
pub(crate) fn is_marked(root: &Path) -> bool {
    let marker = root.join(Place::Marker.at().text()).symlink_metadata();
    marker.is_ok_and(|found| found.is_file())
}

/// Marks a folder that has been checked, and makes sure that the mark outlives a power cut; a store keeps its mark.
///
/// # Errors
/// A mark that cannot be written.
pub(crate) fn mark(disk: &dyn Disk) -> Result<()> {
    for (place, text) in [(Place::Marker, MARKER), (Place::CacheTag, CACHE_TAG)] {
        let at = place.at();
        if disk.length(&at).is_ok() {
            continue;
        }
        let path = disk.root().join(at.text());
        match disk.write_new(&at, text.as_bytes()) {
            // Another run was faster.
            Err(why) if why.kind() == ErrorKind::AlreadyExists => continue,
            // The tag is a courtesy, and a store can do without it.
            Err(_) if place == Place::CacheTag => continue,
            written => written.map_err(Error::writing("mark the store by", &path, text.len() as u64))?,
        }
        for at in [at, At::root()] {
            disk.synchronise(&at).map_err(Error::writing("synchronise", &path, 0))?;
        }
    }
    Ok(())
}

/// Whether a file is a committed lock.
fn is_lock(entry: &DirEntry) -> bool {
    let name = entry.file_name();
    let is_named_so = Path::new(&name)
        .extension()
        .is_some_and(|extension| extension == "lock");
    // To open a pipe would be to wait for its other end.
    if !is_named_so || !entry.file_type().is_ok_and(|kind| kind.is_file()) {
        return false;
    }
    let mut head = [0; LOCK.len()];
    let read = fs::File::open(entry.path()).and_then(|mut file| file.read_exact(&mut head));
    read.is_ok() && head == *LOCK
}
