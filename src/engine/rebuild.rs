//! Rebuild: a run from nothing against the committed lock. The first node that differs, in paper order, is looked into:
//! its pieces are compared value by value with those that the lock speaks of, where an ordinary store still has them, and
//! are made once more, on another number of threads, which tells a stage that is not reproducible from one that changed.
//!
//! | the node's recipe | made again here | verdict |
//! |---|---|---|
//! | any | differs from itself | not reproducible |
//! | that of the lock | the same, but recorded otherwise by the same compiler and system | not reproducible |
//! | that of the lock | the same | differs: another compiler or system, or the lock was edited |
//! | another | the same | differs: code or parameters changed |
//!
//! Tested in `tests/cache/verify.rs` and `tests/reliability/mutants.rs`.

use std::collections::BTreeSet;
use std::path::Path;

use rayon::iter::{IntoParallelRefIterator, ParallelIterator};
use serde::Serialize;

use crate::engine::codec::CODEC;
use crate::engine::difference::Difference;
use crate::engine::error::{Error, Result};
use crate::engine::id::{Id, schema_number};
use crate::engine::lock::{Line, Lock};
use crate::engine::manifest;
use crate::engine::run::Run;
use crate::engine::store::{Found, Store};
use crate::engine::threads::pool;
use crate::engine::twice::{elsewhere, keep};
use crate::engine::verify::{between, recipe_reason, toolchains};
use crate::text::count::counted;

/// How a run from nothing differs from a lock.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Rebuilt {
    /// The lines that differ, in the lock's order; those that follow from others are only counted.
    pub differences: Vec<String>,
    /// How many more lines differ: of nodes that read one that does, and of files.
    pub downstream: usize,
    /// The first node that differs in content.
    pub first: Option<First>,
}

/// The first node of the paper that differs in content.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct First {
    /// The node, and the first piece that differs, where that is known.
    pub node: String,
    /// The content that the lock states, or the id of the piece that it speaks of.
    pub earlier: String,
    /// The content or id that was made now.
    pub later: String,
    /// What differs within the piece: the lock's value first, or, where its object is gone, two makings of today.
    pub difference: Option<Difference>,
    /// Whether the stage gave the same content each time it was made now.
    pub reproducible: bool,
    /// What that tells, one sentence.
    pub verdict: String,
}

impl Rebuilt {
    /// A run that ended because a key was made twice with two ids while it went on.
    pub fn cut_short(error: &Error) -> Option<Self> {
        let Error::NotReproducible {
            node,
            recorded,
            made,
            difference,
            note,
        } = error
        else {
            return None;
        };
        let first = First {
            node: node.clone(),
            earlier: recorded.clone(),
            later: made.clone(),
            difference: difference.as_deref().cloned(),
            reproducible: false,
            verdict: note.clone(),
        };
        Some(Self {
            differences: vec![format!("{node}: it differs from itself")],
            downstream: 0,
            first: Some(first),
        })
    }

    /// The error that the process ends with, if anything differs.
    pub fn error(&self, lock: &Path) -> Option<Error> {
        if let Some(first) = self.first.as_ref().filter(|first| !first.reproducible) {
            return Some(Error::NotReproducible {
                node: first.node.clone(),
                recorded: first.earlier.clone(),
                made: first.later.clone(),
                difference: first.difference.clone().map(Box::new),
                note: self.with_others(&first.verdict),
            });
        }
        let (one, others) = self.differences.split_first()?;
        let mut lines = vec![format!("{} differs: {one}", lock.display())];
        if let Some(first) = &self.first {
            let difference = first.difference.as_ref();
            lines.extend(difference.map(|difference| format!("  {}: {difference}", first.node)));
            lines.push(format!("  {}", first.verdict));
        }
        lines.extend(others.iter().map(|other| format!("  {other}")));
        match self.downstream {
            0 => {}
            1 => lines.push("  1 more line of the lock follows from this".to_owned()),
            more => lines.push(format!("  {more} more lines of the lock follow from this")),
        }
        Some(Error::Difference(lines.join("\n")))
    }
}

impl Rebuilt {
    /// A verdict on the first difference, and how many more there are.
    fn with_others(&self, verdict: &str) -> String {
        match (self.differences.len() + self.downstream).saturating_sub(1) {
            0 => verdict.to_owned(),
            1 => format!("{verdict}\n  1 more line of the lock differs"),
            more => format!("{verdict}\n  {more} more lines of the lock differ"),
        }
    }
}

