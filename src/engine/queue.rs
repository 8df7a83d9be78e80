//! Queue: the pieces whose inputs are known, deepest first, and those that others are making.
//!
//! Deepest first sends a batch of fields from its phases to its maxima before the next batch begins, so memory does
//! not grow with the number of fields.

use std::cmp::Reverse;
use std::collections::{BTreeMap, BTreeSet, BinaryHeap};
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use crate::engine::arrow::Kind;
use crate::engine::error::{Error, Result};
use crate::engine::event::Event;
use crate::engine::graph::Graph;
use crate::engine::run::Run;

/// How often pieces that others are making are looked at again.
const PATIENCE: Duration = Duration::from_millis(10);

/// What came of a piece.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Turn {
    /// Its id is known.
    Done,
    /// Another worker of this run is making it.
    MadeHere,
    /// Another run is making it.
    MadeElsewhere,
}

pub(crate) struct Queue {
    state: Mutex<State>,
    ready: Condvar,
    closed: Condvar,
    /// Per node: the nodes that read it piece by piece, and those that read it whole.
    each: Vec<Vec<usize>>,
    whole: Vec<Vec<usize>>,
}

struct State {
    heap: BinaryHeap<(usize, Reverse<usize>)>,
    /// Pieces that somebody else is making, and whether that is another run.
    aside: Vec<(usize, usize, bool)>,
    /// Pieces whose wait has been told of.
    told: BTreeSet<(usize, usize)>,
    /// Whether something has been finished since those aside were looked at.
    news: bool,
    running: usize,
    is_closed: bool,
    /// Per piece: inputs not known yet.
    missing: Vec<Vec<usize>>,
    /// Per node: wanted pieces not done yet.
    left: Vec<usize>,
    fatal: Option<Error>,
    failures: BTreeMap<(usize, usize), Error>,
}

impl Queue {
    /// The pieces of a graph, those without inputs ready.
    pub(crate) fn new(graph: &Graph) -> Self {
        let mut each = vec![Vec::new(); graph.nodes.len()];
        let mut whole = vec![Vec::new(); graph.nodes.len()];
        let mut missing: Vec<Vec<usize>> = Vec::new();
        for (down, node) in graph.nodes.iter().enumerate() {
            let mut inputs = 0;
            for link in &node.links {
                for up in &link.upstream {
                    inputs += 1;
                    if link.kind == Kind::Each {
                        each[*up].push(down);
                    } else {
                        whole[*up].push(down);
                    }
                }
            }
            // One that nobody wants misses something that never comes.
            let wanted = graph.wanted[down].iter();
            missing.push(wanted.map(|wanted| inputs + usize::from(!wanted)).collect());
        }
        let mut heap = BinaryHeap::new();
        for (node, pieces) in missing.iter().enumerate() {
            for (piece, inputs) in pieces.iter().enumerate() {
                if *inputs == 0 {
                    heap.push((node, Reverse(piece)));
                }
            }
        }
        let left = (0..graph.nodes.len()).map(|node| graph.wanted_pieces(node).count());
        let left = left.collect();
        let state = State {
            heap,
            aside: Vec::new(),
            told: BTreeSet::new(),
            news: false,
            running: 0,
            is_closed: false,
            missing,
            left,
            fatal: None,
            failures: BTreeMap::new(),
        };
        Self {
            state: Mutex::new(state),
            ready: Condvar::new(),
            closed: Condvar::new(),
            each,
            whole,
        }
    }

    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The deepest ready piece; waits while others may still become ready, ends when none can.
    pub(crate) fn take(&self, run: &Run<'_>) -> Option<(usize, usize)> {
        let mut state = self.state();
        loop {
            if state.fatal.is_some() || (state.heap.is_empty() && state.aside.is_empty() && state.running == 0) {
                return None;
            }
            if let Some((node, Reverse(piece))) = state.heap.pop() {
                state.running += 1;
                return Some((node, piece));
            }
            state = if state.aside.is_empty() {
                self.ready.wait(state).unwrap_or_else(PoisonError::into_inner)
            } else {
                self.wait_for_others(state, run)
            };
        }
    }

