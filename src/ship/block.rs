//! A block of roll: up to sixteen RK4 steps of 24 lanes, and the largest roll over each of them.
//!
//! A capsize is !(|theta| <= capsize_angle) at a full step: the ship is set upright at rest and goes on, and the roll
//! measured at that instant is capsize_angle. The instant is the end of one step and the start of the next. An overflowed
//! state is a capsize too: no NaN and no infinity gets out.
//!
//! The largest roll over a step takes in both ends and the peak between them.
//!
//! Tested through `tests/physics/{response,encounter}.rs` against a scalar twin, bit for bit, at every level.

use crate::numerics::rk4;
use crate::ship::initial_condition::RollState;
use crate::ship::roll_equation::RollEquation;
use crate::ship::simulation::{BlockRows, COLUMNS, EPSILONS, LANES};
use crate::ship::turn::{Rules, Turn};
use std::ops::Range;

/// Steps of a block.
pub(crate) const BLOCK: usize = 16;
/// The sign of a number.
const SIGN: u64 = 1 << 63;

/// Up to sixteen steps of roll: row 0 of each state is the start, row k the end of the k-th step.
#[repr(C, align(64))]
pub(crate) struct Block {
    /// Roll after a possible restart, rad; (n + 1, lanes).
    pub(crate) theta: [[f64; LANES]; BLOCK + 1],
    /// Roll velocity after a possible restart, rad/s; (n + 1, lanes).
    pub(crate) theta_dot: [[f64; LANES]; BLOCK + 1],
    /// Roll as measured, rad, capsize_angle at a capsize; (n + 1, lanes).
    measured: [[f64; LANES]; BLOCK + 1],
    /// The largest measured roll of all rows, rad.
    top: [f64; LANES],
    /// Bit k: `theta_dot` changes sign in step k.
    turns: [u64; LANES],
    /// Full steps, the start left out, with |theta| above the temporal level; a capsize is above.
    pub(crate) above: [f64; LANES],
    /// Capsizes in this block.
    pub(crate) capsizes: [f64; LANES],
    /// Whether there are any.
    pub(crate) has_capsizes: bool,
    /// Steps in use.
    pub(crate) n: usize,
    rules: Rules,
}

impl Block {
    /// A block of no steps yet, which ends at rest.
    #[inline(always)]
    pub(crate) fn at_rest(rules: Rules) -> Self {
        Self {
            theta: [[0.0; LANES]; BLOCK + 1],
            theta_dot: [[0.0; LANES]; BLOCK + 1],
            measured: [[0.0; LANES]; BLOCK + 1],
            top: [0.0; LANES],
            turns: [0; LANES],
            above: [0.0; LANES],
            capsizes: [0.0; LANES],
            has_capsizes: false,
            n: 0,
            rules,
        }
    }

    /// Changes the states in which one column ended, (epsilon_1).
    pub(crate) fn depart(&mut self, column: usize, states: &[RollState; EPSILONS]) {
        for (e, state) in states.iter().enumerate() {
            let lane = e * COLUMNS + column;
            self.theta[self.n][lane] = state.theta;
            self.theta_dot[self.n][lane] = state.theta_dot;
            self.measured[self.n][lane] = self.rules.measured(state.theta);
        }
    }

    /// |theta| at the end of the first step, rad; capsize_angle at a capsize.
    #[inline(always)]
    pub(crate) fn first_angle(&self) -> [f64; LANES] {
        let mut angle = [0.0; LANES];
        for i in 0..LANES {
            let capsized = self.has_capsizes && self.measured[1][i] == self.rules.capsize_angle;
            angle[i] = if capsized {
                self.rules.capsize_angle
            } else {
                self.theta[1][i].abs()
            };
        }
        angle
    }

