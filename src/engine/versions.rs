//! Versions: two states of the committed files compared: parameters, lock, numbers in CSV. Nothing is run.

use std::collections::{BTreeMap, BTreeSet};

use serde::Serialize;
use serde_json::Value;

use crate::engine::compare::shown;
use crate::engine::id::Id;
use crate::engine::key_path::KeyPath;
use crate::engine::lock::{Line, Lock};
use crate::engine::params::ParamsFile;
use crate::engine::settings::{Values, flatten};

/// A parameter that differs.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ParamChange {
    /// Keys joined by dots.
    pub name: String,
    /// The value then, `none` if there was none.
    pub old: String,
    /// The value now.
    pub new: String,
    /// Where the value now was written.
    pub origin: String,
}

/// A node or published file whose line in the lock differs.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LineChange {
    /// `STAGE/CASE`, or the path of a file.
    pub name: String,
    /// `content`; `recipe` if it was made otherwise and came out equal; `new` or `gone`.
    pub change: &'static str,
    /// The content then.
    pub old: Option<String>,
    /// The content now.
    pub new: Option<String>,
}

/// A cell that differs.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CellChange {
    /// The row: the values of its key columns.
    pub row: String,
    /// The column; empty for a row that is new or gone.
    pub column: String,
    /// The cell then, as it was written.
    pub old: Option<String>,
    /// The cell now.
    pub new: Option<String>,
    /// (new - old) / |old|, if both are numbers and the old one is not 0.
    pub relative: Option<f64>,
}

/// Parameters that differ, sorted; 12 and 12.0 do not.
pub fn params(old: &ParamsFile, new: &ParamsFile) -> Vec<ParamChange> {
    let (before, now) = (values(old), values(new));
    let names: BTreeSet<&String> = before.keys().chain(now.keys()).collect();
    let changed = names
        .into_iter()
        .filter(|name| !same(before.get(*name), now.get(*name)));
    let change = |name: &String| ParamChange {
        name: name.clone(),
        old: shown(before.get(name)),
        new: shown(now.get(name)),
        origin: new.origin(&KeyPath::of(name)),
    };
    changed.map(change).collect()
}

fn values(params: &ParamsFile) -> Values {
    let mut values = Values::new();
    for path in params.leaves() {
        let value = params.get(&path).and_then(|value| serde_json::to_value(value).ok());
        flatten(&path.to_string(), &value.unwrap_or_default(), &mut values);
    }
    values
}

fn same(old: Option<&Value>, new: Option<&Value>) -> bool {
    match (old, new) {
        (Some(Value::Array(old)), Some(Value::Array(new))) => {
            old.len() == new.len() && old.iter().zip(new).all(|(old, new)| same(Some(old), Some(new)))
        }
        (Some(Value::Number(old)), Some(Value::Number(new))) => old == new || old.as_f64() == new.as_f64(),
        _ => old == new,
    }
}

/// Nodes (`of_files` false) or published files (true) whose lines differ, in the order of the new lock, then those gone.
pub fn lines(old: &Lock, new: &Lock, of_files: bool) -> Vec<LineChange> {
    let of = |lock: &'_ Lock| -> Vec<Line> {
        let lines = lock.lines.iter().filter(|line| line.pieces.is_none() == of_files);
        lines.cloned().collect()
    };
    let mut before: BTreeMap<String, Line> = of(old).into_iter().map(|line| (line.name.clone(), line)).collect();
    let mut changes = Vec::new();
    for line in of(new) {
        let earlier = before.remove(&line.name);
        let change = match &earlier {
            None => "new",
            Some(earlier) if earlier.content != line.content => "content",
            Some(earlier) if earlier.recipe != line.recipe => "recipe",
            Some(_) => continue,
        };
        let earlier = earlier.map(|earlier| earlier.content);
        changes.push(line_change(&line.name, change, earlier, Some(line.content)));
    }
    let gone = before.into_values();
    changes.extend(gone.map(|line| line_change(&line.name, "gone", Some(line.content), None)));
    changes
}

fn line_change(name: &str, change: &'static str, old: Option<Id>, new: Option<Id>) -> LineChange {
    LineChange {
        name: name.strip_prefix("file ").unwrap_or(name).to_owned(),
        change,
        old: old.map(|id| id.to_string()),
        new: new.map(|id| id.to_string()),
    }
}

/// Cells of two CSV texts that differ, row by row as the key columns name them.
pub fn cells(old: &str, new: &str, keys: &[&str]) -> Vec<CellChange> {
    let (mut before, now) = (rows(old, keys), rows(new, keys));
    let mut changes = Vec::new();
    for (row, cells) in now {
        let place = before.iter().position(|(other, _)| *other == row);
        let Some((_, earlier)) = place.map(|place| before.remove(place)) else {
            changes.push(row_change(row, None, Some("new")));
            continue;
        };
        let columns: BTreeSet<&String> = earlier.keys().chain(cells.keys()).collect();
        for column in columns {
            let (old, new) = (earlier.get(column), cells.get(column));
            if old != new {
                changes.push(CellChange {
                    row: row.clone(),
                    column: column.clone(),
                    old: old.cloned(),
                    new: new.cloned(),
                    relative: old.zip(new).and_then(|(old, new)| relative(old, new)),
                });
            }
        }
    }
    changes.extend(before.into_iter().map(|(row, _)| row_change(row, Some("gone"), None)));
    changes
}

fn row_change(row: String, old: Option<&str>, new: Option<&str>) -> CellChange {
    CellChange {
        row,
        column: String::new(),
        old: old.map(str::to_owned),
        new: new.map(str::to_owned),
        relative: None,
    }
}

fn relative(old: &str, new: &str) -> Option<f64> {
    let (old, new): (f64, f64) = (old.parse().ok()?, new.parse().ok()?);
    let relative = (new - old) / old.abs();
    relative.is_finite().then_some(relative)
}

/// The rows of a CSV text: the values of its key columns, and the other cells by column.
fn rows(text: &str, keys: &[&str]) -> Vec<(String, BTreeMap<String, String>)> {
    let mut lines = text.lines().map(split);
    let header = lines.next().unwrap_or_default();
    let mut rows = Vec::new();
    for cells in lines {
        let (key, rest): (Vec<_>, Vec<_>) = header
            .iter()
            .cloned()
            .zip(cells)
            .partition(|(column, _)| keys.contains(&column.as_str()));
        let key: Vec<String> = key.into_iter().map(|(_, cell)| cell).collect();
        rows.push((key.join(" "), rest.into_iter().collect()));
    }
    rows
}

/// The cells of a line; a quoted one may hold commas.
fn split(line: &str) -> Vec<String> {
    let mut cells = vec![String::new()];
    let mut quoted = false;
    for c in line.chars() {
        match c {
            '"' => quoted = !quoted,
            ',' if !quoted => cells.push(String::new()),
            c => cells.last_mut().expect("there is a first cell").push(c),
        }
    }
    cells
}
