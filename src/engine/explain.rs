//! Explain: why a node's pieces are not cached, gathered over its pieces: its own changes, the inputs that run first, and
//! the inputs that have changed already, each followed back to what changed there.

use std::collections::{BTreeMap, BTreeSet};

use crate::engine::arrow::Kind;
use crate::engine::compare::{Difference, InputChange, Side};
use crate::engine::graph::Graph;
use crate::engine::plan::{Cause, Cost, Plan, State, not_cached};
use crate::engine::reason::Reason;
use crate::engine::record::Record;

/// Why a node is not all cached, and what it costs.
#[derive(Clone, Debug, Default)]
pub(crate) struct Told {
    /// Changes of its own.
    pub(crate) reasons: BTreeSet<Reason>,
    /// Inputs that will or may run first.
    pub(crate) upstream: BTreeSet<usize>,
    /// Inputs that are cached with another content than the node was made from.
    pub(crate) changed: Vec<Changed>,
    /// Per piece that is not cached, and all together.
    pub(crate) costs: BTreeMap<usize, Cost>,
    pub(crate) cost: Cost,
}

/// An input that has changed already.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Changed {
    pub(crate) node: usize,
    /// The first such change: recorded and present content.
    pub(crate) old: String,
    pub(crate) new: String,
    /// What changed there.
    pub(crate) reasons: BTreeSet<Reason>,
    /// Inputs of that node that changed before.
    pub(crate) inputs: Vec<Changed>,
}

impl Told {
    /// All reasons as data; what runs upstream is named, not followed.
    pub(crate) fn all(&self, graph: &Graph) -> Vec<Reason> {
        let mut all: Vec<Reason> = self.reasons.iter().cloned().collect();
        all.extend(self.changed.iter().map(|changed| Reason::Input {
            name: graph.nodes[changed.node].name(),
            old: changed.old.clone(),
            new: changed.new.clone(),
        }));
        all.extend(self.upstream.iter().rev().map(|up| Reason::Upstream {
            name: graph.nodes[*up].name(),
        }));
        all
    }

    /// The reasons as one sentence: its own, or the inputs that changed, or the nearest ones that run first.
    pub(crate) fn sentence(&self, graph: &Graph) -> String {
        const LONGEST: usize = 2;
        let own = self.reasons.len() + self.changed.len();
        let all = self.all(graph);
        let told = if own > 0 { &all[..own] } else { &all };
        let longest = if own > 0 { LONGEST } else { 1 };
        let mut texts: Vec<String> = told.iter().take(longest).map(ToString::to_string).collect();
        if told.len() > longest {
            texts.push(format!("{} more", told.len() - longest));
        }
        texts.join("; ")
    }
}

/// Explains a node.
pub(crate) fn tell(plan: &Plan<'_>, node: usize) -> Told {
    let mut told = Told::default();
    for piece in not_cached(&plan.states[node]) {
        let seconds = match &plan.states[node][piece] {
            State::Cached => continue,
            State::WillRun(Cause::Key) | State::MayRun(Cause::Key) => tell_key(plan, node, piece, &mut told),
            State::WillRun(cause) | State::MayRun(cause) => {
                told.reasons.extend(object_reason(plan, node, cause));
                let record = plan.run.key(node, piece).and_then(|key| plan.run.store.record(&key));
                record.map(|record| record.seconds)
            }
        };
        let seconds = seconds.or_else(|| plan.history().median(&plan.run.graph.nodes[node].name()));
        let certain = matches!(plan.states[node][piece], State::WillRun(_));
        let cost = Cost {
            certain: seconds.filter(|_| certain).unwrap_or(0.0),
            at_most: seconds.unwrap_or(0.0),
            untimed: usize::from(seconds.is_none()),
        };
        told.costs.insert(piece, cost);
        told.cost.add(cost);
    }
    told
}

fn object_reason(plan: &Plan<'_>, node: usize, cause: &Cause) -> Option<Reason> {
    let of = plan.run.graph.nodes[node].name();
    match cause {
        Cause::Key => None,
        Cause::Missing => Some(Reason::Missing { of }),
        Cause::Damaged(what) => Some(Reason::Damaged { of, what: what.clone() }),
        Cause::Needed(reader) => Some(Reason::Evicted {
            of,
            reader: plan.run.graph.nodes[*reader].name(),
        }),
    }
}

