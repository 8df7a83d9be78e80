//! The bytes of an artifact: bincode 2, little endian, fixed-width integers. Nothing else knows bincode.
//!
//! Part of every code fingerprint: a change here may change the bytes of every artifact.

use serde::Serialize;
use serde::de::DeserializeOwned;

use crate::engine::error::{Error, Result};

/// The codec's number in every object's header.
pub const CODEC: u16 = 1;

/// No artifact is larger than this, in bytes; a larger length in a file is a lie.
pub const LIMIT: usize = 1 << 30;

fn configuration() -> impl bincode::config::Config {
    bincode::config::standard()
        .with_little_endian()
        .with_fixed_int_encoding()
        .with_limit::<LIMIT>()
}

/// Encodes a value.
///
/// # Errors
/// A value that serde cannot describe, or one longer than [`LIMIT`].
pub fn encode<T: Serialize>(value: &T) -> Result<Vec<u8>> {
    let bytes = bincode::serde::encode_to_vec(value, configuration()).map_err(|why| Error::Damaged {
        what: "a value to encode".into(),
        why: why.to_string(),
    })?;
    if bytes.len() > LIMIT {
        let why = format!("{} bytes, more than the limit of {LIMIT}", bytes.len());
        return Err(Error::Damaged {
            what: "a value to encode".into(),
            why,
        });
    }
    Ok(bytes)
}

/// Decodes a value that fills the bytes exactly.
///
/// # Errors
/// Bytes of another type, too few or too many, or a length beyond [`LIMIT`].
pub fn decode<T: DeserializeOwned>(bytes: &[u8]) -> Result<T> {
    let damaged = |why: String| Error::Damaged {
        what: "an encoded value".into(),
        why,
    };
    let (value, read) =
        bincode::serde::decode_from_slice(bytes, configuration()).map_err(|why| damaged(why.to_string()))?;
    if read != bytes.len() {
        return Err(damaged(format!("{read} of {} bytes decoded", bytes.len())));
    }
    Ok(value)
}
