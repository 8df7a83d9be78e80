//! What is measured of the roll, and its peaks between full steps.
//!
//! Where theta_dot changes sign inside a step the roll has the extremum of the cubic Hermite interpolant, at most
//! capsize_angle. Of all turns of a lane between two bounds the highest alone is evaluated, at the end: two cannot be told
//! apart by their bounds but rarely.
//!
//! Tested through `tests/physics/{response,encounter}.rs` against a scalar twin that evaluates all.

use crate::numerics::hermite;
use crate::ship::response::Roll;
use crate::ship::simulation::Simulation;

/// What the inner loops need of [`Simulation`].
#[derive(Clone, Copy)]
pub(crate) struct Rules {
    pub(crate) h: f64,
    pub(crate) capsize_angle: f64,
    pub(crate) temporal_level: f64,
    pub(crate) is_signed: bool,
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
    pub(crate) fn is_upright(self, theta: f64, theta_dot: f64) -> bool {
        (theta.abs() <= self.capsize_angle) & (theta_dot.abs() <= f64::MAX)
    }

    /// The roll that is compared with thresholds, of a roll angle.
    #[inline(always)]
    pub(crate) fn measured(self, theta: f64) -> f64 {
        if self.is_signed { theta } else { theta.abs() }
    }
}

/// A step inside which theta_dot changes sign.
#[derive(Clone, Copy)]
pub(crate) struct Turn {
    // Of both ends.
    theta: [f64; 2],
    theta_dot: [f64; 2],
    /// A bound of the measured peak.
    pub(crate) most: f64,
}

impl Turn {
    /// No turn.
    pub(crate) const NONE: Self = Self {
        theta: [0.0; 2],
        theta_dot: [0.0; 2],
        most: f64::NEG_INFINITY,
    };

    /// The turn between two states.
    #[inline(always)]
    pub(crate) fn new(rules: Rules, theta: [f64; 2], theta_dot: [f64; 2]) -> Self {
        let ([x_0, x_1], [v_0, v_1]) = (theta, theta_dot);
        let (start, end) = (rules.measured(x_0), rules.measured(x_1));
        let higher = if start > end { start } else { end };
        // The cubic's two slopes lift it by h (|v_0| + |v_1|) 4/27 at most: rounded up, and the last term stands for rounding.
        let most = higher + 0.15 * rules.h * (v_0.abs() + v_1.abs()) + 1e-12 * (x_0.abs() + x_1.abs());
        Self { theta, theta_dot, most }
    }

    /// The larger of a roll so far and the measured peak.
    pub(crate) fn raise(&self, rules: Rules, largest: f64) -> f64 {
        if self.most <= largest {
            return largest;
        }
        let [peak] = hermite::extremum(rules.h, self.theta.map(|x| [x]), self.theta_dot.map(|v| [v]));
        let there = rules.measured(peak);
        let peak = if there > rules.capsize_angle {
            rules.capsize_angle
        } else {
            there
        };
        if peak > largest { peak } else { largest }
    }

    /// Takes the place of a turn that was held, if it can be above the largest roll so far: both peaks, this one held back.
    #[inline(always)]
    pub(crate) fn hold(self, rules: Rules, held: &mut Self, largest: &mut f64) {
        if self.most > *largest {
            *largest = held.raise(rules, *largest);
            *held = self;
        }
    }
}
