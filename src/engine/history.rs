//! History: every undamaged record of a store, by stage and piece, to explain what changed and to guess what it costs.
//!
//! Read only when something is not cached. The disk is scanned.

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::rc::Rc;

use crate::engine::id::Id;
use crate::engine::listing::listed;
use crate::engine::names::{Folder, Place};
use crate::engine::parts::{CodePart, InputsPart, ParamsPart, get};
use crate::engine::record::Record;
use crate::engine::store::Store;

/// What a store remembers.
pub(crate) struct History<'s> {
    store: &'s Store,
    /// (stage, first item, items) -> records.
    pieces: BTreeMap<(String, u64, u64), Vec<Record>>,
    /// Node -> its records' seconds, ascending; likewise stage.
    nodes: BTreeMap<String, Vec<f64>>,
    stages: BTreeMap<String, Vec<f64>>,
    code: RefCell<BTreeMap<String, Option<Rc<CodePart>>>>,
    params: RefCell<BTreeMap<String, Option<Rc<ParamsPart>>>>,
    inputs: RefCell<BTreeMap<String, Option<Rc<InputsPart>>>>,
}

impl<'s> History<'s> {
    /// Reads all records of a store.
    pub(crate) fn read(store: &'s Store) -> Self {
        let mut history = Self {
            store,
            pieces: BTreeMap::new(),
            nodes: BTreeMap::new(),
            stages: BTreeMap::new(),
            code: RefCell::default(),
            params: RefCell::default(),
            inputs: RefCell::default(),
        };
        // What cannot be listed only leaves less to tell.
        for file in listed(store, Folder::Records).unwrap_or_default() {
            let Some(Place::Record(key)) = file.place else { continue };
            if let Some(record) = store.record(&key) {
                history.take(record);
            }
        }
        let of_nodes = history.nodes.values_mut();
        for seconds in of_nodes.chain(history.stages.values_mut()) {
            seconds.sort_by(f64::total_cmp);
        }
        history
    }

    fn take(&mut self, record: Record) {
        let stage = stage_of(&record.node).to_owned();
        self.nodes.entry(record.node.clone()).or_default().push(record.seconds);
        self.stages.entry(stage.clone()).or_default().push(record.seconds);
        let place = (stage, record.first, record.items);
        self.pieces.entry(place).or_default().push(record);
    }

    /// The records of one piece, of whatever case.
    pub(crate) fn of_piece(&self, stage: &str, piece: (u64, u64)) -> &[Record] {
        let found = self.pieces.get(&(stage.to_owned(), piece.0, piece.1));
        found.map_or(&[], Vec::as_slice)
    }

    /// The records of one node, of whatever piece.
    pub(crate) fn of_node<'h>(&'h self, node: &'h str) -> impl Iterator<Item = &'h Record> {
        self.of_stage(stage_of(node)).filter(move |record| record.node == node)
    }

    /// The records of one stage.
    pub(crate) fn of_stage<'h>(&'h self, stage: &str) -> impl Iterator<Item = &'h Record> {
        let stage = stage.to_owned();
        let from = self.pieces.range((stage.clone(), 0, 0)..);
        from.take_while(move |((name, ..), _)| *name == stage)
            .flat_map(|(_, records)| records)
    }

    /// The median of the recorded seconds of a node's pieces; else of its stage's.
    pub(crate) fn median(&self, node: &str) -> Option<f64> {
        let seconds = self.nodes.get(node).or_else(|| self.stages.get(stage_of(node)))?;
        Some(seconds[seconds.len() / 2])
    }

    /// Whether a record's output can still be had.
    pub(crate) fn is_usable(&self, record: &Record) -> bool {
        record.evicted || Id::parse(&record.id).is_some_and(|id| self.store.has(&id))
    }

    pub(crate) fn code_of(&self, record: &Record) -> Option<Rc<CodePart>> {
        cached(&self.code, &record.parts.as_ref()?.code, |name| get(self.store, name))
    }

    pub(crate) fn params_of(&self, record: &Record) -> Option<Rc<ParamsPart>> {
        cached(&self.params, &record.parts.as_ref()?.params, |name| {
            get(self.store, name)
        })
    }

    pub(crate) fn inputs_of(&self, record: &Record) -> Option<Rc<InputsPart>> {
        cached(&self.inputs, &record.parts.as_ref()?.inputs, |name| {
            get(self.store, name)
        })
    }
}

/// The stage of a node's name.
pub(crate) fn stage_of(node: &str) -> &str {
    node.split('/').next().unwrap_or(node)
}

fn cached<T>(
    known: &RefCell<BTreeMap<String, Option<Rc<T>>>>,
    name: &str,
    read: impl FnOnce(&str) -> Option<T>,
) -> Option<Rc<T>> {
    let mut known = known.borrow_mut();
    let entry = known.entry(name.to_owned());
    entry.or_insert_with(|| read(name).map(Rc::new)).clone()
}
