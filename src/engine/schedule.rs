//! Schedule: a queue of pieces whose inputs are known, deepest first, and the workers that empty it.
//!
//! Deepest first sends a batch of fields from its phases to its maxima before the next batch begins, so memory does
//! not grow with the number of fields. Which worker runs what never shows in a result.

use std::cmp::Reverse;
use std::collections::{BTreeMap, BinaryHeap};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};

use crate::engine::arrow::Kind;
use crate::engine::error::{Error, Result};
use crate::engine::event::Event;
use crate::engine::graph::Graph;
use crate::engine::run::{Decision, Run};

/// Runs everything in a run's graph that is not cached.
///
/// # Errors
/// A store that cannot be written, a stage that is not reproducible, or the list of the nodes that failed.
pub fn execute(run: &Run<'_>, workers: usize) -> Result<()> {
    let nodes = run
        .graph
        .nodes
        .iter()
        .map(|node| (node.name(), node.pieces.len()))
        .collect();
    run.tell(&Event::DidPlan { nodes });
    let queue = Queue::new(run.graph);
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(workers)
        .build()
        .map_err(|why| Error::Usage(format!("-j {workers}: cannot start the workers: {why}")))?;
    pool.broadcast(|_| {
        while let Some((node, piece)) = queue.take() {
            let outcome = step(run, node, piece);
            queue.finish(run.graph, node, piece, outcome);
        }
    });
    run.store.flush()?;
    queue.verdict(run.graph)
}

fn step(run: &Run<'_>, node: usize, piece: usize) -> Result<()> {
    match run.decide(node, piece) {
        Decision::Cached => {
            run.tell(&Event::DidReuse {
                node: run.graph.nodes[node].name(),
                piece,
            });
            Ok(())
        }
        Decision::WillRun(key) => {
            // A stage that panics must not leave the other workers waiting for it.
            let made = catch_unwind(AssertUnwindSafe(|| run.make(node, piece, key)));
            let made =
                made.unwrap_or_else(|_| Err(Error::stage("it panicked").at(&run.graph.nodes[node].piece_name(piece))));
            if let Err(error) = &made {
                let node = run.graph.nodes[node].name();
                run.tell(&Event::DidFail {
                    node,
                    piece,
                    message: error.to_string(),
                });
            }
            made
        }
        Decision::MayRun => Err(Error::stage("a piece was ready before its inputs")),
    }
}

struct Queue {
    state: Mutex<State>,
    ready: Condvar,
    /// Per node: the nodes that read it piece by piece, and those that read it whole.
    each: Vec<Vec<usize>>,
    whole: Vec<Vec<usize>>,
}

struct State {
    heap: BinaryHeap<(usize, Reverse<usize>)>,
    running: usize,
    /// Per piece: inputs not known yet.
    missing: Vec<Vec<usize>>,
    /// Per node: pieces not done yet.
    left: Vec<usize>,
    fatal: Option<Error>,
    failures: BTreeMap<(usize, usize), Error>,
}

impl Queue {
    fn new(graph: &Graph) -> Self {
        let mut each = vec![Vec::new(); graph.nodes.len()];
        let mut whole = vec![Vec::new(); graph.nodes.len()];
        let mut missing = Vec::new();
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
            missing.push(vec![inputs; node.pieces.len()]);
        }
        let mut heap = BinaryHeap::new();
        for (node, pieces) in missing.iter().enumerate() {
            for (piece, inputs) in pieces.iter().enumerate() {
                if *inputs == 0 {
                    heap.push((node, Reverse(piece)));
                }
            }
        }
        let left = graph.nodes.iter().map(|node| node.pieces.len()).collect();
        let state = State {
            heap,
            running: 0,
            missing,
            left,
            fatal: None,
            failures: BTreeMap::new(),
        };
        Self {
            state: Mutex::new(state),
            ready: Condvar::new(),
            each,
            whole,
        }
    }

    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The deepest ready piece; waits while others may still become ready, ends when none can.
    fn take(&self) -> Option<(usize, usize)> {
        let mut state = self.state();
        loop {
            if state.fatal.is_some() {
                return None;
            }
            if let Some((node, Reverse(piece))) = state.heap.pop() {
                state.running += 1;
                return Some((node, piece));
            }
            if state.running == 0 {
                return None;
            }
            state = self.ready.wait(state).unwrap_or_else(PoisonError::into_inner);
        }
    }

    fn finish(&self, graph: &Graph, node: usize, piece: usize, outcome: Result<()>) {
        let mut state = self.state();
        state.running -= 1;
        match outcome {
            Ok(()) => self.release(&mut state, graph, node, piece),
            Err(error @ Error::Stage { .. }) => {
                state.failures.insert((node, piece), error);
            }
            Err(error) => state.fatal = Some(state.fatal.take().unwrap_or(error)),
        }
        drop(state);
        self.ready.notify_all();
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

    fn verdict(self, graph: &Graph) -> Result<()> {
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
            "{}\n{undone} nodes are not done; the others are kept",
            told.join("\n")
        )))
    }
}

impl State {
    fn arrive(&mut self, node: usize, piece: usize) {
        self.missing[node][piece] -= 1;
        if self.missing[node][piece] == 0 {
            self.heap.push((node, Reverse(piece)));
        }
    }
}
