//! Why: the walk from a node to the root changes that make it run, not just to "an input changed".
//!
//! A root is told once, at the most upstream node of the first branch that leads to it; branches that lead only to roots
//! already told are left out, and what else runs on the way is listed beside the tree.

use std::cmp::Reverse;
use std::collections::{BTreeMap, BTreeSet};

use serde::Serialize;

use crate::engine::arrow::Kind;
use crate::engine::compare::inputs;
use crate::engine::explain::Changed;
use crate::engine::plan::{Cost, Plan, State};
use crate::engine::reason::Reason;
use crate::engine::record::Record;

/// Why some nodes of one stage are not cached.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Branch {
    /// The first of the nodes, `STAGE/CASE`.
    pub node: String,
    /// The number of nodes: cases with equal roots are told together.
    pub cases: usize,
    /// `will_run`, `may_run`, or `changed` for an input that has changed already and runs no more.
    pub state: &'static str,
    /// Their pieces that will or may run.
    pub pieces: usize,
    /// All their pieces.
    pub of: usize,
    /// What these pieces are expected to take.
    pub cost: Cost,
    /// Root changes that lie here.
    pub reasons: Vec<Reason>,
    /// Inputs that lead to further roots.
    pub because: Vec<Branch>,
}

/// Nodes of one stage that run on the way and that the tree leaves out.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Besides {
    /// The stage.
    pub stage: String,
    /// Its nodes.
    pub nodes: usize,
    /// Their pieces that will or may run.
    pub pieces: usize,
}

/// The answer to `why`.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Why {
    /// `cached`, `will_run` or `may_run`.
    pub state: &'static str,
    /// Pieces that will or may run to bring the nodes up to date, all inputs included.
    pub pieces: usize,
    /// What they are expected to take.
    pub cost: Cost,
    /// A tree for each group of nodes with equal roots.
    pub because: Vec<Branch>,
    /// What else runs for it.
    pub besides: Vec<Besides>,
    /// The records that make the cached pieces so, if all are cached.
    pub records: Vec<Kept>,
}

/// A record and what its inputs are.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Kept {
    /// The record of a piece.
    pub record: Record,
    /// The nodes of its inputs, in their order.
    pub reads: Vec<String>,
}

/// A step of the walk: a node that is not cached, or one that has changed already.
#[derive(Clone)]
enum Step {
    Runs(usize),
    Changed(Changed),
}

struct Walk<'p, 'g> {
    plan: &'p Plan<'g>,
    roots: BTreeMap<usize, BTreeSet<Reason>>,
    depths: BTreeMap<usize, usize>,
    told: BTreeSet<Reason>,
    shown: BTreeSet<usize>,
}

/// Explains some nodes, or one piece of them.
pub fn why(plan: &Plan<'_>, nodes: &[usize], piece: Option<usize>) -> Why {
    let closure = closure(plan, nodes, piece);
    let mut cost = Cost::default();
    let costs: Vec<&Cost> = closure
        .iter()
        .filter_map(|(node, piece)| plan.told(*node).costs.get(piece))
        .collect();
    for own in &costs {
        cost.add(**own);
    }
    let asked = |node: usize| {
        plan.states[node]
            .iter()
            .enumerate()
            .filter(move |(at, _)| piece.is_none_or(|piece| piece == *at))
    };
    let states: Vec<&State> = nodes
        .iter()
        .flat_map(|node| asked(*node))
        .map(|(_, state)| state)
        .collect();
    let state = state_of(&states);
    let mut walk = Walk {
        plan,
        roots: BTreeMap::new(),
        depths: BTreeMap::new(),
        told: BTreeSet::new(),
        shown: BTreeSet::new(),
    };
    let (mut because, mut records) = (Vec::new(), Vec::new());
    if state == "cached" {
        let places = nodes
            .iter()
            .flat_map(|node| asked(*node).map(|(piece, _)| (*node, piece)));
        records = places.filter_map(|(node, piece)| kept(plan, node, piece)).collect();
    } else {
        let running = nodes
            .iter()
            .filter(|node| asked(**node).any(|(_, state)| *state != State::Cached));
        for group in walk.groups(running.map(|node| Step::Runs(*node)).collect()) {
            because.push(walk.branch(&group));
        }
    }
    let besides = besides(plan, &closure, &walk.shown);
    Why {
        state,
        pieces: costs.len(),
        cost,
        because,
        besides,
        records,
    }
}

