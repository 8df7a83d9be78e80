//! Whatever bytes the store may hold are decoded or refused: artifacts of every stage, object files, locks. A panic, an
//! abort, or memory beyond what libFuzzer is told to allow is a finding.

#![no_main]

use encounter::engine::id::Id;
use encounter::engine::lock::Lock;
use encounter::engine::object::{self, HEADER};
use encounter::stages::PIPELINE;
use libfuzzer_sys::fuzz_target;

/// An object file whose id is that of its payload, so that what its header says is all that is checked.
fn with_its_own_hash(bytes: &[u8]) -> Option<(Id, Vec<u8>)> {
    let (head, payload) = bytes.split_first_chunk::<HEADER>()?;
    let codec = u16::from_le_bytes([head[8], head[9]]);
    let schema = head[16..24].iter().rev().fold(0, |all, byte| (all << 8) | u64::from(*byte));
    let id = Id::of(codec, schema, payload);
    let mut file = bytes.to_vec();
    file[32..HEADER].copy_from_slice(&id.0);
    Some((id, file))
}

fuzz_target!(|bytes: &[u8]| {
    for node in PIPELINE.contents {
        if node.decode(bytes).is_ok() {
            let _ = node.json(bytes);
            let _ = node.published(bytes);
            let same = node.difference(bytes, bytes).expect("what was decoded can be compared");
            assert!(same.is_none(), "{}: a value differs from itself", node.name());
        }
    }
    if let Some((id, file)) = with_its_own_hash(bytes)
        && object::verify(&id, None, &file).is_ok()
    {
        assert_eq!(object::payload(file).len() + HEADER, bytes.len());
    }
    if let Ok(text) = std::str::from_utf8(bytes)
        && let Ok(lock) = Lock::parse(text)
    {
        assert_eq!(Lock::parse(&lock.text()).expect("our own text"), lock);
    }
});