    /// Nothing is left but what others are making: waits a little, then has another look at it.
    fn wait_for_others<'q>(&'q self, mut state: MutexGuard<'q, State>, run: &Run<'_>) -> MutexGuard<'q, State> {
        let untold = state.untold();
        drop(state);
        // Others may be waiting for what this run has made but not published.
        if let Err(error) = run.store.flush() {
            self.fail(error);
        }
        for (node, piece) in untold {
            let node = run.graph.nodes[node].name();
            run.tell(&Event::DidWait { node, piece });
        }
        state = self.state();
        if state.heap.is_empty() && !state.news && state.fatal.is_none() {
            let woken = self.ready.wait_timeout(state, PATIENCE);
            state = woken.unwrap_or_else(PoisonError::into_inner).0;
        }
        state.news = false;
        for (node, piece, _) in std::mem::take(&mut state.aside) {
            state.heap.push((node, Reverse(piece)));
        }
        state
    }

    /// Takes note of what came of a piece that was taken.
    pub(crate) fn finish(&self, graph: &Graph, node: usize, piece: usize, outcome: Result<Turn>) {
        let mut state = self.state();
        state.running -= 1;
        match outcome {
            Ok(Turn::Done) => self.release(&mut state, graph, node, piece),
            // Nobody is woken: whoever set it aside looks after it.
            Ok(taken) => return state.aside.push((node, piece, taken == Turn::MadeElsewhere)),
            Err(error @ Error::Stage { .. }) => {
                state.failures.insert((node, piece), error);
            }
            Err(error) => state.fatal = Some(state.fatal.take().unwrap_or(error)),
        }
        state.news = true;
        drop(state);
        self.ready.notify_all();
    }

    /// Ends the run: nothing new is begun.
    pub(crate) fn fail(&self, error: Error) {
        let mut state = self.state();
        state.fatal = Some(state.fatal.take().unwrap_or(error));
        drop(state);
        self.ready.notify_all();
    }

    /// Says that the workers have ended.
    pub(crate) fn close(&self) {
        self.state().is_closed = true;
        self.closed.notify_all();
    }

    /// Waits; whether the workers are still at work afterwards.
    pub(crate) fn is_open_after(&self, time: Duration) -> bool {
        let state = self.state();
        let waited = self.closed.wait_timeout_while(state, time, |state| !state.is_closed);
        !waited.unwrap_or_else(PoisonError::into_inner).0.is_closed
    }

    fn release(&self, state: &mut State, graph: &Graph, node: usize, piece: usize) {
        for down in &self.each[node] {
            state.arrive(*down, piece);
        }
        state.left[node] -= 1;
        if state.left[node] == 0 {
            for down in &self.whole[node] {
                for piece in 0..graph.nodes[*down].pieces.len() {
                    state.arrive(*down, piece);
                }
            }
        }
    }

    /// The error that ended the run, or the list of the pieces that failed.
    pub(crate) fn verdict(self, graph: &Graph) -> Result<()> {
        let state = self.state.into_inner().unwrap_or_else(PoisonError::into_inner);
        if let Some(error) = state.fatal {
            return Err(error);
        }
        if state.failures.is_empty() {
            return Ok(());
        }
        let told: Vec<String> = state.failures.values().map(ToString::to_string).collect();
        let undone = state
            .left
            .iter()
            .zip(&graph.nodes)
            .filter(|(left, _)| **left > 0)
            .count();
        Err(Error::Failures(format!(
            "{}\n{} not done; the others are kept",
            told.join("\n"),
            if undone == 1 {
                "1 node is".to_owned()
            } else {
                format!("{undone} nodes are")
            }
        )))
    }
}

impl State {
    /// The pieces that other runs are making and whose wait is news.
    fn untold(&mut self) -> Vec<(usize, usize)> {
        let Self { aside, told, .. } = self;
        let others = aside.iter().filter(|(_, _, elsewhere)| *elsewhere);
        let fresh = others.map(|(node, piece, _)| (*node, *piece));
        fresh.filter(|it| told.insert(*it)).collect()
    }

    fn arrive(&mut self, node: usize, piece: usize) {
        self.missing[node][piece] -= 1;
        if self.missing[node][piece] == 0 {
            self.heap.push((node, Reverse(piece)));
        }
    }
}
