//! Publishing: the text files of figures and tables, written into a folder a person reads.
//!
//! The first value of the first axis (the first ship) writes to the folder itself, each further one to a folder of its
//! name; the full set lies in each. A file is written only if its bytes differ; one that no run has written was edited by
//! hand, and is kept in `edited/`.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt;
use std::fs::{self, File};
use std::hash::{BuildHasher, RandomState};
use std::io::{self, ErrorKind, Write};
use std::path::{Path, PathBuf};

use crate::engine::case::Axis;
use crate::engine::disk::{read_regular, read_text};
use crate::engine::error::{Error, Result};
use crate::engine::event::Event;
use crate::engine::graph::Graph;
use crate::engine::lock::Lock;
use crate::engine::run::Run;
use crate::engine::store::Store;

/// The published files of a graph: path within the figures folder -> (node, name of the file in the artifact).
pub fn layout(graph: &Graph, axis: Axis, values: &[String]) -> Vec<(usize, String)> {
    let mut folders = Vec::new();
    for (i, value) in values.iter().enumerate() {
        let prefix = if i == 0 { String::new() } else { format!("{value}/") };
        for target in &graph.targets {
            let node = &graph.nodes[*target];
            let own = node.case.value(axis);
            if node.node.is_published() && own.is_none_or(|own| own == value) {
                folders.push((*target, prefix.clone()));
            }
        }
    }
    folders
}

/// The text of every published file, by path within the figures folder.
///
/// # Errors
/// An artifact that cannot be read or made again.
pub fn texts(run: &Run<'_>, axis: Axis, values: &[String]) -> Result<BTreeMap<String, String>> {
    let mut texts = BTreeMap::new();
    // A node that failed, or that another's failure kept from running, publishes nothing.
    for (node, prefix) in layout(run.graph, axis, values)
        .into_iter()
        .filter(|(node, _)| run.content(*node).is_some())
    {
        let bytes = run.bytes(node, 0)?;
        for (name, text) in run.graph.nodes[node].node.published(&bytes)? {
            texts.insert(format!("{prefix}{name}"), text);
        }
    }
    Ok(texts)
}

/// Writes what differs. A file that is not of our making is copied to `edited/` in the store first.
///
/// # Errors
/// A folder or file that cannot be written.
pub fn publish(run: &Run<'_>, texts: &BTreeMap<String, String>, folder: &Path) -> Result<()> {
    let ours = Ours::of(run.store);
    ours.remember(run.store, texts)?;
    for (name, text) in texts {
        let path = folder.join(name);
        let state = ours.state(&path, Some(text));
        if state == State::Edited {
            set_aside(run, name, &path)?;
        }
        if state != State::Current {
            write(&path, text)?;
        }
        let id = blake3::hash(text.as_bytes()).to_hex().to_string();
        run.tell(&Event::DidPublish {
            path: name.clone(),
            id,
            written: state != State::Current,
        });
    }
    Ok(())
}

fn set_aside(run: &Run<'_>, name: &str, path: &Path) -> Result<()> {
    let bytes = read_regular(path).map_err(Error::io("read the figure", path))?;
    let hash = blake3::hash(&bytes).to_hex();
    let (stem, extension) = name.rsplit_once('.').unwrap_or((name, ""));
    let kept = run.store.root().join("edited");
    let kept = kept.join(format!("{stem}.{}.{extension}", &hash[..8]));
    write(&kept, &String::from_utf8_lossy(&bytes))?;
    let path = name.to_owned();
    run.tell(&Event::DidSetAside { path, kept });
    Ok(())
}

/// Makes sure, before hours of work, that what a graph publishes can be written.
///
/// # Errors
/// A folder in which no file can be made.
pub fn check_folder(graph: &Graph, axis: Axis, values: &[String], folder: &Path) -> Result<()> {
    let folders = layout(graph, axis, values).into_iter().map(|(_, prefix)| prefix);
    for prefix in folders.collect::<BTreeSet<_>>() {
        // Without the slash at its end, which hides a file of the same name.
        let folder: PathBuf = folder.join(prefix).components().collect();
        // What is not there yet will be made in the nearest folder that is.
        let there = folder.ancestors().find(|path| path.symlink_metadata().is_ok());
        let there = there.unwrap_or(Path::new("."));
        let probe = there.join(format!(".encounter-{:016x}.tmp", tag(there)));
        let made = fs::write(&probe, "").and_then(|()| match fs::remove_file(&probe) {
            // Another run has taken it for a dead one's.
            Err(why) if why.kind() == ErrorKind::NotFound => Ok(()),
            removed => removed,
        });
        made.map_err(Error::io("write figures to", folder))?;
    }
    Ok(())
}

/// How a published file stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum State {
    /// What a run would write.
    Current,
    /// Not there.
    Missing,
    /// Written by an earlier run.
    Outdated,
    /// Written by somebody else.
    Edited,
}

impl fmt::Display for State {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Current => "current",
            Self::Missing => "missing",
            Self::Outdated => "outdated",
            Self::Edited => "edited",
        })
    }
}

