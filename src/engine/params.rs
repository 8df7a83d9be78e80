//! The parameter file: a base, overlays and `--set`, merged key by key, each value with the place it was written.
//!
//! A stage never sees the file. It sees a view: the tables it reads, the axis tables selected by its case, without the
//! counts, which belong to the engine.

use std::path::Path;
use std::sync::Arc;

use serde::Deserialize;
use toml::de::{DeTable, Deserializer};
use toml::{Table, Value};

use crate::engine::case::{Axis, Case};
use crate::engine::decode::{Fault, What};
use crate::engine::disk::read_stream;
use crate::engine::error::{Error, Result};
use crate::engine::key_path::{KeyPath, Step, legible, printable, split_assignment};
use crate::engine::layers::{Lines, Origins, Place, collect_leaves, merge, offsets};
use crate::engine::nearest::{nearest, shown};

/// The table of the axis values in a stage's view; no table of the file.
pub(crate) const CASE: &str = "case";

/// The most keys and list elements of one layer; the paper's own file has some 600. Every stage decodes them anew, so that a
/// million would take minutes before the first of them was refused.
const MOST_ENTRIES: usize = 20_000;

/// The parameters in force and where each of them was written.
#[derive(Clone, Debug, Default)]
pub struct ParamsFile {
    values: Table,
    origins: Origins,
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
    /// Text that is no TOML, or one of more than 20,000 entries, with file, line and reason.
    pub fn layer(&mut self, file: &str, text: &str) -> Result<()> {
        let source: Arc<str> = printable(file).into();
        let lines = Lines::of(text);
        let place = |offset: usize| Place {
            source: Arc::clone(&source),
            line: Some(lines.at(offset)),
        };
        let refuse = |error: &toml::de::Error| {
            let at = place(error.span().map_or(0, |span| span.start));
            Error::Usage(format!("{at}: expected TOML, found: {}", legible(error.message())))
        };
        let spanned = DeTable::parse(text).map_err(|error| refuse(&error))?;
        let entries = offsets(spanned.get_ref());
        if let Some(offset) = entries.get(MOST_ENTRIES) {
            let (at, found) = (place(*offset), entries.len());
            return Err(Error::Usage(format!("{at}: {}", crowd(found))));
        }
        self.origins.lay(Origins::of_text(spanned.get_ref(), &place));
        let table = Table::deserialize(Deserializer::from(spanned)).map_err(|error| refuse(&error))?;
        merge(&mut self.values, table);
        Ok(())
    }

    /// Applies one `table.key=value`, its path as TOML writes it; a bare word is taken as a string.
    ///
    /// # Errors
    /// No `=`, no table, or a value that is no TOML.
    pub fn set(&mut self, assignment: &str) -> Result<()> {
        let usage = |found: &str| {
            Error::Usage(format!(
                "--set {}: expected table.key=value, such as sea.S2.bandwidth=0.035, found {found}",
                legible(assignment)
            ))
        };
        let (written, text) = split_assignment(assignment).ok_or_else(|| usage("no `=`"))?;
        let written = written.trim();
        let path = KeyPath::parse(written);
        let keys = path.as_ref().and_then(KeyPath::keys);
        let keys = keys.filter(|keys| (2..=DEEPEST).contains(&keys.len()));
        let keys = keys.ok_or_else(|| usage(&format!("`{}`", legible(written))))?;
        let value = set_value(text.trim()).map_err(|found| usage(&found))?;
        let place = Place {
            source: "--set".into(),
            line: None,
        };
        let nested = keys.iter().rev().fold(value, |inner, key| {
            Value::Table(Table::from_iter([((*key).to_owned(), inner)]))
        });
        if let Value::Table(table) = nested {
            let mut origins = Origins::at(&place, &Value::Table(table.clone()));
            origins.forget_place();
            self.origins.lay(origins);
            merge(&mut self.values, table);
        }
        Ok(())
    }

    /// The value at a path.
    pub fn get(&self, path: &KeyPath) -> Option<&Value> {
        let (first, rest) = path.0.split_first()?;
        let Step::Key(first) = first else { return None };
        rest.iter()
            .try_fold(self.values.get(first)?, |value, step| step_into(value, step))
    }

    /// All parameters in force as TOML that can be used as an overlay.
    pub fn text(&self) -> String {
        toml::to_string(&self.values).expect("values that were read from TOML can be written as TOML")
    }

