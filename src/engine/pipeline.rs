//! Pipeline: every node in paper order, which is dataflow order; and the rules its parameters keep.

use std::collections::{BTreeMap, BTreeSet, HashSet};

use crate::engine::case::{Axis, Case};
use crate::engine::error::{Error, Result};
use crate::engine::key_path::{KeyPath, Step};
use crate::engine::nearest::{nearest, shown};
use crate::engine::node::{Decoded, Node};
use crate::engine::params::{CASE, ParamsFile, no_name};
use crate::engine::stage::{Pieces, Select};

/// All nodes in paper order and the axes that their cases run over.
#[derive(Clone, Copy)]
pub struct Pipeline {
    /// The axes, in the order in which a case names its values.
    pub axes: &'static [Axis],
    /// The nodes, in paper order.
    pub contents: &'static [&'static dyn Node],
    /// Keys of `[run]` that are neither the seed nor the list of an axis, and keys that any table may leave out.
    pub optional: &'static [&'static str],
    /// Stages that run only when they, or what reads them, are named: neither a run of everything nor its lock has them.
    pub on_request: &'static [&'static str],
}

/// The parameters of one stage in one case, each key checked by itself.
pub(crate) struct Checked {
    pub(crate) place: usize,
    pub(crate) case: Case,
    pub(crate) decoded: Decoded,
}

impl Pipeline {
    /// The place of a stage in the contents.
    pub fn place(&self, name: &str) -> Option<usize> {
        self.contents.iter().position(|node| node.name() == name)
    }

    /// The axes that each node depends on: those of the tables it reads and of its inputs, less those it gathers.
    pub(crate) fn axes_of_all(&self) -> Vec<Vec<Axis>> {
        let mut of: BTreeMap<&str, Vec<Axis>> = BTreeMap::new();
        let mut all = Vec::new();
        for node in self.contents {
            let read = |axis: &Axis| node.tables().contains(&axis.table);
            let inherited = |axis: &Axis| {
                let upstream = node.arrows().into_iter().filter_map(|(_, up)| of.get(up.name()));
                upstream.flatten().any(|other| other == axis)
            };
            let axes: Vec<Axis> = self
                .axes
                .iter()
                .copied()
                .filter(|axis| (read(axis) || inherited(axis)) && !node.gathers().contains(axis))
                .collect();
            of.insert(node.name(), axes.clone());
            all.push(axes);
        }
        all
    }

