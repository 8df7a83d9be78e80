//! The parameter file: a base, overlays and `--set`, merged key by key, each value with the place it was written.
//!
//! A stage never sees the file. It sees a view: the tables it reads, the axis tables selected by its case, without the
//! counts, which belong to the engine.

use std::collections::BTreeMap;
use std::path::Path;

use serde::Deserialize;
use toml::de::{DeTable, Deserializer};
use toml::{Table, Value};

use crate::engine::case::{Axis, Case};
use crate::engine::decode::Fault;
use crate::engine::disk::read_stream;
use crate::engine::error::{Error, Result};
use crate::engine::layers::{Lines, collect_leaves, merge, note_origins};

/// The table of the axis values in a stage's view; no table of the file.
pub(crate) const CASE: &str = "case";

/// The parameters in force and where each of them was written.
#[derive(Clone, Debug, Default)]
pub struct ParamsFile {
    values: Table,
    origins: BTreeMap<String, String>,
}

impl ParamsFile {
    /// Reads the base and its overlays, later ones first in force, then the `--set` assignments.
    ///
    /// # Errors
    /// A file that cannot be read, text that is no TOML, an assignment that is none.
    pub fn read(files: &[&Path], sets: &[String]) -> Result<Self> {
        let mut params = Self::default();
        for file in files {
            let name = file.display().to_string();
            let text = read_stream(file).map_err(|why| {
                Error::Usage(format!(
                    "{name}: expected a readable parameter file in TOML, found: {why}"
                ))
            })?;
            params.layer(&name, &text)?;
        }
        for assignment in sets {
            params.set(assignment)?;
        }
        Ok(params)
    }

    /// Lays the keys of a TOML text over those already there.
    ///
    /// # Errors
    /// Text that is no TOML, with file, line and reason.
    pub fn layer(&mut self, file: &str, text: &str) -> Result<()> {
        let lines = Lines::of(text);
        let refuse = |error: &toml::de::Error| {
            let line = error.span().map_or(1, |span| lines.at(span.start));
            Error::Usage(format!("{file}:{line}: expected TOML, found: {}", error.message()))
        };
        let spanned = DeTable::parse(text).map_err(|error| refuse(&error))?;
        note_origins(&mut self.origins, "", spanned.get_ref(), &|offset| {
            format!("{file}:{}", lines.at(offset))
        });
        let table = Table::deserialize(Deserializer::from(spanned)).map_err(|error| refuse(&error))?;
        merge(&mut self.values, table);
        Ok(())
    }

    /// Applies one `table.key=value`; a bare word is taken as a string.
    ///
    /// # Errors
    /// No `=`, no table, or a value that is no TOML.
    pub fn set(&mut self, assignment: &str) -> Result<()> {
        let usage = |found: &str| {
            Error::Usage(format!(
                "--set {assignment}: expected table.key=value, such as sea.S2.bandwidth=0.035, found {found}"
            ))
        };
        let (path, text) = assignment.split_once('=').ok_or_else(|| usage("no `=`"))?;
        let keys: Vec<&str> = path.trim().split('.').collect();
        if keys.len() < 2 || keys.iter().any(|key| !is_name(key)) {
            return Err(usage(&format!("`{path}`")));
        }
        let text = text.trim();
        let bare = is_name(text)
            && !text.starts_with(|c: char| c.is_ascii_digit())
            && !matches!(text, "true" | "false" | "nan" | "inf");
        let value = if bare {
            Value::String(text.to_owned())
        } else {
            let line = format!("value = {text}");
            let mut table: Table =
                toml::from_str(&line).map_err(|error| usage(&format!("`{text}` ({})", error.message())))?;
            let value = table.remove("value").ok_or_else(|| usage("no value"))?;
            if !table.is_empty() {
                return Err(usage("more than one value"));
            }
            value
        };
        let mut written = Vec::new();
        if let Value::Table(inner) = &value {
            collect_leaves(inner, path.trim(), &mut written);
        }
        let nested = keys.iter().rev().fold(value, |inner, key| {
            Value::Table(Table::from_iter([((*key).to_owned(), inner)]))
        });
        if let Value::Table(table) = nested {
            merge(&mut self.values, table);
        }
        for depth in 1..=keys.len() {
            let path = keys[..depth].join(".");
            let new = depth == keys.len() || !self.origins.contains_key(&path);
            if new {
                self.origins.insert(path, "--set".to_owned());
            }
        }
        self.origins
            .extend(written.into_iter().map(|path| (path, "--set".to_owned())));
        Ok(())
    }

    /// The value at a dotted path.
    pub fn get(&self, path: &str) -> Option<&Value> {
        let mut keys = path.split('.');
        let first = self.values.get(keys.next()?)?;
        keys.try_fold(first, |value, key| value.as_table()?.get(key))
    }

