//! Index: key, id, length and stat of each object as last verified, in one file a profile; never the truth.
//!
//! A run with nothing to do needs one look at each object instead of its record and its bytes. What the index says is
//! believed by a run for a whole graph or not at all ([`Index::believe`]): as soon as one piece is to be made or healed,
//! records decide anew, and every read for use verifies as ever. Published files are believed in like manner
//! ([`shown`](crate::engine::shown)); whoever shares a store under another name disturbs neither.
//!
//! | what happened to an object | is seen because |
//! |---|---|
//! | written, cut, moved, replaced | size, mtime, ctime or inode differ: it is hashed again |
//! | the same, size and mtime put back | nobody can set ctime |
//! | the same, within one tick of the clock | a stat less than 2 s old when verifying began is not believed (racy, `stat`) |
//! | deleted | there is no stat |
//! | its record deleted or written | the record's own times are looked at alike: it is read whole |
//! | bytes rotted on the medium under an equal stat | not here: at the next read, or by `verify --store`, which reads all |
//!
//! An index that is gone, damaged or of another layout is empty, which costs the time to read the records and to hash the
//! objects once. Tested in `tests/cache/index.rs`.
//!
//! On disk, little endian: magic `ENCINDX1` | seconds i64 and nanoseconds i64 when verifying began | rows, sorted by key | BLAKE3
//! of all before. A row: key (32), id (32), bytes u64, kept u64, size u64, mtime i64 i64, ctime i64 i64, inode u64.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use crate::engine::disk::read_regular;
use crate::engine::error::Result;
use crate::engine::history::record_file;
use crate::engine::id::{Id, Key};
use crate::engine::run::Run;
use crate::engine::stat::{Began, Stat};
use crate::engine::store::Found;

const MAGIC: &[u8; 8] = b"ENCINDX1";
const HEAD: usize = 24;
const ROW: usize = 128;
const CHECK: usize = 32;
/// Rows of other graphs that are kept: an edit taken back, or a run of everything after one of a part, finds its own.
const MOST: usize = 20_000;
/// So many rows take longer than starting a thread.
const WORTH_A_THREAD: usize = 100;

/// What the last runs verified.
#[derive(Default)]
pub struct Index {
    /// Who shares it: a profile.
    name: String,
    began: Began,
    /// The file but for its check; empty without one.
    bytes: Vec<u8>,
}

#[derive(Clone, Debug, PartialEq)]
struct Row {
    key: Key,
    id: Id,
    bytes: u64,
    /// None if the bytes are not in the store and nobody needed them.
    stat: Option<Stat>,
}

/// Whether record and object of a row, read whole, are what it says.
fn is_sound(run: &Run<'_>, row: &Row) -> bool {
    let record = run.store.record(&row.key);
    let is_gone = row.stat.is_none() && !run.store.has(&row.id);
    record.is_some_and(|record| record.id == row.id.to_string())
        && (is_gone || matches!(run.store.peek(&row.id, None), Found::Bytes(_)))
}

/// What the index could say of a whole graph.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Belief {
    /// Every piece is cached.
    All {
        /// Whether objects had to be hashed again, so that the index is worth writing anew.
        rehashed: bool,
    },
    /// At least one piece is not as the index has it.
    Not,
}

impl Index {
    /// The index of a name in a store.
    pub fn read(root: &Path, name: &str) -> Self {
        let name = name.to_owned();
        let read = read_regular(&file(root, &name)).ok().and_then(Self::parse);
        let (began, bytes) = read.unwrap_or_default();
        Self { name, began, bytes }
    }

    fn parse(mut bytes: Vec<u8>) -> Option<(Began, Vec<u8>)> {
        let rows = bytes.len().checked_sub(HEAD + CHECK)?;
        if rows % ROW != 0 || &bytes[..8] != MAGIC {
            return None;
        }
        let (body, check) = bytes.split_at(HEAD + rows);
        if blake3::hash(body).as_bytes() != check {
            return None;
        }
        let began = Began((number(&bytes, 8) as i64, number(&bytes, 16) as i64));
        bytes.truncate(HEAD + rows);
        Some((began, bytes))
    }

