//! Parts: what records name instead of holding it: `parts/<hash>.json`, each stored once.
//!
//! A part explains; it is no truth. A damaged or missing one makes `why` say less and nothing else, so parts are written
//! by a rename but not synchronised, and written again when found damaged. Named by the BLAKE3 of the bytes before the
//! check, which is their last field, as in records.

use std::collections::BTreeMap;

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

use crate::engine::arrow::Kind;
use crate::engine::code;
use crate::engine::error::Result;
use crate::engine::id::Id;
use crate::engine::names::Place;
use crate::engine::record::{opened, sealed};
use crate::engine::run::Run;
use crate::engine::settings::{Values, shape, values};
use crate::engine::store::Store;

/// The parts of one record, hexadecimal.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct PartNames {
    /// What its code fingerprint is of: files and crates.
    pub code: String,
    /// What its encoded parameters are of: names and values.
    pub params: String,
    /// What its input ids are of: nodes and their pieces.
    pub inputs: String,
}

/// What a code fingerprint is of.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct CodePart {
    /// Path -> hash of the tokens.
    pub(crate) files: BTreeMap<String, String>,
    /// Name -> what Cargo.lock and Cargo.toml say of each version, in order.
    pub(crate) crates: BTreeMap<String, Vec<CrateVersion>>,
}

/// One version of an outside crate.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct CrateVersion {
    pub(crate) version: String,
    pub(crate) checksum: String,
    pub(crate) declared: String,
}

/// What encoded parameters are of.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct ParamsPart {
    /// In the key: dotted path -> value.
    pub(crate) values: Values,
    /// In no key: counts and lists of cases.
    pub(crate) shape: Values,
}

/// What the input ids of a record are of, in the same order.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct InputsPart {
    pub(crate) inputs: Vec<InputPart>,
}

/// One input.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct InputPart {
    /// `STAGE/CASE`.
    pub(crate) node: String,
    /// The ids of its pieces, if it has several and they are read together.
    pub(crate) pieces: Vec<String>,
}

/// The code of a stage in this binary.
pub(crate) fn code_part(stage: &str) -> CodePart {
    let Some(code) = code::of(stage) else {
        return CodePart::default();
    };
    let mut part = CodePart::default();
    for file in code.files {
        part.files.insert(file.path.to_owned(), file.tokens.to_owned());
    }
    for it in code.crates {
        let version = CrateVersion {
            version: it.version.to_owned(),
            checksum: it.checksum.to_owned(),
            declared: it.declared.to_owned(),
        };
        part.crates.entry(it.name.to_owned()).or_default().push(version);
    }
    part
}

/// The parameters of a node.
pub(crate) fn params_part(run: &Run<'_>, node: usize) -> ParamsPart {
    ParamsPart {
        values: values(run.graph, node),
        shape: shape(run.graph, node),
    }
}

/// The inputs of a node, in the order of its arrows; ids of pieces as far as they are known.
pub(crate) fn inputs_part(run: &Run<'_>, node: usize) -> InputsPart {
    let mut inputs = Vec::new();
    for link in &run.graph.nodes[node].links {
        for up in &link.upstream {
            let it = &run.graph.nodes[*up];
            let count = it.pieces.len();
            let together = link.kind != Kind::Each && count > 1;
            let ids: Option<Vec<String>> = (0..if together { count } else { 0 })
                .map(|piece| Some(run.id(*up, piece)?.to_string()))
                .collect();
            inputs.push(InputPart {
                node: it.name(),
                pieces: ids.unwrap_or_default(),
            });
        }
    }
    InputsPart { inputs }
}

/// Puts the parts of a node whose inputs are known into the store.
///
/// # Errors
/// A write that fails.
pub(crate) fn keep(run: &Run<'_>, node: usize) -> Result<PartNames> {
    Ok(PartNames {
        code: put(run.store, &code_part(run.graph.nodes[node].node.name()))?,
        params: put(run.store, &params_part(run, node))?,
        inputs: put(run.store, &inputs_part(run, node))?,
    })
}

/// Writes a part that is not there undamaged; gives its name.
pub(crate) fn put<T: Serialize>(store: &Store, part: &T) -> Result<String> {
    let json = serde_json::to_string(part).expect("a part holds strings and finite numbers");
    let (name, text) = sealed(&json);
    let place = Place::Part(Id::parse(&name).expect("a check is a hash"));
    if store.read_file(&place).is_ok_and(|there| there == text.as_bytes()) {
        return Ok(name);
    }
    store.write(&place, text.as_bytes(), false)?;
    Ok(name)
}

/// Reads a part; a damaged one is none.
pub(crate) fn get<T: DeserializeOwned>(store: &Store, name: &str) -> Option<T> {
    // A name comes from a record: it is a hash, or it is no name.
    let place = Place::Part(Id::parse(name)?);
    let (check, json) = opened(&store.read_text(&place).ok()?)?;
    if check != name {
        return None;
    }
    serde_json::from_str(&json).ok()
}