    /// All parameters in force as TOML that can be used as an overlay.
    pub fn text(&self) -> String {
        toml::to_string(&self.values).expect("values that were read from TOML can be written as TOML")
    }

    /// The same as a table.
    pub(crate) fn table(&self) -> &Table {
        &self.values
    }

    /// The place where a path, or the nearest table around it, was written: `stages/paper.toml:62`, or `--set`.
    pub fn origin(&self, path: &str) -> &str {
        let mut known = path;
        while !self.origins.contains_key(known) {
            match known.rfind(['.', '[']) {
                Some(end) => known = &known[..end],
                None => break,
            }
        }
        self.origins.get(known).map_or("parameters", String::as_str)
    }

    /// An error about a path, with its place.
    pub fn refuse(&self, path: &str, message: &str) -> Error {
        Error::Usage(format!("{}: {path}: {message}", self.origin(path)))
    }

    /// The root seed.
    ///
    /// # Errors
    /// `run.seed` missing or no whole number >= 0.
    pub fn seed(&self) -> Result<u64> {
        let found = self.get("run.seed");
        found
            .and_then(Value::as_integer)
            .and_then(|seed| u64::try_from(seed).ok())
            .ok_or_else(|| {
                self.refuse(
                    "run.seed",
                    &format!("expected a whole number >= 0, found {}", shown(found)),
                )
            })
    }

    /// A count that the engine owns.
    ///
    /// # Errors
    /// Missing, or no whole number from 1 to 100 million.
    pub fn count(&self, path: &str) -> Result<u64> {
        let found = self.get(path);
        found
            .and_then(Value::as_integer)
            .and_then(|count| u64::try_from(count).ok())
            .filter(|count| (1..=100_000_000).contains(count))
            .ok_or_else(|| {
                let message = format!("expected a whole number from 1 to 100000000, found {}", shown(found));
                self.refuse(path, &message)
            })
    }

    /// The names of an axis in force, in the order of `[run]`.
    ///
    /// # Errors
    /// No list, an empty one, a name twice, or a name without a table.
    pub fn list(&self, axis: Axis) -> Result<Vec<String>> {
        let path = format!("run.{}", axis.list);
        let tables = self.tables(axis)?;
        let found = self.get(&path);
        let refuse = |what: String| {
            let expected = format!(
                "expected a list of names of [{}.*] tables ({})",
                axis.table,
                tables.join(", ")
            );
            self.refuse(&path, &format!("{expected}, found {what}"))
        };
        let entries = found.and_then(Value::as_array).ok_or_else(|| refuse(shown(found)))?;
        let mut names: Vec<String> = Vec::new();
        for entry in entries {
            let name = entry.as_str().ok_or_else(|| refuse(shown(Some(entry))))?;
            if !tables.iter().any(|table| table == name) {
                let hint = nearest(name, tables.iter().map(String::as_str));
                return Err(refuse(format!("\"{name}\"{hint}")));
            }
            if names.iter().any(|earlier| earlier == name) {
                return Err(refuse(format!("\"{name}\" twice")));
            }
            names.push(name.to_owned());
        }
        if names.is_empty() {
            return Err(refuse("an empty list".to_owned()));
        }
        Ok(names)
    }

    /// The names of all tables of an axis.
    ///
    /// # Errors
    /// No such tables, or a name with other characters than letters, digits and `_`.
    pub fn tables(&self, axis: Axis) -> Result<Vec<String>> {
        let found = self.get(axis.table);
        let table = found.and_then(Value::as_table).ok_or_else(|| {
            self.refuse(
                axis.table,
                &format!("expected tables [{}.NAME], found {}", axis.table, shown(found)),
            )
        })?;
        for name in table.keys() {
            let path = format!("{}.{name}", axis.table);
            if !is_name(name) {
                return Err(self.refuse(
                    &path,
                    "expected a name of letters, digits and `_`, since it becomes a folder",
                ));
            }
        }
        Ok(table.keys().cloned().collect())
    }

    /// The dotted paths of all single values (an array counts as one, and so does an empty table).
    pub fn leaves(&self) -> Vec<String> {
        let mut paths = Vec::new();
        collect_leaves(&self.values, "", &mut paths);
        paths
    }

