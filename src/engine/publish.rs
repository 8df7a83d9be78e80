//! Publishing: the text files of figures and tables, written into a folder a person reads.
//!
//! The first value of the first axis (the first ship) writes to the folder itself, each further one to a folder of its
//! name; the full set lies in each. A file is written only if its bytes differ.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use crate::engine::case::Axis;
use crate::engine::error::{Error, Result};
use crate::engine::event::Event;
use crate::engine::graph::Graph;
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
        let bytes = run.bytes(node, 0)?;
        for (name, text) in run.graph.nodes[node].node.published(&bytes)? {
            texts.insert(format!("{prefix}{name}"), text);
        }
    }
    Ok(texts)
}

/// Writes what differs.
///
/// # Errors
/// A folder or file that cannot be written.
pub fn publish(run: &Run<'_>, texts: &BTreeMap<String, String>, folder: &Path) -> Result<()> {
    for (name, text) in texts {
        let path = folder.join(name);
        let same = fs::read(&path).is_ok_and(|old| old == text.as_bytes());
        if !same {
            write(&path, text)?;
        }
        let id = blake3::hash(text.as_bytes()).to_hex().to_string();
        run.tell(&Event::DidPublish {
            path: name.clone(),
            id,
            written: !same,
        });
    }
    Ok(())
}

fn write(path: &Path, text: &str) -> Result<()> {
    let folder = path.parent().expect("a published file lies in a folder");
    fs::create_dir_all(folder).map_err(Error::io("make the figures folder", folder))?;
    let temporary = path.with_extension(format!("{}.tmp", std::process::id()));
    let result = fs::write(&temporary, text).and_then(|()| fs::rename(&temporary, path));
    if result.is_err() {
        // The error to report is the first one.
        let _ = fs::remove_file(&temporary);
    }
    result.map_err(Error::io("write the figure", path))
}
