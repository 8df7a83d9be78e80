//! Twice: a key made twice with two ids. The stage depends on something that its key does not hold; never papered over.
//!
//! Both outputs are kept in `quarantine/`. They are compared value by value; where the recorded one is gone, the piece is
//! made once more, which tells a stage that differs each time from one that something else has changed.

use crate::engine::code;
use crate::engine::error::Error;
use crate::engine::id::{Id, schema_number};
use crate::engine::names::Place;
use crate::engine::object;
use crate::engine::record::{Record, system};
use crate::engine::run::Run;
use crate::engine::store::{Found, Store};

/// The error of a piece that came out otherwise than its record says.
pub(crate) fn error(run: &Run<'_>, node: usize, piece: usize, recorded: &str, bytes: &[u8]) -> Error {
    let it = &run.graph.nodes[node];
    let schema = schema_number(it.node.schema());
    let made = keep(run.store, schema, bytes);
    let id = Id::parse(recorded);
    let earlier = id.and_then(|id| match run.store.read(&id, Some(schema)) {
        Found::Bytes(bytes) => Some(bytes),
        Found::Missing | Found::Damaged(_) => None,
    });
    let (difference, note) = if let Some(earlier) = &earlier {
        keep(run.store, schema, earlier);
        let note = "both outputs are kept in quarantine/".to_owned();
        (it.node.difference(earlier, bytes).ok().flatten(), note)
    } else {
        let again = run.compute(node, piece).ok().filter(|again| again != bytes);
        let difference = again.and_then(|again| it.node.difference(bytes, &again).ok().flatten());
        let note = without_the_recorded(run, node, piece, difference.is_some());
        (difference, note)
    };
    Error::NotReproducible {
        node: it.piece_name(piece),
        recorded: recorded.to_owned(),
        made: made.to_string(),
        difference: difference.map(Box::new),
        note,
    }
}

fn without_the_recorded(run: &Run<'_>, node: usize, piece: usize, differs_from_itself: bool) -> String {
    let record = run.key(node, piece).map(|key| run.store.path(&Place::Record(key)));
    let record = record.map_or(String::new(), |path| {
        format!(
            "; in a store from elsewhere the record may be false: without {} it is made anew",
            path.display()
        )
    });
    let kept = format!("the new output is kept in quarantine/, the recorded one is gone{record}");
    if differs_from_itself {
        return format!("made twice just now, it differs from itself; {kept}");
    }
    let record = run.key(node, piece).and_then(|key| run.store.record(&key));
    let since = record.map_or(String::new(), |record| elsewhere(&record, " with "));
    format!("made once more, it came out the same: what is in no key has changed since it was recorded{since}; {kept}")
}

/// `rustc 1.94.0 on x86_64-linux, now rustc 1.95.0 on x86_64-linux`, where a record was made with other tools than these.
pub(crate) fn elsewhere(record: &Record, before: &str) -> String {
    let (then, now) = (
        (record.rustc.as_str(), record.target.as_str()),
        (code::RUSTC, &*system()),
    );
    if then == now {
        return String::new();
    }
    format!("{before}{} on {}, now {} on {}", then.0, then.1, now.0, now.1)
}

/// Keeps an output in `quarantine/`; gives its id.
pub(crate) fn keep(store: &Store, schema: u64, bytes: &[u8]) -> Id {
    let (id, file) = object::seal(schema, bytes);
    // The error to report is the one that brought us here.
    let _ = store.write(&Place::Quarantined(id.to_string(), None), &file, false);
    id
}
