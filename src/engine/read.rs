//! Reader: what an arrow holds while a piece runs; the way back from a stage to the outputs it may read.

use std::sync::Arc;

use crate::engine::case::Case;
use crate::engine::error::{Error, Result};
use crate::engine::run::Run;

/// The inputs of one piece.
#[derive(Clone)]
pub struct Reader<'a> {
    run: &'a Run<'a>,
    node: usize,
    piece: usize,
}

impl<'a> Reader<'a> {
    pub(crate) fn new(run: &'a Run<'a>, node: usize, piece: usize) -> Self {
        Self { run, node, piece }
    }

    /// The upstream cases that an arrow reaches.
    pub(crate) fn upstream(&self, arrow: usize) -> &'a [usize] {
        &self.run.graph.nodes[self.node].links[arrow].upstream
    }

    /// The number of the running piece.
    pub(crate) fn piece(&self) -> usize {
        self.piece
    }

    /// The number of pieces of an upstream case.
    pub(crate) fn pieces(&self, upstream: usize) -> usize {
        self.run.graph.nodes[upstream].pieces.len()
    }

    /// An upstream case.
    pub(crate) fn case(&self, upstream: usize) -> &'a Case {
        &self.run.graph.nodes[upstream].case
    }

    /// An upstream output, decoded.
    pub(crate) fn value<T: Send + Sync + 'static>(&self, upstream: usize, piece: usize) -> Result<Arc<T>> {
        let value = self.run.value(upstream, piece)?;
        value
            .downcast()
            .map_err(|_| Error::stage("an input of another type than its arrow says"))
    }
}
