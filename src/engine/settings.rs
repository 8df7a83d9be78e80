//! Settings: the parameters of one node under the names that its reader writes in the parameter file.
//!
//! A stage decodes a view (`sea.bandwidth`); the reader wrote `sea.S2.bandwidth`. What a stage does not decode but what
//! shapes the graph around it (counts, lists of cases) is told apart: it is in no key, so it explains only pieces that
//! were never made and inputs that came or went.

use std::collections::BTreeMap;

use serde_json::Value;

use crate::engine::arrow::Kind;
use crate::engine::graph::Graph;
use crate::engine::key_path::KeyPath;
use crate::engine::params::CASE;
use crate::engine::pipeline::rows_of;
use crate::engine::stage::Pieces;

/// Single values by dotted path; a list of numbers or words is one value.
pub(crate) type Values = BTreeMap<String, Value>;

/// What a node decodes.
pub(crate) fn values(graph: &Graph, node: usize) -> Values {
    let mut values = Values::new();
    if let Value::Object(tables) = graph.nodes[node].params_json() {
        for (table, value) in tables.iter().filter(|(table, _)| *table != CASE) {
            let selected = graph.nodes[node].case.values().iter().find(|(axis, _)| axis == table);
            let path = selected.map_or_else(|| table.clone(), |(_, value)| format!("{table}.{value}"));
            flatten(&path, value, &mut values);
        }
    }
    values
        .into_iter()
        .map(|(path, value)| (row_path(graph, node, &path), value))
        .collect()
}

/// What is in no key: the count of its pieces and the lists of the cases that it gathers.
pub(crate) fn shape(graph: &Graph, node: usize) -> Values {
    let mut shape = Values::new();
    let gathered = graph.nodes[node]
        .node
        .gathers()
        .iter()
        .map(|axis| format!("run.{}", axis.list));
    for path in counts(graph, node).into_iter().chain(gathered) {
        let value = graph
            .params
            .get(&KeyPath::of(&path))
            .and_then(|value| serde_json::to_value(value).ok());
        shape.insert(path, value.unwrap_or_default());
    }
    shape
}

/// The key that counts a node's pieces: its own, or that of the node it follows piece by piece.
fn counts(graph: &Graph, node: usize) -> Option<String> {
    let it = &graph.nodes[node];
    match it.node.pieces() {
        Pieces::One => None,
        Pieces::Counted(key) | Pieces::Batches(key, _) => Some(key.to_owned()),
        Pieces::AsUpstream => {
            let each = it.links.iter().find(|link| link.kind == Kind::Each)?;
            counts(graph, each.upstream[0])
        }
    }
}

/// Single values below a path; a list of tables is told row by row.
pub(crate) fn flatten(path: &str, value: &Value, values: &mut Values) {
    match value {
        Value::Object(table) if !table.is_empty() => {
            for (key, value) in table {
                flatten(&format!("{path}.{key}"), value, values);
            }
        }
        Value::Array(rows) if rows.iter().any(Value::is_object) => {
            for (place, row) in rows.iter().enumerate() {
                flatten(&format!("{path}[{place}]"), row, values);
            }
        }
        // What a table leaves out is no value of it.
        Value::Null => {}
        single => {
            values.insert(path.to_owned(), single.clone());
        }
    }
}

/// A stage sees its own rows alone, so its row 0 may be row 2 of the file.
fn row_path(graph: &Graph, node: usize, path: &str) -> String {
    let of = &graph.nodes[node];
    let rows = rows_of(of.node);
    let path = graph.params.real_path(&KeyPath::of(path), &[], &of.case, &rows);
    path.to_string()
}
