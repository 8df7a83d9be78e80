//! Names made of hashes: an [`Id`] names bytes, a [`Key`] names what they were made from.

use std::fmt;

/// The hash of an artifact's codec, schema and bytes.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Id(pub [u8; 32]);

/// The hash of everything that a piece depends on.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Key(pub [u8; 32]);

impl Id {
    /// The id of an artifact's bytes.
    pub fn of(codec: u16, schema: u64, payload: &[u8]) -> Self {
        let mut hasher = Self::hasher(codec, schema);
        hasher.update(payload);
        Self(*hasher.finalize().as_bytes())
    }

    /// What hashes an artifact's bytes into its id.
    pub(crate) fn hasher(codec: u16, schema: u64) -> blake3::Hasher {
        let mut hasher = blake3::Hasher::new();
        hasher.update(&codec.to_le_bytes());
        hasher.update(&schema.to_le_bytes());
        hasher
    }

    /// The content of a node in pieces: the ordered ids of the pieces.
    pub fn of_manifest(pieces: &[Self]) -> Self {
        let mut hasher = blake3::Hasher::new_derive_key("encounter 1 manifest");
        for piece in pieces {
            hasher.update(&piece.0);
        }
        Self(*hasher.finalize().as_bytes())
    }

    /// Reads 64 hexadecimal digits.
    pub fn parse(text: &str) -> Option<Self> {
        parse_hex(text).map(Self)
    }
}

impl Key {
    /// Reads 64 hexadecimal digits.
    pub fn parse(text: &str) -> Option<Self> {
        parse_hex(text).map(Self)
    }
}

/// The number of an artifact type's layout, from its name.
pub fn schema_number(schema: &str) -> u64 {
    let hash = blake3::hash(schema.as_bytes());
    let mut first = [0; 8];
    first.copy_from_slice(&hash.as_bytes()[..8]);
    u64::from_le_bytes(first)
}

fn parse_hex(text: &str) -> Option<[u8; 32]> {
    blake3::Hash::from_hex(text).ok().map(|hash| *hash.as_bytes())
}

fn write_hex(bytes: &[u8; 32], f: &mut fmt::Formatter<'_>) -> fmt::Result {
    f.write_str(&blake3::Hash::from_bytes(*bytes).to_hex())
}

impl fmt::Display for Id {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write_hex(&self.0, f)
    }
}

impl fmt::Debug for Id {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write_hex(&self.0, f)
    }
}

impl fmt::Display for Key {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write_hex(&self.0, f)
    }
}

impl fmt::Debug for Key {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write_hex(&self.0, f)
    }
}
