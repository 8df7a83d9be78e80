//! Stage: what a domain scientist writes. One file: parameters, inputs, output, and a pure function between them.

use std::collections::BTreeMap;

use rand_chacha::ChaCha12Rng;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

use crate::engine::arrow::Inputs;
use crate::engine::case::Axis;
use crate::engine::error::Result;
use crate::engine::streams::Streams;

/// One step of the paper.
pub trait Stage: 'static {
    /// The file stem, which is also the word on the command line.
    const NAME: &'static str;
    /// The place in the paper.
    const PAPER: &'static str;
    /// How the work is cut into independent pieces.
    const PIECES: Pieces = Pieces::One;
    /// The axes that its [`Cases`](crate::engine::arrow::Cases) arrows run over. Of their tables, if it reads them, it
    /// sees all in force, by name.
    const GATHERS: &'static [Axis] = &[];
    /// Axes whose values come from elsewhere than `[run]`.
    const SELECTS: &'static [Select] = &[];
    /// Keys that name values of an axis and choose no case by them: each name must be that of a table of the axis.
    const NAMES: &'static [Select] = &[];
    /// Keys that number an item, each with the count that it must stay below and the size of the blocks it is rounded up to.
    const ITEMS: &'static [(&'static str, &'static str, u64)] = &[];
    /// Whether the bytes of the output stay in the store.
    const KEEP: Keep = Keep::Auto;
    /// The parameters it reads: a struct whose fields are tables of the parameter file.
    type Params: Serialize + DeserializeOwned + Send + Sync;
    /// A tuple of arrows.
    type Inputs: Inputs;
    /// What it makes.
    type Output: Artifact;
    /// Name and version of the output's layout, such as `wave-groups/1`.
    const SCHEMA: &'static str;

    /// Rules between parameters that one key alone cannot state; the message reads `key: expected .., found ..`,
    /// other keys in backticks, all of them as the stage reads them.
    ///
    /// # Errors
    /// The first rule that does not hold.
    fn check(_params: &Self::Params) -> std::result::Result<(), String> {
        Ok(())
    }

    /// Rules between parameters and the counts of the engine, which `count` gives by their keys: what a stage that gathers
    /// many pieces holds in memory. Counts are in no key, so nothing here may shape the output.
    ///
    /// # Errors
    /// The first rule that does not hold, worded as by [`Stage::check`].
    fn check_counts(_params: &Self::Params, _count: &dyn Fn(&str) -> u64) -> std::result::Result<(), String> {
        Ok(())
    }

    /// What the grids and steps of a case resolve; asked of every case of a run, since a step that suits one ship or sea
    /// need not suit another. Gives warnings; a warning and an error both read as in [`Stage::check`].
    ///
    /// # Errors
    /// The first grid or step whose results would be those of the method instead of the ship's.
    fn resolution(_params: &Self::Params) -> std::result::Result<Vec<String>, String> {
        Ok(Vec::new())
    }

    /// The invariants of an output over the items of its piece: what readers take for granted and serde cannot say, such
    /// as equal lengths. Asked when an output is made, and when one enters from the store, which may hold anything. That
    /// all numbers are finite is checked before.
    ///
    /// # Errors
    /// The first invariant that does not hold: `place: expected .., found ..`.
    fn check_output(
        _params: &Self::Params,
        _items: std::ops::Range<u64>,
        _output: &Self::Output,
    ) -> std::result::Result<(), String> {
        Ok(())
    }

    /// Makes the output of one piece; a pure function.
    ///
    /// # Errors
    /// What keeps the output from being made.
    fn run(params: &Self::Params, inputs: <Self::Inputs as Inputs>::Values<'_>, here: Here<'_>)
    -> Result<Self::Output>;
}

/// A value that a stage makes and the store keeps: whatever serde can describe.
pub trait Artifact: Serialize + DeserializeOwned + Send + Sync + 'static {}

impl<T: Serialize + DeserializeOwned + Send + Sync + 'static> Artifact for T {}

/// The text files of a figure or table, by file name.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Published {
    /// File name to content.
    pub files: BTreeMap<String, String>,
}

impl Published {
    /// The layout's name and version.
    pub const SCHEMA: &'static str = "published/1";

    /// Files that share a stem, by extension.
    pub fn new<const N: usize>(stem: &str, files: [(&str, String); N]) -> Self {
        let named = files
            .into_iter()
            .map(|(extension, text)| (format!("{stem}.{extension}"), text));
        Self { files: named.collect() }
    }

    /// The id of each file: the BLAKE3 hash of its bytes, in hexadecimal, by file name.
    pub fn ids(&self) -> BTreeMap<String, String> {
        let id = |text: &str| blake3::hash(text.as_bytes()).to_hex().to_string();
        self.files.iter().map(|(name, text)| (name.clone(), id(text))).collect()
    }
}

/// How a node is cut into pieces; items are counted over the whole node.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pieces {
    /// One piece.
    One,
    /// One item a piece; the parameter counts them.
    Counted(&'static str),
    /// The parameter counts the items; a piece holds at most this many.
    Batches(&'static str, u64),
    /// The pieces of the first `Each` arrow.
    AsUpstream,
}

/// Where the values of an axis come from, if not from `[run]`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Select {
    /// One value, that of this parameter.
    At(Axis, &'static str),
    /// Those values of `[run]` that name a row of this array of tables; the stage sees its own rows alone.
    Rows(Axis, &'static str),
}

/// Whether the bytes of an artifact stay in the store.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Keep {
    /// Written and kept, whatever the room.
    Always,
    /// Written; `gc` may take the bytes when room is short, and they are made again when needed.
    Auto,
    /// Hashed and recorded, handed to readers in memory, made again when needed.
    Evict,
}

/// Where a stage stands: the piece and its random streams.
pub struct Here<'a> {
    /// The first item of the piece.
    pub first: u64,
    /// The number of items in the piece.
    pub items: u64,
    pub(crate) streams: &'a Streams,
}

impl Here<'_> {
    /// The random stream of an item, counted over the whole node.
    pub fn stream(&self, item: u64) -> ChaCha12Rng {
        self.streams.of(item)
    }

    /// The random streams of the piece's items, in order.
    pub fn streams(&self) -> impl Iterator<Item = ChaCha12Rng> + '_ {
        (self.first..self.first + self.items).map(|item| self.stream(item))
    }
}
