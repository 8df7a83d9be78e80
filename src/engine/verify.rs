//! Verify: the committed lock against code, parameters and published files (no store needed), and two locks.
//!
//! A recipe tells that a node differs; what the lock was made with tells in what: outside crates by name, code,
//! parameters. A run from nothing is compared in `rebuild`, the store itself in `audit`. Tested in
//! `tests/cache/{locks,verify}.rs`.

use std::path::Path;

use crate::engine::code;
use crate::engine::disk::read_regular;
use crate::engine::graph::Graph;
use crate::engine::id::Id;
use crate::engine::key::KEY_SCHEMA;
use crate::engine::lock::{Line, Lock, crates, recipes, short};
use crate::engine::run::Run;
use crate::text::count::counted;

/// Every way in which code, parameters and published files differ from a lock; empty if none.
pub fn against_lock(run: &Run<'_>, lock: &Lock, figures: &Path) -> Vec<String> {
    let mut differences = Vec::new();
    let mut known: Vec<&Line> = lock.lines.iter().collect();
    for (index, (node, recipe)) in run.graph.nodes.iter().zip(recipes(run, lock)).enumerate() {
        let name = node.name();
        let Some(place) = known.iter().position(|line| line.name == name) else {
            differences.push(format!("{name}: not in the lock"));
            continue;
        };
        let line = known.remove(place);
        if line.pieces != Some(node.pieces.len()) {
            let pieces = line.pieces.map_or("-".to_owned(), |pieces| pieces.to_string());
            differences.push(format!(
                "{name}: {}, the lock says {pieces}",
                counted(node.pieces.len(), "piece")
            ));
        } else if line.recipe != recipe {
            differences.push(format!("{name}: {}", recipe_reason(run, lock, index, line)));
        }
    }
    for line in known {
        match line.name.strip_prefix("file ") {
            Some(path) => differences.extend(file_difference(figures, path, &line.content)),
            None => differences.push(format!("{}: in the lock, but no node of this pipeline", line.name)),
        }
    }
    differences
}

/// What a lock does not say: its own profile, seed and layout of keys, and a file of each published node; empty if nothing is amiss.
///
/// `layout` holds published nodes and the folders they are written to.
pub fn omissions(graph: &Graph, lock: &Lock, profile: &str, layout: &[(usize, String)]) -> Vec<String> {
    let mut found = Vec::new();
    if lock.profile != profile {
        found.push(format!("head: expected profile {profile}, found {}", lock.profile));
    }
    if lock.seed != graph.seed {
        found.push(format!("head: expected seed {}, found {}", graph.seed, lock.seed));
    }
    if lock.keys != KEY_SCHEMA {
        found.push(format!("head: expected keys {KEY_SCHEMA}, found {}", lock.keys));
    }
    for (node, prefix) in layout {
        let stem = format!("file {prefix}{}.", graph.nodes[*node].node.name());
        if !lock.lines.iter().any(|line| line.name.starts_with(&stem)) {
            found.push(format!("{stem}*: expected a published file, found none in the lock"));
        }
    }
    found
}

/// What of a node differs from its line, as far as the lock tells.
pub(crate) fn recipe_reason(run: &Run<'_>, lock: &Lock, node: usize, line: &Line) -> String {
    let graph = run.graph;
    let it = &graph.nodes[node];
    let contents = lock.contents();
    let content = |node: usize| contents.get(graph.nodes[node].name().as_str()).copied();
    if lock.seed != graph.seed && run.recipe_under(lock.seed, node, &content) == line.recipe {
        return format!("root seed {} -> {}", lock.seed, graph.seed);
    }
    match code_reason(lock, it.node.name()) {
        CodeReason::Unknown => "its code, parameters or inputs are not those of the lock".to_owned(),
        CodeReason::Crates(crates) => format!("outside crates: {}", crates.join(", ")),
        CodeReason::Own => "its code is not that of the lock".to_owned(),
        CodeReason::Same if it.links.is_empty() => "its parameters are not those of the lock".to_owned(),
        CodeReason::Same => "its parameters or inputs are not those of the lock, its code is".to_owned(),
    }
}

/// What the lock tells of a stage's code.
enum CodeReason {
    Unknown,
    Same,
    /// Crates that came, went or changed their version.
    Crates(Vec<String>),
    Own,
}

