//! Runs: what the last runs used, and of which pieces a content consists; garbage collection begins from both.
//!
//! `runs/<n>.json` names the content of every node that a run knew, and the ids of pieces of nodes it did not finish;
//! `manifests/ab/cdef..` holds the ids of a content in pieces, in order, and is named by their hash. Neither decides what
//! is cached: a damaged one is none.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::time::SystemTime;

use serde::{Deserialize, Serialize};

use crate::engine::disk::{read_text, regular};
use crate::engine::error::Result;
use crate::engine::id::Id;
use crate::engine::record::{opened, sealed};
use crate::engine::run::Run;
use crate::engine::store::{Store, path_in};

/// How many runs are remembered.
const KEPT: usize = 3;

/// The lock of who writes here.
pub(crate) const TURN: &str = "runs";

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

/// Takes note of what a run used, unless the last one used the same.
pub(crate) fn remember(run: &Run<'_>) -> Result<()> {
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
    let is_last = |there: &[(u64, PathBuf)]| there.last().and_then(|(_, path)| read(path)).as_ref() == Some(&file);
    if is_last(&numbered(run.store.root())) {
        return Ok(());
    }
    // One at a time, so that no two runs choose the same number.
    let _turn = run.store.wait_for_turn(TURN)?;
    let there = numbered(run.store.root());
    if is_last(&there) {
        return Ok(());
    }
    let number = there.last().map_or(1, |(number, _)| number + 1);
    let path = run.store.root().join("runs").join(format!("{number}.json"));
    let (_, text) = sealed(&serde_json::to_string(&file).expect("names and ids are text"));
    run.store.write(&path, text.as_bytes(), false)?;
    for (_, old) in there.iter().rev().skip(KEPT - 1) {
        // Another run may have been faster.
        let _ = fs::remove_file(old);
    }
    Ok(())
}

/// The remembered runs, the last one last, and when it was written; no time if one of them is damaged, so that what it
/// used is not known.
pub(crate) fn last(root: &Path) -> (Vec<RunFile>, Option<SystemTime>) {
    let there = numbered(root);
    let newest = there.last().and_then(|(_, path)| path.metadata().ok()?.modified().ok());
    let runs: Vec<RunFile> = there.iter().filter_map(|(_, path)| read(path)).collect();
    let newest = newest.filter(|_| runs.len() == there.len());
    (runs, newest)
}

fn read(path: &Path) -> Option<RunFile> {
    serde_json::from_str(&opened(&read_text(path).ok()?)?.1).ok()
}

fn numbered(root: &Path) -> Vec<(u64, PathBuf)> {
    let entries = fs::read_dir(root.join("runs")).into_iter().flatten().flatten();
    let number = |path: &Path| path.file_name()?.to_str()?.strip_suffix(".json")?.parse().ok();
    let mut found: Vec<(u64, PathBuf)> = entries
        .filter_map(|entry| Some((number(&entry.path())?, entry.path())))
        // No run counts that far; the next number must be one.
        .filter(|(number, _)| *number < u64::MAX)
        .collect();
    found.sort();
    found
}

fn keep_manifest(store: &Store, content: &Id, ids: &[Id]) -> Result<()> {
    // The content of a node in one piece is the piece's own id.
    if ids.len() == 1 {
        return Ok(());
    }
    let hex = content.to_string();
    let path = path_in(store.root(), "manifests", &hex, "");
    // One that rotted only lets `gc` keep more than it must; `verify --store` finds it.
    if regular(&path).is_ok_and(|length| length == 32 * ids.len() as u64) {
        return Ok(());
    }
    let bytes: Vec<u8> = ids.iter().flat_map(|id| id.0).collect();
    store.write(&path, &bytes, false)
}