    /// The keys that count items or pieces.
    pub(crate) fn counts(&self) -> Vec<&'static str> {
        let keys = self.contents.iter().filter_map(|node| match node.pieces() {
            Pieces::Counted(key) | Pieces::Batches(key, _) => Some(key),
            Pieces::One | Pieces::AsUpstream => None,
        });
        keys.collect::<BTreeSet<_>>().into_iter().collect()
    }

    /// The values of an axis for one node, in order.
    pub(crate) fn values(params: &ParamsFile, node: &dyn Node, axis: Axis) -> Result<Vec<String>> {
        for select in node.selects() {
            match *select {
                Select::At(selected, path) if selected == axis => return Ok(vec![pinned(params, axis, path)?]),
                Select::Rows(selected, path) if selected == axis => {
                    let named = row_names(params, axis, path)?;
                    return Ok(params
                        .list(axis)?
                        .into_iter()
                        .filter(|name| named.contains(name))
                        .collect());
                }
                _ => {}
            }
        }
        params.list(axis)
    }

    /// Decodes the parameters of one node in one case.
    pub(crate) fn decode(&self, params: &ParamsFile, counts: &[&str], node: &dyn Node, case: &Case) -> Result<Decoded> {
        let rows = rows_of(node);
        let view = params.view(node.tables(), self.axes, case, counts, &rows);
        node.decode_params(view)
            .map_err(|fault| params.fault(&fault, self.axes, case, &rows))
    }

    /// Checks every key by itself, also those that this run will not use; gives what was decoded on the way.
    ///
    /// # Errors
    /// The first key that is unknown, of a wrong type or out of range.
    pub(crate) fn check(&self, params: &ParamsFile) -> Result<Vec<Checked>> {
        params.seed()?;
        let counts = self.counts();
        for count in &counts {
            params.count(count)?;
        }
        let mut unread: BTreeSet<KeyPath> = params.leaves().into_iter().collect();
        unread.remove(&KeyPath::of("run.seed"));
        for key in counts.iter().chain(self.optional) {
            unread.remove(&KeyPath::of(key));
        }
        let mut tables = Vec::new();
        for axis in self.axes {
            unread.remove(&KeyPath::of("run").key(axis.list));
            params.list(*axis)?;
            tables.push(params.tables(*axis)?);
        }
        let mut checked = Vec::new();
        for (place, (node, axes)) in self.contents.iter().zip(&self.axes_of_all()).enumerate() {
            for select in node.selects() {
                if let Select::At(axis, path) = select {
                    pinned(params, *axis, path)?;
                    unread.remove(&KeyPath::of(path));
                }
            }
            for named in node.names() {
                match *named {
                    Select::At(axis, path) => pinned(params, axis, path).map(drop)?,
                    Select::Rows(axis, path) => row_names(params, axis, path).map(drop)?,
                }
            }
            for case in self.covering_cases(axes, &tables) {
                let decoded = self.decode(params, &counts, *node, &case)?;
                self.cross_off(params, *node, &case, &decoded, &mut unread)?;
                checked.push(Checked { place, case, decoded });
            }
            for (axis, path) in rows_of(*node) {
                row_names(params, axis, path)?;
            }
        }
        if unread.is_empty() {
            return Ok(checked);
        }
        Err(self.unknown(params, &unread))
    }

    /// Takes what a stage has read in one case off the paths that are still unread.
    ///
    /// # Errors
    /// A key in a row of a list that the stage takes no notice of: among the unread paths a list counts as one.
    fn cross_off(
        &self,
        params: &ParamsFile,
        node: &dyn Node,
        case: &Case,
        decoded: &Decoded,
        unread: &mut BTreeSet<KeyPath>,
    ) -> Result<()> {
        let rows = rows_of(node);
        let real = |path: &KeyPath| params.real_path(path, self.axes, case, &rows);
        if let Some(path) = decoded.ignored.iter().find(|path| path.has_place()) {
            return Err(params.refuse(&real(path), UNKNOWN));
        }
        let ignored: HashSet<Vec<Step>> = decoded.ignored.iter().map(|path| real(path).0).collect();
        let is_ignored = |leaf: &KeyPath| (1..=leaf.0.len()).any(|depth| ignored.contains(&leaf.0[..depth]));
        // The tables of a gathered axis are read whole by the stage that has the axis.
        let gathered = |table: &str| node.gathers().iter().any(|axis| axis.table == table);
        for table in node.tables().iter().filter(|table| **table != CASE && !gathered(table)) {
            let table = real(&KeyPath::of(table));
            let below = unread.range(&table..).take_while(|leaf| leaf.0.starts_with(&table.0));
            let read: Vec<KeyPath> = below.filter(|leaf| !is_ignored(leaf)).cloned().collect();
            for leaf in read {
                unread.remove(&leaf);
            }
        }
        Ok(())
    }

    /// Checks the rules between keys, for the stages at some places: a run is not refused for what it does not use.
    ///
    /// # Errors
    /// The first rule that does not hold.
    pub(crate) fn check_rules(&self, params: &ParamsFile, checked: &[Checked], places: &BTreeSet<usize>) -> Result<()> {
        for Checked { place, case, decoded } in checked.iter().filter(|checked| places.contains(&checked.place)) {
            let node = self.contents[*place];
            // Every count has been checked by itself.
            let count = |key: &str| params.count(key).unwrap_or(u64::MAX);
            node.check_params(decoded, &count)
                .map_err(|fault| params.fault(&fault, self.axes, case, &rows_of(node)))?;
        }
        places
            .iter()
            .try_for_each(|place| check_items(params, self.contents[*place]))
    }

    /// Cases that together take every table of every axis at least once.
    fn covering_cases(&self, axes: &[Axis], tables: &[Vec<String>]) -> Vec<Case> {
        let of = |axis: &Axis| {
            let place = self.axes.iter().position(|other| other == axis).unwrap_or(0);
            &tables[place]
        };
        let longest = axes.iter().map(|axis| of(axis).len()).max().unwrap_or(1);
        let case = |i: usize| {
            axes.iter().fold(Case::default(), |case, axis| {
                let names = of(axis);
                case.with(*axis, &names[i % names.len()])
            })
        };
        (0..longest).map(case).collect()
    }

    /// The error about keys that nothing reads: the first of them, and how many more there are.
    fn unknown(&self, params: &ParamsFile, unread: &BTreeSet<KeyPath>) -> Error {
        let leaves = params.leaves();
        let known: Vec<&KeyPath> = leaves.iter().filter(|leaf| !unread.contains(leaf)).collect();
        let mut lines: Vec<String> = unread
            .iter()
            .take(MOST_TOLD)
            .map(|path| {
                let hint = nearest(&path.to_string(), self.like(path, &known).iter().map(String::as_str));
                params.refuse(path, &format!("{UNKNOWN}{hint}")).to_string()
            })
            .collect();
        if unread.len() > MOST_TOLD {
            lines.push(format!("{} more unknown keys", unread.len() - MOST_TOLD));
        }
        Error::Usage(lines.join("\n  "))
    }

    /// The known names that may be meant by an unknown path.
    fn like(&self, path: &KeyPath, known: &[&KeyPath]) -> BTreeSet<String> {
        let [table @ .., _] = path.0.as_slice() else {
            return BTreeSet::new();
        };
        if table.is_empty() {
            // A lone name is rather a table's than a key's; one with a dot in it was rather meant as a path.
            let tables = known.iter().filter_map(|leaf| leaf.first()).map(str::to_owned);
            let dotted = path.first().is_some_and(|key| key.contains('.'));
            let paths = known.iter().filter(|_| dotted).map(ToString::to_string);
            return tables.chain(paths).collect();
        }
        let mut names: BTreeSet<String> = known.iter().map(ToString::to_string).collect();
        let is_axis = |axis: &Axis| path.first() == Some(axis.table);
        if self.axes.iter().any(is_axis) {
            // Keys of one [sea.*] are keys of all of them.
            let siblings = known
                .iter()
                .filter(|leaf| leaf.first() == path.first() && leaf.0.len() > 2);
            let own = siblings.map(|leaf| KeyPath([table, &leaf.0[2..]].concat()).to_string());
            names.extend(own);
        }
        names
    }
}

