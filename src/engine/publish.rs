//! Publishing: the text files of figures and tables, written into a folder a person reads.
//!
//! The first value of the first axis (the first ship) writes to the folder itself, each further one to a folder of its
//! name; the full set lies in each. All files of a run are put into place in one go, under a lock on the folder, so that two
//! runs at once never leave a mixture. A file is written only if its bytes differ; one that no run has written was edited by
//! hand, and is kept in `artifacts/edited/`. What lies there of an earlier run and is no part of this one is removed or named
//! ([`leftover`](crate::engine::leftover)). Tested in `tests/cache/publish.rs`, `tests/cli/figures.rs`.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt;
use std::fs::{self, File};
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use crate::engine::case::Axis;
use crate::engine::checkout::Checkout;
use crate::engine::disk::read_text;
use crate::engine::error::{Error, Result};
use crate::engine::event::{Event, Fate};
use crate::engine::figures::{self, Written};
use crate::engine::graph::Graph;
use crate::engine::leftover::{Due, leftovers};
use crate::engine::run::Run;

/// The file inside a published set that says which parameters it was made with.
pub const PARAMETERS: &str = "parameters.toml";

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
        for (name, text) in run.published(node)? {
            texts.insert(format!("{prefix}{name}"), text);
        }
    }
    Ok(texts)
}

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
    fn there(&self) -> Option<String> {
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

/// Puts the texts of a run into their folder: what differs is written, all of it at once.
///
/// A file that is not of our making is copied to `edited/` first. Where the folder held a set of other parameters, the files
/// of that set which this run did not make are removed.
///
/// # Errors
/// A name that is no plain one, a link in place of a folder, a folder or file that cannot be written.
pub fn publish(run: &Run<'_>, texts: &BTreeMap<String, String>, due: &Due<'_>, set: &Set<'_>) -> Result<()> {
    if texts.is_empty() {
        return Ok(());
    }
    let folders = folders_of(texts, set)?;
    if !set.folder.is_dir() {
        figures::make_folder(&set.checkout.artifacts(), set.folder)?;
    }
    let _turn = figures::turn(set.folder);
    set.check()?;
    for folder in &folders {
        figures::refuse_links(set.folder, folder)?;
        figures::clear(folder);
    }
    let ours = Ours::of(set);
    let before = set
        .there()
        .filter(|_| set.parameters.is_some() || ours.made(set, PARAMETERS));
    let is_same_set = before.as_deref() == set.parameters;
    // Without parameters that we wrote there is nothing that tells two sets apart.
    let is_other_set = !is_same_set && ours.made(set, PARAMETERS);
    let states = states(&ours, texts, set);
    if !is_same_set || states.values().any(|state| *state != State::Current) {
        ours.remember(set, texts)?;
        put_all(run, texts, &states, set, is_same_set)?;
    }
    for (path, text) in texts {
        let id = blake3::hash(text.as_bytes()).to_hex().to_string();
        let (path, written) = (path.clone(), states[path] != State::Current);
        run.tell(&Event::DidPublish { path, id, written });
    }
    if is_other_set {
        return remove_others(run, texts, &Ours::of(set), set);
    }
    for (path, state) in leftovers(&Ours::of(set), due, set) {
        let fate = if state == State::Edited {
            Fate::KeptEdited
        } else {
            Fate::Kept
        };
        run.tell(&Event::DidFindOld { path, fate });
    }
    Ok(())
}

/// The folders that texts go to. Whatever names the texts came with, they leave no figures folder.
fn folders_of(texts: &BTreeMap<String, String>, set: &Set<'_>) -> Result<BTreeSet<PathBuf>> {
    let mut folders = BTreeSet::from([set.folder.to_owned()]);
    for path in texts.keys() {
        let (folder, _) = figures::parts(path).ok_or_else(|| Error::Damaged {
            what: "a published output".to_owned(),
            why: format!("expected a plain name within the figures folder, found {path:?}; nothing was written"),
        })?;
        folders.insert(set.folder.join(folder));
    }
    Ok(folders)
}

fn states(ours: &Ours, texts: &BTreeMap<String, String>, set: &Set<'_>) -> BTreeMap<String, State> {
    let state = |(path, text): (&String, &String)| (path.clone(), ours.state(&set.folder.join(path), Some(text)));
    texts.iter().map(state).collect()
}

/// Writes every temporary file before the first is moved into place, so that an error leaves the old set as it was. The
/// parameters go first and come last: a set that was cut short is one without them.
fn put_all(
    run: &Run<'_>,
    texts: &BTreeMap<String, String>,
    states: &BTreeMap<String, State>,
    set: &Set<'_>,
    is_same_set: bool,
) -> Result<()> {
    let mut written = Vec::new();
    for (path, text) in texts.iter().filter(|(path, _)| states[*path] != State::Current) {
        let place = set.folder.join(path);
        figures::make_folder(set.folder, place.parent().expect("a figure lies in a folder"))?;
        if states[path] == State::Edited {
            set_aside(run, path, set)?;
        }
        written.push(Written::beside(&place, text.as_bytes())?);
    }
    let parameters = set.folder.join(PARAMETERS);
    let last = match set.parameters.filter(|_| !is_same_set) {
        None => None,
        Some(text) => {
            if Ours::of(set).state(&parameters, Some(text)) == State::Edited {
                set_aside(run, PARAMETERS, set)?;
            }
            Some(Written::beside(&parameters, text.as_bytes())?)
        }
    };
    if !is_same_set && parameters.symlink_metadata().is_ok() {
        fs::remove_file(&parameters).map_err(Error::io("remove", &parameters))?;
    }
    written.into_iter().chain(last).try_for_each(Written::put)
}

/// Removes what the set before this one left in its folder; what somebody edited stays, and is named.
fn remove_others(run: &Run<'_>, texts: &BTreeMap<String, String>, ours: &Ours, set: &Set<'_>) -> Result<()> {
    let others = ours.there(set).into_iter();
    for path in others.filter(|path| !texts.contains_key(path) && path != PARAMETERS) {
        let mut fate = Fate::KeptEdited;
        if ours.made(set, &path) {
            let place = set.folder.join(&path);
            fs::remove_file(&place).map_err(Error::io("remove the figure of other parameters", place))?;
            fate = Fate::Removed;
        }
        run.tell(&Event::DidFindOld { path, fate });
    }
    Ok(())
}

/// Copies an edited file to where it is kept. A link is no file of anybody's: it is replaced, its target stays.
fn set_aside(run: &Run<'_>, name: &str, set: &Set<'_>) -> Result<()> {
    let path = set.folder.join(name);
    if figures::is_link(&path) {
        return Ok(());
    }
    let bytes = figures::read(&path).map_err(Error::io("read the figure", &path))?;
    let hash = blake3::hash(&bytes).to_hex();
    let (stem, extension) = name.rsplit_once('.').unwrap_or((name, ""));
    let artifacts = set.checkout.artifacts();
    let kept = artifacts
        .join("edited")
        .join(format!("{stem}.{}.{extension}", &hash[..8]));
    figures::make_folder(&artifacts, kept.parent().expect("it lies in edited/"))?;
    Written::beside(&kept, &bytes)?.put()?;
    let path = name.to_owned();
    run.tell(&Event::DidSetAside { path, kept });
    Ok(())
}

/// Makes sure, before hours of work, that what a graph publishes can be written.
///
/// # Errors
/// A folder in which no file can be made, or a link in place of one.
pub fn check_folder(graph: &Graph, axis: Axis, values: &[String], set: &Set<'_>) -> Result<()> {
    set.check()?;
    let folders = layout(graph, axis, values).into_iter().map(|(_, prefix)| prefix);
    for prefix in folders.collect::<BTreeSet<_>>() {
        let folder = set.folder.join(prefix);
        figures::refuse_links(set.folder, &folder)?;
        figures::probe(&folder)?;
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
    fn remember(&self, set: &Set<'_>, texts: &BTreeMap<String, String>) -> Result<()> {
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
