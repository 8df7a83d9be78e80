//! Roll in lanes: eight columns of waves times up to three epsilon_1, integrated side by side in blocks of sixteen steps.
//!
//! A column is a field of the record or a single run; lane = 8 e + column, so that all epsilon_1 share one elevation.
//! Each block has two phases: sixteen RK4 steps, then the maximum of the roll over each step, with the peak inside it
//! from the cubic Hermite interpolant. Then an observer looks at the block: the truth, single runs and the ensemble of
//! initial conditions differ in waves and observer alone. Step s is the interval [s h, (s + 1) h].
//!
//! A capsize, !(|theta| <= capsize_angle) at a full step, is a select per lane: the ship is set upright at rest and goes
//! on; the roll measured at that instant is capsize_angle. It is the end of one step and the start of the next.
//! An overflowed state is a capsize too: no NaN and no infinity gets out.
//!
//! Tested through `tests/physics/{response,encounter}.rs` against a scalar twin, bit for bit, at every level and width.

use crate::numerics::lanes::{Kernel, Level, dispatch_at};
use crate::numerics::{hermite, rk4};
use crate::ship::initial_condition::RollState;
use crate::ship::response::{Roll, Truth};
use crate::ship::roll_equation::{Damping, RollEquation, Ship};
use std::ops::Range;

/// Columns of waves side by side: fields, or single runs.
pub const COLUMNS: usize = 8;
/// The most epsilon_1 side by side: 24 lanes keep the CPU busy, 32 do not fit its registers.
pub const EPSILONS: usize = 3;
/// Lanes of every block; with fewer epsilon_1 the last one fills up, which costs a wide CPU nothing.
pub(crate) const LANES: usize = COLUMNS * EPSILONS;
/// Steps of a block.
pub(crate) const BLOCK: usize = 16;

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

/// Surface elevation in eight columns.
pub(crate) trait Waves {
    /// Fills the elevation in m at full and half steps from a full step on: `rows[k]` at `(step + k/2) h`.
    fn fill(&self, step: i64, rows: &mut [[f64; COLUMNS]]);
}

/// What looks at the roll, block by block.
pub(crate) trait Observer {
    /// Whether the maxima of a block that ends at this step are of use.
    fn needs_maxima(&self, end: i64) -> bool;
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
    /// `initial` holds one state per lane, or nothing: at rest.
    pub(crate) fn integrate<W: Waves, O: Observer>(
        &self,
        epsilon_1: &[f64],
        initial: &[RollState],
        span: &Span,
        waves: &W,
        observer: &mut O,
    ) {
        let integration = Integration {
            simulation: *self,
            epsilon_1,
            initial,
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
    initial: &'a [RollState],
    span: &'a Span,
    waves: &'a W,
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
        let mut block = Block::starting(rules, task.initial);
        let mut eta = [[0.0; COLUMNS]; 2 * BLOCK + 1];
        let mut step = task.span.steps.start;
        while step < task.span.steps.end {
            let n = task.span.block_length(step);
            let end = step + n as i64;
            task.waves.fill(step, &mut eta[..=2 * n]);
            block.advance(&equation, rules, n, &eta);
            if task.observer.needs_maxima(end) {
                block.find_maxima(rules);
            }
            task.observer.observe(step, &block);
            step = end;
        }
        task.observer.finish();
    }
}

/// What the inner loops need of [`Truth`].
#[derive(Clone, Copy)]
struct Rules {
    h: f64,
    capsize_angle: f64,
    /// Clears the sign of an absolute roll, keeps that of a signed one.
    sign_mask: u64,
}

impl Rules {
    fn new(simulation: &Simulation) -> Self {
        Self {
            h: simulation.h,
            capsize_angle: simulation.truth.capsize_angle,
            sign_mask: match simulation.truth.roll {
                Roll::Absolute => !(1 << 63),
                Roll::Signed => !0,
            },
        }
    }

    /// False at a capsize, and in a state that is no number.
    #[inline(always)]
    fn is_upright(self, theta: f64, theta_dot: f64) -> bool {
        (theta.abs() <= self.capsize_angle) & (theta_dot.abs() <= f64::MAX)
    }

