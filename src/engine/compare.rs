//! Compare: what a record was made from against what its piece would be made from now.

use std::cell::OnceCell;
use std::collections::BTreeSet;
use std::rc::Rc;

use serde_json::Value;

use crate::engine::arrow::Kind;
use crate::engine::history::History;
use crate::engine::key::KEY_SCHEMA;
use crate::engine::key_path::KeyPath;
use crate::engine::parts::{CodePart, CrateVersion, InputPart, ParamsPart, code_part, inputs_part, params_part};
use crate::engine::reason::Reason;
use crate::engine::record::Record;
use crate::engine::run::Run;
use crate::engine::settings::Values;

/// What differs.
#[derive(Clone, Debug, Default)]
pub(crate) struct Difference {
    /// Changes of the piece's own: code, parameters, seed.
    pub(crate) reasons: BTreeSet<Reason>,
    /// Inputs whose content is known and differs.
    pub(crate) inputs: Vec<InputChange>,
}

/// An input whose content changed.
#[derive(Clone, Debug)]
pub(crate) struct InputChange {
    /// The upstream node's place in the graph.
    pub(crate) node: usize,
    /// The piece that is read, if it is read piece by piece.
    pub(crate) piece: Option<usize>,
    /// The recorded content.
    pub(crate) old: String,
    /// The present content.
    pub(crate) new: String,
    /// The recorded ids of its pieces, if it was read whole and had several.
    pub(crate) pieces: Vec<String>,
}

/// What the pieces of one node have in common now.
pub(crate) struct Present {
    pub(crate) code: String,
    pub(crate) params: String,
    code_part: OnceCell<Rc<CodePart>>,
    params_part: OnceCell<Rc<ParamsPart>>,
}

/// One input of a piece now; its id, if it is known.
pub(crate) struct Input {
    pub(crate) node: usize,
    pub(crate) piece: Option<usize>,
    pub(crate) id: Option<String>,
}

impl Present {
    pub(crate) fn new(run: &Run<'_>, node: usize) -> Self {
        let it = &run.graph.nodes[node];
        Self {
            code: blake3::Hash::from_bytes(it.code).to_hex().to_string(),
            params: blake3::hash(&it.decoded.bytes).to_hex().to_string(),
            code_part: OnceCell::new(),
            params_part: OnceCell::new(),
        }
    }

    fn code_part(&self, run: &Run<'_>, node: usize) -> Rc<CodePart> {
        let make = || Rc::new(code_part(run.graph.nodes[node].node.name()));
        self.code_part.get_or_init(make).clone()
    }

    pub(crate) fn params_part(&self, run: &Run<'_>, node: usize) -> Rc<ParamsPart> {
        let make = || Rc::new(params_part(run, node));
        self.params_part.get_or_init(make).clone()
    }
}

/// The inputs of a piece in the order of its record.
pub(crate) fn inputs(run: &Run<'_>, node: usize, piece: usize) -> Vec<Input> {
    let mut inputs = Vec::new();
    for link in &run.graph.nodes[node].links {
        for up in &link.upstream {
            let each = link.kind == Kind::Each;
            let id = if each { run.id(*up, piece) } else { run.content(*up) };
            inputs.push(Input {
                node: *up,
                piece: each.then_some(piece),
                id: id.map(|id| id.to_string()),
            });
        }
    }
    inputs
}

/// One side of a comparison: a piece as it would be made now.
pub(crate) struct Side<'a> {
    pub(crate) run: &'a Run<'a>,
    pub(crate) history: &'a History<'a>,
    pub(crate) present: &'a Present,
    pub(crate) node: usize,
    pub(crate) piece: usize,
}

