//! Graph: the cases of the nodes that some targets need, linked by their arrows, in paper order.

use std::collections::BTreeMap;

use crate::engine::arrow::Kind;
use crate::engine::case::{Axis, Case};
use crate::engine::code;
use crate::engine::decode::Fault;
use crate::engine::error::{Error, Result};
use crate::engine::key_path::KeyPath;
use crate::engine::nearest::nearest;
use crate::engine::node::{Decoded, Node, Value};
use crate::engine::params::ParamsFile;
use crate::engine::pipeline::{Checked, Pipeline, rows_of};
use crate::engine::stage::{Pieces, Select};
use crate::engine::streams::Streams;
use crate::engine::target::Target;

/// One case of one node.
pub struct NodeCase {
    /// The stage.
    pub node: &'static dyn Node,
    /// The case.
    pub case: Case,
    /// Its pieces: first item and number of items.
    pub pieces: Vec<(u64, u64)>,
    /// Its arrows, in order.
    pub(crate) links: Vec<Link>,
    pub(crate) decoded: Decoded,
    pub(crate) code: [u8; 32],
    pub(crate) streams: Streams,
}

/// An arrow with the upstream cases it reaches.
pub(crate) struct Link {
    pub(crate) kind: Kind,
    pub(crate) upstream: Vec<usize>,
}

/// The nodes that some targets need, upstream before downstream.
pub struct Graph {
    /// The node cases, in paper order.
    pub nodes: Vec<NodeCase>,
    /// The root seed.
    pub seed: u64,
    /// The node cases that were asked for.
    pub targets: Vec<usize>,
    /// Per node case and piece: whether it was asked for, or is read on the way to one that was.
    pub(crate) wanted: Vec<Vec<bool>>,
    /// The parameters in force, each with the place where it was written.
    pub(crate) params: ParamsFile,
    /// What the grids and steps of its cases resolve poorly: `place: key: expected .., found ..`, each once.
    pub warnings: Vec<String>,
}

impl NodeCase {
    /// `STAGE/CASE`, or `STAGE` for a node without axes.
    pub fn name(&self) -> String {
        let case = self.case.to_string();
        if case.is_empty() {
            self.node.name().to_owned()
        } else {
            format!("{}/{case}", self.node.name())
        }
    }

    /// The parameters it reads.
    pub fn params_json(&self) -> serde_json::Value {
        self.node.params_json(self.decoded.value.as_ref())
    }

    /// Decodes an output of a piece and checks it: the way from the store into a stage.
    ///
    /// The right hash says that the bytes are those that the store was given, not that the stage made them.
    ///
    /// # Errors
    /// Bytes of another type, or an output that breaks a rule of its stage.
    pub fn decode(&self, piece: usize, bytes: &[u8]) -> Result<Value> {
        let (first, items) = self.pieces[piece];
        let value = self.node.decode(bytes)?;
        let params = self.decoded.value.as_ref();
        self.node.check_value(params, first..first + items, &value)?;
        Ok(value)
    }

    /// `STAGE/CASE/PIECE`.
    pub fn piece_name(&self, piece: usize) -> String {
        if self.pieces.len() == 1 {
            self.name()
        } else {
            format!("{}/{piece}", self.name())
        }
    }
}

/// The most pieces of a graph: the plan of a run takes a few hundred bytes for each. The paper's has 10,500.
const MOST_PIECES: u64 = 250_000;

type Slot = (usize, Vec<usize>);

struct Builder<'a> {
    pipeline: &'a Pipeline,
    params: &'a ParamsFile,
    axes: Vec<Vec<Axis>>,
    /// All table names of each axis, those of `[run]` first, in its order.
    order: Vec<Vec<String>>,
    wanted: BTreeMap<Slot, Case>,
}

