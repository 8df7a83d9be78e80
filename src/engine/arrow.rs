//! Arrows: how a stage reads another. The graph is the types at the head of each stage's file.

use std::marker::PhantomData;
use std::sync::Arc;

use crate::engine::case::Case;
use crate::engine::error::Result;
use crate::engine::node::{Node, node};
use crate::engine::read::Reader;
use crate::engine::stage::Stage;

/// The only output of a stage in one piece.
pub struct One<S>(PhantomData<S>);
/// Piece i of the upstream feeds piece i.
pub struct Each<S>(PhantomData<S>);
/// Every piece, in order.
pub struct All<S>(PhantomData<S>);
/// Every case along the gathered axes with all its pieces, in order.
pub struct Cases<S>(PhantomData<S>);

/// The four kinds of arrow.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// [`One`].
    One,
    /// [`Each`].
    Each,
    /// [`All`].
    All,
    /// [`Cases`].
    Cases,
}

/// One arrow of a stage's inputs.
pub trait Arrow {
    /// What the stage receives.
    type Value<'a>;
    /// Which kind of arrow.
    const KIND: Kind;
    /// The stage at its tail.
    fn upstream() -> &'static dyn Node;
    /// Opens the arrow for one piece; `arrow` is its place in the tuple.
    ///
    /// # Errors
    /// An input that cannot be read or made again.
    fn open<'a>(reader: &Reader<'a>, arrow: usize) -> Result<Self::Value<'a>>;
}

/// The pieces of one upstream case, read when asked for.
pub struct PiecesOf<'a, T> {
    reader: Reader<'a>,
    upstream: usize,
    output: PhantomData<T>,
}

impl<'a, T: Send + Sync + 'static> PiecesOf<'a, T> {
    fn new(reader: &Reader<'a>, upstream: usize) -> Self {
        Self {
            reader: reader.clone(),
            upstream,
            output: PhantomData,
        }
    }

    /// The number of pieces.
    pub fn len(&self) -> usize {
        self.reader.pieces(self.upstream)
    }

    /// True if there is no piece.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// One piece, read and verified.
    ///
    /// # Errors
    /// A piece that cannot be read or made again.
    pub fn get(&self, piece: usize) -> Result<Arc<T>> {
        self.reader.value(self.upstream, piece)
    }

    /// Every piece, in order.
    pub fn iter(&self) -> impl Iterator<Item = Result<Arc<T>>> + '_ {
        (0..self.len()).map(|piece| self.get(piece))
    }
}

/// One case of a [`Cases`] arrow.
pub struct CaseOf<'a, T> {
    /// The case: its axis values.
    pub case: Case,
    /// Its pieces.
    pub pieces: PiecesOf<'a, T>,
}

impl<T: Send + Sync + 'static> CaseOf<'_, T> {
    /// The output of a stage in one piece.
    ///
    /// # Errors
    /// An output that cannot be read or made again.
    pub fn get(&self) -> Result<Arc<T>> {
        self.pieces.get(0)
    }
}

impl<S: Stage> Arrow for One<S> {
    type Value<'a> = Arc<S::Output>;
    const KIND: Kind = Kind::One;
    fn upstream() -> &'static dyn Node {
        node::<S>()
    }
    fn open<'a>(reader: &Reader<'a>, arrow: usize) -> Result<Self::Value<'a>> {
        reader.value(reader.upstream(arrow)[0], 0)
    }
}

impl<S: Stage> Arrow for Each<S> {
    type Value<'a> = Arc<S::Output>;
    const KIND: Kind = Kind::Each;
    fn upstream() -> &'static dyn Node {
        node::<S>()
    }
    fn open<'a>(reader: &Reader<'a>, arrow: usize) -> Result<Self::Value<'a>> {
        reader.value(reader.upstream(arrow)[0], reader.piece())
    }
}

impl<S: Stage> Arrow for All<S> {
    type Value<'a> = PiecesOf<'a, S::Output>;
    const KIND: Kind = Kind::All;
    fn upstream() -> &'static dyn Node {
        node::<S>()
    }
    fn open<'a>(reader: &Reader<'a>, arrow: usize) -> Result<Self::Value<'a>> {
        Ok(PiecesOf::new(reader, reader.upstream(arrow)[0]))
    }
}

impl<S: Stage> Arrow for Cases<S> {
    type Value<'a> = Vec<CaseOf<'a, S::Output>>;
    const KIND: Kind = Kind::Cases;
    fn upstream() -> &'static dyn Node {
        node::<S>()
    }
    fn open<'a>(reader: &Reader<'a>, arrow: usize) -> Result<Self::Value<'a>> {
        let open = |upstream: &usize| CaseOf {
            case: reader.case(*upstream).clone(),
            pieces: PiecesOf::new(reader, *upstream),
        };
        Ok(reader.upstream(arrow).iter().map(open).collect())
    }
}

/// A tuple of arrows.
pub trait Inputs {
    /// What the stage receives: the tuple of the arrows' values.
    type Values<'a>;
    /// Kind and upstream of each arrow, in order.
    fn arrows() -> Vec<(Kind, &'static dyn Node)>;
    /// Opens every arrow for one piece.
    ///
    /// # Errors
    /// An input that cannot be read or made again.
    fn open<'a>(reader: &Reader<'a>) -> Result<Self::Values<'a>>;
}

macro_rules! tuples {
    ($(($($arrow:ident $index:tt),*))*) => {$(
        impl<$($arrow: Arrow),*> Inputs for ($($arrow,)*) {
            type Values<'a> = ($($arrow::Value<'a>,)*);
            fn arrows() -> Vec<(Kind, &'static dyn Node)> {
                vec![$(($arrow::KIND, $arrow::upstream())),*]
            }
            #[allow(clippy::unused_unit, unused_variables)]
            fn open<'a>(reader: &Reader<'a>) -> Result<Self::Values<'a>> {
                Ok(($($arrow::open(reader, $index)?,)*))
            }
        }
    )*};
}

tuples! {
    ()
    (A 0)
    (A 0, B 1)
    (A 0, B 1, C 2)
    (A 0, B 1, C 2, D 3)
    (A 0, B 1, C 2, D 3, E 4)
    (A 0, B 1, C 2, D 3, E 4, F 5)
    (A 0, B 1, C 2, D 3, E 4, F 5, G 6)
    (A 0, B 1, C 2, D 3, E 4, F 5, G 6, H 7)
    (A 0, B 1, C 2, D 3, E 4, F 5, G 6, H 7, I 8)
    (A 0, B 1, C 2, D 3, E 4, F 5, G 6, H 7, I 8, J 9)
    (A 0, B 1, C 2, D 3, E 4, F 5, G 6, H 7, I 8, J 9, K 10)
    (A 0, B 1, C 2, D 3, E 4, F 5, G 6, H 7, I 8, J 9, K 10, L 11)
}
