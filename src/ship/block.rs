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
use crate::ship::simulation::{BlockRows, COLUMNS, LANES, Simulation};

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
    /// Clears the sign of an absolute roll, keeps that of a signed one.
    sign_mask: u64,
}

impl Rules {
    pub(crate) fn new(simulation: &Simulation) -> Self {
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
    /// Capsizes in this block.
    pub(crate) capsizes: [f64; LANES],
    /// Whether there are any.
    pub(crate) has_capsizes: bool,
    /// Steps in use.
    pub(crate) n: usize,
    rules: Rules,
}

impl Block {
    /// A block of no steps yet, which ends in the given states.
    #[inline(always)]
    pub(crate) fn starting(rules: Rules, initial: &[RollState]) -> Self {
        let mut block = Self {
            theta: [[0.0; LANES]; BLOCK + 1],
            theta_dot: [[0.0; LANES]; BLOCK + 1],
            measured: [[0.0; LANES]; BLOCK + 1],
            capsizes: [0.0; LANES],
            has_capsizes: false,
            n: 0,
            rules,
        };
        for (lane, state) in initial.iter().enumerate() {
            block.theta[0][lane] = state.theta;
            block.theta_dot[0][lane] = state.theta_dot;
            block.measured[0][lane] = rules.measured(state.theta);
        }
        block
    }

    /// Goes on by n RK4 steps from where the block ended.
    ///
    /// Capsizes are rare: the block is run as if there were none, and again step by step if there are.
    #[inline(always)]
    pub(crate) fn advance<const CUBIC: bool>(
        &mut self,
        equation: &RollEquation<LANES, CUBIC>,
        n: usize,
        eta: &BlockRows,
    ) {
        let rules = self.rules;
        self.theta[0] = self.theta[self.n];
        self.theta_dot[0] = self.theta_dot[self.n];
        self.measured[0] = self.measured[self.n];
        self.n = n;
        let (mut theta, mut theta_dot) = (self.theta[0], self.theta_dot[0]);
        for k in 0..n {
            (theta, theta_dot) = stepped(equation, rules.h, theta, theta_dot, k, eta);
            self.theta[k + 1] = theta;
            self.theta_dot[k + 1] = theta_dot;
        }
        let mut highest = [0.0; LANES];
        for k in 1..=n {
            for i in 0..LANES {
                let angle = self.theta[k][i].abs();
                highest[i] = if angle > highest[i] { angle } else { highest[i] };
                self.measured[k][i] = rules.measured(self.theta[k][i]);
            }
        }
        // A state that is no number stays none: the last one tells of all.
        let mut upright = true;
        for i in 0..LANES {
            upright &= (highest[i] <= rules.capsize_angle) & rules.is_upright(theta[i], theta_dot[i]);
        }
        self.has_capsizes = !upright;
        if !upright {
            self.capsizes = [0.0; LANES];
            self.restart_where_capsized(equation, eta);
        }
    }

    /// The block again from its start, with a restart at every capsize.
    #[inline(always)]
    fn restart_where_capsized<const CUBIC: bool>(&mut self, equation: &RollEquation<LANES, CUBIC>, eta: &BlockRows) {
        let rules = self.rules;
        let (mut theta, mut theta_dot) = (self.theta[0], self.theta_dot[0]);
        for k in 0..self.n {
            (theta, theta_dot) = stepped(equation, rules.h, theta, theta_dot, k, eta);
            for i in 0..LANES {
                let upright = rules.is_upright(theta[i], theta_dot[i]);
                let measured = rules.measured(theta[i]);
                self.measured[k + 1][i] = if upright { measured } else { rules.capsize_angle };
                theta[i] = if upright { theta[i] } else { 0.0 };
                theta_dot[i] = if upright { theta_dot[i] } else { 0.0 };
                self.capsizes[i] += if upright { 0.0 } else { 1.0 };
            }
            self.theta[k + 1] = theta;
            self.theta_dot[k + 1] = theta_dot;
        }
    }

    /// The largest of a roll so far and the measured roll over the block, both ends and all peaks included, in every lane.
    #[inline(always)]
    pub(crate) fn largest(&self, so_far: &[f64; LANES]) -> [f64; LANES] {
        let mut largest = *so_far;
        // The signs of theta_dot, the start's lowest.
        let mut signs = [0; LANES];
        for k in 0..=self.n {
            for i in 0..LANES {
                let measured = self.measured[k][i];
                largest[i] = if measured > largest[i] { measured } else { largest[i] };
                signs[i] = (signs[i] >> 1) | (self.theta_dot[k][i].to_bits() & SIGN);
            }
        }
        let mut turns = [0; LANES];
        for i in 0..LANES {
            turns[i] = (signs[i] ^ (signs[i] << 1)) >> (64 - self.n);
        }
        self.raise_to_peaks(turns, &mut largest);
        largest
    }

    /// Raises the largest roll to the peaks inside the steps at which theta_dot changes sign: bit k of a lane's `turns`.
    #[inline(always)]
    fn raise_to_peaks(&self, mut turns: [u64; LANES], largest: &mut [f64; LANES]) {
        let mut left = 1;
        // Rarely does a lane turn twice in one block: then once more.
        while left != 0 {
            left = 0;
            let mut found = [(0, 0); LANES];
            let mut count = 0;
            for lane in 0..LANES {
                let turn = turns[lane];
                found[count] = (lane, turn.trailing_zeros() as usize % BLOCK);
                count += usize::from(turn != 0);
                turns[lane] = turn & turn.wrapping_sub(1);
                left |= turns[lane];
            }
            let mut high = 0;
            for at in 0..count {
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

    /// The largest measured roll over some steps of one lane, both ends and all peaks included.
    #[inline(always)]
    pub(crate) fn largest_over(&self, lane: usize, steps: std::ops::Range<usize>) -> f64 {
        let mut largest = f64::NEG_INFINITY;
        for k in steps {
            let (start, end) = (self.measured[k][lane], self.measured[k + 1][lane]);
            largest = if start > largest { start } else { largest };
            largest = if end > largest { end } else { largest };
            let signs = self.theta_dot[k][lane].to_bits() ^ self.theta_dot[k + 1][lane].to_bits();
            if signs & SIGN != 0 {
                let [peak] = self.peaks([(lane, k)]);
                largest = if peak > largest { peak } else { largest };
            }
        }
        largest
    }

    /// The number of full steps, the start left out, with |theta| above a level; a capsize is above.
    #[inline(always)]
    pub(crate) fn time_above(&self, level: f64) -> [f64; LANES] {
        let mut count = [0.0; LANES];
        for k in 1..=self.n {
            for i in 0..LANES {
                count[i] += if self.theta[k][i].abs() > level { 1.0 } else { 0.0 };
            }
        }
        if self.has_capsizes && self.rules.capsize_angle > level {
            for i in 0..LANES {
                count[i] += self.capsizes[i];
            }
        }
        count
    }
}

/// One RK4 step from the k-th full step of a block.
#[inline(always)]
fn stepped<const CUBIC: bool>(
    equation: &RollEquation<LANES, CUBIC>,
    h: f64,
    theta: [f64; LANES],
    theta_dot: [f64; LANES],
    k: usize,
    eta: &BlockRows,
) -> ([f64; LANES], [f64; LANES]) {
    let forcing = [spread(&eta[2 * k]), spread(&eta[2 * k + 1]), spread(&eta[2 * k + 2])];
    rk4::step(
        |x, v, eta| equation.acceleration(x, v, eta),
        h,
        theta,
        theta_dot,
        forcing,
    )
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
