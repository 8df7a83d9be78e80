//! Manifest: the ordered ids of the pieces that a content consists of, in `manifests/ab/cdef..`, named by their hash. A
//! damaged one is none.

use std::path::Path;

use crate::engine::disk::read_regular;
use crate::engine::id::Id;
use crate::engine::store::path_in;

/// The ids in the bytes of a manifest of this name.
pub(crate) fn parse(content: &Id, bytes: &[u8]) -> Option<Vec<Id>> {
    let (ids, rest) = bytes.as_chunks::<32>();
    let ids: Vec<Id> = ids.iter().map(|id| Id(*id)).collect();
    (rest.is_empty() && Id::of_manifest(&ids) == *content).then_some(ids)
}

/// The ids that a content in pieces consists of, where a store knows them.
pub(crate) fn pieces(store: &Path, content: &Id) -> Option<Vec<Id>> {
    let hex = content.to_string();
    let path = path_in(store, "manifests", &hex, "");
    parse(content, &read_regular(&path).ok()?)
}