    /// Its rows, one after another.
    fn rows(&self) -> &[u8] {
        self.bytes.get(HEAD..).unwrap_or_default()
    }

    /// Its name.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Whether nothing is known.
    pub fn is_empty(&self) -> bool {
        self.rows().is_empty()
    }

    /// Takes the id of a piece for known, if its object is as it was when it was verified.
    pub(crate) fn hint(&self, run: &Run<'_>, node: usize, piece: usize) -> bool {
        let row = run.key(node, piece).and_then(|key| self.row(&key));
        let row = row.filter(|row| self.vouches_for(run, row));
        if let Some(row) = &row {
            run.suppose(node, piece, row.id, row.bytes);
        }
        row.is_some()
    }

    /// Decides a whole graph by the index; nothing is moved or made.
    pub fn believe(&self, run: &Run<'_>) -> Belief {
        let (mut rows, mut is_whole) = (Vec::new(), true);
        for node in 0..run.graph.nodes.len() {
            for piece in run.graph.wanted_pieces(node) {
                let row = run.key(node, piece).and_then(|key| self.row(&key));
                is_whole &= row.is_some();
                // Made again, a lost output must have the same id: what reads it can be looked at all the same.
                rows.extend(row.inspect(|row| run.suppose(node, piece, row.id, row.bytes)));
            }
        }
        if is_whole {
            self.judge_by_halves(run, &rows)
        } else {
            Belief::Not
        }
    }

    /// What is to be believed of some rows. A stat is a walk through folders that two cores do in half the time.
    fn judge_by_halves(&self, run: &Run<'_>, rows: &[Row]) -> Belief {
        if rows.len() < WORTH_A_THREAD {
            return self.judge(run, rows);
        }
        let (first, second) = rows.split_at(rows.len() / 2);
        let (first, second) = std::thread::scope(|scope| {
            let first = scope.spawn(|| self.judge(run, first));
            let second = self.judge(run, second);
            (first.join().unwrap_or(Belief::Not), second)
        });
        match (first, second) {
            (Belief::All { rehashed: first }, Belief::All { rehashed: second }) => Belief::All {
                rehashed: first || second,
            },
            _ => Belief::Not,
        }
    }

    fn judge(&self, run: &Run<'_>, rows: &[Row]) -> Belief {
        let mut rehashed = false;
        for row in rows.iter().filter(|row| !self.vouches_for(run, row)) {
            if !is_sound(run, row) {
                return Belief::Not;
            }
            rehashed = true;
        }
        Belief::All { rehashed }
    }

    /// Whether the object of a row is as it was when it was verified, or is still not there if it was not then; and whether
    /// its record has lain untouched since.
    fn vouches_for(&self, run: &Run<'_>, row: &Row) -> bool {
        let record = Stat::of(&record_file(run.store, &row.key));
        let object = match &row.stat {
            Some(noted) => self.began.vouches_for(noted, &run.store.object(&row.id)),
            None => !run.store.has(&row.id),
        };
        object && record.is_some_and(|record| self.began.is_calm(&record))
    }

    /// Writes the index anew after a run: its own pieces, and what is known of others. Objects that nobody has verified
    /// since they last changed are read, and healed if they are damaged.
    ///
    /// # Errors
    /// An object that cannot be made again, an index that cannot be written.
    pub fn renew(&self, run: &Run<'_>) -> Result<()> {
        let began = Began::now();
        let mut rows = BTreeMap::new();
        for (node, it) in run.graph.nodes.iter().enumerate() {
            for piece in 0..it.pieces.len() {
                if let Some(row) = self.verified(run, node, piece)? {
                    rows.insert(row.key.0, row.encoded());
                }
            }
        }
        for old in self.rows().chunks_exact(ROW) {
            // What was not to be believed must not come to be by a later time at the head.
            let is_calm = Row::decoded(old).stat.is_none_or(|noted| self.began.is_calm(&noted));
            if is_calm && rows.len() < MOST {
                rows.entry(key_of(old)).or_insert_with(|| old.to_vec());
            }
        }
        let mut bytes = MAGIC.to_vec();
        bytes.extend(began.0.0.to_le_bytes());
        bytes.extend(began.0.1.to_le_bytes());
        bytes.extend(rows.into_values().flatten());
        bytes.extend(blake3::hash(&bytes).as_bytes());
        run.store.write(&file(run.store.root(), &self.name), &bytes, false)
    }

