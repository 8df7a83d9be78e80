//! `encounter diff`: what changed since a revision: parameters, contents of nodes, numbers of Table 1 and Figure 3.

use std::path::Path;

use clap::Args;
use serde_json::json;

use crate::cli::session::{Common, Profile};
use crate::cli::words::{self, Line};
use crate::cli::{print_json, say};
use crate::engine::disk::read_text;
use crate::engine::error::Result;
use crate::engine::lock::Lock;
use crate::engine::params::ParamsFile;
use crate::engine::reason::short;
use crate::engine::revision::Revision;
use crate::engine::versions::{self, CellChange, LineChange, ParamChange};
use crate::stages::axes::SHIP;
use crate::text::count::counted;

/// Arguments of `encounter diff`.
#[derive(Debug, Args)]
pub struct DiffArgs {
    /// A commit, tag or branch, such as `HEAD` or `v1.0`
    rev: String,
    #[command(flatten)]
    common: Common,
}

/// The published tables that are compared, and the columns that name a row.
const TABLES: [(&str, &[&str]); 2] = [
    ("table1.csv", &["spectrum"]),
    (
        "fig3_exceedance.csv",
        &["ship", "spectrum", "epsilon_1", "theta_t", "method"],
    ),
];

/// One table of one ship, then and now.
struct Table {
    file: &'static str,
    ship: String,
    /// What differs, or which side lacks the table.
    cells: std::result::Result<Vec<CellChange>, String>,
}

/// All that is compared.
struct Changes {
    params: Vec<ParamChange>,
    /// Nodes and files; none if either side has no lock.
    lines: Option<(Vec<LineChange>, Vec<LineChange>)>,
    tables: Vec<Table>,
}

/// Runs the verb.
///
/// # Errors
/// No git, no work tree, no such revision, or a file that cannot be read.
pub fn diff(args: &DiffArgs) -> Result<()> {
    let common = &args.common;
    // What no run would take is not compared either.
    let new = common.open(&[])?.graph.params;
    let revision = Revision::find(&Common::root()?, &args.rev)?;
    let old = params_at(common, &revision)?;
    let changes = Changes {
        params: versions::params(&old, &new),
        lines: lines(common, &revision)?,
        tables: tables(common, &revision, &old, &new)?,
    };
    if common.json {
        print_json(&changes.json(common, &revision));
    } else {
        changes.print(common, &revision);
    }
    Ok(())
}

/// The parameters of a revision; an overlay of the command line is of today alone.
fn params_at(common: &Common, revision: &Revision) -> Result<ParamsFile> {
    let mut params = ParamsFile::default();
    let mut names = vec!["paper"];
    if common.profile != Profile::Paper {
        names.push(common.profile.name());
    }
    for name in names {
        let path = format!("stages/{name}.toml");
        if let Some(text) = revision.file(&path)? {
            params.layer(&format!("{}:{path}", revision.name), &text)?;
        }
    }
    Ok(params)
}

fn lines(common: &Common, revision: &Revision) -> Result<Option<(Vec<LineChange>, Vec<LineChange>)>> {
    let name = format!("artifacts/{}", lock_name(common));
    let path = common.lock_file(&[])?;
    let old = revision.file(&name)?;
    let new = read_text(&path).ok();
    let Some((old, new)) = old.zip(new) else {
        return Ok(None);
    };
    let old = Lock::parse_file(&format!("{}:{name}", revision.name), &old)?;
    let new = Lock::parse_file(&path.display().to_string(), &new)?;
    let of = |files| versions::lines(&old, &new, files);
    Ok(Some((of(false), of(true))))
}

/// The tables of every ship, each from the folder that was or is its own. Only those of the bare paper are committed.
fn tables(common: &Common, revision: &Revision, old: &ParamsFile, new: &ParamsFile) -> Result<Vec<Table>> {
    let mut tables = Vec::new();
    if common.profile != Profile::Paper {
        return Ok(tables);
    }
    let folder = common.figures_folder(new)?;
    let before = old.list(SHIP).unwrap_or_default();
    for (place, ship) in new.list(SHIP)?.iter().enumerate() {
        let prefix = |place: usize| if place == 0 { String::new() } else { format!("{ship}/") };
        for (file, keys) in TABLES {
            let then = match before.iter().position(|other| other == ship) {
                Some(place) => revision.file(&format!("figures/{}{file}", prefix(place)))?,
                None => None,
            };
            let path = folder.join(prefix(place)).join(file);
            let cells = match (then, read_text(&path)) {
                (None, _) => Err(format!("not committed at {}", revision.name)),
                (_, Err(_)) => Err(format!("no {}", path.display())),
                (Some(then), Ok(now)) => Ok(versions::cells(&then, &now, keys)),
            };
            let ship = ship.clone();
            tables.push(Table { file, ship, cells });
        }
    }
    Ok(tables)
}