    /// The same as a table.
    pub(crate) fn table(&self) -> &Table {
        &self.values
    }

    /// The place where a path, or the nearest value around it, was written: `stages/paper.toml:62`, or `--set`.
    pub fn origin(&self, path: &KeyPath) -> String {
        let place = self.origins.find(path);
        place.map_or_else(|| "parameters".to_owned(), ToString::to_string)
    }

    /// An error about a path, with its place. Where something else than a table stands on the way to it, that is the fault.
    pub fn refuse(&self, path: &KeyPath, message: &str) -> Error {
        for depth in 1..path.0.len() {
            let on_the_way = KeyPath(path.0[..depth].to_vec());
            let (Some(found), Step::Key(_)) = (self.get(&on_the_way), &path.0[depth]) else {
                continue;
            };
            if !found.is_table() {
                let found = format!("expected a table, found {}", shown(Some(found)));
                return self.refuse_as_it_is(&on_the_way, &found);
            }
        }
        self.refuse_as_it_is(path, message)
    }

    fn refuse_as_it_is(&self, path: &KeyPath, message: &str) -> Error {
        Error::Usage(format!(
            "{}: {}: {}",
            self.origin(path),
            legible(&path.to_string()),
            legible(message)
        ))
    }

    /// The root seed.
    ///
    /// # Errors
    /// `run.seed` missing or no whole number >= 0.
    pub fn seed(&self) -> Result<u64> {
        let path = KeyPath::of("run.seed");
        let found = self.get(&path);
        found
            .and_then(Value::as_integer)
            .and_then(|seed| u64::try_from(seed).ok())
            .ok_or_else(|| {
                let message = format!("expected a whole number >= 0, found {}", shown(found));
                self.refuse(&path, &message)
            })
    }

    /// A count that the engine owns.
    ///
    /// # Errors
    /// Missing, or no whole number from 1 to 100 million.
    pub fn count(&self, path: &str) -> Result<u64> {
        let path = KeyPath::of(path);
        let found = self.get(&path);
        found
            .and_then(Value::as_integer)
            .and_then(|count| u64::try_from(count).ok())
            .filter(|count| (1..=100_000_000).contains(count))
            .ok_or_else(|| {
                let message = format!("expected a whole number from 1 to 100000000, found {}", shown(found));
                self.refuse(&path, &message)
            })
    }

    /// The names of an axis in force, in the order of `[run]`.
    ///
    /// # Errors
    /// No list, an empty one, a name twice, or a name without a table.
    pub fn list(&self, axis: Axis) -> Result<Vec<String>> {
        let path = KeyPath::of("run").key(axis.list);
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
            let name = entry.as_str().ok_or_else(|| refuse(no_name(entry, &tables)))?;
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
        let root = KeyPath::of(axis.table);
        let found = self.get(&root);
        let table = found.and_then(Value::as_table).ok_or_else(|| {
            let message = format!("expected tables [{}.NAME], found {}", axis.table, shown(found));
            self.refuse(&root, &message)
        })?;
        for (name, value) in table {
            let path = root.key(name);
            if !is_name(name) {
                let message = "expected a name of letters, digits and `_`, since it becomes a folder";
                return Err(self.refuse(&path, message));
            }
            if !value.is_table() {
                let message = format!("expected a table [{path}], found {}", shown(Some(value)));
                return Err(self.refuse(&path, &message));
            }
        }
        Ok(table.keys().cloned().collect())
    }

    /// The paths of all single values (a list counts as one, and so does an empty table).
    pub fn leaves(&self) -> Vec<KeyPath> {
        let mut paths = Vec::new();
        collect_leaves(&self.values, &KeyPath::default(), &mut paths);
        paths
    }