/// What is said of a key that nothing reads.
const UNKNOWN: &str = "expected a known key, found an unknown one";

/// So many unknown keys are named.
const MOST_TOLD: usize = 10;

/// The lists of which a stage sees its own rows alone.
pub(crate) fn rows_of(node: &dyn Node) -> Vec<(Axis, &'static str)> {
    let rows = node.selects().iter().filter_map(|select| match select {
        Select::Rows(axis, path) => Some((*axis, *path)),
        Select::At(..) => None,
    });
    rows.collect()
}

/// Keys that number an item stay below their counts.
fn check_items(params: &ParamsFile, node: &dyn Node) -> Result<()> {
    for (key, count, block) in node.items() {
        let items = params.count(count)?;
        let key = &KeyPath::of(key);
        let found = params.get(key);
        let number = found.and_then(toml::Value::as_integer);
        let number = number.and_then(|number| u64::try_from(number).ok());
        let is_below = |number: u64| {
            number
                .checked_next_multiple_of(*block)
                .is_some_and(|number| number < items)
        };
        if !number.is_some_and(is_below) {
            let blocks = if *block > 1 {
                format!(" in whole blocks of {block}")
            } else {
                String::new()
            };
            let message = format!(
                "expected a whole number{blocks} below {count} = {items}, found {}",
                shown(found)
            );
            return Err(params.refuse(key, &message));
        }
    }
    Ok(())
}

fn pinned(params: &ParamsFile, axis: Axis, path: &str) -> Result<String> {
    let tables = params.tables(axis)?;
    let path = KeyPath::of(path);
    let found = params.get(&path);
    let name = found.and_then(toml::Value::as_str);
    if let Some(name) = name.filter(|name| tables.iter().any(|table| table == name)) {
        return Ok(name.to_owned());
    }
    let hint = name.map_or(String::new(), |name| nearest(name, tables.iter().map(String::as_str)));
    let expected = format!(
        "expected the name of a [{}.*] table ({})",
        axis.table,
        tables.join(", ")
    );
    let found = found.map_or_else(|| shown(None), |found| no_name(found, &tables));
    Err(params.refuse(&path, &format!("{expected}, found {found}{hint}")))
}

fn row_names(params: &ParamsFile, axis: Axis, path: &str) -> Result<Vec<String>> {
    let path = &KeyPath::of(path);
    let found = params.get(path);
    let rows = found.and_then(toml::Value::as_array);
    let rows = rows.ok_or_else(|| params.refuse(path, &format!("expected a list of rows, found {}", shown(found))))?;
    let tables = params.tables(axis)?;
    let mut names: Vec<String> = Vec::new();
    for (i, row) in rows.iter().enumerate() {
        let found = row.get(axis.table);
        let refuse = |what: String| {
            let expected = format!(
                "row {i}: expected {} = the name of a [{}.*] table",
                axis.table, axis.table
            );
            params.refuse(path, &format!("{expected} ({}), found {what}", tables.join(", ")))
        };
        let name = found
            .and_then(toml::Value::as_str)
            .ok_or_else(|| refuse(found.map_or_else(|| shown(None), |found| no_name(found, &tables))))?;
        if !tables.iter().any(|table| table == name) {
            let hint = nearest(name, tables.iter().map(String::as_str));
            return Err(refuse(format!("\"{name}\"{hint}")));
        }
        if names.iter().any(|earlier| earlier == name) {
            return Err(refuse(format!("\"{name}\" twice")));
        }
        names.push(name.to_owned());
    }
    Ok(names)
}
