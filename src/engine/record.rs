//! Record: key -> id, and how it was made. Its last field is the BLAKE3 of the bytes before it.
//!
//! What later runs compare (files and crates, parameters, names of inputs) would be the same in thousands of records, so
//! it lies in `parts/`, and a record names it. A record from before that names none: still a hit, only less to tell.

use std::time::{SystemTime, UNIX_EPOCH};

use serde::{Deserialize, Serialize};

use crate::engine::code;
use crate::engine::compare::inputs;
use crate::engine::id::{Id, Key};
use crate::engine::key::KEY_SCHEMA;
use crate::engine::parts::PartNames;
use crate::engine::run::Run;
use crate::engine::stage::Keep;

/// What the store remembers of one piece.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Record {
    /// The layout of this record.
    pub format: u32,
    /// The node, `STAGE/CASE`.
    pub node: String,
    /// The first item of the piece.
    pub first: u64,
    /// The number of items.
    pub items: u64,
    /// The key, hexadecimal.
    pub key: String,
    /// The id of the output, hexadecimal.
    pub id: String,
    /// The length of the output, bytes.
    pub bytes: u64,
    /// What it took to make, seconds.
    pub seconds: f64,
    /// Whether the bytes were left out of the store on purpose.
    pub evicted: bool,
    /// The code fingerprint, hexadecimal.
    pub code: String,
    /// The BLAKE3 of the encoded parameters.
    pub params: String,
    /// The root seed.
    pub seed: u64,
    /// The content ids of the inputs, arrow by arrow.
    pub inputs: Vec<String>,
    /// The compiler.
    pub rustc: String,
    /// Architecture and system.
    pub target: String,
    /// The layout of the key's preimage.
    #[serde(default = "first_key_schema")]
    pub keys: u32,
    /// When it was made, ms since 1970; tells only which of two records is the later one.
    #[serde(default)]
    pub made: u64,
    /// The parts that say what the hashes above are of; none in a record from before there were parts.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub parts: Option<PartNames>,
}

/// Architecture and system of this process.
pub(crate) fn system() -> String {
    format!("{}-{}", std::env::consts::ARCH, std::env::consts::OS)
}

const CHECK: &str = ",\"check\":\"";

/// Records that do not say so are of the first layout.
fn first_key_schema() -> u32 {
    1
}

impl Record {
    /// The record of a piece, `(node, piece)`, that was just made: `(id, bytes)` in so many seconds.
    pub(crate) fn of(
        run: &Run<'_>,
        (node, piece): (usize, usize),
        key: Key,
        (id, bytes): (Id, u64),
        seconds: f64,
    ) -> Self {
        let it = &run.graph.nodes[node];
        let (first, items) = it.pieces[piece];
        let made = SystemTime::now().duration_since(UNIX_EPOCH);
        Self {
            format: 1,
            node: it.name(),
            first,
            items,
            key: key.to_string(),
            id: id.to_string(),
            bytes,
            seconds,
            evicted: it.node.keep() == Keep::Evict,
            code: blake3::Hash::from_bytes(it.code).to_hex().to_string(),
            params: blake3::hash(&it.decoded.bytes).to_hex().to_string(),
            seed: run.graph.seed,
            inputs: inputs(run, node, piece)
                .into_iter()
                .filter_map(|input| input.id)
                .collect(),
            rustc: code::RUSTC.to_owned(),
            target: system(),
            keys: KEY_SCHEMA,
            made: made.map_or(0, |since| since.as_millis() as u64),
            parts: None,
        }
    }

    /// The record's text, check included.
    pub(crate) fn text(&self) -> String {
        let json = serde_json::to_string(self).expect("a record holds only strings and finite numbers");
        sealed(&json).1
    }

    /// Reads a record; a damaged one is none.
    pub(crate) fn parse(text: &str) -> Option<Self> {
        serde_json::from_str(&opened(text)?.1).ok()
    }
}

/// A JSON object with the check as its last field, and the check.
pub(crate) fn sealed(json: &str) -> (String, String) {
    let body = &json[..json.len() - 1];
    let check = blake3::hash(body.as_bytes()).to_hex().to_string();
    let text = format!("{body}{CHECK}{check}\"}}\n");
    (check, text)
}

/// The check of such a text and the object without it; none if it is damaged.
pub(crate) fn opened(text: &str) -> Option<(String, String)> {
    let (body, check) = text.rsplit_once(CHECK)?;
    let check = check.strip_suffix("\"}\n")?;
    let holds = blake3::hash(body.as_bytes()).to_hex().as_str() == check;
    holds.then(|| (check.to_owned(), format!("{body}}}")))
}
