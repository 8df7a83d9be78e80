//! Chart: the pipeline as boxes in paper order and arrows between them, each box with what a run would do with it.

use std::collections::BTreeSet;

use crate::engine::arrow::Kind;
use crate::engine::plan::{Plan, State};
use crate::text::count::thousands;

/// One stage, or one case of it.
#[derive(Clone, Debug, PartialEq)]
pub struct Tile {
    /// `STAGE`, or `STAGE/CASE`.
    pub name: String,
    /// Its place in the paper.
    pub paper: String,
    /// Its cases; one for a case.
    pub cases: usize,
    /// The pieces of all of them.
    pub pieces: usize,
    /// Pieces that will run.
    pub will_run: usize,
    /// Pieces that run only if an input comes out changed.
    pub may_run: usize,
    /// Whether it writes figures or tables.
    pub published: bool,
}

/// One stage reads another.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Flow {
    /// The place of the tile that is read.
    pub from: usize,
    /// The place of the reader, which comes later.
    pub to: usize,
    /// `one`, `each`, `all` or `cases`.
    pub kind: &'static str,
}

/// The tiles in paper order, and the arrows.
#[derive(Clone, Debug, PartialEq)]
pub struct Chart {
    /// In paper order, which is dataflow order.
    pub tiles: Vec<Tile>,
    /// Sorted.
    pub flows: Vec<Flow>,
}

impl Tile {
    /// `cached`, `will_run` or `may_run`.
    pub fn state(&self) -> &'static str {
        match (self.will_run, self.may_run) {
            (0, 0) => "cached",
            (0, _) => "may_run",
            _ => "will_run",
        }
    }

    /// "8 cases, 1,048 pieces", as far as it is more than one.
    pub(crate) fn counts(&self) -> String {
        let many = |count: usize, noun: &str| (count > 1).then(|| format!("{} {noun}", thousands(count as u64)));
        let pieces = many(self.pieces, "pieces").filter(|_| self.pieces != self.cases);
        let told: Vec<String> = [many(self.cases, "cases"), pieces].into_iter().flatten().collect();
        told.join(", ")
    }

    /// "4 will run, 8 may run"; empty if all is cached.
    pub(crate) fn news(&self) -> String {
        let some = |count: usize, what: &str| (count > 0).then(|| format!("{} {what}", thousands(count as u64)));
        let told = [some(self.will_run, "will run"), some(self.may_run, "may run")];
        told.into_iter().flatten().collect::<Vec<_>>().join(", ")
    }
}

/// The chart of a plan: a tile a stage, or a tile a case.
pub fn chart(plan: &Plan<'_>, by_case: bool) -> Chart {
    let graph = plan.run.graph;
    let mut tiles: Vec<Tile> = Vec::new();
    let mut place_of = Vec::new();
    for (node, it) in graph.nodes.iter().enumerate() {
        let name = if by_case { it.name() } else { it.node.name().to_owned() };
        if tiles.last().is_none_or(|tile| tile.name != name) {
            tiles.push(Tile {
                name,
                paper: it.node.paper().to_owned(),
                cases: 0,
                pieces: 0,
                will_run: 0,
                may_run: 0,
                published: it.node.is_published(),
            });
        }
        place_of.push(tiles.len() - 1);
        let tile = tiles.last_mut().expect("one was pushed if there was none");
        tile.cases += 1;
        tile.pieces += it.pieces.len();
        for state in &plan.states[node] {
            tile.will_run += usize::from(matches!(state, State::WillRun(_)));
            tile.may_run += usize::from(matches!(state, State::MayRun(_)));
        }
    }
    let mut flows = BTreeSet::new();
    for (node, it) in graph.nodes.iter().enumerate() {
        for link in &it.links {
            let kind = match link.kind {
                Kind::One => "one",
                Kind::Each => "each",
                Kind::All => "all",
                Kind::Cases => "cases",
            };
            let flow = |up: &usize| Flow {
                from: place_of[*up],
                to: place_of[node],
                kind,
            };
            flows.extend(link.upstream.iter().map(flow));
        }
    }
    let flows = flows.into_iter().collect();
    Chart { tiles, flows }
}