    /// The row of a piece whose object has been verified as it is now.
    fn verified(&self, run: &Run<'_>, node: usize, piece: usize) -> Result<Option<Row>> {
        let (Some(key), Some(id)) = (run.key(node, piece), run.id(node, piece)) else {
            return Ok(None);
        };
        if let Some(row) = self.row(&key).filter(|row| row.id == id && self.vouches_for(run, row)) {
            return Ok(Some(row));
        }
        let Some(record) = run.store.record(&key).filter(|record| record.id == id.to_string()) else {
            return Ok(None);
        };
        let bytes = record.bytes;
        // One that is gone was evicted, or deleted while nobody needed it.
        if !run.store.has(&id) {
            let stat = None;
            return Ok(Some(Row { key, id, bytes, stat }));
        }
        let path = run.store.object(&id);
        let stat = Stat::of(&path);
        run.bytes(node, piece)?;
        // One that was healed is another file now.
        let same = stat.is_some() && Stat::of(&path) == stat;
        Ok(same.then_some(Row { key, id, bytes, stat }))
    }

    fn row(&self, key: &Key) -> Option<Row> {
        let rows = self.rows();
        let (mut from, mut to) = (0, rows.len() / ROW);
        while from < to {
            let middle = usize::midpoint(from, to);
            let row = &rows[middle * ROW..(middle + 1) * ROW];
            match row[..32].cmp(&key.0) {
                std::cmp::Ordering::Less => from = middle + 1,
                std::cmp::Ordering::Greater => to = middle,
                std::cmp::Ordering::Equal => return Some(Row::decoded(row)),
            }
        }
        None
    }
}

impl Row {
    fn encoded(&self) -> Vec<u8> {
        let mut row = [self.key.0, self.id.0].concat();
        let stat = self.stat.as_ref();
        let mut push = |number: u64| row.extend(number.to_le_bytes());
        push(self.bytes);
        push(u64::from(stat.is_some()));
        push(stat.map_or(0, |stat| stat.size));
        for time in [stat.map(|stat| stat.mtime), stat.map(|stat| stat.ctime)] {
            let (seconds, nanoseconds) = time.unwrap_or_default();
            push(seconds as u64);
            push(nanoseconds as u64);
        }
        push(stat.map_or(0, |stat| stat.inode));
        row
    }

    fn decoded(row: &[u8]) -> Self {
        let at = |place: usize| number(row, 64 + 8 * place);
        let stat = Stat {
            size: at(2),
            mtime: (at(3) as i64, at(4) as i64),
            ctime: (at(5) as i64, at(6) as i64),
            inode: at(7),
        };
        Self {
            key: Key(key_of(row)),
            id: Id(key_of(&row[32..])),
            bytes: at(0),
            stat: (at(1) == 1).then_some(stat),
        }
    }
}

fn file(root: &Path, name: &str) -> PathBuf {
    root.join(format!("index.{name}"))
}

fn key_of(row: &[u8]) -> [u8; 32] {
    let mut key = [0; 32];
    key.copy_from_slice(&row[..32]);
    key
}

fn number(bytes: &[u8], from: usize) -> u64 {
    let mut number = [0; 8];
    number.copy_from_slice(&bytes[from..from + 8]);
    u64::from_le_bytes(number)
}