    /// What a node sees: `tables` of the file, those of axes as selected by `case`, or all of `[run]` by their names if it
    /// selects none, rows of `rows` that name the case, no counts; and the table `case` with the axis values, for a stage
    /// that prints them.
    pub fn view(&self, tables: &[&str], axes: &[Axis], case: &Case, counts: &[&str], rows: &[(Axis, &str)]) -> Table {
        let mut view = Table::new();
        for name in tables {
            let table = |value: &str| self.get(&KeyPath::of(name).key(value)).cloned();
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

    /// Turns a fault in the view of a case into an error about the file.
    pub fn fault(&self, fault: &Fault, axes: &[Axis], case: &Case, rows: &[(Axis, &str)]) -> Error {
        let path = self.real_path(&fault.path, axes, case, rows);
        match &fault.what {
            What::Missing(key) => self.refuse(&path.key(key), "expected a value, found none"),
            What::Said(message) => {
                let named = |text: String, (table, value): &(&str, String)| {
                    text.replace(&format!("`{table}."), &format!("`{table}.{value}."))
                };
                self.refuse(&path, &case.values().iter().fold(message.clone(), named))
            }
        }
    }

    /// The path in the file of a path in the view of a case: `sea.bandwidth` is `sea.S2.bandwidth`, and the first of a case's
    /// own rows is the file's row that names the case.
    pub(crate) fn real_path(&self, path: &KeyPath, axes: &[Axis], case: &Case, rows: &[(Axis, &str)]) -> KeyPath {
        let mut steps = path.0.clone();
        for (axis, list) in rows {
            let list = KeyPath::of(list);
            let depth = list.0.len();
            if let (true, Some(Step::Place(own))) = (steps.starts_with(&list.0), steps.get(depth).cloned()) {
                let place = self.places_of_own_rows(*axis, &list, case).nth(own);
                steps[depth] = Step::Place(place.unwrap_or(own));
            }
        }
        let axis = axes.iter().find(|axis| path.first() == Some(axis.table));
        if let Some(value) = axis.and_then(|axis| case.value(*axis)) {
            steps.insert(1, Step::Key(value.to_owned()));
        }
        KeyPath(steps)
    }

    /// The places, in a list of rows, of those that name a case.
    fn places_of_own_rows(&self, axis: Axis, list: &KeyPath, case: &Case) -> impl Iterator<Item = usize> {
        let rows = self.get(list).and_then(Value::as_array);
        let wanted = case.value(axis).map(str::to_owned);
        let own = move |row: &Value| row.get(axis.table).and_then(Value::as_str) == wanted.as_deref();
        let rows = rows.into_iter().flatten().enumerate();
        rows.filter(move |(_, row)| own(row)).map(|(place, _)| place)
    }
}

/// The most keys in the path of a `--set`; the deepest parameter has five.
const DEEPEST: usize = 16;

fn step_into<'a>(value: &'a Value, step: &Step) -> Option<&'a Value> {
    match step {
        Step::Key(key) => value.as_table()?.get(key),
        Step::Place(place) => value.as_array()?.get(*place),
    }
}

/// What is wrong with a layer of too many entries.
fn crowd(found: usize) -> String {
    format!(
        "expected at most {MOST_ENTRIES} keys and list elements, since every stage reads them anew, found {found} of them"
    )
}

/// The value of a `--set`; else what was found.
fn set_value(text: &str) -> std::result::Result<Value, String> {
    let bare = is_name(text)
        && !text.starts_with(|c: char| c.is_ascii_digit())
        && !matches!(text, "true" | "false" | "nan" | "inf");
    if bare {
        return Ok(Value::String(text.to_owned()));
    }
    let line = format!("value = {text}");
    let refuse = |error: toml::de::Error| format!("`{}` ({})", legible(text), legible(error.message()));
    let spanned = DeTable::parse(&line).map_err(refuse)?;
    let entries = offsets(spanned.get_ref()).len();
    if entries > MOST_ENTRIES {
        return Err(format!("{entries} list elements; {}", crowd(entries)));
    }
    let mut table = Table::deserialize(Deserializer::from(spanned)).map_err(refuse)?;
    let value = table.remove("value").ok_or("no value")?;
    if table.is_empty() {
        Ok(value)
    } else {
        Err("more than one value".to_owned())
    }
}

/// What was found in the place of a name; where it reads like one of the names, how that name is written.
pub(crate) fn no_name(found: &Value, names: &[String]) -> String {
    let name = found.to_string();
    if !names.contains(&name) {
        return shown(Some(found));
    }
    let kind = if found.is_bool() { "truth value" } else { "number" };
    format!("the {kind} {name}; as a name it is written in quotes: \"{name}\"")
}

fn is_name(text: &str) -> bool {
    !text.is_empty() && text.chars().all(|c| c.is_ascii_alphanumeric() || c == '_')
}
