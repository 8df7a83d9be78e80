//! Layers: parameter tables laid over each other key by key, each value with the place where it was written. Tested through
//! `params` in `tests/cache/keys.rs`.

use std::collections::BTreeMap;
use std::fmt;
use std::sync::Arc;

use toml::de::{DeTable, DeValue};
use toml::{Spanned, Table, Value};

use crate::engine::key_path::{KeyPath, Step};

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

/// A place where a value was written: `stages/paper.toml:62`, or `--set`.
#[derive(Clone, Debug)]
pub(crate) struct Place {
    pub(crate) source: Arc<str>,
    /// From 1; none on the command line.
    pub(crate) line: Option<usize>,
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.line {
            Some(line) => write!(f, "{}:{line}", self.source),
            None => f.write_str(&self.source),
        }
    }
}

/// Where a value, and everything in it, was written: a tree of the same shape as the value.
///
/// Since a value that is replaced takes its whole tree with it, no place outlives what stood there.
#[derive(Clone, Debug, Default)]
pub(crate) struct Origins {
    place: Option<Place>,
    inner: Inner,
}

#[derive(Clone, Debug, Default)]
enum Inner {
    #[default]
    Single,
    Keys(BTreeMap<String, Origins>),
    Places(Vec<Origins>),
}

impl Origins {
    /// The places of a parsed text; `at` gives the place of an offset in it.
    pub(crate) fn of_text(table: &DeTable<'_>, at: &dyn Fn(usize) -> Place) -> Self {
        let below = |(key, value): (&Spanned<_>, &Spanned<DeValue<'_>>)| {
            let place = Some(at(key.span().start));
            let name: &std::borrow::Cow<'_, str> = key.get_ref();
            (
                name.to_string(),
                Self {
                    place,
                    ..Self::of_value(value, at)
                },
            )
        };
        Self {
            place: None,
            inner: Inner::Keys(table.iter().map(below).collect()),
        }
    }

    fn of_value(value: &Spanned<DeValue<'_>>, at: &dyn Fn(usize) -> Place) -> Self {
        let inner = match value.get_ref() {
            DeValue::Table(table) => Self::of_text(table, at).inner,
            DeValue::Array(rows) => Inner::Places(rows.iter().map(|row| Self::of_value(row, at)).collect()),
            _ => Inner::Single,
        };
        Self {
            place: Some(at(value.span().start)),
            inner,
        }
    }

    /// The places of a value that was written as a whole at one place.
    pub(crate) fn at(place: &Place, value: &Value) -> Self {
        let inner = match value {
            Value::Table(table) => {
                let below = |(key, value): (&String, &Value)| (key.clone(), Self::at(place, value));
                Inner::Keys(table.iter().map(below).collect())
            }
            // All of a list stands where the list stands.
            _ => Inner::Single,
        };
        Self {
            place: Some(place.clone()),
            inner,
        }
    }

    /// The root of all layers stands in none of them.
    pub(crate) fn forget_place(&mut self) {
        self.place = None;
    }

    /// Lays the places of another value over these, as [`merge`] does with the values.
    pub(crate) fn lay(&mut self, over: Self) {
        self.place = over.place.or(self.place.take());
        match (&mut self.inner, over.inner) {
            (Inner::Keys(own), Inner::Keys(others)) => {
                for (key, other) in others {
                    own.entry(key).or_default().lay(other);
                }
            }
            (own, other) => *own = other,
        }
    }

    /// The place of a value; for one that is nowhere written, that of the nearest value around it.
    pub(crate) fn find(&self, path: &KeyPath) -> Option<&Place> {
        let mut here = self;
        let mut place = here.place.as_ref();
        for step in &path.0 {
            let next = match (&here.inner, step) {
                (Inner::Keys(keys), Step::Key(key)) => keys.get(key),
                (Inner::Places(rows), Step::Place(row)) => rows.get(*row),
                _ => None,
            };
            let Some(next) = next else { break };
            here = next;
            place = here.place.as_ref().or(place);
        }
        place
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

/// The paths of all single values of a table: a list counts as one, and so does an empty table.
pub(crate) fn collect_leaves(table: &Table, prefix: &KeyPath, paths: &mut Vec<KeyPath>) {
    for (key, value) in table {
        let path = prefix.key(key);
        match value {
            Value::Table(inner) if !inner.is_empty() => collect_leaves(inner, &path, paths),
            _ => paths.push(path),
        }
    }
}

/// The offsets of all keys and list elements of a parsed text, in the order of the text.
pub(crate) fn offsets(table: &DeTable<'_>) -> Vec<usize> {
    let mut offsets = Vec::new();
    let mut open: Vec<&DeTable<'_>> = vec![table];
    let mut values: Vec<&Spanned<DeValue<'_>>> = Vec::new();
    while let Some(table) = open.pop() {
        offsets.extend(table.keys().map(|key| key.span().start));
        values.extend(table.values());
        while let Some(value) = values.pop() {
            match value.get_ref() {
                DeValue::Table(inner) => open.push(inner),
                DeValue::Array(rows) => {
                    offsets.extend(rows.iter().map(|row| row.span().start));
                    values.extend(rows.iter());
                }
                _ => {}
            }
        }
    }
    offsets.sort_unstable();
    offsets
}