/// What a rebuild is compared with.
pub struct Against<'a> {
    /// The committed lock.
    pub lock: &'a Lock,
    /// The ordinary store, which may still have what the lock speaks of.
    pub ordinary: &'a Store,
    /// Whether all of the paper was asked for, so that a line that was not made is missed.
    pub whole: bool,
    /// The threads that the rebuild had.
    pub workers: usize,
}

/// Compares a finished run in an empty store, and the lock it gives, with a committed lock.
///
/// # Errors
/// A piece that cannot be made again, or a store that cannot be read.
pub fn compare(run: &Run<'_>, made: &Lock, against: &Against<'_>) -> Result<Rebuilt> {
    let mut spoiled = BTreeSet::new();
    let mut follows = BTreeSet::new();
    let mut first = None;
    for (node, it) in run.graph.nodes.iter().enumerate() {
        let name = it.name();
        let mut upstream = it.links.iter().flat_map(|link| &link.upstream);
        if upstream.any(|up| spoiled.contains(up)) {
            follows.insert(name.clone());
        }
        let line = against.lock.lines.iter().find(|line| line.name == name);
        let Some(line) = line.filter(|line| run.content(node) != Some(line.content)) else {
            continue;
        };
        spoiled.insert(node);
        if first.is_none() {
            first = Some(look_into(run, node, line, against)?);
        }
    }
    let mut committed = against.lock.clone();
    let is_made = |line: &Line| made.lines.iter().any(|own| own.name == line.name);
    committed.lines.retain(|line| against.whole || is_made(line));
    let mut differences = between(&committed, made);
    let all = differences.len();
    differences.retain(|difference| {
        let name = difference.split(": ").next().unwrap_or_default();
        // A published file follows from its node.
        !follows.contains(name) && (first.is_none() || !name.starts_with("file "))
    });
    Ok(Rebuilt {
        downstream: all - differences.len(),
        differences,
        first,
    })
}

fn look_into(run: &Run<'_>, node: usize, line: &Line, against: &Against<'_>) -> Result<First> {
    let it = &run.graph.nodes[node];
    let changed = |verdict: String| First {
        node: it.name(),
        earlier: line.content.to_string(),
        later: run.content(node).map(|id| id.to_string()).unwrap_or_default(),
        difference: None,
        reproducible: true,
        verdict,
    };
    if let Some(then) = line.pieces.filter(|then| *then != it.pieces.len()) {
        return Ok(changed(format!("{} -> {}", counted(then, "piece"), it.pieces.len())));
    }
    let earlier = earlier(run, node, line, against.ordinary);
    let id = |piece: usize| earlier.as_ref().and_then(|ids| ids.get(piece).copied().flatten());
    let pieces = (0..it.pieces.len()).filter(|piece| id(*piece).is_none() || id(*piece) != run.id(node, *piece));
    let differing: Vec<usize> = pieces.collect();
    let threads = if against.workers == 1 { 2 } else { 1 };
    if let Some((piece, again)) = made_otherwise(run, node, &differing, threads)? {
        return not_itself(run, node, piece, &again, against, threads);
    }
    let twice = format!(
        "made once more, on {}, it came out the same",
        counted(threads, "thread")
    );
    match differing.iter().find_map(|piece| Some((*piece, id(*piece)?))) {
        Some((piece, id)) => itself(run, (node, piece), &id, line, against, &twice),
        None => Ok(changed(format!("{twice}; {}", change(run, node, line, against)))),
    }
}

/// The first of some pieces that comes out otherwise when it is made again, with its new bytes.
fn made_otherwise(run: &Run<'_>, node: usize, pieces: &[usize], threads: usize) -> Result<Option<(usize, Vec<u8>)>> {
    let pool = pool(threads)?;
    let again = |piece: &usize| match run.compute(node, *piece) {
        Ok(bytes) if Some(id_of(run, node, &bytes)) == run.id(node, *piece) => None,
        Ok(bytes) => Some(Ok((*piece, bytes))),
        Err(error) => Some(Err(error)),
    };
    pool.install(|| pieces.par_iter().find_map_first(again)).transpose()
}

fn id_of(run: &Run<'_>, node: usize, bytes: &[u8]) -> Id {
    Id::of(CODEC, schema_number(run.graph.nodes[node].node.schema()), bytes)
}