impl Changes {
    fn json(&self, common: &Common, revision: &Revision) -> serde_json::Value {
        let tables: Vec<_> = self
            .tables
            .iter()
            .map(|table| json!({"file": table.file, "ship": table.ship, "cells": table.cells.as_ref().ok()}))
            .collect();
        let (nodes, files) = self.lines.clone().unzip();
        json!({
            "format": 1, "profile": common.profile.name(), "revision": revision.name, "commit": revision.commit,
            "parameters": self.params, "nodes": nodes, "files": files, "tables": tables,
        })
    }

    fn print(&self, common: &Common, revision: &Revision) {
        let commit = revision.commit.get(..10).unwrap_or(&revision.commit);
        say(format_args!("{} ({commit}) -> now", revision.name));
        print_params(&self.params);
        match &self.lines {
            None => say(format_args!("nodes: no {} on both sides", lock_name(common))),
            Some((nodes, files)) => {
                print_nodes(nodes);
                let names: Vec<&str> = files.iter().map(|line| line.name.as_str()).collect();
                say(format_args!("files: {}", listed(&names)));
            }
        }
        for table in &self.tables {
            print_table(table);
        }
    }
}

fn lock_name(common: &Common) -> String {
    format!("{}.lock", common.profile.name())
}

fn print_params(changes: &[ParamChange]) {
    if changes.is_empty() {
        say(format_args!("parameters: equal"));
        return;
    }
    say(format_args!("parameters"));
    let line = |change: &ParamChange| Line {
        left: format!("  {}  {} -> {}", change.name, change.old, change.new),
        right: change.origin.clone(),
        note: String::new(),
    };
    words::print(&changes.iter().map(line).collect::<Vec<_>>());
}

fn print_nodes(changes: &[LineChange]) {
    const MOST: usize = 12;
    let content: Vec<&LineChange> = changes.iter().filter(|line| line.change != "recipe").collect();
    let equal = changes.len() - content.len();
    let told = match (content.len(), equal) {
        (0, 0) => "equal".to_owned(),
        (changed, 0) => format!("{changed} changed"),
        (changed, equal) => format!("{changed} changed, {equal} made otherwise and equal"),
    };
    say(format_args!("nodes: {told}"));
    let id = |id: &Option<String>| id.as_ref().map_or("none".to_owned(), |id| short(id));
    let lines: Vec<Line> = content
        .iter()
        .take(MOST)
        .map(|line| Line {
            left: format!("  {}", line.name),
            right: format!("{} -> {}", id(&line.old), id(&line.new)),
            note: String::new(),
        })
        .collect();
    words::print(&lines);
    if content.len() > MOST {
        say(format_args!("  and {} more; --json tells all", content.len() - MOST));
    }
}

fn listed(names: &[&str]) -> String {
    const MOST: usize = 4;
    match names.len() {
        0 => "equal".to_owned(),
        count if count > MOST => format!("{} and {} more changed", names[..MOST].join(", "), count - MOST),
        _ => format!("{} changed", names.join(", ")),
    }
}

/// A table: the cells that changed most.
fn print_table(table: &Table) {
    const MOST: usize = 16;
    let name = Path::new(table.file).with_extension("");
    let head = format!("{} of {}", name.display(), table.ship);
    let cells = match &table.cells {
        Ok(cells) => cells,
        Err(lack) => {
            say(format_args!("{head}: {lack}"));
            return;
        }
    };
    if cells.is_empty() {
        say(format_args!("{head}: equal"));
        return;
    }
    let mut largest: Vec<&CellChange> = cells.iter().collect();
    if cells.len() > MOST {
        let size = |cell: &CellChange| cell.relative.map_or(f64::INFINITY, f64::abs);
        largest.sort_by(|a, b| size(b).total_cmp(&size(a)));
    }
    let shown = if cells.len() > MOST {
        format!(", the {MOST} largest changes")
    } else {
        String::new()
    };
    say(format_args!("{head}: {}{shown}", counted(cells.len(), "cell")));
    let lines: Vec<Line> = largest.into_iter().take(MOST).map(cell_line).collect();
    words::print(&lines);
}

fn cell_line(cell: &CellChange) -> Line {
    let text = |cell: &Option<String>| cell.as_ref().map_or("none".to_owned(), |text| digits(text));
    Line {
        left: format!(
            "  {}  {}  {} -> {}",
            cell.row,
            cell.column,
            text(&cell.old),
            text(&cell.new)
        ),
        right: cell
            .relative
            .map_or(String::new(), |relative| format!("{:+.2} %", 100.0 * relative)),
        note: String::new(),
    }
}

/// Five digits of a number; a word as it is.
fn digits(text: &str) -> String {
    let rounded = text
        .parse::<f64>()
        .ok()
        .and_then(|number| format!("{number:.4e}").parse::<f64>().ok());
    rounded.map_or_else(|| text.to_owned(), |number| number.to_string())
}