/// The hashes of what runs have published: those that this store remembers, and those of its locks.
pub struct Ours {
    hashes: Vec<String>,
    locked: BTreeSet<String>,
}

impl Ours {
    /// The newest texts that are remembered.
    const MOST: usize = 4096;

    /// What a store and its locks know.
    pub fn of(store: &Store) -> Self {
        let text = read_text(&store.root().join("published")).unwrap_or_default();
        let locks = fs::read_dir(store.root()).into_iter().flatten().flatten();
        let locks = locks.filter_map(|entry| Lock::parse(&read_text(&entry.path()).ok()?).ok());
        let files = locks.flat_map(|lock| lock.lines.into_iter().filter(|line| line.pieces.is_none()));
        Self {
            hashes: text.lines().map(str::to_owned).collect(),
            locked: files.map(|line| line.content.to_string()).collect(),
        }
    }

    /// How a file stands; `text` is what a run would write, if that is known.
    pub fn state(&self, path: &Path, text: Option<&str>) -> State {
        let bytes = match read_regular(path) {
            Ok(bytes) => bytes,
            Err(why) if why.kind() == ErrorKind::NotFound => return State::Missing,
            // What cannot be read may be somebody's work: it is not written over.
            Err(_) => return State::Edited,
        };
        if text.is_some_and(|text| text.as_bytes() == bytes) {
            return State::Current;
        }
        let hash = blake3::hash(&bytes).to_hex();
        if self.locked.contains(hash.as_str()) || self.hashes.iter().any(|known| known == hash.as_str()) {
            State::Outdated
        } else {
            State::Edited
        }
    }

    /// Notes what is about to be written: a crash after that leaves nothing that looks edited.
    fn remember(&self, store: &Store, texts: &BTreeMap<String, String>) -> Result<()> {
        let mut hashes = self.hashes.clone();
        for text in texts.values() {
            let hash = blake3::hash(text.as_bytes()).to_hex().to_string();
            if !hashes.contains(&hash) {
                hashes.push(hash);
            }
        }
        if hashes == self.hashes {
            return Ok(());
        }
        let first = hashes.len().saturating_sub(Self::MOST);
        let text = hashes[first..].join("\n") + "\n";
        write(&store.root().join("published"), &text)
    }
}

/// Writes a text that people read by way of a temporary file beside it and a rename; on an error nothing is left.
///
/// # Errors
/// A folder or file that cannot be written.
pub fn write(path: &Path, text: &str) -> Result<()> {
    let folder = path.parent().expect("a published file lies in a folder");
    fs::create_dir_all(folder).map_err(Error::writing("make the folder", folder, 0))?;
    let written = match write_by_rename(path, text) {
        // Taken for a dead one's between its making and its lock.
        Err(why) if why.kind() == ErrorKind::NotFound => write_by_rename(path, text),
        written => written,
    };
    written.map_err(Error::writing("write", path, text.len() as u64))
}

fn write_by_rename(path: &Path, text: &str) -> io::Result<()> {
    let extension = path.extension().unwrap_or_default().display();
    let temporary = path.with_extension(format!("{extension}.{:016x}.tmp", tag(path)));
    let result = write_locked(&temporary, text).and_then(|_lock| fs::rename(&temporary, path));
    if result.is_err() {
        // The error to report is the first one.
        let _ = fs::remove_file(&temporary);
    }
    result
}

/// Writes a file that is locked as long as it is held: one that is not was left by a dead process.
fn write_locked(path: &Path, text: &str) -> io::Result<File> {
    let mut file = File::create(path)?;
    // Where the file system has no locks, nothing is taken for a dead one's either.
    let _ = file.try_lock();
    file.write_all(text.as_bytes())?;
    file.sync_all()?;
    Ok(file)
}

/// Whoever else writes a file, in this process or another, has a temporary file of their own.
fn tag(path: &Path) -> u64 {
    RandomState::new().hash_one(path)
}

/// Removes the temporary files that killed runs left in the folders of a graph's figures and beside the locks.
pub fn clear(graph: &Graph, axis: Axis, values: &[String], figures: &Path, store: &Path) {
    let folders = layout(graph, axis, values).into_iter().map(|(_, prefix)| prefix);
    let folders: BTreeSet<String> = folders.collect();
    for folder in folders
        .iter()
        .map(|prefix| figures.join(prefix))
        .chain([store.to_owned()])
    {
        for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
            if entry.file_name().to_str().is_some_and(is_temporary) && is_abandoned(&entry.path()) {
                // It is in nobody's way.
                let _ = fs::remove_file(entry.path());
            }
        }
    }
}

/// Whether a name is one that [`write()`] or [`check_folder`] gives: 16 hexadecimal digits before `.tmp`.
fn is_temporary(name: &str) -> bool {
    let stem = name.strip_suffix(".tmp");
    let tag = stem.and_then(|stem| stem.rsplit(['.', '-']).next());
    tag.is_some_and(|tag| tag.len() == 16 && tag.bytes().all(|byte| byte.is_ascii_hexdigit()))
}

fn is_abandoned(path: &Path) -> bool {
    File::options()
        .write(true)
        .open(path)
        .is_ok_and(|file| file.try_lock().is_ok())
}
