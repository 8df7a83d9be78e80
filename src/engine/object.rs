//! An object file: a header of 64 bytes and the payload. Reading is verifying.
//!
//! Header, little endian: magic `ENCOUNT1` (8) | codec u16 | zero u16, u32 | schema u64 | length u64 | BLAKE3 (32).

use crate::engine::codec::{CODEC, LIMIT};
use crate::engine::id::Id;

const MAGIC: &[u8; 8] = b"ENCOUNT1";
const HEADER: usize = 64;

/// The bytes of an object file.
pub(crate) fn seal(schema: u64, payload: &[u8]) -> (Id, Vec<u8>) {
    let id = Id::of(CODEC, schema, payload);
    let mut file = Vec::with_capacity(HEADER + payload.len());
    file.extend_from_slice(MAGIC);
    file.extend_from_slice(&CODEC.to_le_bytes());
    file.extend_from_slice(&[0; 6]);
    file.extend_from_slice(&schema.to_le_bytes());
    file.extend_from_slice(&(payload.len() as u64).to_le_bytes());
    file.extend_from_slice(&id.0);
    file.extend_from_slice(payload);
    (id, file)
}

/// The payload of an object file that is what its name says.
///
/// # Errors
/// What is wrong with the bytes.
pub(crate) fn open(id: &Id, schema: Option<u64>, file: &[u8]) -> Result<Vec<u8>, String> {
    if file.len() < HEADER {
        return Err(format!("{} bytes, too short for a header", file.len()));
    }
    let (header, payload) = file.split_at(HEADER);
    if &header[..8] != MAGIC {
        return Err("no object: the magic bytes are wrong".to_owned());
    }
    let codec = u16::from_le_bytes([header[8], header[9]]);
    if codec != CODEC || header[10..16] != [0; 6] {
        return Err(format!("unknown codec {codec}"));
    }
    let number = |from: usize| {
        let mut bytes = [0; 8];
        bytes.copy_from_slice(&header[from..from + 8]);
        u64::from_le_bytes(bytes)
    };
    let found_schema = number(16);
    if schema.is_some_and(|expected| expected != found_schema) {
        return Err("an artifact of another type".to_owned());
    }
    if number(24) != payload.len() as u64 || payload.len() > LIMIT {
        return Err(format!(
            "{} bytes of payload, the header says {}",
            payload.len(),
            number(24)
        ));
    }
    if header[32..] != id.0 || Id::of(codec, found_schema, payload) != *id {
        return Err("the bytes do not hash to the name".to_owned());
    }
    Ok(payload.to_vec())
}
