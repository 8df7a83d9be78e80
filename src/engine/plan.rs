//! Plan: what a run would do, piece by piece, without doing it.

use crate::engine::graph::Graph;
use crate::engine::run::{Decision, Run};
use crate::engine::store::Store;

/// What a run would do with one node.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct NodePlan {
    /// `STAGE/CASE`.
    pub node: String,
    /// Its place in the paper.
    pub paper: String,
    /// Its pieces.
    pub pieces: usize,
    /// Pieces that are cached.
    pub cached: usize,
    /// Pieces that will run.
    pub will_run: usize,
    /// Pieces that run only if an input comes out changed.
    pub may_run: usize,
    /// Why it is not all cached; empty if it is.
    pub reason: String,
    /// The recorded seconds of the cached pieces.
    pub seconds: f64,
}

/// Decides every piece of a graph.
pub fn plan(graph: &Graph, store: &Store) -> Vec<NodePlan> {
    let silent = |_: &_| {};
    let run = Run::new(graph, store, &silent);
    graph
        .nodes
        .iter()
        .enumerate()
        .map(|(node, _)| plan_node(&run, node))
        .collect()
}

fn plan_node(run: &Run<'_>, node: usize) -> NodePlan {
    let it = &run.graph.nodes[node];
    let mut plan = NodePlan {
        node: it.name(),
        paper: it.node.paper().to_owned(),
        pieces: it.pieces.len(),
        cached: 0,
        will_run: 0,
        may_run: 0,
        reason: String::new(),
        seconds: 0.0,
    };
    for piece in 0..it.pieces.len() {
        match run.decide(node, piece) {
            Decision::Cached => {
                plan.cached += 1;
                let record = run.key(node, piece).and_then(|key| run.store.record(&key));
                plan.seconds += record.map_or(0.0, |record| record.seconds);
            }
            Decision::WillRun(_) => plan.will_run += 1,
            Decision::MayRun => plan.may_run += 1,
        }
    }
    if plan.will_run > 0 {
        "nothing in the store was made from these parameters, inputs and code".clone_into(&mut plan.reason);
    } else if plan.may_run > 0 {
        "an input will run".clone_into(&mut plan.reason);
    }
    plan
}
