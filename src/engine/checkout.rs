//! Checkout: what belongs to one copy of the repository, below its `artifacts/` folder, whatever folder is the store.
//!
//! A store holds content that several checkouts may share. Locks, figures, copies of edited figures and the list of what was
//! published belong to one checkout alone, so that a run in one never makes another's `verify --lock` fail.
//!
//! | below `artifacts/` | what it is |
//! |---|---|
//! | `NAME.lock` | committed contents of a profile; only `run --update-lock` changes it |
//! | `figures/PROFILE/`, `figures/WHAT-IF/` | published sets, each with its `parameters.toml` |
//! | `edited/` | copies of published files that somebody had edited before a run restored them |
//! | `published` | hash and place of each file that a run has written |

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use toml::Value;

use crate::engine::disk::read_text;
use crate::engine::lock::Lock;
use crate::engine::params::ParamsFile;

/// The longest name of a what-if, characters.
const LONGEST_NAME: usize = 64;

/// One copy of the repository.
#[derive(Clone, Debug)]
pub struct Checkout {
    root: PathBuf,
}

impl Checkout {
    /// The checkout whose folder this is.
    pub fn at(root: &Path) -> Self {
        Self { root: root.to_owned() }
    }

    /// Its folder.
    pub fn root(&self) -> &Path {
        &self.root
    }

    /// The folder of everything that runs make here and that is no figure of the paper.
    pub fn artifacts(&self) -> PathBuf {
        self.root.join("artifacts")
    }

    /// The lock of a profile or of an output that only runs on request.
    pub fn lock_file(&self, name: &str) -> PathBuf {
        self.artifacts().join(format!("{name}.lock"))
    }

    /// The figures folder of a profile or what-if.
    pub fn figures(&self, name: &str) -> PathBuf {
        self.artifacts().join("figures").join(name)
    }

    /// The locks that can be read, by name of their files.
    pub fn locks(&self) -> BTreeMap<String, Lock> {
        let mut locks = BTreeMap::new();
        for entry in fs::read_dir(self.artifacts()).into_iter().flatten().flatten() {
            let file = entry.file_name().to_string_lossy().into_owned();
            if let Some(name) = file.strip_suffix(".lock")
                && let Some(lock) = read_text(&entry.path()).ok().and_then(|text| Lock::parse(&text).ok())
            {
                locks.insert(name.to_owned(), lock);
            }
        }
        locks
    }

    /// The name of a figures folder in the list of what was published: relative to the checkout where it lies within, so
    /// that a checkout that is moved keeps its list.
    pub(crate) fn place(&self, folder: &Path) -> String {
        let root = if self.root.as_os_str().is_empty() {
            Path::new(".")
        } else {
            &self.root
        };
        let whole = |path: &Path| path.canonicalize().or_else(|_| std::path::absolute(path));
        let (Ok(root), Ok(folder)) = (whole(root), whole(folder)) else {
            return folder.display().to_string();
        };
        folder.strip_prefix(&root).unwrap_or(&folder).display().to_string()
    }
}

/// Checks the name of a what-if, which becomes a folder: letters, digits, `_` and `-`, no profile's own.
///
/// # Errors
/// What was expected and found, in words.
pub fn check_name(name: &str, profiles: &[&str]) -> Result<(), String> {
    let is_plain = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '-';
    if name.is_empty() || name.len() > LONGEST_NAME || !name.chars().all(is_plain) || name.starts_with('-') {
        return Err(format!(
            "expected at most {LONGEST_NAME} letters, digits, `_` and `-`, no `-` at the head, found `{name}`"
        ));
    }
    // Some file systems take `Paper` and `paper` for one folder.
    if profiles.iter().any(|profile| profile.eq_ignore_ascii_case(name)) {
        return Err(format!(
            "expected a name that is no profile's ({}), found `{name}`",
            profiles.join(", ")
        ));
    }
    Ok(())
}

/// The name of a what-if that was given none: the hash of what differs from the profile, so that the same set of
/// parameters always goes to the same folder.
pub fn derived_name(params: &ParamsFile, profile: &ParamsFile, name: &str) -> String {
    let (mine, base) = (spelled(params), spelled(profile));
    let mut hasher = blake3::Hasher::new_derive_key("encounter 1 what-if");
    let mut field = |text: &str| {
        hasher.update(&(text.len() as u64).to_le_bytes());
        hasher.update(text.as_bytes());
    };
    field(name);
    for (path, value) in mine.iter().filter(|(path, value)| base.get(*path) != Some(*value)) {
        field(path);
        field(value);
    }
    for path in base.keys().filter(|path| !mine.contains_key(*path)) {
        field(path);
        field("gone");
    }
    format!("whatif-{}", &hasher.finalize().to_hex()[..8])
}

/// Every single value by its path, numbers in one spelling: 7, 7.0 and 7.00 are one value.
fn spelled(params: &ParamsFile) -> BTreeMap<String, String> {
    let mut leaves = BTreeMap::new();
    for (key, value) in params.table() {
        spell(&format!("{key:?}"), value, &mut leaves);
    }
    leaves
}

/// Spells the single values below a path; a key is quoted, so that no dot within one is taken for a level.
fn spell(path: &str, value: &Value, leaves: &mut BTreeMap<String, String>) {
    match value {
        Value::Table(table) => {
            for (key, value) in table {
                spell(&format!("{path}.{key:?}"), value, leaves);
            }
        }
        Value::Array(rows) => {
            leaves.insert(path.to_owned(), rows.len().to_string());
            for (place, row) in rows.iter().enumerate() {
                spell(&format!("{path}[{place}]"), row, leaves);
            }
        }
        // A number beyond 2^53 is spelled as it stands: as a float it might be another.
        Value::Integer(number) if number.unsigned_abs() < 1 << 53 => {
            leaves.insert(path.to_owned(), format!("{:?}", *number as f64));
        }
        Value::Float(number) => {
            leaves.insert(path.to_owned(), format!("{number:?}"));
        }
        single => {
            leaves.insert(path.to_owned(), single.to_string());
        }
    }
}