impl Graph {
    /// The graph that some targets need; all of the pipeline for none, but for what runs on request.
    ///
    /// # Errors
    /// A parameter or target that cannot be used.
    pub fn new(pipeline: &Pipeline, params: &ParamsFile, targets: &[Target]) -> Result<Self> {
        let checked = pipeline.check(params)?;
        let mut builder = Builder::new(pipeline, params)?;
        let mut asked = Vec::new();
        for place in 0..pipeline.contents.len() {
            let name = pipeline.contents[place].name();
            for target in targets.iter().filter(|target| target.stage == name) {
                asked.extend(builder.want_target(place, target)?);
            }
            if targets.is_empty() && !pipeline.on_request.contains(&name) {
                asked.extend(builder.want_all(place)?);
            }
        }
        if let Some(unknown) = targets.iter().find(|target| pipeline.place(&target.stage).is_none()) {
            let names = pipeline.contents.iter().map(|node| node.name());
            let hint = nearest(&unknown.stage, names.clone());
            let all: Vec<&str> = names.collect();
            return Err(Error::Usage(format!(
                "target `{}`: expected the name of a stage or output ({}), found none of them{hint}",
                unknown.stage,
                all.join(", ")
            )));
        }
        let places = builder.wanted.keys().map(|(place, _)| *place).collect();
        pipeline.check_rules(params, &checked, &places)?;
        builder.check_size()?;
        let mut graph = builder.link(&asked, checked)?;
        graph.warnings = graph.resolution(pipeline)?;
        targets.iter().try_for_each(|target| graph.check_piece(target))?;
        graph.want_pieces(targets);
        Ok(graph)
    }

    /// Checks what the grids and steps of every case resolve; gives the warnings.
    fn resolution(&self, pipeline: &Pipeline) -> Result<Vec<String>> {
        let mut warnings = Vec::new();
        for it in &self.nodes {
            let told = |fault: &Fault| self.params.fault(fault, pipeline.axes, &it.case, &rows_of(it.node));
            let found = it.node.resolution(&it.decoded).map_err(|fault| told(&fault))?;
            for warning in found.iter().map(|fault| told(fault).to_string()) {
                if !warnings.contains(&warning) {
                    warnings.push(warning);
                }
            }
        }
        Ok(warnings)
    }

    /// Marks the pieces that some targets need: a target that names one wants no other of its node.
    fn want_pieces(&mut self, targets: &[Target]) {
        for node in &self.targets {
            let it = &self.nodes[*node];
            let names = |target: &&Target| target.is_of(it.node.name(), &it.case.to_string());
            let named: Vec<Option<usize>> = targets.iter().filter(names).map(|target| target.piece).collect();
            let whole = named.is_empty() || named.contains(&None);
            for (piece, wanted) in self.wanted[*node].iter_mut().enumerate() {
                *wanted = whole || named.contains(&Some(piece));
            }
        }
        for node in (0..self.nodes.len()).rev() {
            let of_node = self.wanted[node].clone();
            for link in &self.nodes[node].links {
                for up in &link.upstream {
                    for (piece, wanted) in self.wanted[*up].iter_mut().enumerate() {
                        *wanted |= match link.kind {
                            Kind::Each => of_node[piece],
                            Kind::One | Kind::All | Kind::Cases => of_node.contains(&true),
                        };
                    }
                }
            }
        }
    }

    /// The wanted pieces of a node case.
    pub(crate) fn wanted_pieces(&self, node: usize) -> impl Iterator<Item = usize> {
        let pieces = self.wanted[node].iter().enumerate();
        pieces.filter(|(_, wanted)| **wanted).map(|(piece, _)| piece)
    }

    /// A piece that a target names exists.
    fn check_piece(&self, target: &Target) -> Result<()> {
        let Some((node, piece)) = self.find(target).map(|node| &self.nodes[node]).zip(target.piece) else {
            return Ok(());
        };
        if piece < node.pieces.len() {
            return Ok(());
        }
        let (name, last) = (node.name(), node.pieces.len() - 1);
        Err(Error::Usage(format!(
            "target `{name}/{piece}`: expected a piece from 0 to {last}, found {piece}"
        )))
    }

    /// The node case with a name as printed.
    pub fn find(&self, target: &Target) -> Option<usize> {
        self.nodes
            .iter()
            .position(|node| target.is_of(node.node.name(), &node.case.to_string()))
    }
}

impl<'a> Builder<'a> {
    fn new(pipeline: &'a Pipeline, params: &'a ParamsFile) -> Result<Self> {
        let mut order = Vec::new();
        for axis in pipeline.axes {
            let mut names = params.list(*axis)?;
            for other in params.tables(*axis)? {
                if !names.contains(&other) {
                    names.push(other);
                }
            }
            order.push(names);
        }
        Ok(Self {
            pipeline,
            params,
            axes: pipeline.axes_of_all(),
            order,
            wanted: BTreeMap::new(),
        })
    }

    fn slot(&self, place: usize, case: &Case) -> Slot {
        let rank = |(table, value): &(&str, String)| {
            let axis = self
                .pipeline
                .axes
                .iter()
                .position(|axis| axis.table == *table)
                .unwrap_or(0);
            self.order[axis]
                .iter()
                .position(|name| name == value)
                .unwrap_or(usize::MAX)
        };
        (place, case.values().iter().map(rank).collect())
    }