    /// Goes on by n RK4 steps from where the block ended, with a restart at every capsize.
    #[inline(always)]
    pub(crate) fn advance<const CUBIC: bool>(
        &mut self,
        equation: &RollEquation<LANES, CUBIC>,
        n: usize,
        eta: &BlockRows,
    ) {
        self.theta[0] = self.theta[self.n];
        self.theta_dot[0] = self.theta_dot[self.n];
        self.measured[0] = self.measured[self.n];
        self.n = n;
        self.has_capsizes = false;
        let mut from = 0;
        // Capsizes are rare: the block is run as if there were none, and again from the first if there are.
        while !self.is_upright_from(from, equation, eta) {
            from = self.restart_after(from);
        }
        if self.has_capsizes {
            self.recount();
        }
        if self.rules.is_signed {
            self.measure_signed();
        }
    }

    /// The block from a full step on, without restarts, its roll measured by its size; false if there is a capsize.
    #[inline(always)]
    fn is_upright_from<const CUBIC: bool>(
        &mut self,
        from: usize,
        equation: &RollEquation<LANES, CUBIC>,
        eta: &BlockRows,
    ) -> bool {
        let rules = self.rules;
        let (mut theta, mut theta_dot) = (self.theta[from], self.theta_dot[from]);
        let mut now = equation.forcing(spread(&eta[2 * from]));
        let [mut top, mut above] = [[0.0; LANES]; 2];
        let mut signs = theta_dot.map(|v| v.to_bits() & SIGN);
        for k in from..self.n {
            let middle = equation.forcing(spread(&eta[2 * k + 1]));
            let next = equation.forcing(spread(&eta[2 * k + 2]));
            (theta, theta_dot) = rk4::step(
                |x, v, eta| equation.acceleration(x, v, eta),
                rules.h,
                theta,
                theta_dot,
                [now, middle, next],
            );
            now = next;
            for i in 0..LANES {
                let angle = theta[i].abs();
                top[i] = if angle > top[i] { angle } else { top[i] };
                above[i] += if angle > rules.temporal_level { 1.0 } else { 0.0 };
                signs[i] = (signs[i] >> 1) | (theta_dot[i].to_bits() & SIGN);
                self.measured[k + 1][i] = angle;
            }
            self.theta[k + 1] = theta;
            self.theta_dot[k + 1] = theta_dot;
        }
        // A state that is no number stays none: the last one tells of all.
        let mut is_upright = true;
        for i in 0..LANES {
            is_upright &= (top[i] <= rules.capsize_angle) & rules.is_upright(theta[i], theta_dot[i]);
            let start = self.measured[0][i];
            self.top[i] = if start > top[i] { start } else { top[i] };
            self.turns[i] = (signs[i] ^ (signs[i] << 1)) >> (64 - self.n);
        }
        self.above = above;
        is_upright
    }

    /// Sets the ships upright that capsize first after a full step: the step at which they do.
    #[inline(always)]
    fn restart_after(&mut self, from: usize) -> usize {
        if !self.has_capsizes {
            self.capsizes = [0.0; LANES];
            self.has_capsizes = true;
        }
        let rules = self.rules;
        let mut k = from + 1;
        while k < self.n && self.is_upright_at(k) {
            k += 1;
        }
        for i in 0..LANES {
            let is_upright = rules.is_upright(self.theta[k][i], self.theta_dot[k][i]);
            self.capsizes[i] += if is_upright { 0.0 } else { 1.0 };
            self.theta[k][i] = if is_upright { self.theta[k][i] } else { 0.0 };
            self.theta_dot[k][i] = if is_upright { self.theta_dot[k][i] } else { 0.0 };
            self.measured[k][i] = if is_upright {
                self.measured[k][i]
            } else {
                rules.capsize_angle
            };
        }
        k
    }

    /// Whether every ship is upright at a full step.
    #[inline(always)]
    fn is_upright_at(&self, k: usize) -> bool {
        let mut is_upright = true;
        for i in 0..LANES {
            is_upright &= self.rules.is_upright(self.theta[k][i], self.theta_dot[k][i]);
        }
        is_upright
    }