/// A piece without a record: against the record nearest to it. Gives that record's seconds if it is of this piece.
fn tell_key(plan: &Plan<'_>, node: usize, piece: usize, told: &mut Told) -> Option<f64> {
    let it = &plan.run.graph.nodes[node];
    let name = it.name();
    for link in &it.links {
        let each = link.kind == Kind::Each;
        let unknown = |up: &&usize| {
            if each {
                plan.run.id(**up, piece)
            } else {
                plan.run.content(**up)
            }
            .is_none()
        };
        told.upstream.extend(link.upstream.iter().filter(unknown));
    }
    let side = side(plan, node, piece);
    let own = plan.history().of_piece(it.node.name(), it.pieces[piece]).iter();
    if let Some((record, difference)) = nearest(&side, own.filter(|record| record.node == name)) {
        let nothing = difference.reasons.is_empty() && difference.inputs.is_empty();
        if nothing && plan.run.key(node, piece).is_some() {
            let what = "key".to_owned();
            told.reasons.insert(Reason::Unrecorded { what });
        }
        told.reasons.extend(difference.reasons);
        follow(plan, &difference.inputs, &mut told.changed);
        return Some(record.seconds);
    }
    let others = nearest(&side, plan.history().of_node(&name));
    let reasons = others.map(|(_, difference)| difference.reasons).unwrap_or_default();
    if reasons.is_empty() {
        told.reasons.insert(Reason::FirstTime);
    }
    told.reasons.extend(reasons);
    None
}

fn side<'a>(plan: &'a Plan<'_>, node: usize, piece: usize) -> Side<'a> {
    Side {
        run: &plan.run,
        history: plan.history(),
        present: &plan.present[node],
        node,
        piece,
    }
}

/// The record that differs least; among those the latest.
fn nearest<'r>(side: &Side<'_>, records: impl Iterator<Item = &'r Record>) -> Option<(&'r Record, Difference)> {
    let compared = records.map(|record| (record, side.against(record)));
    compared.min_by(|(a, left), (b, right)| {
        let count = |difference: &Difference| difference.reasons.len() + difference.inputs.len();
        (count(left), b.made, &a.key).cmp(&(count(right), a.made, &b.key))
    })
}

/// Follows inputs that have changed to what changed there.
fn follow(plan: &Plan<'_>, changes: &[InputChange], known: &mut Vec<Changed>) {
    for change in changes {
        let mut changed = Changed {
            node: change.node,
            old: change.old.clone(),
            new: change.new.clone(),
            reasons: BTreeSet::new(),
            inputs: Vec::new(),
        };
        for (piece, old) in changed_pieces(plan, change) {
            let side = side(plan, change.node, piece);
            let stage = plan.run.graph.nodes[change.node].node.name();
            let made = plan.history().of_stage(stage).filter(|record| record.id == old);
            if let Some((_, difference)) = nearest(&side, made) {
                changed.reasons.extend(difference.reasons);
                follow(plan, &difference.inputs, &mut changed.inputs);
            }
        }
        if changed.reasons.is_empty() && changed.inputs.is_empty() {
            changed.reasons = count_reasons(plan, change);
        }
        if changed.reasons.is_empty() && changed.inputs.is_empty() {
            changed.reasons.insert(Reason::Input {
                name: plan.run.graph.nodes[change.node].name(),
                old: change.old.clone(),
                new: change.new.clone(),
            });
        }
        match known.iter_mut().find(|known| known.node == changed.node) {
            Some(known) => known.merge(changed),
            None => known.push(changed),
        }
    }
}

impl Changed {
    fn merge(&mut self, other: Self) {
        self.reasons.extend(other.reasons);
        for changed in other.inputs {
            match self.inputs.iter_mut().find(|known| known.node == changed.node) {
                Some(known) => known.merge(changed),
                None => self.inputs.push(changed),
            }
        }
    }
}

/// The pieces of a changed input that differ, each with its recorded id.
fn changed_pieces(plan: &Plan<'_>, change: &InputChange) -> Vec<(usize, String)> {
    if change.pieces.is_empty() {
        return vec![(change.piece.unwrap_or(0), change.old.clone())];
    }
    let pieces = change.pieces.iter().enumerate();
    pieces
        .filter(|(piece, old)| {
            let here = *piece < plan.states[change.node].len();
            here && plan
                .run
                .id(change.node, *piece)
                .is_none_or(|id| id.to_string() != **old)
        })
        .map(|(piece, old)| (piece, old.clone()))
        .collect()
}

/// An input that lost or gained pieces and nothing else: the count that did it.
fn count_reasons(plan: &Plan<'_>, change: &InputChange) -> BTreeSet<Reason> {
    let by_id: BTreeMap<&str, &Record> = plan
        .history()
        .of_stage(plan.run.graph.nodes[change.node].node.name())
        .map(|record| (record.id.as_str(), record))
        .collect();
    let now = plan.states[change.node].len();
    if change.pieces.len() == now || now == 0 {
        return BTreeSet::new();
    }
    let last = change.pieces.last().and_then(|id| by_id.get(id.as_str()));
    let side = side(plan, change.node, 0);
    last.map(|record| side.shape_against(record)).unwrap_or_default()
}
