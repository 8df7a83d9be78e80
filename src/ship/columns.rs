//! Single runs in eight columns: as one ends the next departs, and all columns end about together.
//!
//! The longest run is placed first, each in the column that is free earliest. A run departs at the start of a block, so its
//! blocks are those it would have alone. Tested through `tests/physics/encounter.rs`.

use crate::ship::block::BLOCK;
use crate::ship::initial_condition::RollState;
use crate::ship::segments::Segment;
use crate::ship::simulation::{COLUMNS, EPSILONS};
use std::cmp::Reverse;

/// A run takes up a column.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Departure {
    /// Full step of the common clock, the run's own step 0: a block starts here.
    pub(crate) step: i64,
    pub(crate) column: usize,
    /// Which run.
    pub(crate) run: usize,
    /// Its states for each epsilon_1.
    pub(crate) states: [RollState; EPSILONS],
}

/// Places runs that last until their segments end, from rest; in the order of time.
pub(crate) fn departures(segments: &[Segment]) -> Vec<Departure> {
    let mut order: Vec<usize> = (0..segments.len()).collect();
    order.sort_by_key(|run| Reverse(segments[*run].last));
    let mut free = [0; COLUMNS];
    let mut departures = Vec::with_capacity(segments.len());
    for run in order {
        let column = (1..COLUMNS).fold(0, |best, column| if free[column] < free[best] { column } else { best });
        departures.push(Departure {
            step: free[column],
            column,
            run,
            states: [RollState::default(); EPSILONS],
        });
        let blocks = (segments[run].last as usize).div_ceil(BLOCK);
        free[column] += (blocks * BLOCK) as i64;
    }
    departures.sort_by_key(|departure| departure.step);
    departures
}
