//! The key of a piece: a plain struct that is hashed field by field, every field with its length.

use crate::engine::id::{Id, Key};

/// The layout of a key's preimage; a release changes it only by saying so.
pub const KEY_SCHEMA: u32 = 1;

/// Everything that a piece depends on.
pub(crate) struct Preimage<'a> {
    pub(crate) stage: &'a str,
    pub(crate) first: u64,
    pub(crate) items: u64,
    pub(crate) seed: u64,
    pub(crate) code: [u8; 32],
    pub(crate) params: &'a [u8],
    pub(crate) inputs: Vec<InputKey>,
}

/// What a piece depends on through one arrow.
pub(crate) enum InputKey {
    /// The content of one upstream piece or node.
    Content(Id),
    /// The name and content of each case.
    Cases(Vec<(String, Id)>),
}

impl Preimage<'_> {
    /// The key of a piece.
    pub(crate) fn key(&self) -> Key {
        self.hash("encounter 1 key")
    }

    /// The key of a whole node, whose inputs are whole nodes: what the lock calls its recipe.
    pub(crate) fn recipe(&self) -> Key {
        self.hash("encounter 1 recipe")
    }

    fn hash(&self, context: &str) -> Key {
        let mut hasher = blake3::Hasher::new_derive_key(context);
        let mut field = |bytes: &[u8]| {
            hasher.update(&(bytes.len() as u64).to_le_bytes());
            hasher.update(bytes);
        };
        field(&KEY_SCHEMA.to_le_bytes());
        field(self.stage.as_bytes());
        field(&self.first.to_le_bytes());
        field(&self.items.to_le_bytes());
        field(&self.seed.to_le_bytes());
        field(&self.code);
        field(self.params);
        field(&(self.inputs.len() as u64).to_le_bytes());
        for input in &self.inputs {
            match input {
                InputKey::Content(id) => field(&id.0),
                InputKey::Cases(cases) => {
                    field(&(cases.len() as u64).to_le_bytes());
                    for (name, id) in cases {
                        field(name.as_bytes());
                        field(&id.0);
                    }
                }
            }
        }
        Key(*hasher.finalize().as_bytes())
    }
}