    fn want_all(&mut self, place: usize) -> Result<Vec<Slot>> {
        let node = self.pipeline.contents[place];
        let mut cases = vec![Case::default()];
        for axis in self.axes[place].clone() {
            let values = Pipeline::values(self.params, node, axis)?;
            cases = cases
                .iter()
                .flat_map(|case| values.iter().map(|value| case.with(axis, value)))
                .collect();
        }
        cases.iter().map(|case| self.want(place, case)).collect()
    }

    fn want_target(&mut self, place: usize, target: &Target) -> Result<Vec<Slot>> {
        let Some(wanted) = &target.case else {
            return self.want_all(place);
        };
        let mut cases = vec![Case::default()];
        for (i, axis) in self.pipeline.axes.iter().enumerate() {
            if self.axes[place].contains(axis) {
                let names = &self.order[i];
                cases = cases
                    .iter()
                    .flat_map(|case| names.iter().map(|value| case.with(*axis, value)))
                    .collect();
            }
        }
        let names: Vec<String> = cases.iter().map(ToString::to_string).collect();
        match cases.into_iter().find(|case| case.to_string() == *wanted) {
            Some(case) => Ok(vec![self.want(place, &case)?]),
            None => Err(Error::Usage(format!(
                "target `{}/{wanted}`: expected a case of {} ({}), found none of them{}",
                target.stage,
                target.stage,
                names.join(", "),
                nearest(wanted, names.iter().map(String::as_str))
            ))),
        }
    }

    fn want(&mut self, place: usize, case: &Case) -> Result<Slot> {
        let slot = self.slot(place, case);
        if self.wanted.insert(slot.clone(), case.clone()).is_none() {
            for upstream in self.upstream_cases(place, case)? {
                for (upstream_place, case) in upstream {
                    self.want(upstream_place, &case)?;
                }
            }
        }
        Ok(slot)
    }

    /// The cases that each arrow of a node reaches.
    fn upstream_cases(&self, place: usize, case: &Case) -> Result<Vec<Vec<(usize, Case)>>> {
        let node = self.pipeline.contents[place];
        node.arrows()
            .into_iter()
            .map(|(kind, upstream)| {
                let up = self
                    .pipeline
                    .place(upstream.name())
                    .filter(|up| *up < place)
                    .ok_or_else(|| {
                        Error::Usage(format!(
                            "{} reads {}, which CONTENTS does not list before it",
                            node.name(),
                            upstream.name()
                        ))
                    })?;
                let mut cases = vec![Case::default()];
                for axis in &self.axes[up] {
                    let values = self.values_for(node, kind, upstream, case, *axis)?;
                    cases = cases
                        .iter()
                        .flat_map(|c| values.iter().map(|value| c.with(*axis, value)))
                        .collect();
                }
                Ok(cases.into_iter().map(|case| (up, case)).collect())
            })
            .collect()
    }

    fn values_for(
        &self,
        node: &dyn Node,
        kind: Kind,
        upstream: &dyn Node,
        case: &Case,
        axis: Axis,
    ) -> Result<Vec<String>> {
        if kind == Kind::Cases && node.gathers().contains(&axis) {
            return Pipeline::values(self.params, upstream, axis);
        }
        let value = case.value(axis).ok_or_else(|| {
            Error::Usage(format!(
                "{} reads {}, but has no axis `{}` to choose by",
                node.name(),
                upstream.name(),
                axis.table
            ))
        })?;
        for select in upstream.selects() {
            if let Select::Rows(selected, path) = select {
                let path = KeyPath::of(path);
                let rows = self.params.get(&path).and_then(toml::Value::as_array);
                let named = |row: &toml::Value| row.get(axis.table).and_then(toml::Value::as_str) == Some(value);
                if *selected == axis && !rows.is_some_and(|rows| rows.iter().any(named)) {
                    let message = format!(
                        "expected a row with {} = \"{value}\", which {} reads, found none",
                        axis.table,
                        node.name()
                    );
                    return Err(self.params.refuse(&path, &message));
                }
            }
        }
        Ok(vec![value.to_owned()])
    }

