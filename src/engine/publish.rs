//! Publishing: the text files of figures and tables, written into a folder a person reads.
//!
//! The first value of the first axis (the first ship) writes to the folder itself, each further one to a folder of its
//! name; the full set lies in each. All files of a run are put into place in one go, under a lock on the folder, so that two
//! runs at once never leave a mixture. A file is written only if its bytes differ; one that no run has written was edited by
//! hand, and is kept in `artifacts/edited/`. What lies there of an earlier run and is no part of this one is removed or named
//! ([`leftover`](crate::engine::leftover)). Tested in `tests/cache/publish.rs`, `tests/cli/figures.rs`.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::PathBuf;

use crate::engine::case::Axis;
use crate::engine::error::{Error, Result};
use crate::engine::event::{Event, Fate};
use crate::engine::figures::{self, Written};
use crate::engine::graph::Graph;
use crate::engine::leftover::{Due, leftovers};
use crate::engine::published::{Ours, PARAMETERS, Set, State};
use crate::engine::run::Run;

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
        figures::probe("write figures to", &folder)?;
    }
    Ok(())
}
