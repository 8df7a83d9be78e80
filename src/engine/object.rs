//! An object file: a header of 64 bytes and the payload. Reading is verifying.
//!
//! Header, little endian: magic `ENCOUNT1` (8) | codec u16 | zero u16, u32 | schema u64 | length u64 | BLAKE3 (32).

use crate::engine::codec::{CODEC, LIMIT};
use crate::engine::id::Id;

const MAGIC: &[u8; 8] = b"ENCOUNT1";
/// Bytes of the header.
pub const HEADER: usize = 64;

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

/// What a header says, checked as far as it can be alone.
struct Header {
    codec: u16,
    schema: u64,
}

/// Verifies an object file in memory.
///
/// # Errors
/// What is wrong with the bytes.
pub fn verify(id: &Id, schema: Option<u64>, file: &[u8]) -> Result<(), String> {
    let Some((head, payload)) = file.split_first_chunk::<HEADER>() else {
        return Err(too_short(file.len()));
    };
    let header = header(id, schema, head, payload.len() as u64)?;
    if Id::of(header.codec, header.schema, payload) != *id {
        return Err(NOT_ITS_NAME.to_owned());
    }
    Ok(())
}

/// The payload of a verified object file, in the memory of the file.
pub fn payload(mut file: Vec<u8>) -> Vec<u8> {
    file.drain(..HEADER);
    file
}

const NOT_ITS_NAME: &str = "the bytes do not hash to the name";

fn too_short(length: usize) -> String {
    format!("{length} bytes, too short for a header")
}

fn another_length(found: u64, expected: u64) -> String {
    format!("{found} bytes of payload, the header says {expected}")
}

fn number(header: &[u8; HEADER], from: usize) -> u64 {
    let mut bytes = [0; 8];
    bytes.copy_from_slice(&header[from..from + 8]);
    u64::from_le_bytes(bytes)
}

fn header(id: &Id, schema: Option<u64>, header: &[u8; HEADER], length: u64) -> Result<Header, String> {
    if &header[..8] != MAGIC {
        return Err("no object: the magic bytes are wrong".to_owned());
    }
    let codec = u16::from_le_bytes([header[8], header[9]]);
    // Whoever asks for no layout wants to know whether the bytes are whole, not whether this program can read them.
    if (schema.is_some() && codec != CODEC) || header[10..16] != [0; 6] {
        return Err(format!("unknown codec {codec}"));
    }
    let found_schema = number(header, 16);
    if schema.is_some_and(|expected| expected != found_schema) {
        return Err("an artifact of another type".to_owned());
    }
    if number(header, 24) != length || length > LIMIT as u64 {
        return Err(another_length(length, number(header, 24)));
    }
    if header[32..] != id.0 {
        return Err(NOT_ITS_NAME.to_owned());
    }
    Ok(Header {
        codec,
        schema: found_schema,
    })
}
