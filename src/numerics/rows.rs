//! Rows of eight numbers, each on a cache line of its own: the series of eight fields.
//!
//! A row that straddles two lines costs every vector load and store twice; the allocator alone aligns to 16 bytes.
//! Tested in `tests/physics/fourier.rs`.

use crate::numerics::fourier::WIDTH;
use std::ops::{Deref, DerefMut};

/// Bytes of a cache line: one row.
const LINE: usize = 64;

/// (n, 8) numbers, row-major; a slice of rows to those who use it.
#[derive(Debug)]
pub struct Rows {
    store: Vec<f64>,
    skipped: usize,
    length: usize,
}

impl Rows {
    /// Rows of zeros.
    pub fn new(length: usize) -> Self {
        let store = vec![0.0; (length + 1) * WIDTH];
        let skipped = store.as_ptr().align_offset(LINE).min(WIDTH);
        Self { store, skipped, length }
    }
}

impl Deref for Rows {
    type Target = [[f64; WIDTH]];
    fn deref(&self) -> &Self::Target {
        &self.store[self.skipped..].as_chunks().0[..self.length]
    }
}

impl DerefMut for Rows {
    fn deref_mut(&mut self) -> &mut Self::Target {
        &mut self.store[self.skipped..].as_chunks_mut().0[..self.length]
    }
}