/// A piece that differs from itself.
fn not_itself(
    run: &Run<'_>,
    node: usize,
    piece: usize,
    again: &[u8],
    against: &Against<'_>,
    threads: usize,
) -> Result<First> {
    let it = &run.graph.nodes[node];
    let schema = schema_number(it.node.schema());
    let id = run.id(node, piece).expect("a finished run knows every id");
    // What was left out of the store can only be made a third time.
    let (earlier, which) = match run.store.read(&id, Some(schema)) {
        Found::Bytes(bytes) => (bytes, "twice"),
        Found::Missing | Found::Damaged(_) => (run.compute(node, piece)?, "three times"),
    };
    let mut verdict = format!(
        "made {which} just now, on {} and {threads} threads, it differs from itself",
        against.workers
    );
    if against.ordinary.root().is_dir() {
        keep(against.ordinary, schema, &earlier);
        keep(against.ordinary, schema, again);
        verdict += "; both outputs are kept in quarantine/";
    }
    Ok(First {
        node: it.piece_name(piece),
        earlier: id.to_string(),
        later: id_of(run, node, again).to_string(),
        difference: it.node.difference(&earlier, again)?,
        reproducible: false,
        verdict,
    })
}

/// A piece that is the same each time, but not what it was.
fn itself(
    run: &Run<'_>,
    (node, piece): (usize, usize),
    id: &Id,
    line: &Line,
    against: &Against<'_>,
    twice: &str,
) -> Result<First> {
    let it = &run.graph.nodes[node];
    let schema = schema_number(it.node.schema());
    let bytes = run.bytes(node, piece)?;
    let earlier = match against.ordinary.read(id, Some(schema)) {
        Found::Bytes(bytes) => Some(bytes),
        Found::Missing | Found::Damaged(_) => None,
    };
    // What an older layout says cannot be decoded any more.
    let difference = earlier
        .as_ref()
        .and_then(|earlier| it.node.difference(earlier, &bytes).ok().flatten());
    let record = run.key(node, piece).and_then(|key| against.ordinary.record(&key));
    let since = record
        .filter(|record| record.id == id.to_string())
        .map(|record| elsewhere(&record, ""));
    let mut verdict = match since.as_deref() {
        Some("") => format!("{twice}, yet it was recorded otherwise by the same compiler on the same system"),
        Some(since) => format!("{twice}; it was recorded with {since}"),
        None => format!("{twice}; {}", change(run, node, line, against)),
    };
    if since.as_deref() == Some("") {
        keep(against.ordinary, schema, &bytes);
        if let Some(earlier) = &earlier {
            keep(against.ordinary, schema, earlier);
        }
        verdict += "; what is at hand is kept in quarantine/";
    }
    if earlier.is_none() {
        verdict += "; the recorded output is gone";
    }
    Ok(First {
        node: it.piece_name(piece),
        earlier: id.to_string(),
        later: id_of(run, node, &bytes).to_string(),
        difference,
        reproducible: since.as_deref() != Some(""),
        verdict,
    })
}

/// What differs between the lock and now, for a node that is the same each time it is made.
fn change(run: &Run<'_>, node: usize, line: &Line, against: &Against<'_>) -> String {
    let recipe = run.recipe(node, &|node| run.content(node));
    let reason = if recipe == line.recipe {
        "the lock was made on another system or by another compiler, or was edited".to_owned()
    } else {
        recipe_reason(run, against.lock, node, line)
    };
    let told: Vec<String> = std::iter::once(reason).chain(toolchains(against.lock)).collect();
    told.join("; ")
}

/// The ids of a node's pieces that the lock speaks of; else, where they differ, those recorded under the same keys.
fn earlier(run: &Run<'_>, node: usize, line: &Line, ordinary: &Store) -> Option<Vec<Option<Id>>> {
    let pieces = run.graph.nodes[node].pieces.len();
    if let Some(ids) = manifest::pieces(ordinary, &line.content) {
        return Some(ids.into_iter().map(Some).collect());
    }
    if line.pieces == Some(1) && ordinary.has(&line.content) {
        return Some(vec![Some(line.content)]);
    }
    let recorded = |piece| Id::parse(&ordinary.record(&run.key(node, piece)?)?.id);
    let ids: Vec<Option<Id>> = (0..pieces).map(recorded).collect();
    let is_other = |(piece, id): (usize, &Option<Id>)| id.is_some() && *id != run.id(node, piece);
    ids.iter().enumerate().any(is_other).then_some(ids)
}
