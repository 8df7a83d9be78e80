//! Plan: what a run would do, piece by piece, without doing it: cached; will run; may run, if an input comes out changed.
//!
//! `Run::decide` decides, here as in a run. The plan adds what a run need not know beforehand: which pieces behind a
//! rerun cannot stay cached whatever comes out, which evicted outputs are needed again, why, and at what cost.

use std::cell::OnceCell;
use std::collections::{BTreeMap, BTreeSet};

use serde::Serialize;

use crate::engine::arrow::Kind;
use crate::engine::compare::{Present, inputs};
use crate::engine::explain::{Told, tell};
use crate::engine::graph::Graph;
use crate::engine::history::History;
use crate::engine::id::{Id, schema_number};
use crate::engine::key::KEY_SCHEMA;
use crate::engine::reason::Reason;
use crate::engine::record::Record;
use crate::engine::run::{Decision, Listener, Run};
use crate::engine::store::{Found, Store};

/// What a run would do with one node.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct NodePlan {
    /// `STAGE/CASE`.
    pub node: String,
    /// Its place in the paper.
    pub paper: String,
    /// Its pieces, of those that the targets need.
    pub pieces: usize,
    /// Pieces that are cached.
    pub cached: usize,
    /// Pieces that will run.
    pub will_run: usize,
    /// Pieces that run only if an input comes out changed.
    pub may_run: usize,
    /// Why it is not all cached, in words; empty if it is.
    pub reason: String,
    /// The same as data.
    pub reasons: Vec<Reason>,
    /// What its pieces that will or may run are expected to take at most, seconds of one core.
    pub seconds: f64,
    /// What those that will run are expected to take.
    pub seconds_certain: f64,
    /// Pieces that will or may run and whose like was never timed: what they take comes on top.
    pub untimed: usize,
}

/// What something is expected to take, seconds of one core.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Cost {
    /// Of the pieces that will run.
    pub certain: f64,
    /// Of those that will or may run.
    pub at_most: f64,
    /// Pieces among them whose like was never timed.
    pub untimed: usize,
}

impl Cost {
    pub(crate) fn add(&mut self, other: Self) {
        self.certain += other.certain;
        self.at_most += other.at_most;
        self.untimed += other.untimed;
    }
}

/// The state of one piece.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum State {
    /// Left alone; so is a piece that no target needs.
    Cached,
    WillRun(Cause),
    /// An input will run; if its content comes out equal, this stays cached.
    MayRun(Cause),
}

/// Why a piece is not cached, as far as that shows without comparing records.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Cause {
    /// There is no record of its key, or no key yet.
    Key,
    /// The object of its record is gone.
    Missing,
    /// Its object or record is not what was written.
    Damaged(String),
    /// It was left out of the store, and this node needs it.
    Needed(usize),
}

/// The plan of a graph.
pub struct Plan<'g> {
    pub(crate) run: Run<'g>,
    pub(crate) states: Vec<Vec<State>>,
    pub(crate) present: Vec<Present>,
    history: OnceCell<History<'g>>,
    told: Vec<OnceCell<Told>>,
}

impl<'g> Plan<'g> {
    /// Decides every piece of a graph by its record. The outputs of published nodes and of `verified` ones are read and
    /// verified besides.
    pub fn new(graph: &'g Graph, store: &'g Store, verified: &[usize]) -> Self {
        const SILENT: &Listener<'static> = &|_| {};
        let mut plan = Self {
            run: Run::new(graph, store, SILENT),
            states: Vec::new(),
            present: Vec::new(),
            history: OnceCell::new(),
            told: graph.nodes.iter().map(|_| OnceCell::new()).collect(),
        };
        for (node, it) in graph.nodes.iter().enumerate() {
            plan.present.push(Present::new(&plan.run, node));
            let verify = it.node.is_published() || verified.contains(&node);
            let state = |piece: usize| {
                if !graph.wanted[node][piece] {
                    return State::Cached;
                }
                plan.state(node, piece, verify)
            };
            let states = (0..it.pieces.len()).map(state).collect();
            plan.states.push(states);
        }
        plan.find_needed();
        plan
    }

    /// Every node, in paper order.
    pub fn nodes(&self) -> Vec<NodePlan> {
        (0..self.states.len()).map(|node| self.node_plan(node)).collect()
    }

