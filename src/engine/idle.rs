//! Idle: whether everything is as the last run left it, so that a run has nothing to do but to say so.
//!
//! Nothing is written on the word of a stat: objects are as the index has them, published files as they were when they last
//! were compared with outputs that were read and verified ([`Shown`]), and the lock is compared with the committed one.
//! Whatever differs, the run goes the long way.
//! Tested in `tests/cache/index.rs`.

use std::collections::BTreeMap;
use std::path::Path;

use crate::engine::case::Axis;
use crate::engine::disk::read_text;
use crate::engine::event::Event;
use crate::engine::index::{Belief, Index};
use crate::engine::lock::{Content, Lock};
use crate::engine::publish;
use crate::engine::run::Run;
use crate::engine::runs;
use crate::engine::shown::{self, Shown};

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
    let Some((shown, compared)) = shown(run, index.name(), traces) else {
        return false;
    };
    let Some(files) = shown.contents().filter(|files| is_locked(run, files, traces)) else {
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
    for (path, content) in files {
        let (id, written) = (content.id.to_string(), false);
        run.tell(&Event::DidPublish { path, id, written });
    }
    // Both only make the next run faster.
    if compared {
        let _ = shown.note(run.store, index.name());
    }
    if rehashed {
        let _ = index.renew(run);
    }
    true
}

/// The published files, if they are what a run would write; and whether that took comparing them.
fn shown(run: &Run<'_>, name: &str, traces: &Traces<'_>) -> Option<(Shown, bool)> {
    let layout = publish::layout(run.graph, traces.axis, traces.values);
    let outputs = shown::outputs(run, &layout)?;
    let noted = Shown::read(run.store.root(), name);
    if let Some(noted) = noted.filter(|noted| noted.vouches_for(&outputs, traces.figures)) {
        return Some((noted, false));
    }
    for (node, _) in layout {
        let record = run.key(node, 0).and_then(|key| run.store.record(&key))?;
        if Some(record.id) != run.id(node, 0).map(|id| id.to_string()) {
            return None;
        }
    }
    let texts = publish::texts(run, traces.axis, traces.values).ok()?;
    Some((Shown::compared(outputs, &texts, traces.figures)?, true))
}

/// Whether the committed lock, if the run has one, is what a run would write.
fn is_locked(run: &Run<'_>, files: &BTreeMap<String, Content>, traces: &Traces<'_>) -> bool {
    let Some((path, profile)) = traces.lock else {
        return true;
    };
    let committed = read_text(path).ok().and_then(|text| Lock::parse(&text).ok());
    let due = Lock::to_compare(run, profile, files.clone());
    committed.is_some_and(|committed| due.is_ok_and(|due| committed.says_the_same_as(&due)))
}
