//! Memo: recently used artifacts in memory, at most a fixed number of bytes; the oldest use leaves first.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use crate::engine::id::Id;
use crate::engine::node::Value;

/// Artifacts by id, encoded and decoded.
pub(crate) struct Memo {
    limit: usize,
    state: Mutex<State>,
}

#[derive(Default)]
struct State {
    entries: BTreeMap<Id, Entry>,
    held: usize,
    clock: u64,
}

struct Entry {
    bytes: Option<Arc<[u8]>>,
    value: Option<Value>,
    size: usize,
    used: u64,
}

impl Memo {
    pub(crate) fn new(limit: usize) -> Self {
        Self {
            limit,
            state: Mutex::default(),
        }
    }

    pub(crate) fn value(&self, id: &Id) -> Option<Value> {
        self.state().touch(id)?.value.clone()
    }

    pub(crate) fn bytes(&self, id: &Id) -> Option<Arc<[u8]>> {
        self.state().touch(id)?.bytes.clone()
    }

    /// Keeps the encoded form.
    pub(crate) fn put_bytes(&self, id: Id, bytes: Arc<[u8]>) {
        let size = bytes.len();
        self.state().put(
            id,
            Entry {
                bytes: Some(bytes),
                value: None,
                size,
                used: 0,
            },
            self.limit,
        );
    }

    /// Keeps the decoded form in place of the encoded one; `size` is the encoded length.
    pub(crate) fn put_value(&self, id: Id, value: Value, size: usize) {
        self.state().put(
            id,
            Entry {
                bytes: None,
                value: Some(value),
                size,
                used: 0,
            },
            self.limit,
        );
    }

    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl State {
    fn touch(&mut self, id: &Id) -> Option<&Entry> {
        self.clock += 1;
        let entry = self.entries.get_mut(id)?;
        entry.used = self.clock;
        Some(entry)
    }

    fn put(&mut self, id: Id, mut entry: Entry, limit: usize) {
        self.clock += 1;
        entry.used = self.clock;
        self.held += entry.size;
        if let Some(old) = self.entries.insert(id, entry) {
            self.held -= old.size;
        }
        while self.held > limit && self.entries.len() > 1 {
            let oldest = self
                .entries
                .iter()
                .min_by_key(|(_, entry)| entry.used)
                .map(|(id, _)| *id);
            let Some(gone) = oldest.and_then(|id| self.entries.remove(&id)) else {
                return;
            };
            self.held -= gone.size;
        }
    }
}