impl Side<'_> {
    /// What differs from a record of this piece; counts are told only if the record is of another piece.
    pub(crate) fn against(&self, old: &Record) -> Difference {
        let graph = self.run.graph;
        let mut difference = Difference::default();
        let reasons = &mut difference.reasons;
        if old.keys != KEY_SCHEMA {
            let (old, new) = (old.keys, KEY_SCHEMA);
            reasons.insert(Reason::KeySchema { old, new });
        }
        if old.seed != graph.seed {
            reasons.insert(Reason::Seed {
                old: old.seed,
                new: graph.seed,
                origin: graph.params.origin(&KeyPath::of("run.seed")),
            });
        }
        if old.code != self.present.code {
            let new = self.present.code_part(self.run, self.node);
            let told = self.history.code_of(old).map(|part| code_reasons(&part, &new));
            reasons.extend(told_or(told, "code"));
        }
        if old.params != self.present.params {
            let told = self
                .history
                .params_of(old)
                .map(|part| self.param_reasons(&part, |part| &part.values));
            reasons.extend(told_or(told, "parameters"));
        }
        if (old.first, old.items) != graph.nodes[self.node].pieces[self.piece] {
            reasons.extend(self.shape_against(old));
        }
        self.compare_inputs(old, &mut difference);
        difference
    }

    /// The counts and lists that differ from those at a record's time.
    pub(crate) fn shape_against(&self, old: &Record) -> BTreeSet<Reason> {
        let part = self.history.params_of(old);
        let reasons = part
            .iter()
            .flat_map(|part| self.param_reasons(part, |part| &part.shape));
        reasons.collect()
    }

    fn param_reasons(&self, old: &ParamsPart, of: fn(&ParamsPart) -> &Values) -> Vec<Reason> {
        let new = self.present.params_part(self.run, self.node);
        let (old, new) = (of(old), of(&new));
        let names: BTreeSet<&String> = old.keys().chain(new.keys()).collect();
        let changed = names.into_iter().filter(|name| old.get(*name) != new.get(*name));
        let reason = |name: &String| Reason::Parameter {
            name: name.clone(),
            old: shown(old.get(name)),
            new: shown(new.get(name)),
            origin: self.run.graph.params.origin(&KeyPath::of(name)),
        };
        changed.map(reason).collect()
    }

    fn compare_inputs(&self, old: &Record, difference: &mut Difference) {
        let new = inputs(self.run, self.node, self.piece);
        let name = |input: &Input| self.run.graph.nodes[input.node].name();
        let part = self
            .history
            .inputs_of(old)
            .filter(|part| part.inputs.len() == old.inputs.len());
        let mut rest: Vec<(InputPart, &String)> = match &part {
            Some(part) => part.inputs.iter().cloned().zip(&old.inputs).collect(),
            None if new.len() == old.inputs.len() => {
                let names = inputs_part(self.run, self.node).inputs.into_iter();
                let unread = |part: InputPart| InputPart {
                    pieces: Vec::new(),
                    ..part
                };
                names.map(unread).zip(&old.inputs).collect()
            }
            None => {
                difference.reasons.extend(told_or(None, "inputs"));
                return;
            }
        };
        let mut added = Vec::new();
        for input in &new {
            let Some(place) = rest.iter().position(|(part, _)| part.node == name(input)) else {
                added.push(name(input));
                continue;
            };
            let (part, id) = rest.remove(place);
            if let Some(found) = input.id.as_ref().filter(|found| *found != id) {
                difference.inputs.push(InputChange {
                    node: input.node,
                    piece: input.piece,
                    old: id.clone(),
                    new: found.clone(),
                    pieces: part.pieces,
                });
            }
        }
        let gone: Vec<String> = rest.into_iter().map(|(part, _)| part.node).collect();
        if !added.is_empty() || !gone.is_empty() {
            let mut lists = self.shape_against(old);
            lists.retain(is_list);
            if lists.is_empty() {
                lists.insert(Reason::Inputs { gone, added });
            }
            difference.reasons.extend(lists);
        }
    }
}

/// A list of cases is in `[run]`; a count is elsewhere.
fn is_list(reason: &Reason) -> bool {
    matches!(reason, Reason::Parameter { name, .. } if name.starts_with("run."))
}

/// What is told, or that nothing can be.
fn told_or(told: Option<Vec<Reason>>, what: &str) -> Vec<Reason> {
    let unrecorded = || vec![Reason::Unrecorded { what: what.to_owned() }];
    told.filter(|told| !told.is_empty()).unwrap_or_else(unrecorded)
}

/// A value as the reader would write it.
pub(crate) fn shown(value: Option<&Value>) -> String {
    match value {
        None | Some(Value::Null) => "none".to_owned(),
        Some(Value::Array(list)) => {
            let texts: Vec<String> = list.iter().map(|value| shown(Some(value))).collect();
            format!("[{}]", texts.join(", "))
        }
        Some(value) => value.to_string(),
    }
}

fn code_reasons(old: &CodePart, new: &CodePart) -> Vec<Reason> {
    let mut reasons = Vec::new();
    let paths: BTreeSet<&String> = old.files.keys().chain(new.files.keys()).collect();
    for path in paths {
        let (old, new) = (old.files.get(path), new.files.get(path));
        if old != new {
            reasons.push(Reason::File {
                path: path.clone(),
                old: old.cloned(),
                new: new.cloned(),
            });
        }
    }
    let names: BTreeSet<&String> = old.crates.keys().chain(new.crates.keys()).collect();
    for name in names {
        let (old, new) = (old.crates.get(name), new.crates.get(name));
        if old != new {
            let told = versions(old, new);
            reasons.push(Reason::Crate {
                name: name.clone(),
                old: told.0,
                new: told.1,
            });
        }
    }
    reasons
}

/// What differs between the locked crates of one name: versions, else what Cargo.toml declares, else the checksums.
fn versions(old: Option<&Vec<CrateVersion>>, new: Option<&Vec<CrateVersion>>) -> (String, String) {
    let told = |of: fn(&CrateVersion) -> String| {
        let list = |versions: Option<&Vec<CrateVersion>>| {
            let texts: Vec<String> = versions.into_iter().flatten().map(of).collect();
            if texts.is_empty() {
                "none".to_owned()
            } else {
                texts.join(", ")
            }
        };
        (list(old), list(new))
    };
    let differ = |pair: &(String, String)| pair.0 != pair.1;
    let version = told(|it| it.version.clone());
    let declared = told(|it| format!("{} ({})", it.version, it.declared));
    let checksum = told(|it| format!("{} (checksum {}..)", it.version, it.checksum.get(..8).unwrap_or("")));
    [version, declared].into_iter().find(differ).unwrap_or(checksum)
}