    /// Counts the pieces of all wanted nodes before any of them is made.
    fn check_size(&self) -> Result<()> {
        // Per key: the pieces that it counts, and their nodes.
        let mut of_keys: BTreeMap<&str, (u64, u64)> = BTreeMap::new();
        for (place, _) in self.wanted.keys() {
            if let Some((key, size)) = self.counted_by(*place) {
                let (pieces, nodes) = of_keys.entry(key).or_default();
                *pieces += self.params.count(key)?.div_ceil(size);
                *nodes += 1;
            }
        }
        let total: u64 = of_keys.values().map(|(pieces, _)| pieces).sum();
        let largest = of_keys.iter().max_by_key(|(_, (pieces, _))| *pieces);
        let Some((key, (pieces, nodes))) = largest.filter(|_| total > MOST_PIECES) else {
            return Ok(());
        };
        // The last piece of each node may be in part.
        let left = MOST_PIECES.saturating_sub(total - pieces + nodes);
        let count = self.params.count(key)?;
        let fits = u128::from(count) * u128::from(left) / u128::from(*pieces);
        let message = format!(
            "expected at most {fits}, since the run would have {total} pieces and its plan holds {MOST_PIECES}, found {count}"
        );
        Err(self.params.refuse(&KeyPath::of(key), &message))
    }

    /// The key that counts the items of a stage, its own or that of the stage it follows piece by piece, and the items of a
    /// piece.
    fn counted_by(&self, place: usize) -> Option<(&'static str, u64)> {
        let node = self.pipeline.contents[place];
        match node.pieces() {
            Pieces::One => None,
            Pieces::Counted(key) => Some((key, 1)),
            Pieces::Batches(key, size) => Some((key, size)),
            Pieces::AsUpstream => {
                let arrows = node.arrows();
                let (_, upstream) = arrows.iter().find(|(kind, _)| *kind == Kind::Each)?;
                self.counted_by(self.pipeline.place(upstream.name()).filter(|up| *up < place)?)
            }
        }
    }

    fn link(self, asked: &[Slot], mut checked: Vec<Checked>) -> Result<Graph> {
        let counts = self.pipeline.counts();
        let seed = self.params.seed()?;
        let index: BTreeMap<&Slot, usize> = self.wanted.keys().enumerate().map(|(i, slot)| (slot, i)).collect();
        let mut nodes: Vec<NodeCase> = Vec::new();
        let mut codes: BTreeMap<usize, [u8; 32]> = BTreeMap::new();
        for ((place, _), case) in &self.wanted {
            let node = self.pipeline.contents[*place];
            let mut links = Vec::new();
            for ((kind, _), cases) in node.arrows().iter().zip(self.upstream_cases(*place, case)?) {
                let upstream = cases.iter().map(|(up, case)| index[&self.slot(*up, case)]).collect();
                links.push(Link { kind: *kind, upstream });
            }
            let pieces = self.pieces(node, &links, &nodes)?;
            let fingerprint = || code::of(node.name()).map_or([0; 32], code::StageCode::fingerprint);
            let is_it = |checked: &Checked| checked.place == *place && checked.case == *case;
            let decoded = match checked.iter().position(is_it) {
                Some(known) => checked.swap_remove(known).decoded,
                None => self.pipeline.decode(self.params, &counts, node, case)?,
            };
            let code = *codes.entry(*place).or_insert_with(fingerprint);
            nodes.push(NodeCase {
                node,
                case: case.clone(),
                pieces,
                links,
                decoded,
                code,
                streams: Streams::new(seed, node.name()),
            });
        }
        let mut targets: Vec<usize> = asked.iter().map(|slot| index[slot]).collect();
        targets.sort_unstable();
        targets.dedup();
        let wanted = nodes.iter().map(|node| vec![false; node.pieces.len()]).collect();
        Ok(Graph {
            wanted,
            nodes,
            seed,
            targets,
            params: self.params.clone(),
            warnings: Vec::new(),
        })
    }

    fn pieces(&self, node: &dyn Node, links: &[Link], nodes: &[NodeCase]) -> Result<Vec<(u64, u64)>> {
        let one = |link: &Link| link.kind == Kind::One && nodes[link.upstream[0]].pieces.len() != 1;
        if links.iter().any(one) {
            return Err(Error::Usage(format!(
                "{} reads `One` of a stage in pieces",
                node.name()
            )));
        }
        Ok(match node.pieces() {
            Pieces::One => vec![(0, 1)],
            Pieces::Counted(key) => (0..self.params.count(key)?).map(|item| (item, 1)).collect(),
            Pieces::Batches(key, size) => {
                let count = self.params.count(key)?;
                (0..count.div_ceil(size))
                    .map(|i| (i * size, size.min(count - i * size)))
                    .collect()
            }
            Pieces::AsUpstream => {
                let each = links.iter().find(|link| link.kind == Kind::Each);
                each.map_or(vec![(0, 1)], |link| nodes[link.upstream[0]].pieces.clone())
            }
        })
    }
}
