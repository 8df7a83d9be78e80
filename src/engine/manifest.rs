//! Manifest: the ordered ids of the pieces that a content consists of, in `manifests/ab/cdef..`, named by their hash. A
//! damaged one is none.

use std::io;

use crate::engine::id::Id;
use crate::engine::names::Place;
use crate::engine::store::Store;

/// The ids in the bytes of a manifest of this name.
pub(crate) fn parse(content: &Id, bytes: &[u8]) -> Option<Vec<Id>> {
    let (ids, rest) = bytes.as_chunks::<32>();
    let ids: Vec<Id> = ids.iter().map(|id| Id(*id)).collect();
    (rest.is_empty() && Id::of_manifest(&ids) == *content).then_some(ids)
}

/// The ids that a content in pieces consists of, where a store knows them.
pub(crate) fn pieces(store: &Store, content: &Id) -> Option<Vec<Id>> {
    read(store, content).ok()
}

/// The same, or why they are not known.
///
/// # Errors
/// The operating system's; `InvalidData` for a manifest whose ids do not hash to its name.
pub(crate) fn read(store: &Store, content: &Id) -> io::Result<Vec<Id>> {
    let bytes = store.read_file(&Place::Manifest(*content))?;
    let damaged = || io::Error::new(io::ErrorKind::InvalidData, "its ids do not hash to the name");
    parse(content, &bytes).ok_or_else(damaged)
}
