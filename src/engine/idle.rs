//! Idle: whether everything is as the last run left it, so that a run has nothing to do but to say so.
//!
//! Nothing is written on the word of the index: the published files are compared with outputs that are read and verified,
//! their records with the index, the lock with the committed one. Whatever differs, the run goes the long way.
//! Tested in `tests/cache/index.rs`.

use std::fs::File;
use std::io::{self, Read};
use std::path::Path;

use crate::engine::case::Axis;
use crate::engine::disk::{read_text, regular};
use crate::engine::event::Event;
use crate::engine::index::{Belief, Index};
use crate::engine::lock::Lock;
use crate::engine::publish;
use crate::engine::run::Run;
use crate::engine::runs;

/// What a run would leave behind.
pub struct Traces<'a> {
    /// The axis whose values have figures folders of their own.
    pub axis: Axis,
    /// Its values.
    pub values: &'a [String],
    /// The figures folder.
    pub figures: &'a Path,
    /// The lock, and the profile that it names; none for a run that writes no lock.
    pub lock: Option<(&'a Path, &'a str)>,
}

/// Tells of every piece as reused and every file as current, if that is so.
pub fn is_idle(run: &Run<'_>, index: &Index, traces: &Traces<'_>) -> bool {
    let Belief::All { rehashed } = index.believe(run) else {
        return false;
    };
    let Some(lock) = lock_of(run, traces) else {
        return false;
    };
    // Idle runs, too, keep what they used out of the reach of `gc`.
    if runs::remember(run).is_err() {
        return false;
    }
    for (node, it) in run.graph.nodes.iter().enumerate() {
        for piece in run.graph.wanted_pieces(node) {
            let node = it.name();
            run.tell(&Event::DidReuse { node, piece });
        }
    }
    for line in &lock.lines {
        if let Some(path) = line.name.strip_prefix("file ") {
            let (path, id) = (path.to_owned(), line.content.to_string());
            let written = false;
            run.tell(&Event::DidPublish { path, id, written });
        }
    }
    if rehashed {
        // It only makes the next run faster.
        let _ = index.renew(run);
    }
    true
}

/// The lock, if published files and lock are what a run would write.
fn lock_of(run: &Run<'_>, traces: &Traces<'_>) -> Option<Lock> {
    for (node, _) in publish::layout(run.graph, traces.axis, traces.values) {
        let record = run.key(node, 0).and_then(|key| run.store.record(&key))?;
        if Some(record.id) != run.id(node, 0).map(|id| id.to_string()) {
            return None;
        }
    }
    let texts = publish::texts(run, traces.axis, traces.values).ok()?;
    let is_current = |(name, text): (&String, &String)| holds(&traces.figures.join(name), text).unwrap_or(false);
    if !texts.iter().all(is_current) {
        return None;
    }
    let profile = traces.lock.map_or("", |(_, profile)| profile);
    let lock = Lock::of(run, profile, "", &texts).ok()?;
    if let Some((path, _)) = traces.lock {
        let committed = Lock::parse(&read_text(path).ok()?).ok()?;
        if !committed.says_the_same_as(&lock) {
            return None;
        }
    }
    Some(lock)
}

/// Whether a file holds a text and nothing else; read in small steps, since fresh memory costs more than comparing.
fn holds(path: &Path, text: &str) -> io::Result<bool> {
    regular(path)?;
    let mut file = File::open(path)?;
    let mut rest = text.as_bytes();
    let mut buffer = [0; 1 << 14];
    loop {
        let length = file.read(&mut buffer)?;
        if length == 0 {
            return Ok(rest.is_empty());
        }
        match rest.strip_prefix(&buffer[..length]) {
            Some(after) => rest = after,
            None => return Ok(false),
        }
    }
}