    /// Counts again what restarts have changed.
    #[inline(always)]
    fn recount(&mut self) {
        self.top = self.measured[0];
        self.turns = [0; LANES];
        self.above = [0.0; LANES];
        for k in 0..self.n {
            for i in 0..LANES {
                let angle = self.measured[k + 1][i];
                self.top[i] = if angle > self.top[i] { angle } else { self.top[i] };
                self.above[i] += if angle > self.rules.temporal_level { 1.0 } else { 0.0 };
                let turn = (self.theta_dot[k + 1][i].to_bits() ^ self.theta_dot[k][i].to_bits()) >> 63;
                self.turns[i] |= turn << k;
            }
        }
    }

    /// Measures the roll with its sign: all but capsizes.
    #[inline(always)]
    fn measure_signed(&mut self) {
        self.top = self.measured[0];
        for k in 1..=self.n {
            for i in 0..LANES {
                let (theta, measured) = (self.theta[k][i], self.measured[k][i]);
                let signed = if measured == theta.abs() { theta } else { measured };
                self.top[i] = if signed > self.top[i] { signed } else { self.top[i] };
                self.measured[k][i] = signed;
            }
        }
    }

    /// Takes in the measured roll over the block, both ends included, in every lane.
    #[inline(always)]
    pub(crate) fn raise(&self, since: &mut Since) {
        let Since { largest, held } = since;
        for i in 0..LANES {
            let top = self.top[i];
            largest[i] = if top > largest[i] { top } else { largest[i] };
        }
        let mut found = [(0, 0); LANES];
        let mut count = 0;
        let mut later = 0;
        for lane in 0..LANES {
            let turns = self.turns[lane];
            found[count] = (lane, turns.trailing_zeros() as usize % BLOCK);
            count += usize::from(turns != 0) & usize::from(largest[lane] < f64::INFINITY);
            later |= turns & turns.wrapping_sub(1);
        }
        let mut high = 0;
        for at in 0..count {
            let (lane, k) = found[at];
            found[high] = (lane, k);
            high += usize::from(self.turn(lane, k).most > largest[lane]);
        }
        for (lane, k) in &found[..high] {
            self.turn(*lane, *k)
                .hold(self.rules, &mut held[*lane], &mut largest[*lane]);
        }
        // Rarely does a lane turn twice in one block.
        if later != 0 {
            for lane in 0..LANES {
                self.hold_all(lane, self.turns[lane] & self.turns[lane].wrapping_sub(1), since);
            }
        }
    }

    /// The same in one lane over some steps alone; nothing is taken in if there are none.
    pub(crate) fn raise_within(&self, lane: usize, steps: Range<usize>, since: &mut Since) {
        if steps.is_empty() {
            return;
        }
        let mut largest = since.largest[lane];
        for row in &self.measured[steps.start..=steps.end] {
            largest = if row[lane] > largest { row[lane] } else { largest };
        }
        since.largest[lane] = largest;
        let turns = self.turns[lane] & ((1 << steps.end) - 1) & !((1 << steps.start) - 1);
        self.hold_all(lane, turns, since);
    }

    /// Takes in some turns of a lane.
    fn hold_all(&self, lane: usize, mut turns: u64, since: &mut Since) {
        while turns != 0 {
            let turn = self.turn(lane, turns.trailing_zeros() as usize);
            turn.hold(self.rules, &mut since.held[lane], &mut since.largest[lane]);
            turns &= turns - 1;
        }
    }

    /// The turn of a lane in the k-th step.
    #[inline(always)]
    fn turn(&self, lane: usize, k: usize) -> Turn {
        Turn::new(
            self.rules,
            [self.theta[k][lane], self.theta[k + 1][lane]],
            [self.theta_dot[k][lane], self.theta_dot[k + 1][lane]],
        )
    }
}

/// The largest roll in every lane since some instant.
pub(crate) struct Since {
    /// Of the full steps and some peaks, rad; nothing is taken in at infinity.
    pub(crate) largest: [f64; LANES],
    /// The one turn that may be higher.
    pub(crate) held: [Turn; LANES],
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
