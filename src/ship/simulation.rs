//! Roll in lanes: eight columns of waves times up to three epsilon_1, integrated side by side in blocks of sixteen steps.
//!
//! A column is a field of the record or a single run; lane = 8 e + column, so that all epsilon_1 share one elevation.
//! An observer looks at each block: the truth, single runs and the ensemble of initial conditions differ in waves and
//! observer alone. Step s is the interval [s h, (s + 1) h].
//!
//! Tested through `tests/physics/{response,encounter}.rs` against a scalar twin, bit for bit, at every level.

use crate::numerics::lanes::{Kernel, Level, dispatch_at};
use crate::ship::block::{BLOCK, Block};
use crate::ship::columns::Departure;
use crate::ship::response::Truth;
use crate::ship::roll_equation::{Damping, RollEquation, Ship};
use crate::ship::turn::Rules;
use std::ops::Range;

/// Columns of waves side by side: fields, or single runs.
pub const COLUMNS: usize = 8;
/// The most epsilon_1 side by side: 24 lanes keep the CPU busy, 32 do not fit its registers.
pub const EPSILONS: usize = 3;
/// Lanes of every block; with fewer epsilon_1 the last one fills up and is not looked at.
pub(crate) const LANES: usize = COLUMNS * EPSILONS;

/// A ship, its rules of response and its step: everything a run needs but the waves.
#[derive(Clone, Copy, Debug)]
pub struct Simulation<'a> {
    /// Coefficients of Eq. (6).
    pub ship: &'a Ship,
    /// Capsize angle, sign of the roll.
    pub truth: &'a Truth,
    /// RK4 step, s.
    pub h: f64,
    /// Instruction set; it cannot change a result.
    pub level: Level,
}

impl<'a> Simulation<'a> {
    /// A simulation at the instruction set in force.
    pub fn new(ship: &'a Ship, truth: &'a Truth, h: f64) -> Self {
        let level = Level::current();
        Self { ship, truth, h, level }
    }
}

/// Elevation at the full and half steps of a block.
pub(crate) type BlockRows = [[f64; COLUMNS]; 2 * BLOCK + 1];

/// Surface elevation in eight columns.
pub(crate) trait Waves {
    /// A run takes up a column: its own step 0 is this full step.
    fn depart(&mut self, step: i64, column: usize, run: usize);
    /// The elevation in m at full and half steps of n steps from a full step on, row k at `(step + k/2) h`.
    ///
    /// What is not kept in such rows is put into the given ones.
    fn rows<'a>(&'a mut self, step: i64, n: usize, space: &'a mut BlockRows) -> &'a BlockRows;
}

/// What looks at the roll, block by block.
pub(crate) trait Observer {
    /// Looks at a block that starts at this step.
    fn observe(&mut self, step: i64, block: &Block);
    /// Takes note that the run is over.
    fn finish(&mut self);
}

/// The steps to integrate over, and full steps that no block may straddle.
pub(crate) struct Span {
    pub(crate) steps: Range<i64>,
    pub(crate) cuts: [i64; 2],
}

impl Span {
    /// The number of steps of the block that starts here.
    fn block_length(&self, step: i64) -> usize {
        let end = self
            .cuts
            .into_iter()
            .filter(|cut| *cut > step)
            .fold(self.steps.end, i64::min);
        (end - step).min(BLOCK as i64) as usize
    }
}

impl Simulation<'_> {
    /// Integrates eight columns for up to three epsilon_1 and shows every block to the observer.
    ///
    /// All start at rest; `departures`, in the order of time, set single columns to other states on the way.
    pub(crate) fn integrate<W: Waves, O: Observer>(
        &self,
        epsilon_1: &[f64],
        departures: &[Departure],
        span: &Span,
        waves: &mut W,
        observer: &mut O,
    ) {
        let integration = Integration {
            simulation: *self,
            epsilon_1,
            departures,
            span,
            waves,
            observer,
        };
        match self.ship.damping {
            Damping::Cubic => dispatch_at(self.level, WithDamping::<true, _>(integration)),
            Damping::Quadratic => dispatch_at(self.level, WithDamping::<false, _>(integration)),
        }
    }
}

struct Integration<'a, W, O> {
    simulation: Simulation<'a>,
    epsilon_1: &'a [f64],
    departures: &'a [Departure],
    span: &'a Span,
    waves: &'a mut W,
    observer: &'a mut O,
}

struct WithDamping<const CUBIC: bool, I>(I);

impl<const CUBIC: bool, W: Waves, O: Observer> Kernel for WithDamping<CUBIC, Integration<'_, W, O>> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let task = self.0;
        let mut epsilon_1 = [0.0; LANES];
        for (lane, value) in epsilon_1.iter_mut().enumerate() {
            *value = task.epsilon_1[(lane / COLUMNS).min(task.epsilon_1.len() - 1)];
        }
        let equation = RollEquation::<LANES, CUBIC>::new(task.simulation.ship, epsilon_1);
        let rules = Rules::new(&task.simulation);
        let mut block = Block::at_rest(rules);
        let mut departures = task.departures;
        let mut space = [[0.0; COLUMNS]; 2 * BLOCK + 1];
        let mut step = task.span.steps.start;
        while step < task.span.steps.end {
            while let Some((departure, later)) = departures.split_first().filter(|(first, _)| first.step == step) {
                block.depart(departure.column, &departure.states);
                task.waves.depart(step, departure.column, departure.run);
                departures = later;
            }
            let n = task.span.block_length(step);
            let eta = task.waves.rows(step, n, &mut space);
            block.advance(&equation, n, eta);
            task.observer.observe(step, &block);
            step += n as i64;
        }
        task.observer.finish();
    }
}
