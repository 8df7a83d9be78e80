//! Verify: the committed lock against the code and parameters (no store needed), or against a run from nothing.

use std::fs;
use std::path::Path;

use crate::engine::graph::Graph;
use crate::engine::id::Id;
use crate::engine::lock::{Line, Lock, recipes};
use crate::engine::run::Run;

/// Every way in which code, parameters and published files differ from a lock; empty if none.
pub fn against_lock(run: &Run<'_>, graph: &Graph, lock: &Lock, figures: &Path) -> Vec<String> {
    let mut differences = Vec::new();
    let mut known: Vec<&Line> = lock.lines.iter().collect();
    for (node, recipe) in graph.nodes.iter().zip(recipes(run, graph, lock)) {
        let name = node.name();
        let Some(place) = known.iter().position(|line| line.name == name) else {
            differences.push(format!("{name}: not in the lock"));
            continue;
        };
        let line = known.remove(place);
        if line.pieces != Some(node.pieces.len()) {
            let pieces = line.pieces.map_or("-".to_owned(), |pieces| pieces.to_string());
            differences.push(format!("{name}: {} pieces, the lock says {pieces}", node.pieces.len()));
        } else if line.recipe != recipe {
            differences.push(format!(
                "{name}: its code, parameters or inputs are not those of the lock"
            ));
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

fn file_difference(figures: &Path, path: &str, content: &Id) -> Option<String> {
    // A lock is hostile input: a path in it may not leave the figures folder.
    let plain = |part: &str| !part.is_empty() && part != "." && part != ".." && !part.contains('\\');
    if !path.split('/').all(plain) {
        return Some(format!("file {path}: no path within the figures folder"));
    }
    match fs::read(figures.join(path)) {
        Err(why) => Some(format!("file {path}: {why}")),
        Ok(bytes) if blake3::hash(&bytes).as_bytes() != &content.0 => {
            Some(format!("file {path}: its bytes are not those of the lock"))
        }
        Ok(_) => None,
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
                    let name = &line.name;
                    differences.push(format!(
                        "{name}: the lock says {}, made {}",
                        line.content, other.content
                    ));
                } else if other != line {
                    differences.push(format!("{}: same content, another recipe", line.name));
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