    /// What all of it is expected to take.
    pub fn cost(&self) -> Cost {
        let mut cost = Cost::default();
        for node in 0..self.states.len() {
            cost.add(self.told(node).cost);
        }
        cost
    }

    /// The nodes asked for whose published files are not certain to stay.
    pub fn affected(&self) -> Vec<String> {
        let graph = self.run.graph;
        let affected = |node: &&usize| graph.nodes[**node].node.is_published() && !self.is_cached(**node);
        graph
            .targets
            .iter()
            .filter(affected)
            .map(|node| graph.nodes[*node].name())
            .collect()
    }

    /// Whether a run would leave a node alone.
    pub fn is_cached(&self, node: usize) -> bool {
        self.states[node].iter().all(|state| *state == State::Cached)
    }

    /// The published texts of a node that is cached, without healing anything.
    pub fn published(&self, node: usize) -> Option<BTreeMap<String, String>> {
        let it = &self.run.graph.nodes[node];
        match self.look(node, &self.run.id(node, 0)?) {
            Found::Bytes(bytes) => it.node.published(&bytes).ok(),
            Found::Missing | Found::Damaged(_) => None,
        }
    }

    pub(crate) fn history(&self) -> &History<'g> {
        self.history.get_or_init(|| History::read(self.run.store))
    }

    pub(crate) fn told(&self, node: usize) -> &Told {
        self.told[node].get_or_init(|| tell(self, node))
    }

    fn node_plan(&self, node: usize) -> NodePlan {
        let it = &self.run.graph.nodes[node];
        let told = self.told(node);
        let graph = self.run.graph;
        let count = |of: fn(&State) -> bool| {
            let wanted = graph.wanted_pieces(node);
            wanted.filter(|piece| of(&self.states[node][*piece])).count()
        };
        NodePlan {
            node: it.name(),
            paper: it.node.paper().to_owned(),
            pieces: count(|_| true),
            cached: count(|state| *state == State::Cached),
            will_run: count(|state| matches!(state, State::WillRun(_))),
            may_run: count(|state| matches!(state, State::MayRun(_))),
            reason: told.sentence(self.run.graph),
            reasons: told.all(self.run.graph),
            seconds: told.cost.at_most,
            seconds_certain: told.cost.certain,
            untimed: told.cost.untimed,
        }
    }

    fn state(&self, node: usize, piece: usize, verify: bool) -> State {
        match self.run.decide(node, piece) {
            Decision::Cached if !verify => State::Cached,
            Decision::Cached => match self.run.id(node, piece).map(|id| self.look(node, &id)) {
                Some(Found::Damaged(why)) => State::WillRun(Cause::Damaged(format!("object damaged: {why}"))),
                _ => State::Cached,
            },
            Decision::WillRun(key) => match self.run.store.record(&key) {
                Some(record) => self.lost(node, piece, &record),
                None if self.run.store.has_record(&key) => State::WillRun(Cause::Damaged("record damaged".to_owned())),
                None => State::WillRun(Cause::Key),
            },
            Decision::MayRun if self.can_hit(node, piece) => State::MayRun(Cause::Key),
            Decision::MayRun => State::WillRun(Cause::Key),
        }
    }

    /// A record without its object: made again, it must have its id, so nothing below needs to run for it, nor it itself
    /// until somebody needs it. What is published is always read; what was damaged is healed at once.
    fn lost(&self, node: usize, piece: usize, record: &Record) -> State {
        let Some(id) = Id::parse(&record.id) else {
            return State::WillRun(Cause::Damaged("record damaged: it names no id".to_owned()));
        };
        self.run.take_as_known(node, piece, id, record.bytes);
        if self.run.store.was_set_aside(&id) {
            let what = "object damaged: it lies in quarantine".to_owned();
            State::WillRun(Cause::Damaged(what))
        } else if self.run.graph.nodes[node].node.is_published() {
            State::WillRun(Cause::Missing)
        } else {
            State::Cached
        }
    }

    /// What is at hand of an object, which stays where it is.
    fn look(&self, node: usize, id: &Id) -> Found {
        let schema = schema_number(self.run.graph.nodes[node].node.schema());
        self.run.store.peek(id, Some(schema))
    }

    /// Whether there is a record that some outcome of the unknown inputs would find.
    fn can_hit(&self, node: usize, piece: usize) -> bool {
        let it = &self.run.graph.nodes[node];
        let now = inputs(&self.run, node, piece);
        // A list of another length is another content, whatever its pieces come to.
        let lengths: Vec<usize> = now.iter().map(|now| self.states[now.node].len()).collect();
        let is_as_long = |record: &Record| {
            let part = self.history().inputs_of(record);
            part.is_none_or(|part| {
                let places = part.inputs.iter().zip(&now).zip(&lengths);
                let mut read_whole = places.filter(|((_, now), _)| now.piece.is_none());
                read_whole.all(|((old, _), length)| old.pieces.len().max(1) == *length)
            })
        };
        let fits = |record: &Record| {
            record.keys == KEY_SCHEMA
                && record.seed == self.run.graph.seed
                && record.code == self.present[node].code
                && record.params == self.present[node].params
                && record.inputs.len() == now.len()
                && now
                    .iter()
                    .zip(&record.inputs)
                    .all(|(now, old)| now.id.as_ref().is_none_or(|id| id == old))
                && is_as_long(record)
                && self.history().is_usable(record)
        };
        self.history()
            .of_piece(it.node.name(), it.pieces[piece])
            .iter()
            .any(fits)
    }

    /// Marks outputs whose bytes are gone and that a piece which will or may run reads; from below, since they may need
    /// others.
    fn find_needed(&mut self) {
        for node in (0..self.states.len()).rev() {
            for link in &self.run.graph.nodes[node].links {
                for up in &link.upstream {
                    self.need(node, *up, link.kind == Kind::Each);
                }
            }
        }
    }

    fn need(&mut self, reader: usize, up: usize, each: bool) {
        let strength = |state: &State| match state {
            State::Cached => 0,
            State::MayRun(_) => 1,
            State::WillRun(_) => 2,
        };
        let whole = self.states[reader].iter().map(strength).max().unwrap_or(0);
        for piece in 0..self.states[up].len() {
            let wanted = if each {
                strength(&self.states[reader][piece])
            } else {
                whole
            };
            let is_stronger = match &self.states[up][piece] {
                State::Cached => wanted > 0 && self.run.id(up, piece).is_some_and(|id| !self.run.store.has(&id)),
                State::MayRun(Cause::Needed(_) | Cause::Missing) => wanted > 1,
                _ => false,
            };
            if is_stronger {
                let cause = self.absence(up, piece, reader);
                self.states[up][piece] = if wanted > 1 {
                    State::WillRun(cause)
                } else {
                    State::MayRun(cause)
                };
            }
        }
    }

    /// Why the bytes of a piece that a reader needs are not there.
    fn absence(&self, node: usize, piece: usize, reader: usize) -> Cause {
        let record = self.run.key(node, piece).and_then(|key| self.run.store.record(&key));
        if record.is_some_and(|record| record.evicted) {
            Cause::Needed(reader)
        } else {
            Cause::Missing
        }
    }
}

