//! Runs: what the last runs used, and of which pieces a content consists; garbage collection begins from both.
//!
//! `runs/<checkout>-<n>.json` names the content of every node that a run knew, and the ids of pieces of nodes it did not
//! finish; `manifests/ab/cdef..` holds the ids of a content in pieces, in order, and is named by their hash. Neither decides
//! what is cached. Several checkouts may share a store, so each keeps its own last runs out of the reach of `gc`.

use std::collections::BTreeMap;
use std::io::ErrorKind;
use std::path::Path;
use std::time::SystemTime;

use serde::{Deserialize, Serialize};

use crate::engine::disk::is_read_only;
use crate::engine::error::{Error, Result};
use crate::engine::id::Id;
use crate::engine::listing::{Listed, listed};
use crate::engine::names::{Folder, Place};
use crate::engine::record::{opened, sealed};
use crate::engine::run::Run;
use crate::engine::store::Store;

/// How many runs of a checkout are remembered.
const KEPT: usize = 3;
/// How many runs of all checkouts are remembered, so that those of clones long gone do not pile up.
const KEPT_OF_ALL: usize = 48;

/// What a run used.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct RunFile {
    /// The layout of this file.
    format: u32,
    /// Node -> its content.
    pub(crate) contents: BTreeMap<String, String>,
    /// Node -> the ids of its finished pieces, if some are missing.
    pub(crate) pieces: BTreeMap<String, Vec<String>>,
}

/// A run that a store remembers.
struct Remembered {
    checkout: u64,
    number: u64,
    modified: SystemTime,
}

/// The number that stands for a checkout in the names of its runs.
pub(crate) fn checkout_number(checkout: &Path) -> u64 {
    let path = checkout.canonicalize().unwrap_or_else(|_| checkout.to_owned());
    let hash = blake3::hash(path.as_os_str().as_encoded_bytes());
    hash.as_bytes()[..8]
        .iter()
        .fold(0, |number, byte| number << 8 | u64::from(*byte))
}

/// Takes note of what a run used, unless the last one of its checkout used the same. A store that may only be read has
/// nothing to note: the run made nothing in it.
///
/// # Errors
/// A file that cannot be written.
pub(crate) fn remember(run: &Run<'_>) -> Result<()> {
    match note(run) {
        Err(Error::Io { source, .. }) if is_read_only(&source) => Ok(()),
        noted => noted,
    }
}

fn note(run: &Run<'_>) -> Result<()> {
    let file = used(run)?;
    let is_last = |there: &[Remembered]| {
        let own = there
            .iter()
            .filter(|it| it.checkout == run.checkout)
            .max_by_key(|it| it.number);
        own.and_then(|own| read(run.store, own).ok().flatten()).as_ref() == Some(&file)
    };
    if is_last(&remembered(run.store)?) {
        return Ok(());
    }
    // One at a time, so that no two runs choose the same number.
    let _turn = run.store.wait_for_runs()?;
    let mut there = remembered(run.store)?;
    if is_last(&there) {
        return Ok(());
    }
    let last = there
        .iter()
        .filter(|it| it.checkout == run.checkout)
        .map(|it| it.number)
        .max();
    let number = last.map_or(1, |last| last + 1);
    let (_, text) = sealed(&serde_json::to_string(&file).expect("names and ids are text"));
    run.store
        .write(&Place::Run(run.checkout, number), text.as_bytes(), false)?;
    there.sort_by_key(|it| (it.modified, it.number));
    let own = there
        .iter()
        .rev()
        .filter(|it| it.checkout == run.checkout)
        .skip(KEPT - 1);
    for old in own.chain(there.iter().rev().skip(KEPT_OF_ALL - 1)) {
        // Another run may have been faster.
        let _ = run.store.files().remove(&Place::Run(old.checkout, old.number).at());
    }
    Ok(())
}

/// What a run knows, its manifests written.
fn used(run: &Run<'_>) -> Result<RunFile> {
    let mut file = RunFile {
        format: 1,
        ..RunFile::default()
    };
    for (i, node) in run.graph.nodes.iter().enumerate() {
        let ids: Vec<Id> = (0..node.pieces.len()).filter_map(|piece| run.id(i, piece)).collect();
        if let Some(content) = run.content(i) {
            keep_manifest(run.store, &content, &ids)?;
            file.contents.insert(node.name(), content.to_string());
        } else if !ids.is_empty() {
            let ids = ids.iter().map(ToString::to_string).collect();
            file.pieces.insert(node.name(), ids);
        }
    }
    Ok(file)
}

/// All remembered runs, and when the newest was written. If one of them is damaged, nobody knows what it used, and no time is
/// given.
///
/// # Errors
/// One that cannot be read.
pub(crate) fn all(store: &Store) -> Result<(Vec<RunFile>, Option<SystemTime>)> {
    let there = remembered(store)?;
    let newest = there.iter().map(|it| it.modified).max();
    let files: Result<Vec<Option<RunFile>>> = there.iter().map(|it| read(store, it)).collect();
    let files: Vec<RunFile> = files?.into_iter().flatten().collect();
    let newest = newest.filter(|_| files.len() == there.len());
    Ok((files, newest))
}

/// What a run used; none if the file is damaged.
fn read(store: &Store, run: &Remembered) -> Result<Option<RunFile>> {
    let place = Place::Run(run.checkout, run.number);
    let text = match store.read_text(&place) {
        Err(why) if why.kind() != ErrorKind::InvalidData => {
            return Err(Error::io("read what a run used,", store.path(&place))(why));
        }
        text => text.unwrap_or_default(),
    };
    Ok(opened(&text).and_then(|(_, json)| serde_json::from_str(&json).ok()))
}

fn remembered(store: &Store) -> Result<Vec<Remembered>> {
    let of = |file: Listed| match file.place? {
        // No run counts that far; the next number must be one.
        Place::Run(checkout, number) if number < u64::MAX => Some(Remembered {
            checkout,
            number,
            modified: file.modified,
        }),
        _ => None,
    };
    Ok(listed(store, Folder::Runs)?.into_iter().filter_map(of).collect())
}

fn keep_manifest(store: &Store, content: &Id, ids: &[Id]) -> Result<()> {
    // The content of a node in one piece is the piece's own id.
    if ids.len() == 1 {
        return Ok(());
    }
    let place = Place::Manifest(*content);
    let bytes: Vec<u8> = ids.iter().flat_map(|id| id.0).collect();
    if store.read_file(&place).is_ok_and(|there| there == bytes) {
        return Ok(());
    }
    store.write(&place, &bytes, false)
}
