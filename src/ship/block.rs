//! A block of roll: up to sixteen RK4 steps of 24 lanes, and the largest roll over each of them.
//!
//! A capsize is !(|theta| <= capsize_angle) at a full step: the ship is set upright at rest and goes on, and the roll
//! measured at that instant is capsize_angle. The instant is the end of one step and the start of the next. An overflowed
//! state is a capsize too: no NaN and no infinity gets out.
//!
//! The largest roll over a step takes in both ends and, where theta_dot changes sign, the extremum of the cubic Hermite
//! interpolant between them, at most capsize_angle.
//!
//! Tested through `tests/physics/{response,encounter}.rs` against a scalar twin, bit for bit, at every level.

use crate::numerics::{hermite, rk4};
use crate::ship::initial_condition::RollState;
use crate::ship::response::Roll;
use crate::ship::roll_equation::RollEquation;
use crate::ship::simulation::{BlockRows, COLUMNS, EPSILONS, LANES, Simulation};
use std::ops::Range;

/// Steps of a block.
pub(crate) const BLOCK: usize = 16;
/// Peaks evaluated side by side.
const AT_ONCE: usize = 8;
/// The sign of a number.
const SIGN: u64 = 1 << 63;

/// What the inner loops need of [`Simulation`].
#[derive(Clone, Copy)]
pub(crate) struct Rules {
    h: f64,
    capsize_angle: f64,
    temporal_level: f64,
    is_signed: bool,
}

impl Rules {
    pub(crate) fn new(simulation: &Simulation) -> Self {
        Self {
            h: simulation.h,
            capsize_angle: simulation.truth.capsize_angle,
            temporal_level: simulation.truth.temporal_level,
            is_signed: simulation.truth.roll == Roll::Signed,
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
        if self.is_signed { theta } else { theta.abs() }
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

    /// The largest of a roll so far and the measured roll over the block, both ends and all peaks included, in every lane.
    #[inline(always)]
    pub(crate) fn largest(&self, so_far: &[f64; LANES]) -> [f64; LANES] {
        let mut largest = *so_far;
        for i in 0..LANES {
            largest[i] = if self.top[i] > largest[i] {
                self.top[i]
            } else {
                largest[i]
            };
        }
        self.raise_to_peaks(&self.turns, &mut largest);
        largest
    }

    /// The same in some lanes over some steps alone; nothing is taken in if there are none.
    pub(crate) fn largest_within<const L: usize>(
        &self,
        lanes: [usize; L],
        steps: Range<usize>,
        so_far: [f64; L],
    ) -> [f64; L] {
        let mut largest = so_far;
        if steps.is_empty() {
            return largest;
        }
        for row in &self.measured[steps.start..=steps.end] {
            for (largest, lane) in largest.iter_mut().zip(lanes) {
                *largest = if row[lane] > *largest { row[lane] } else { *largest };
            }
        }
        for (largest, lane) in largest.iter_mut().zip(lanes) {
            let turns = self.turns[lane] & ((1 << steps.end) - 1) & !((1 << steps.start) - 1);
            *largest = self.raised(lane, turns, *largest);
        }
        largest
    }

    /// Raises the largest roll to the peaks inside the steps at which theta_dot changes sign: bit k of a lane's `turns`.
    ///
    /// A largest roll of infinity is let alone.
    #[inline(always)]
    fn raise_to_peaks(&self, turns: &[u64; LANES], largest: &mut [f64; LANES]) {
        let mut found = [(0, 0); LANES];
        let mut count = 0;
        let mut again = 0;
        for lane in 0..LANES {
            let turns = turns[lane];
            found[count] = (lane, turns.trailing_zeros() as usize % BLOCK);
            count += usize::from((turns != 0) & (largest[lane] < f64::INFINITY));
            again |= turns & turns.wrapping_sub(1);
        }
        self.raise_to_some(&mut found[..count], largest);
        // Rarely does a lane turn twice in one block.
        if again != 0 {
            for lane in 0..LANES {
                largest[lane] = self.raised(lane, turns[lane] & turns[lane].wrapping_sub(1), largest[lane]);
            }
        }
    }

    /// The largest of a roll so far and the peaks of some turns of a lane.
    fn raised(&self, lane: usize, mut turns: u64, mut largest: f64) -> f64 {
        while turns != 0 {
            let k = turns.trailing_zeros() as usize;
            if self.highest_peak(lane, k) > largest {
                let [peak] = self.peaks([(lane, k)]);
                largest = if peak > largest { peak } else { largest };
            }
            turns &= turns - 1;
        }
        largest
    }

    /// Raises the largest roll to the peaks of some turns, (lane, step), a lane once at most.
    #[inline(always)]
    fn raise_to_some(&self, found: &mut [(usize, usize)], largest: &mut [f64; LANES]) {
        let mut high = 0;
        for at in 0..found.len() {
            let (lane, k) = found[at];
            found[high] = (lane, k);
            high += usize::from(self.highest_peak(lane, k) > largest[lane]);
        }
        for first in (0..high).step_by(AT_ONCE) {
            let mut places = [found[first]; AT_ONCE];
            for (place, turn) in places.iter_mut().zip(&found[first..high]) {
                *place = *turn;
            }
            let peaks = self.peaks(places);
            for (peak, (lane, _)) in peaks.into_iter().zip(places) {
                largest[lane] = if peak > largest[lane] { peak } else { largest[lane] };
            }
        }
    }

    /// A bound of the measured extremum inside a step: the cubic's two slopes lift it by h (|v_0| + |v_1|) 4/27 at most.
    #[inline(always)]
    fn highest_peak(&self, lane: usize, k: usize) -> f64 {
        let ([x_0, x_1], [v_0, v_1]) = (
            [self.theta[k][lane], self.theta[k + 1][lane]],
            [self.theta_dot[k][lane], self.theta_dot[k + 1][lane]],
        );
        let (start, end) = (self.rules.measured(x_0), self.rules.measured(x_1));
        let higher = if start > end { start } else { end };
        // Both terms are rounded up, the second stands for rounding.
        higher + 0.15 * self.rules.h * (v_0.abs() + v_1.abs()) + 1e-12 * (x_0.abs() + x_1.abs())
    }

    /// The measured extrema inside some steps, (lane, step), at most capsize_angle.
    #[inline(always)]
    fn peaks<const L: usize>(&self, places: [(usize, usize); L]) -> [f64; L] {
        let [mut x, mut v] = [[[0.0; L]; 2]; 2];
        for (j, (lane, k)) in places.into_iter().enumerate() {
            for end in 0..2 {
                x[end][j] = self.theta[k + end][lane];
                v[end][j] = self.theta_dot[k + end][lane];
            }
        }
        let mut peaks = hermite::extremum(self.rules.h, x, v);
        for peak in &mut peaks {
            let there = self.rules.measured(*peak);
            *peak = if there > self.rules.capsize_angle {
                self.rules.capsize_angle
            } else {
                there
            };
        }
        peaks
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