fn kept(plan: &Plan<'_>, node: usize, piece: usize) -> Option<Kept> {
    let record = plan.run.store.record(&plan.run.key(node, piece)?)?;
    let reads = inputs(&plan.run, node, piece).into_iter();
    let reads = reads.map(|input| plan.run.graph.nodes[input.node].name()).collect();
    Some(Kept { record, reads })
}

fn state_of(states: &[&State]) -> &'static str {
    if states.iter().any(|state| matches!(state, State::WillRun(_))) {
        "will_run"
    } else if states.iter().any(|state| matches!(state, State::MayRun(_))) {
        "may_run"
    } else {
        "cached"
    }
}

/// Every piece that some nodes, or one piece of them, depend on, these included.
fn closure(plan: &Plan<'_>, nodes: &[usize], piece: Option<usize>) -> BTreeSet<(usize, usize)> {
    let pieces = |node: usize| 0..plan.states[node].len();
    let asked = |node: &usize| {
        pieces(*node)
            .filter(|at| piece.is_none_or(|piece| piece == *at))
            .map(|at| (*node, at))
            .collect::<Vec<_>>()
    };
    let mut open: Vec<(usize, usize)> = nodes.iter().flat_map(asked).collect();
    let mut closure = BTreeSet::new();
    while let Some((node, piece)) = open.pop() {
        if !closure.insert((node, piece)) {
            continue;
        }
        for link in &plan.run.graph.nodes[node].links {
            for up in &link.upstream {
                let read = if link.kind == Kind::Each {
                    piece..piece + 1
                } else {
                    pieces(*up)
                };
                open.extend(read.map(|piece| (*up, piece)).filter(|place| !closure.contains(place)));
            }
        }
    }
    closure
}

/// What of the closure runs and is not in the tree, by stage, in paper order.
fn besides(plan: &Plan<'_>, closure: &BTreeSet<(usize, usize)>, shown: &BTreeSet<usize>) -> Vec<Besides> {
    let mut besides: Vec<Besides> = Vec::new();
    let mut last = None;
    let running = |place: &&(usize, usize)| plan.states[place.0][place.1] != State::Cached && !shown.contains(&place.0);
    for (node, _) in closure.iter().filter(running) {
        let stage = plan.run.graph.nodes[*node].node.name();
        if besides.last().is_none_or(|besides| besides.stage != stage) {
            let stage = stage.to_owned();
            besides.push(Besides {
                stage,
                nodes: 0,
                pieces: 0,
            });
        }
        let of_stage = besides.last_mut().expect("one was pushed if there was none");
        of_stage.nodes += usize::from(last != Some(*node));
        of_stage.pieces += 1;
        last = Some(*node);
    }
    besides
}

impl Walk<'_, '_> {
    fn steps(&self, step: &Step) -> Vec<Step> {
        let changed = |changed: &[Changed]| changed.iter().cloned().map(Step::Changed).collect::<Vec<_>>();
        match step {
            Step::Runs(node) => {
                let told = self.plan.told(*node);
                let mut steps = changed(&told.changed);
                steps.extend(told.upstream.iter().map(|up| Step::Runs(*up)));
                steps
            }
            Step::Changed(it) => changed(&it.inputs),
        }
    }

    fn own<'s>(&'s self, step: &'s Step) -> &'s BTreeSet<Reason> {
        match step {
            Step::Runs(node) => &self.plan.told(*node).reasons,
            Step::Changed(changed) => &changed.reasons,
        }
    }

    /// Every root that a step leads to.
    fn roots(&mut self, step: &Step) -> BTreeSet<Reason> {
        if let Step::Runs(node) = step
            && let Some(roots) = self.roots.get(node)
        {
            return roots.clone();
        }
        let mut roots = self.own(step).clone();
        for step in self.steps(step) {
            roots.extend(self.roots(&step));
        }
        if let Step::Runs(node) = step {
            self.roots.insert(*node, roots.clone());
        }
        roots
    }

