//! The code table: per file two hashes, per stage the files and the crates its results depend on.

use crate::code_graph::CodeGraph;
use crate::crate_graph::{Crate, CrateGraph};
use crate::modules::Sources;
use crate::tokens::{byte_hash, token_hash};
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// The manifests: not in any stage's files, but a binary older than them is old.
const MANIFESTS: [&str; 2] = ["Cargo.lock", "Cargo.toml"];

/// Hashes of one file, in hex.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct FileRow {
    /// BLAKE3 of the normal form; of a manifest, of its bytes.
    pub(crate) tokens: String,
    /// BLAKE3 of the bytes.
    pub(crate) bytes: String,
}

/// What the results of one stage depend on.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct StageRow {
    /// Path -> token hash.
    pub(crate) files: BTreeMap<String, String>,
    /// The outside crates.
    pub(crate) crates: BTreeSet<Crate>,
}

/// The table that the build script writes.
pub(crate) struct CodeTable {
    /// Path -> hashes, for every file of the package's trees and the manifests.
    pub(crate) files: BTreeMap<String, FileRow>,
    /// NAME -> what the stage depends on.
    pub(crate) stages: BTreeMap<String, StageRow>,
}

impl CodeTable {
    /// Computes the table from the texts of the sources and the manifests.
    pub(crate) fn new(sources: &Sources, manifest: &str, lock: &str) -> Result<Self, String> {
        let crates = CrateGraph::new(manifest, lock)?;
        let code = CodeGraph::new(sources, crates.names())?;
        let mut files = BTreeMap::new();
        for (path, file) in &code.tree.files {
            let row = FileRow {
                tokens: token_hash(&file.syntax),
                bytes: byte_hash(&sources[path]),
            };
            files.insert(path.clone(), row);
        }
        let mut stages = BTreeMap::new();
        for stage in &code.stages {
            let closure = code.closure(stage);
            let names = closure
                .iter()
                .flat_map(|path| code.links[path].crates.iter().cloned())
                .collect();
            let row = StageRow {
                files: closure
                    .into_iter()
                    .map(|path| (path.clone(), files[&path].tokens.clone()))
                    .collect(),
                crates: crates.closure(&names),
            };
            if stages.insert(stage.name.clone(), row).is_some() {
                return Err(format!("{}: another stage is named `{}` too", stage.file, stage.name));
            }
        }
        for (path, text) in MANIFESTS.into_iter().zip([lock, manifest]) {
            files.insert(
                path.to_owned(),
                FileRow {
                    tokens: byte_hash(text),
                    bytes: byte_hash(text),
                },
            );
        }
        Ok(Self { files, stages })
    }
}

/// Reads every `.rs` file under `src` and `stages`, but for the build script.
pub(crate) fn read_sources(root: &Path) -> std::io::Result<Sources> {
    let mut sources = Sources::new();
    for folder in ["src", "stages"] {
        if root.join(folder).is_dir() {
            read_folder(root, folder, &mut sources)?;
        }
    }
    Ok(sources)
}

fn read_folder(root: &Path, folder: &str, sources: &mut Sources) -> std::io::Result<()> {
    for entry in std::fs::read_dir(root.join(folder))? {
        let entry = entry?;
        let Some(path) = entry.file_name().to_str().map(|name| format!("{folder}/{name}")) else {
            continue;
        };
        if path == "src/build" {
            continue;
        }
        if entry.file_type()?.is_dir() {
            read_folder(root, &path, sources)?;
        } else if Path::new(&path).extension().is_some_and(|extension| extension == "rs") {
            sources.insert(path, std::fs::read_to_string(entry.path())?);
        }
    }
    Ok(())
}
