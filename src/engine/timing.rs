//! Timing: what each stage took, by the pieces that a run made or by the records of when each piece was made.
//!
//! The seconds of a piece are those its worker had it in hand: inputs read and verified (an evicted one made again),
//! output computed and encoded. Writing it is not among them. Tested in `tests/cache/timing.rs`.

use std::collections::BTreeSet;

use serde::Serialize;

use crate::engine::graph::{Graph, NodeCase};
use crate::engine::history::stage_of;
use crate::engine::id::Id;
use crate::engine::run::{Listener, Run};
use crate::engine::store::Store;

/// What the pieces of one stage took.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct StageTime {
    /// The stage.
    pub stage: &'static str,
    /// Its place in the paper.
    pub paper: &'static str,
    /// Its nodes of which a piece is counted.
    pub nodes: usize,
    /// Those pieces; one that several cases share is one.
    pub pieces: usize,
    /// What they took, seconds of one core.
    pub seconds: f64,
    /// The length of their outputs.
    pub bytes: u64,
}

/// One piece: its node, seconds and bytes.
pub type PieceTime<'a> = (&'a str, f64, u64);

/// The stages of some pieces, in paper order; stages without any are left out.
pub fn by_stage<'a>(graph: &Graph, pieces: impl IntoIterator<Item = PieceTime<'a>>) -> Vec<StageTime> {
    let mut stages: Vec<StageTime> = Vec::new();
    for it in &graph.nodes {
        if stages.iter().all(|of| of.stage != it.node.name()) {
            stages.push(StageTime {
                stage: it.node.name(),
                paper: it.node.paper(),
                nodes: 0,
                pieces: 0,
                seconds: 0.0,
                bytes: 0,
            });
        }
    }
    let mut nodes = BTreeSet::new();
    for (node, seconds, bytes) in pieces {
        let Some(of) = stages.iter_mut().find(|of| of.stage == stage_of(node)) else {
            continue;
        };
        of.nodes += usize::from(nodes.insert(node));
        of.pieces += 1;
        of.seconds += seconds;
        of.bytes = of.bytes.saturating_add(bytes);
    }
    stages.retain(|of| of.pieces > 0);
    stages
}

/// What the pieces of a graph took when each was made, as their records say; nothing is run, nothing but records read.
pub fn recorded(graph: &Graph, store: &Store) -> Vec<StageTime> {
    const SILENT: &Listener<'static> = &|_| {};
    let run = Run::new(graph, store, SILENT);
    let names: Vec<String> = graph.nodes.iter().map(NodeCase::name).collect();
    let (mut seen, mut pieces) = (BTreeSet::new(), Vec::new());
    for (node, name) in names.iter().enumerate() {
        for piece in graph.wanted_pieces(node) {
            let Some(key) = run.key(node, piece) else { continue };
            let Some(record) = store.record(&key) else { continue };
            if let Some(id) = Id::parse(&record.id) {
                run.take_as_known(node, piece, id, record.bytes);
            }
            if seen.insert(record.key) {
                pieces.push((name.as_str(), record.seconds, record.bytes));
            }
        }
    }
    by_stage(graph, pieces)
}