    /// What a node sees: `tables` of the file, those of axes as selected by `case`, or all of `[run]` by their names if it
    /// selects none, rows of `rows` that name the case, no counts; and the table `case` with the axis values, for a stage
    /// that prints them.
    pub fn view(&self, tables: &[&str], axes: &[Axis], case: &Case, counts: &[&str], rows: &[(Axis, &str)]) -> Table {
        let mut view = Table::new();
        for name in tables {
            let table = |value: &str| self.get(&format!("{name}.{value}")).cloned();
            let value = match axes.iter().find(|axis| axis.table == *name) {
                None => self.values.get(*name).cloned(),
                Some(axis) => case.value(*axis).map_or_else(
                    || {
                        let names = self.list(*axis).unwrap_or_default().into_iter();
                        let all = names.filter_map(|name| table(&name).map(|value| (name, value)));
                        Some(Value::Table(all.collect()))
                    },
                    table,
                ),
            };
            if let Some(value) = value {
                view.insert((*name).to_owned(), value);
            }
        }
        if tables.contains(&CASE) {
            let values = case
                .values()
                .iter()
                .map(|(table, value)| ((*table).to_owned(), Value::String(value.clone())));
            view.insert(CASE.to_owned(), Value::Table(values.collect()));
        }
        for count in counts {
            if let Some(table) = count
                .split_once('.')
                .and_then(|(table, key)| Some((view.get_mut(table)?, key)))
            {
                let (Value::Table(table), key) = table else { continue };
                table.remove(key);
            }
        }
        for (axis, path) in rows {
            let Some((table, key)) = path.split_once('.') else {
                continue;
            };
            let entry = view
                .get_mut(table)
                .and_then(Value::as_table_mut)
                .and_then(|table| table.get_mut(key));
            if let Some(Value::Array(entries)) = entry {
                let wanted = case.value(*axis);
                entries.retain(|row| row.get(axis.table).and_then(Value::as_str) == wanted);
            }
        }
        view
    }

    /// Turns a fault in a view into an error about the file.
    pub fn fault(&self, fault: &Fault, axes: &[Axis], case: &Case) -> Error {
        let missing = fault
            .message
            .strip_prefix("missing field `")
            .and_then(|rest| rest.split('`').next());
        let mut path = fault.path.clone();
        if let Some(key) = missing {
            path = if path.is_empty() {
                key.to_owned()
            } else {
                format!("{path}.{key}")
            };
        }
        let path = real_path(&path, axes, case);
        if missing.is_some() {
            return self.refuse(&path, "expected a value, found none");
        }
        let named = |text: String, (table, value): &(&str, String)| {
            text.replace(&format!("`{table}."), &format!("`{table}.{value}."))
        };
        self.refuse(&path, &case.values().iter().fold(plain(&fault.message), named))
    }
}

/// The path in the file of a path in a view: `sea.bandwidth` is `sea.S2.bandwidth`.
pub(crate) fn real_path(path: &str, axes: &[Axis], case: &Case) -> String {
    let (table, rest) = path
        .split_once('.')
        .map_or((path, None), |(table, rest)| (table, Some(rest)));
    let value = axes
        .iter()
        .find(|axis| axis.table == table)
        .and_then(|axis| case.value(*axis));
    match (value, rest) {
        (Some(value), Some(rest)) => format!("{table}.{value}.{rest}"),
        (Some(value), None) => format!("{table}.{value}"),
        (None, _) => path.to_owned(),
    }
}

/// `; nearest: x` for the candidate nearest to a word, or nothing.
pub(crate) fn nearest<'a>(word: &str, candidates: impl Iterator<Item = &'a str>) -> String {
    let scored = candidates.map(|candidate| (strsim::damerau_levenshtein(word, candidate), candidate));
    scored
        .min()
        .map_or(String::new(), |(_, candidate)| format!("; nearest: `{candidate}`"))
}

/// A value as the reader wrote it, for an error.
pub(crate) fn shown(value: Option<&Value>) -> String {
    match value {
        None => "none".to_owned(),
        Some(Value::Table(_)) => "a table".to_owned(),
        Some(other) => other.to_string(),
    }
}

/// Serde's message in the order expected, found.
fn plain(message: &str) -> String {
    for prefix in [
        "invalid type: ",
        "invalid value: ",
        "unknown variant ",
        "unknown field ",
        "invalid length ",
    ] {
        let rest = message.strip_prefix(prefix);
        if let Some((found, expected)) = rest.and_then(|rest| rest.split_once(", expected ")) {
            let expected = match expected {
                "f64" => "a number",
                "a sequence" => "a list",
                structure if structure.starts_with("struct ") => "a table",
                "u32" | "u64" | "i64" => "a whole number",
                other => other,
            };
            let hint = if prefix.starts_with("unknown ") {
                nearest(found.trim_matches('`'), expected.split('`').skip(1).step_by(2))
            } else {
                String::new()
            };
            return format!("expected {expected}, found {found}{hint}");
        }
    }
    message.to_owned()
}

fn is_name(text: &str) -> bool {
    !text.is_empty() && text.chars().all(|c| c.is_ascii_alphanumeric() || c == '_')
}
