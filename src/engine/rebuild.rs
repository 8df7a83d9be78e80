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
use std::fs;
use std::path::{Path, PathBuf};

use rayon::iter::{IntoParallelRefIterator, ParallelIterator};
use serde::Serialize;

use crate::engine::audit;
use crate::engine::codec::CODEC;
use crate::engine::difference::Difference;
use crate::engine::error::{Error, Result};
use crate::engine::id::{Id, schema_number};
use crate::engine::lock::{Line, Lock};
use crate::engine::record::Record;
use crate::engine::run::{Run, content_of};
use crate::engine::store::{Found, Store};
use crate::engine::twice::{elsewhere, keep};
use crate::engine::verify::{between, recipe_reason, toolchains};

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
                note: first.verdict.clone(),
            });
        }
        let (one, others) = self.differences.split_first()?;
        let mut text = format!("{} differs: {one}", lock.display());
        if let Some(first) = &self.first {
            if let Some(difference) = &first.difference {
                text += &format!("\n  {}: {difference}", first.node);
            }
            text += &format!("\n  {}", first.verdict);
        }
        if !others.is_empty() {
            text += &format!("\nand {} more:\n{}", others.len(), others.join("\n"));
        }
        match self.downstream {
            0 => {}
            1 => text += "\n1 more line of the lock follows from this",
            more => text += &format!("\n{more} more lines of the lock follow from this"),
        }
        Some(Error::Difference(text))
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
    let pieces: Vec<usize> = (0..run.graph.nodes[node].pieces.len()).collect();
    let recorded = recorded(run, node, line, against.ordinary);
    let differs = |piece: &usize| {
        let record = recorded.as_ref().and_then(|records| records[*piece].as_ref());
        record.is_none_or(|record| Some(&record.id) != run.id(node, *piece).map(|id| id.to_string()).as_ref())
    };
    let differing: Vec<usize> = pieces.into_iter().filter(differs).collect();
    let threads = if against.workers == 1 { 2 } else { 1 };
    if let Some((piece, again)) = made_otherwise(run, node, &differing, threads)? {
        return not_itself(run, node, piece, &again, against, threads);
    }
    let record = recorded.as_ref().and_then(|records| {
        differing
            .iter()
            .find_map(|piece| Some((*piece, records[*piece].as_ref()?)))
    });
    let twice =
        format!("made once more, on {threads} threads, it came out the same").replace(" 1 threads", " 1 thread");
    match record {
        Some((piece, record)) => as_recorded(run, node, piece, record, line, against, &twice),
        None => Ok(First {
            node: run.graph.nodes[node].name(),
            earlier: line.content.to_string(),
            later: run.content(node).map(|id| id.to_string()).unwrap_or_default(),
            difference: None,
            reproducible: true,
            verdict: format!("{twice}; {}", change(run, node, line, against)),
        }),
    }
}

/// The first of some pieces that comes out otherwise when it is made again, with its new bytes.
fn made_otherwise(run: &Run<'_>, node: usize, pieces: &[usize], threads: usize) -> Result<Option<(usize, Vec<u8>)>> {
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(threads)
        .build()
        .map_err(|why| Error::Usage(format!("cannot start the workers: {why}")))?;
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

/// A piece that is the same each time, but not what was recorded.
fn as_recorded(
    run: &Run<'_>,
    node: usize,
    piece: usize,
    record: &Record,
    line: &Line,
    against: &Against<'_>,
    twice: &str,
) -> Result<First> {
    let it = &run.graph.nodes[node];
    let schema = schema_number(it.node.schema());
    let bytes = run.bytes(node, piece)?;
    let earlier = Id::parse(&record.id).map(|id| against.ordinary.read(&id, Some(schema)));
    // An object of another layout under the same name has nothing that could be compared.
    let difference = match &earlier {
        Some(Found::Bytes(earlier)) => it.node.difference(earlier, &bytes).ok().flatten(),
        _ => None,
    };
    let since = elsewhere(record, "");
    let same_key = run.key(node, piece).is_some_and(|key| key.to_string() == record.key);
    let reproducible = !same_key || !since.is_empty();
    let mut verdict = match (same_key, since.as_str()) {
        (true, "") => {
            keep(against.ordinary, schema, &bytes);
            if let Some(Found::Bytes(earlier)) = &earlier {
                keep(against.ordinary, schema, earlier);
            }
            let yet = "yet it was recorded otherwise by the same compiler on the same system";
            format!("{twice}, {yet}; what is at hand is kept in quarantine/")
        }
        (true, since) => format!("{twice}; it was recorded with {since}"),
        (false, _) => format!("{twice}; {}", change(run, node, line, against)),
    };
    if difference.is_none() {
        verdict += "; the recorded output is gone";
    }
    Ok(First {
        node: it.piece_name(piece),
        earlier: record.id.clone(),
        later: id_of(run, node, &bytes).to_string(),
        difference,
        reproducible,
        verdict,
    })
}

/// What differs between the lock and now, for a node that is the same each time it is made.
fn change(run: &Run<'_>, node: usize, line: &Line, against: &Against<'_>) -> String {
    let recipe = run.recipe(node, &|node| run.content(node));
    let reason = if recipe == line.recipe {
        "the lock was made on another system or by another compiler, or was edited".to_owned()
    } else {
        recipe_reason(run, run.graph, against.lock, node, line)
    };
    let told: Vec<String> = std::iter::once(reason).chain(toolchains(against.lock)).collect();
    told.join("; ")
}

/// The records of a node's pieces that the lock speaks of, or, where there are none such, of the same keys.
fn recorded(run: &Run<'_>, node: usize, line: &Line, ordinary: &Store) -> Option<Vec<Option<Record>>> {
    let it = &run.graph.nodes[node];
    let under = |code: &[u8; 32]| -> Vec<Option<Record>> {
        let record = |piece| ordinary.record(&run.key_under(code, node, piece)?);
        (0..it.pieces.len()).map(record).collect()
    };
    let is_of_the_lock = |records: &Vec<Option<Record>>| {
        let id = |record: &Option<Record>| Id::parse(&record.as_ref()?.id);
        let ids: Option<Vec<Id>> = records.iter().map(id).collect();
        ids.is_some_and(|ids| content_of(&ids) == line.content)
    };
    let own = under(&it.code);
    if is_of_the_lock(&own) {
        return Some(own);
    }
    let earlier = codes(ordinary, it.node.name());
    let of_the_lock = earlier.iter().map(under).find(is_of_the_lock);
    let is_other = |(piece, record): (usize, &Option<Record>)| {
        let made = run.id(node, piece).map(|id| id.to_string());
        record.as_ref().is_some_and(|record| Some(&record.id) != made.as_ref())
    };
    of_the_lock.or_else(|| own.iter().enumerate().any(is_other).then_some(own))
}

/// Every code fingerprint that a store has records of a stage under.
fn codes(store: &Store, stage: &str) -> BTreeSet<[u8; 32]> {
    let files = audit::files(&store.root().join("records")).unwrap_or_default();
    let code = |file: &PathBuf| {
        let record = Record::parse(&fs::read_to_string(file).ok()?)?;
        let of_stage = record.node.split('/').next() == Some(stage);
        Some(
            *blake3::Hash::from_hex(&record.code)
                .ok()
                .filter(|_| of_stage)?
                .as_bytes(),
        )
    };
    files.iter().filter_map(|(file, _)| code(file)).collect()
}
