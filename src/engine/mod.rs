//! THE CACHE: knows no wave and no ship.
//!
//! A piece of work runs when, and only when, something it depends on has changed. What it depends on is hashed into a
//! [`key`]; a [`record`] says which output that key gave; the output is an
//! object named by the hash of its own bytes, verified each time it is read.
//!
//! | in the key | as |
//! |---|---|
//! | key schema | u32, changed only by saying so |
//! | stage name, first item and number of items of the piece | with the root seed they name all random streams |
//! | root seed | u64 |
//! | code | tokens of the stage's files and of those they use, versions of the crates they name |
//! | parameters | the tables the stage decodes, encoded again: 1.0 = 1.00, order and comments do not count |
//! | inputs | content ids, arrow by arrow; case names where several cases meet |
//!
//! | not in the key | because |
//! |---|---|
//! | case name, counts, other pieces | cases share what is equal; 100 -> 200 realisations runs 100 |
//! | times, paths, host, environment, threads | they must not change bits; `verify --rebuild` varies threads |
//! | compiler, CPU level | same bits; recorded |
//!
//! Inputs enter by content, so an upstream rerun that gives equal bytes changes no key below it, and an edit taken back
//! finds its old records.
//!
//! On disk: `objects/` (header and payload, named by id), `records/` (key -> id), `parts/` (code tables, parameters and
//! names of inputs that records name, each stored once: they explain, they are no truth), `tmp/` (being written),
//! `quarantine/` (damaged files, and both outputs of a stage that is not reproducible). Locks, figures and edited copies lie in
//! the checkout, not in the store (`checkout`). Publication: object, then record, each by a temporary file and a rename, synchronised before the record
//! counts. An object without a record is garbage, never a lie. A record whose object is damaged is healed as soon as that is
//! seen; one whose object was deleted when somebody needs it. Made again, it is required to have its recorded id. No NaN
//! and no infinity gets into an artifact (`finite`), and none that breaks a rule of its stage (`Stage::check_output`). Both
//! are asked again when an artifact enters a stage: its hash says that the bytes are whole, not who made them.
//!
//! Several runs may share a store: `locks/KEY` is locked while its piece is made and until its record can be read, so each
//! key is made once; the kernel frees the lock of a process that dies. `store.lock` is held shared by every verb, and by
//! `gc` alone. `runs/` (what the last three used), `manifests/` (the pieces of a content) and the locks say what `gc` must
//! keep; the checkout's `published` tells our figures from edited ones, which go to `edited/` before ours are restored.
//!
//! Outputs marked [`Keep::Evict`](crate::engine::stage::Keep) are hashed and recorded but not written; when a reader needs
//! one and it has left memory, it is made again and checked. What `gc` took to make room is treated alike.
//!
//! No time stamp and no other word of the file system is trusted: a run with nothing to do reads the record of every piece,
//! looks whether its object is there, reads and verifies the outputs that are published, and compares each published file
//! byte by byte. An object that rots without being read is seen when it is read for use, which always verifies, or by
//! `verify --store`, which reads everything.
//!
//! Before a run, a plan says of each piece: cached; will run; may run, if an input comes out changed. `why` compares what a
//! piece would be made from with the nearest record of it (fewest differences, of those the latest, so that another
//! profile in the same store explains nothing) and walks the inputs to the root changes. A record from before parts were
//! kept is a hit like any other; what it cannot tell is said to be unrecorded.
//!
//! Order of reading: `stage`, `arrow`, `node`; `case`, `params`, `pipeline`, `graph`; `key`, `code`, `run`, `schedule`,
//! `queue`; `store`, `disk`, `flight`, `object`, `record`, `parts`, `finite`; `lock`, `verify`, `audit`,
//! `rebuild`, `difference`, `checkout`, `figures`, `published`, `leftover`, `publish`, `runs`, `gc`; `plan`, `history`, `compare`, `explain`, `why`; `revision`, `versions`;
//! `chart`; `timing`; `stop`, `threads`. What the command line names is in `target`, how parameter tables are laid over each other in `layers`,
//! how a key is named in `key_path`, which name is meant in `nearest`.

pub mod arrow;
pub mod audit;
pub mod case;
pub mod chart;
pub mod chart_svg;
pub mod chart_text;
pub mod checkout;
pub mod claim;
pub mod code;
pub mod codec;
mod compare;
mod decode;
pub mod difference;
pub mod disk;
pub mod error;
pub mod event;
mod explain;
mod fields;
pub mod figures;
pub mod finite;
mod flight;
pub mod gc;
pub mod graph;
mod history;
pub mod id;
pub mod key;
pub mod key_path;
mod layers;
pub mod leftover;
mod listing;
pub mod lock;
mod manifest;
mod memo;
pub mod names;
mod nearest;
pub mod node;
pub mod object;
pub mod params;
pub mod parts;
pub mod pipeline;
pub mod plan;
pub mod publish;
pub mod published;
mod queue;
pub mod read;
pub mod reason;
pub mod rebuild;
pub mod record;
pub mod revision;
pub mod run;
mod runs;
pub mod schedule;
mod settings;
pub mod stage;
pub mod stop;
pub mod store;
pub mod streams;
pub mod target;
mod threads;
pub mod timing;
mod tree;
mod twice;
pub mod verify;
pub mod versions;
pub mod why;
