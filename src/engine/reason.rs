//! Reason: why a piece is not cached, with old and new, and its sentence.

use std::fmt;

use serde::Serialize;

/// One difference between what a piece was made from and what it would be made from now.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum Reason {
    /// The layout of keys.
    KeySchema {
        /// The recorded number.
        old: u32,
        /// This binary's.
        new: u32,
    },
    /// The root seed.
    Seed {
        /// The recorded seed.
        old: u64,
        /// The seed in force.
        new: u64,
        /// Where it was written.
        origin: String,
    },
    /// A parameter under its name in the parameter file.
    Parameter {
        /// Keys joined by dots.
        name: String,
        /// The recorded value, `none` if it had none.
        old: String,
        /// The value in force.
        new: String,
        /// Where it was written, `stages/paper.toml:62` or `--set`.
        origin: String,
    },
    /// A source file that the results depend on.
    File {
        /// Relative to the package.
        path: String,
        /// The recorded hash of its tokens; none if it was not among the stage's files.
        old: Option<String>,
        /// Its hash in this binary.
        new: Option<String>,
    },
    /// An outside crate that the results depend on.
    Crate {
        /// Its name.
        name: String,
        /// The recorded version.
        old: String,
        /// The version in this binary.
        new: String,
    },
    /// An input whose content changed, when nothing is recorded of how that came about.
    Input {
        /// The node, with its piece if it is read piece by piece.
        name: String,
        /// The recorded id.
        old: String,
        /// The present id.
        new: String,
    },
    /// The nodes that are read.
    Inputs {
        /// Those no longer read.
        gone: Vec<String>,
        /// Those read since.
        added: Vec<String>,
    },
    /// An input that will or may run first.
    Upstream {
        /// The node.
        name: String,
    },
    /// Something changed, and the record is from before that was kept.
    Unrecorded {
        /// `code`, `parameters`, `inputs` or `key`.
        what: String,
    },
    /// Nothing of this node was ever made with this piece.
    FirstTime,
    /// The object of a record is gone.
    Missing {
        /// The node.
        of: String,
    },
    /// The object of a record, or the record, is not what was written.
    Damaged {
        /// The node.
        of: String,
        /// `object` or `record`, and how it is damaged.
        what: String,
    },
    /// Left out of the store on purpose, and needed again.
    Evicted {
        /// The node.
        of: String,
        /// A node that needs it.
        reader: String,
    },
}

impl Reason {
    /// Where the new value was written, for what is written in a parameter file.
    pub fn origin(&self) -> Option<&str> {
        match self {
            Self::Seed { origin, .. } | Self::Parameter { origin, .. } => Some(origin),
            _ => None,
        }
    }
}

impl fmt::Display for Reason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::KeySchema { old, new } => write!(f, "key schema {old} -> {new}"),
            Self::Seed { old, new, .. } => write!(f, "seed `run.seed` {old} -> {new}"),
            Self::Parameter { name, old, new, .. } => write!(f, "parameter `{name}` {old} -> {new}"),
            Self::File { path, old, new } => match (old, new) {
                (None, _) => write!(f, "`{path}` is new here"),
                (_, None) => write!(f, "`{path}` is no longer used"),
                _ => write!(f, "`{path}` changed"),
            },
            Self::Crate { name, old, new } => write!(f, "crate `{name}` {old} -> {new}"),
            Self::Input { name, old, new } => write!(f, "input `{name}` {} -> {}", short(old), short(new)),
            Self::Inputs { gone, added } => write!(f, "{}", reading(gone, added)),
            Self::Upstream { name } => write!(f, "input `{name}` runs first"),
            Self::Unrecorded { what } => write!(f, "its {what} changed (recorded before the old ones were kept)"),
            Self::FirstTime => f.write_str("first time"),
            Self::Missing { .. } => f.write_str("object missing"),
            Self::Damaged { what, .. } => write!(f, "{what}"),
            Self::Evicted { reader, .. } => write!(f, "evicted, and needed by `{reader}`"),
        }
    }
}

fn reading(gone: &[String], added: &[String]) -> String {
    let listed = |names: &[String]| format!("`{}`", names.join("`, `"));
    match (gone, added) {
        ([], added) => format!("also reads {}", listed(added)),
        (gone, []) => format!("no longer reads {}", listed(gone)),
        (gone, added) => format!("reads {} instead of {}", listed(added), listed(gone)),
    }
}

/// The head of an id.
pub fn short(id: &str) -> String {
    format!("{}..", id.get(..4).unwrap_or(id))
}