    /// The number of steps to the farthest root.
    fn depth(&mut self, step: &Step) -> usize {
        if let Step::Runs(node) = step
            && let Some(depth) = self.depths.get(node)
        {
            return *depth;
        }
        let below = self.steps(step);
        let depth = below.iter().map(|step| self.depth(step) + 1).max().unwrap_or(0);
        if let Step::Runs(node) = step {
            self.depths.insert(*node, depth);
        }
        depth
    }

    /// Steps of one stage with equal roots together; the longest way first, of equal ones the dearest.
    fn groups(&mut self, steps: Vec<Step>) -> Vec<Vec<Step>> {
        let graph = self.plan.run.graph;
        let mut groups: Vec<(bool, BTreeSet<Reason>, Vec<Step>)> = Vec::new();
        let node = |step: &Step| match step {
            Step::Runs(node) => (*node, true),
            Step::Changed(changed) => (changed.node, false),
        };
        for step in steps {
            let (at, runs) = node(&step);
            let roots = self.roots(&step);
            let same = groups.iter_mut().find(|(other_runs, other_roots, others)| {
                let stage = graph.nodes[node(&others[0]).0].node.name();
                *other_runs == runs && *other_roots == roots && stage == graph.nodes[at].node.name()
            });
            match same {
                Some((_, _, others)) if others.iter().any(|other| node(other).0 == at) => {}
                Some((_, _, others)) => others.push(step),
                None => groups.push((runs, roots, vec![step])),
            }
        }
        let mut groups: Vec<Vec<Step>> = groups.into_iter().map(|(_, _, steps)| steps).collect();
        for steps in &mut groups {
            steps.sort_by_key(|step| node(step).0);
        }
        groups.sort_by_cached_key(|steps| {
            let pieces: usize = steps.iter().map(|step| self.plan.states[node(step).0].len()).sum();
            let cost: f64 = steps.iter().map(|step| self.plan.told(node(step).0).cost.at_most).sum();
            // Seconds are not negative, so their bits are in their order.
            Reverse((self.depth(&steps[0]), pieces, cost.to_bits(), node(&steps[0]).0))
        });
        groups
    }

    fn branch(&mut self, group: &[Step]) -> Branch {
        let mut branch = self.head(group);
        let own: BTreeSet<Reason> = group.iter().flat_map(|step| self.own(step).clone()).collect();
        // What was never made needs no further reason, least of all that its inputs were not made either.
        let first = own.contains(&Reason::FirstTime) && self.told.insert(Reason::FirstTime);
        let below = group.iter().flat_map(|step| self.steps(step)).collect();
        for group in self.groups(below) {
            if !self.roots(&group[0]).is_subset(&self.told) {
                let told = self.branch(&group);
                branch.because.push(told);
            }
        }
        let untold = own
            .into_iter()
            .filter(|reason| (first && *reason == Reason::FirstTime) || self.told.insert(reason.clone()));
        branch.reasons = untold.collect();
        branch
    }

    fn head(&mut self, group: &[Step]) -> Branch {
        let graph = self.plan.run.graph;
        let mut cost = Cost::default();
        let (mut pieces, mut of) = (0, 0);
        let (mut states, mut names) = (Vec::new(), Vec::new());
        for step in group {
            let node = match step {
                Step::Runs(node) => *node,
                Step::Changed(changed) => changed.node,
            };
            names.push(graph.nodes[node].name());
            of += self.plan.states[node].len();
            if let Step::Runs(node) = step {
                self.shown.insert(*node);
                cost.add(self.plan.told(*node).cost);
                states.extend(&self.plan.states[*node]);
                pieces += self.plan.states[*node]
                    .iter()
                    .filter(|state| **state != State::Cached)
                    .count();
            }
        }
        Branch {
            node: names.swap_remove(0),
            cases: group.len(),
            state: if states.is_empty() {
                "changed"
            } else {
                state_of(&states)
            },
            pieces,
            of,
            cost,
            reasons: Vec::new(),
            because: Vec::new(),
        }
    }
}
