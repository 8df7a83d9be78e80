//! Published: a folder of figures, the set of parameters that it holds, and whose the files in it are.
//!
//! A checkout notes hash and place of every file before it is written. A file is ours at a place only if a run of this
//! checkout put these bytes at that very path, or a lock says so of the folder of its profile. Tested in
//! `tests/cache/publish.rs`.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt;
use std::fs::{self, File};
use std::io::ErrorKind;
use std::path::Path;

use crate::engine::checkout::Checkout;
use crate::engine::disk::read_text;
use crate::engine::error::{Error, Result};
use crate::engine::figures;

/// The file inside a published set that says which parameters it was made with.
pub const PARAMETERS: &str = "parameters.toml";

/// A folder and the set of parameters whose figures it holds.
pub struct Set<'a> {
    /// The checkout that publishes.
    pub checkout: &'a Checkout,
    /// The figures folder.
    pub folder: &'a Path,
    /// The profile whose own folder this is: the files in its locks are ours.
    pub home: Option<&'a str>,
    /// All parameters in force, to be written beside the figures; none in the folder of the committed ones.
    pub parameters: Option<&'a str>,
    /// Whether a set of other parameters may be replaced by this one.
    pub may_replace: bool,
}

impl Set<'_> {
    /// The parameters that the folder was last written with.
    pub(crate) fn there(&self) -> Option<String> {
        let bytes = figures::read(&self.folder.join(PARAMETERS)).ok()?;
        String::from_utf8(bytes).ok()
    }

    /// Refuses a link in place of a folder below `artifacts/`.
    ///
    /// # Errors
    /// The link, by name.
    pub(crate) fn check_links(&self) -> Result<()> {
        figures::refuse_links(&self.checkout.artifacts(), self.folder)
    }

    /// Refuses a folder that holds another set under the same name.
    ///
    /// # Errors
    /// Such a folder.
    pub fn check(&self) -> Result<()> {
        self.check_links()?;
        let there = if self.may_replace { None } else { self.there() };
        match there.filter(|there| Some(there.as_str()) != self.parameters) {
            None => Ok(()),
            Some(_) => Err(Error::Usage(format!(
                "{}: expected the figures of these parameters or none, found those of others (see {PARAMETERS} there); \
                 choose another --name, or add --replace",
                self.folder.display()
            ))),
        }
    }
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

/// What runs of this checkout have published, by hash and place, and what its locks name.
pub struct Ours {
    /// `(hash, place of the figures folder/path within it)`, oldest first.
    lines: Vec<(String, String)>,
    /// The folder that is asked about, as it stands in the lines.
    place: String,
    locked: BTreeSet<String>,
    /// Path within this folder -> hash, from the locks of the profile whose folder it is.
    at_home: BTreeMap<String, BTreeSet<String>>,
}

impl Ours {
    /// The newest lines that are remembered.
    const MOST: usize = 8192;

    /// What a checkout and its locks know, asked about one folder.
    pub fn of(set: &Set<'_>) -> Self {
        let (mut locked, mut at_home) = (BTreeSet::new(), BTreeMap::<String, BTreeSet<String>>::new());
        for lock in set.checkout.locks().into_values() {
            for line in lock.lines.iter().filter(|line| line.pieces.is_none()) {
                let hash = line.content.to_string();
                if let Some(path) = line
                    .name
                    .strip_prefix("file ")
                    .filter(|_| set.home == Some(&lock.profile))
                {
                    at_home.entry(path.to_owned()).or_default().insert(hash.clone());
                }
                locked.insert(hash);
            }
        }
        Self {
            lines: lines(set.checkout),
            place: set.checkout.place(set.folder),
            locked,
            at_home,
        }
    }

    /// How a file stands; `text` is what a run would write, if that is known.
    pub fn state(&self, path: &Path, text: Option<&str>) -> State {
        let bytes = match figures::read(path) {
            Ok(bytes) => bytes,
            Err(why) if why.kind() == ErrorKind::NotFound && !figures::is_link(path) => return State::Missing,
            // What cannot be read may be somebody's work: it is not written over.
            Err(_) => return State::Edited,
        };
        if text.is_some_and(|text| text.as_bytes() == bytes) {
            return State::Current;
        }
        let hash = blake3::hash(&bytes).to_hex();
        if self.locked.contains(hash.as_str()) || self.lines.iter().any(|(known, _)| known == hash.as_str()) {
            State::Outdated
        } else {
            State::Edited
        }
    }

    /// The paths within the folder at which a run of ours has published something that is there, be it edited since.
    pub(crate) fn there(&self, set: &Set<'_>) -> BTreeSet<String> {
        let prefix = format!("{}/", self.place);
        let published = self.lines.iter().filter_map(|(_, path)| path.strip_prefix(&prefix));
        let all: BTreeSet<&str> = published.chain(self.at_home.keys().map(String::as_str)).collect();
        let is_there = |path: &&str| {
            figures::parts(path).is_some_and(|(folder, _)| !figures::is_link(&set.folder.join(folder)))
                && set.folder.join(path).symlink_metadata().is_ok()
        };
        all.into_iter().filter(is_there).map(str::to_owned).collect()
    }

    /// Whether the file at a path holds bytes that a run of ours put at that path.
    pub(crate) fn made(&self, set: &Set<'_>, path: &str) -> bool {
        let Ok(bytes) = figures::read(&set.folder.join(path)) else {
            return false;
        };
        let hash = blake3::hash(&bytes).to_hex().to_string();
        let whole = format!("{}/{path}", self.place);
        self.at_home.get(path).is_some_and(|hashes| hashes.contains(&hash))
            || self.lines.iter().any(|(known, at)| *known == hash && *at == whole)
    }

    /// Notes what is about to be written: a crash after that leaves nothing that looks edited.
    pub(crate) fn remember(&self, set: &Set<'_>, texts: &BTreeMap<String, String>) -> Result<()> {
        let artifacts = set.checkout.artifacts();
        fs::create_dir_all(&artifacts).map_err(Error::writing("make the folder", &artifacts, 0))?;
        // Another run of this checkout may be adding its own lines.
        let _turn: Option<File> = figures::turn(&artifacts);
        figures::clear(&artifacts);
        let parameters = set.parameters.map(|text| (PARAMETERS, text));
        let all = texts.iter().map(|(path, text)| (path.as_str(), text.as_str()));
        let mut lines = lines(set.checkout);
        let mut known: BTreeSet<(String, String)> = lines.iter().cloned().collect();
        let before = lines.len();
        for (path, text) in all.chain(parameters) {
            let hash = blake3::hash(text.as_bytes()).to_hex().to_string();
            let line = (hash, format!("{}/{path}", self.place));
            // A folder whose name breaks the line could not be read back.
            if !line.1.contains(['\n', '\r']) && known.insert(line.clone()) {
                lines.push(line);
            }
        }
        if lines.len() == before {
            return Ok(());
        }
        let first = lines.len().saturating_sub(Self::MOST);
        let line = |(hash, path): &(String, String)| format!("{hash} {path}\n");
        let text: String = lines[first..].iter().map(line).collect();
        figures::write(&artifacts.join("published"), &text)
    }
}

/// The lines of the list of what a checkout has published; a damaged line is none.
fn lines(checkout: &Checkout) -> Vec<(String, String)> {
    let text = read_text(&checkout.artifacts().join("published")).unwrap_or_default();
    let line = |line: &str| {
        let (hash, path) = line.split_once(' ')?;
        blake3::Hash::from_hex(hash).ok()?;
        Some((hash.to_owned(), path.to_owned()))
    };
    text.lines().filter_map(line).collect()
}
