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
use crate::ship::simulation::{COLUMNS, LANES, Simulation};

/// Steps of a block.
pub(crate) const BLOCK: usize = 16;

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
    pub(crate) fn starting(rules: Rules, initial: &[RollState]) -> Self {
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
    pub(crate) fn advance<const CUBIC: bool>(
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
    pub(crate) fn find_maxima(&mut self, rules: Rules) {
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
