//! Segments of a run and the largest roll in each: the r_i of Eq. (1).
//!
//! A segment is the set of whole steps inside [t_i - window l_i, t_i + window l_i]: a peak between two full steps counts
//! if both lie in the segment, a capsize at a full step counts if that instant does. Steps of a run are gathered in rows
//! of lanes, sixteen rows are condensed into one, and every 1,024 steps the segments take what lies in them.

use crate::ship::block::{BLOCK, Block};
use crate::ship::simulation::{COLUMNS, LANES};

/// Rows gathered before the segments take their maxima: small enough for the second-level cache.
const ROWS: usize = 1024;
/// Rows condensed into one.
const CONDENSED: usize = 16;

/// Full steps `first..=last` of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Segment {
    /// The first full step.
    pub first: i64,
    /// The last full step, at least one after the first.
    pub last: i64,
}

impl Segment {
    /// The full steps in [centre - reach, centre + reach], times in s; the step at the centre if there is no whole step.
    pub fn around(centre: f64, reach: f64, h: f64) -> Self {
        let first = ((centre - reach) / h).ceil() as i64;
        let last = ((centre + reach) / h).floor() as i64;
        if first < last {
            return Self { first, last };
        }
        let first = (centre / h).floor() as i64;
        Self { first, last: first + 1 }
    }

    /// The same instants counted from another step.
    #[must_use]
    pub fn since(self, step: i64) -> Self {
        let (first, last) = (self.first - step, self.last - step);
        Self { first, last }
    }

    /// What of it lies in the steps first..=last of a run, at least one step of them.
    #[must_use]
    pub fn within(self, first: i64, last: i64) -> Self {
        let first = self.first.clamp(first, last - 1);
        let last = self.last.clamp(first + 1, last);
        Self { first, last }
    }
}

/// The largest roll in every segment of every column, gathered along a run.
pub(crate) struct SegmentMaxima<'a> {
    columns: &'a [Vec<Segment>],
    opening: i64,
    epsilons: usize,
    /// Largest roll so far, `[epsilon_1][column][segment]`, rad.
    pub(crate) r: Vec<Vec<Vec<f64>>>,
    base: i64,
    // (rows, lanes), row-major.
    rows: Vec<f64>,
    condensed: Vec<f64>,
}

impl<'a> SegmentMaxima<'a> {
    pub(crate) fn new(columns: &'a [Vec<Segment>], epsilons: usize) -> Self {
        let unseen: Vec<Vec<f64>> = columns.iter().map(|list| vec![f64::NEG_INFINITY; list.len()]).collect();
        Self {
            columns,
            opening: columns
                .iter()
                .flatten()
                .map(|segment| segment.first)
                .min()
                .unwrap_or(i64::MAX),
            epsilons,
            r: vec![unseen; epsilons],
            base: 0,
            rows: Vec::with_capacity(ROWS * LANES),
            condensed: Vec::with_capacity(ROWS / CONDENSED * LANES),
        }
    }

    /// Whether some segment reaches into the steps before `end`.
    pub(crate) fn is_open(&self, end: i64) -> bool {
        end > self.opening
    }

    /// Gathers the maxima of a block that starts at this step.
    #[inline(always)]
    pub(crate) fn gather(&mut self, step: i64, block: &Block) {
        if self.rows.len() + BLOCK * LANES > ROWS * LANES {
            self.settle();
        }
        if self.rows.is_empty() {
            self.base = step;
        }
        self.rows.extend_from_slice(block.maximum[..block.n].as_flattened());
    }

    /// Gives the gathered rows to the segments.
    #[inline(always)]
    pub(crate) fn settle(&mut self) {
        self.condensed.clear();
        for rows in self.rows.chunks_exact(CONDENSED * LANES) {
            self.condensed.extend_from_slice(&largest(rows));
        }
        self.take();
        self.rows.clear();
    }

    /// Every segment takes the maximum of the gathered rows it holds.
    fn take(&mut self) {
        let count = (self.rows.len() / LANES) as i64;
        for (column, segments) in self.columns.iter().enumerate() {
            for (index, segment) in segments.iter().enumerate() {
                let from = (segment.first - self.base).max(0) as usize;
                let to = (segment.last - self.base).clamp(0, count) as usize;
                for e in 0..self.epsilons {
                    let found = self.maximum_over(e * COLUMNS + column, from, to);
                    let r = &mut self.r[e][column][index];
                    *r = if found > *r { found } else { *r };
                }
            }
        }
    }

    /// The maximum of one lane over the rows from..to.
    fn maximum_over(&self, lane: usize, from: usize, to: usize) -> f64 {
        let mut largest = f64::NEG_INFINITY;
        let mut k = from;
        while k < to {
            let whole = k.is_multiple_of(CONDENSED) && k + CONDENSED <= to;
            let (value, taken) = if whole {
                (self.condensed[k / CONDENSED * LANES + lane], CONDENSED)
            } else {
                (self.rows[k * LANES + lane], 1)
            };
            largest = if value > largest { value } else { largest };
            k += taken;
        }
        largest
    }
}

/// The largest of some rows, lane by lane.
#[inline(always)]
fn largest(rows: &[f64]) -> [f64; LANES] {
    let mut result = [f64::NEG_INFINITY; LANES];
    for row in rows.as_chunks::<LANES>().0 {
        for i in 0..LANES {
            result[i] = if row[i] > result[i] { row[i] } else { result[i] };
        }
    }
    result
}