fn code_reason(lock: &Lock, stage: &str) -> CodeReason {
    let (Some(then), Some(now)) = (lock.code.get(stage), code::of(stage)) else {
        return CodeReason::Unknown;
    };
    if *then == short(now) {
        return CodeReason::Same;
    }
    let changed: Vec<String> = crates(std::iter::once(now))
        .into_iter()
        .filter_map(|(name, now)| crate_change(&name, lock.crates.get(&name).map_or(&[], Vec::as_slice), &now))
        .collect();
    if changed.is_empty() {
        CodeReason::Own
    } else {
        CodeReason::Crates(changed)
    }
}

/// `pxfm 0.1.30 -> 0.1.31`; none if the lock lists every version, be it for this stage or another.
fn crate_change(name: &str, then: &[String], now: &[String]) -> Option<String> {
    let without = |all: &[String], others: &[String]| {
        let left: Vec<&str> = all
            .iter()
            .filter(|it| !others.contains(it))
            .map(String::as_str)
            .collect();
        left.join(" and ")
    };
    match (without(then, now), without(now, then)) {
        (_, new) if new.is_empty() => None,
        (old, new) if old.is_empty() => Some(format!("{name} {new}, new")),
        (old, new) => Some(format!("{name} {old} -> {new}")),
    }
}

/// The compilers, where another one made the lock; alone that is no difference.
pub fn toolchains(lock: &Lock) -> Option<String> {
    let differ = lock.made_with != code::RUSTC;
    differ.then(|| format!("the lock was made with {}, this is {}", lock.made_with, code::RUSTC))
}

/// Every line of a lock that says something else than the store's records of the same recipe; empty if none.
pub fn against_store(run: &Run<'_>, lock: &Lock) -> Vec<String> {
    let mut differences = Vec::new();
    for (index, (node, recipe)) in run.graph.nodes.iter().zip(recipes(run, lock)).enumerate() {
        for piece in 0..node.pieces.len() {
            run.decide(index, piece);
        }
        let name = node.name();
        let line = lock
            .lines
            .iter()
            .find(|line| line.name == name && line.recipe == recipe);
        let Some((line, content)) = line.zip(run.content(index)) else {
            continue;
        };
        if line.content != content {
            let (then, now) = (head(&line.content), head(&content));
            differences.push(format!("{name}: the lock says {then}, the store {now}"));
        } else if run.bytes_of_node(index).is_some_and(|bytes| bytes != line.bytes) {
            differences.push(format!("{name}: another number of bytes in the lock than in the store"));
        }
    }
    differences
}

fn file_difference(figures: &Path, path: &str, content: &Id) -> Option<String> {
    // A lock is hostile input: a path in it may not leave the figures folder.
    let plain = |part: &str| !part.is_empty() && part != "." && part != ".." && !part.contains('\\');
    if !path.split('/').all(plain) {
        return Some(format!("file {path}: no path within the figures folder"));
    }
    match read_regular(&figures.join(path)) {
        Err(why) => Some(format!("file {path}: {why}")),
        Ok(bytes) if blake3::hash(&bytes).as_bytes() != &content.0 => {
            Some(format!("file {path}: its bytes are not those of the lock"))
        }
        Ok(_) => None,
    }
}

/// Enough of an id to be found by.
fn head(id: &Id) -> String {
    format!("{}..", &id.to_string()[..12])
}

/// What differs in two lines of one content.
fn beside_content(line: &Line, other: &Line) -> Option<&'static str> {
    if line.recipe != other.recipe {
        Some("recipe")
    } else if line.pieces != other.pieces {
        Some("number of pieces")
    } else {
        (line.bytes != other.bytes).then_some("number of bytes")
    }
}

/// The lines in which two locks differ, the first one first; empty if none.
pub fn between(committed: &Lock, made: &Lock) -> Vec<String> {
    let mut differences = Vec::new();
    let mut rest: Vec<&Line> = made.lines.iter().collect();
    for line in &committed.lines {
        match rest.iter().position(|other| other.name == line.name) {
            None => differences.push(format!("{}: in the lock, but was not made", line.name)),
            Some(place) => {
                let other = rest.remove(place);
                if other.content != line.content {
                    let (name, then, now) = (&line.name, head(&line.content), head(&other.content));
                    differences.push(format!("{name}: the lock says {then}, made {now}"));
                } else if let Some(what) = beside_content(line, other) {
                    differences.push(format!("{}: same content, another {what}", line.name));
                }
            }
        }
    }
    differences.extend(
        rest.iter()
            .map(|line| format!("{}: made, but not in the lock", line.name)),
    );
    differences
}