    /// The roll that is compared with thresholds, of a roll angle.
    #[inline(always)]
    fn measured(self, theta: f64) -> f64 {
        f64::from_bits(theta.to_bits() & self.sign_mask)
    }
}

/// Up to sixteen steps of roll: row 0 of each state is the start, row k the end of the k-th step.
#[repr(C, align(64))]
pub(crate) struct Block {
    /// Roll after a possible restart, rad; (n + 1, lanes).
    pub(crate) theta: [[f64; LANES]; BLOCK + 1],
    /// Roll velocity after a possible restart, rad/s; (n + 1, lanes).
    pub(crate) theta_dot: [[f64; LANES]; BLOCK + 1],
    /// Roll as measured, rad, capsize_angle at a capsize; (n + 1, lanes).
    pub(crate) measured: [[f64; LANES]; BLOCK + 1],
    /// Largest measured roll over each step, both ends and the peak inside included, rad; (n, lanes).
    pub(crate) maximum: [[f64; LANES]; BLOCK],
    /// Capsizes in this block.
    pub(crate) capsizes: [f64; LANES],
    /// Steps in use.
    pub(crate) n: usize,
}

impl Block {
    /// A block of no steps yet, which ends in the given states.
    #[inline(always)]
    fn starting(rules: Rules, initial: &[RollState]) -> Self {
        let mut block = Self {
            theta: [[0.0; LANES]; BLOCK + 1],
            theta_dot: [[0.0; LANES]; BLOCK + 1],
            measured: [[0.0; LANES]; BLOCK + 1],
            maximum: [[0.0; LANES]; BLOCK],
            capsizes: [0.0; LANES],
            n: 0,
        };
        for (lane, state) in initial.iter().enumerate() {
            block.theta[0][lane] = state.theta;
            block.theta_dot[0][lane] = state.theta_dot;
            block.measured[0][lane] = rules.measured(state.theta);
        }
        block
    }

    /// Goes on by n RK4 steps from where the block ended.
    #[inline(always)]
    fn advance<const CUBIC: bool>(
        &mut self,
        equation: &RollEquation<LANES, CUBIC>,
        rules: Rules,
        n: usize,
        eta: &[[f64; COLUMNS]; 2 * BLOCK + 1],
    ) {
        let (mut theta, mut theta_dot) = (self.theta[self.n], self.theta_dot[self.n]);
        self.theta[0] = theta;
        self.theta_dot[0] = theta_dot;
        self.measured[0] = self.measured[self.n];
        let mut capsizes = [0.0; LANES];
        for k in 0..n {
            let forcing = [spread(&eta[2 * k]), spread(&eta[2 * k + 1]), spread(&eta[2 * k + 2])];
            let acceleration = |x, v, eta| equation.acceleration(x, v, eta);
            (theta, theta_dot) = rk4::step(acceleration, rules.h, theta, theta_dot, forcing);
            let mut upright = true;
            for i in 0..LANES {
                self.measured[k + 1][i] = rules.measured(theta[i]);
                upright &= rules.is_upright(theta[i], theta_dot[i]);
            }
            // Capsizes are rare: one branch for all lanes, then a select per lane.
            if !upright {
                for i in 0..LANES {
                    let upright = rules.is_upright(theta[i], theta_dot[i]);
                    theta[i] = if upright { theta[i] } else { 0.0 };
                    theta_dot[i] = if upright { theta_dot[i] } else { 0.0 };
                    self.measured[k + 1][i] = if upright {
                        self.measured[k + 1][i]
                    } else {
                        rules.capsize_angle
                    };
                    capsizes[i] += if upright { 0.0 } else { 1.0 };
                }
            }
            self.theta[k + 1] = theta;
            self.theta_dot[k + 1] = theta_dot;
        }
        self.n = n;
        self.capsizes = capsizes;
    }

    /// The largest roll over each step of the block.
    #[inline(always)]
    fn find_maxima(&mut self, rules: Rules) {
        for k in 0..self.n {
            for first in (0..LANES).step_by(COLUMNS) {
                let [mut x, mut v] = [[[0.0; COLUMNS]; 2]; 2];
                let mut largest = [0.0; COLUMNS];
                let mut signs = 0;
                for i in 0..COLUMNS {
                    let lane = first + i;
                    x[0][i] = self.theta[k][lane];
                    x[1][i] = self.theta[k + 1][lane];
                    v[0][i] = self.theta_dot[k][lane];
                    v[1][i] = self.theta_dot[k + 1][lane];
                    let (start, end) = (self.measured[k][lane], self.measured[k + 1][lane]);
                    largest[i] = if end > start { end } else { start };
                    signs |= v[0][i].to_bits() ^ v[1][i].to_bits();
                }
                // Most steps have no peak in any of the eight columns, and the root costs more than the step.
                if signs >> 63 == 1 {
                    let peak = hermite::extremum(rules.h, x, v);
                    for i in 0..COLUMNS {
                        let there = rules.measured(peak[i]);
                        let there = if there > rules.capsize_angle {
                            rules.capsize_angle
                        } else {
                            there
                        };
                        largest[i] = if there > largest[i] { there } else { largest[i] };
                    }
                }
                self.maximum[k][first..first + COLUMNS].copy_from_slice(&largest);
            }
        }
    }
}

/// The elevation of each lane's column.
#[inline(always)]
fn spread(eta: &[f64; COLUMNS]) -> [f64; LANES] {
    let mut result = [0.0; LANES];
    for i in 0..LANES {
        result[i] = eta[i % COLUMNS];
    }
    result
}