/// Decides every wanted piece of a run; whether all of them are cached, so that nothing has to run.
///
/// A piece whose object was deleted by hand counts as cached while no reader needs its bytes: like what garbage
/// collection took, it is made again when somebody reads it.
pub fn decide_all(run: &Run<'_>) -> bool {
    let pieces = |node| run.graph.wanted_pieces(node).map(move |piece| (node, piece));
    let all = || (0..run.graph.nodes.len()).flat_map(pieces);
    let (mut is_complete, mut is_lost) = (true, false);
    for (node, piece) in all() {
        match run.decide(node, piece) {
            Decision::Cached => {}
            Decision::MayRun => is_complete = false,
            Decision::WillRun(key) => {
                is_complete = false;
                is_lost |= run.store.record(&key).is_some();
            }
        }
    }
    if !is_lost {
        return is_complete;
    }
    let plan = Plan::new(run.graph, run.store, &[]);
    for (node, piece) in all().filter(|(node, piece)| plan.states[*node][*piece] == State::Cached) {
        if let (Some(id), Some(bytes)) = (plan.run.id(node, piece), plan.run.bytes_of(node, piece)) {
            run.take_as_known(node, piece, id, bytes);
        }
    }
    all().all(|(node, piece)| run.id(node, piece).is_some())
}

/// The pieces of a node that the plan would not leave alone.
pub(crate) fn not_cached(states: &[State]) -> BTreeSet<usize> {
    let pieces = states.iter().enumerate();
    pieces
        .filter(|(_, state)| **state != State::Cached)
        .map(|(piece, _)| piece)
        .collect()
}
