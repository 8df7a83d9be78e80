//! Segments of a run and the largest roll in each: the r_i of Eq. (1).
//!
//! A segment is the set of whole steps inside [t_i - window l_i, t_i + window l_i]: a peak between two full steps counts
//! if both lie in the segment, a capsize at a full step counts if that instant does. Between two bounds of a column's
//! segments its lanes keep one running maximum, which goes to every open segment at the next bound: blocks without a bound
//! are taken in whole.

use crate::ship::block::{Block, Since};
use crate::ship::simulation::{COLUMNS, LANES};
use crate::ship::turn::{Rules, Turn};
use std::ops::Range;

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

/// The largest roll of a lane that no segment looks at: nothing is larger.
const CLOSED: f64 = f64::INFINITY;

/// A segment of a column opens or closes.
struct Bound {
    step: i64,
    column: usize,
    index: usize,
    opens: bool,
}

/// The largest roll in every segment of every column, gathered along a run.
pub(crate) struct SegmentMaxima {
    epsilons: usize,
    /// Largest roll so far, `[epsilon_1][column][segment]`, rad.
    pub(crate) r: Vec<Vec<Vec<f64>>>,
    /// All bounds in the order of time, the next one first in `next..`.
    bounds: Vec<Bound>,
    next: usize,
    // Per column, the open segments.
    open: [Vec<usize>; COLUMNS],
    /// Open segments of all columns.
    count: usize,
    rules: Rules,
    // The largest roll since the last bound of each lane's column, or CLOSED.
    since: Since,
}

impl SegmentMaxima {
    pub(crate) fn new(columns: &[Vec<Segment>], epsilons: usize, rules: Rules) -> Self {
        let unseen: Vec<Vec<f64>> = columns.iter().map(|list| vec![f64::NEG_INFINITY; list.len()]).collect();
        let mut bounds = Vec::new();
        for (column, segments) in columns.iter().enumerate() {
            for (index, segment) in segments.iter().enumerate() {
                for (step, opens) in [(segment.first, true), (segment.last, false)] {
                    bounds.push(Bound {
                        step,
                        column,
                        index,
                        opens,
                    });
                }
            }
        }
        bounds.sort_by_key(|bound| bound.step);
        Self {
            epsilons,
            r: vec![unseen; epsilons],
            bounds,
            next: 0,
            open: std::array::from_fn(|_| Vec::new()),
            count: 0,
            rules,
            since: Since {
                largest: [CLOSED; LANES],
                held: [Turn::NONE; LANES],
            },
        }
    }

    /// Takes in the roll of a block that starts at this step.
    #[inline(always)]
    pub(crate) fn gather(&mut self, step: i64, block: &Block) {
        let end = step + block.n as i64;
        if self.bounds.get(self.next).is_some_and(|bound| bound.step < end) {
            self.pass_bounds(step, block);
        } else if self.count != 0 {
            block.raise(&mut self.since);
        }
    }

    /// Takes in a block with bounds inside: whole where a column has none, else from bound to bound.
    #[inline(always)]
    fn pass_bounds(&mut self, step: i64, block: &Block) {
        let first = self.next;
        let end = step + block.n as i64;
        let mut has_bound = [false; COLUMNS];
        while let Some(bound) = self.bounds.get(self.next).filter(|bound| bound.step < end) {
            has_bound[bound.column] = true;
            self.next += 1;
        }
        let before = self.since.largest;
        for lane in 0..LANES {
            let largest = &mut self.since.largest[lane];
            *largest = if has_bound[lane % COLUMNS] { CLOSED } else { *largest };
        }
        block.raise(&mut self.since);
        for lane in 0..LANES {
            let largest = &mut self.since.largest[lane];
            *largest = if has_bound[lane % COLUMNS] {
                before[lane]
            } else {
                *largest
            };
        }
        let mut from = [0; COLUMNS];
        for index in first..self.next {
            let Bound { step: at, column, .. } = self.bounds[index];
            // A segment that starts before its run is open from the run's start.
            let at = (at - step).max(0) as usize;
            self.take(block, column, from[column]..at);
            from[column] = at;
            self.pass(index);
        }
        for column in 0..COLUMNS {
            if has_bound[column] {
                self.take(block, column, from[column]..block.n);
            }
        }
    }

    /// Takes in some steps of a block in one column.
    fn take(&mut self, block: &Block, column: usize, steps: Range<usize>) {
        if !self.open[column].is_empty() {
            for e in 0..self.epsilons {
                block.raise_within(e * COLUMNS + column, steps.clone(), &mut self.since);
            }
        }
    }

    /// Opens or closes a segment.
    fn pass(&mut self, at: usize) {
        let Bound {
            column, index, opens, ..
        } = self.bounds[at];
        self.settle(column);
        if opens {
            self.open[column].push(index);
            self.count += 1;
        } else {
            self.open[column].retain(|open| *open != index);
            self.count -= 1;
        }
        let start = if self.open[column].is_empty() {
            CLOSED
        } else {
            f64::NEG_INFINITY
        };
        for e in 0..self.epsilons {
            self.since.largest[e * COLUMNS + column] = start;
            self.since.held[e * COLUMNS + column] = Turn::NONE;
        }
    }

    /// Gives what a column gathered since its last bound to its open segments.
    fn settle(&mut self, column: usize) {
        if self.open[column].is_empty() {
            return;
        }
        for (e, columns) in self.r.iter_mut().enumerate() {
            let lane = e * COLUMNS + column;
            let since = self.since.held[lane].raise(self.rules, self.since.largest[lane]);
            for index in &self.open[column] {
                let r = &mut columns[column][*index];
                *r = if since > *r { since } else { *r };
            }
        }
    }

    /// Gives what is left to the segments that end with the run.
    pub(crate) fn finish(&mut self) {
        for column in 0..COLUMNS {
            self.settle(column);
        }
    }
}
