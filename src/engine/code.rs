//! The code of every stage, as it was when this binary was built: which files and crates its results depend on.
//!
//! The table is written by the build script (`src/build/`), which tells what is in a stage's closure. Token hashes enter
//! the fingerprint, so that comments, docs, formatting and unit tests change nothing; byte hashes tell only whether the
//! binary is older than its sources. Tested in `tests/invalidation.rs`.

use std::path::Path;

include!(concat!(env!("OUT_DIR"), "/code_table.rs"));

/// The compiler that built this binary.
pub const RUSTC: &str = env!("ENCOUNTER_RUSTC");

/// One source file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FileCode {
    /// Relative to the package, with forward slashes.
    pub path: &'static str,
    /// BLAKE3 of the tokens without comments, docs and unit tests, 64 hex digits.
    pub tokens: &'static str,
    /// BLAKE3 of the bytes, 64 hex digits.
    pub bytes: &'static str,
}

/// One outside crate, as Cargo.lock has it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CrateCode {
    /// The name of the package.
    pub name: &'static str,
    /// The locked version.
    pub version: &'static str,
    /// The locked checksum, 64 hex digits; empty for a local package.
    pub checksum: &'static str,
    /// How Cargo.toml declares it (version, features); empty if only other crates do.
    pub declared: &'static str,
}

/// What the results of one stage depend on.
#[derive(Clone, Copy, Debug)]
pub struct StageCode {
    /// The stage's NAME.
    pub stage: &'static str,
    /// Its files, sorted by path.
    pub files: &'static [&'static FileCode],
    /// Its outside crates and theirs, sorted by name and version.
    pub crates: &'static [CrateCode],
}

/// The code of a stage; none for a stage that is not in this package's `stages/`.
pub fn of(stage: &str) -> Option<&'static StageCode> {
    STAGES.iter().find(|code| code.stage == stage)
}

/// The files whose bytes on disk are not those this binary was built from, or that are gone; sorted.
pub fn stale(root: &Path) -> Vec<String> {
    let is_current = |file: &&FileCode| {
        std::fs::read(root.join(file.path)).is_ok_and(|bytes| blake3::hash(&bytes).to_hex().as_str() == file.bytes)
    };
    FILES
        .iter()
        .filter(|file| !is_current(file))
        .map(|file| file.path.to_owned())
        .collect()
}

impl StageCode {
    /// The fingerprint: BLAKE3 over files (path, tokens) and crates, sorted, counts and lengths before all.
    pub fn fingerprint(&self) -> [u8; 32] {
        let files = self.files.iter().map(|file| vec![file.path, file.tokens]);
        let crates = self
            .crates
            .iter()
            .map(|it| vec![it.name, it.version, it.checksum, it.declared]);
        let mut text = Vec::new();
        for mut rows in [files.collect::<Vec<_>>(), crates.collect()] {
            rows.sort_unstable();
            text.extend((rows.len() as u64).to_le_bytes());
            for field in rows.into_iter().flatten() {
                text.extend((field.len() as u64).to_le_bytes());
                text.extend(field.as_bytes());
            }
        }
        // In one go, which hashes several blocks at once.
        blake3::derive_key("encounter 1 code", &text)
    }
}
