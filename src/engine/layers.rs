//! Layers: parameter tables laid over each other key by key, each key with the place where it was written. Tested through
//! `params` in `tests/cache/params.rs`.

use std::collections::BTreeMap;

use toml::de::{DeTable, DeValue};
use toml::{Spanned, Table, Value};

/// Where the lines of a text end.
pub(crate) struct Lines(Vec<usize>);

impl Lines {
    pub(crate) fn of(text: &str) -> Self {
        Self(text.match_indices('\n').map(|(offset, _)| offset).collect())
    }

    /// The number of the line that holds an offset, from 1.
    pub(crate) fn at(&self, offset: usize) -> usize {
        self.0.partition_point(|end| *end < offset) + 1
    }
}

/// Lays a table over another, key by key.
pub(crate) fn merge(base: &mut Table, over: Table) {
    for (key, value) in over {
        match (base.get_mut(&key), value) {
            (Some(Value::Table(inner)), Value::Table(table)) => merge(inner, table),
            (_, value) => {
                base.insert(key, value);
            }
        }
    }
}

/// Notes where each key of a table was written.
pub(crate) fn note_origins(
    origins: &mut BTreeMap<String, String>,
    prefix: &str,
    table: &DeTable<'_>,
    place: &dyn Fn(usize) -> String,
) {
    for (key, value) in table {
        let path = if prefix.is_empty() {
            key.get_ref().to_string()
        } else {
            format!("{prefix}.{}", key.get_ref())
        };
        origins.insert(path.clone(), place(Spanned::span(key).start));
        if let DeValue::Table(inner) = value.get_ref() {
            note_origins(origins, &path, inner, place);
        }
    }
}

/// The dotted paths of all single values of a table.
pub(crate) fn collect_leaves(table: &Table, prefix: &str, paths: &mut Vec<String>) {
    for (key, value) in table {
        let path = if prefix.is_empty() {
            key.clone()
        } else {
            format!("{prefix}.{key}")
        };
        match value {
            Value::Table(inner) if !inner.is_empty() => collect_leaves(inner, &path, paths),
            _ => paths.push(path),
        }
    }
}
