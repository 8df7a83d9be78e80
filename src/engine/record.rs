//! Record: key -> id, and how it was made. Its last field is the BLAKE3 of the bytes before it.

use serde::{Deserialize, Serialize};

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
}

/// Architecture and system of this process.
pub(crate) fn system() -> String {
    format!("{}-{}", std::env::consts::ARCH, std::env::consts::OS)
}

const CHECK: &str = ",\"check\":\"";

impl Record {
    /// The record's text, check included.
    pub(crate) fn text(&self) -> String {
        let json = serde_json::to_string(self).expect("a record holds only strings and finite numbers");
        let body = &json[..json.len() - 1];
        format!("{body}{CHECK}{}\"}}\n", blake3::hash(body.as_bytes()).to_hex())
    }

    /// Reads a record; a damaged one is none.
    pub(crate) fn parse(text: &str) -> Option<Self> {
        let (body, check) = text.rsplit_once(CHECK)?;
        let check = check.strip_suffix("\"}\n")?;
        if blake3::hash(body.as_bytes()).to_hex().as_str() != check {
            return None;
        }
        serde_json::from_str(&format!("{body}}}")).ok()
    }
}
