//! The slow, obvious twin of roll in lanes: one ship, one scalar loop, the whole trajectory kept.

use encounter::ship::response::{Capsize, Roll, Truth, temporal_levels};
use encounter::ship::roll_equation::{Damping, Ship};

/// The ship as the paper prints it.
pub(crate) fn printed() -> Ship {
    Ship {
        alpha_1: 0.01,
        alpha_2: 0.052,
        damping: Damping::Cubic,
        beta_1: 0.1175,
        beta_2: -0.09,
        epsilon_1: vec![0.0, 0.02, 0.04],
        epsilon_2: 0.004,
    }
}

/// The `[truth]` table of the paper profile.
pub(crate) fn truth() -> Truth {
    Truth {
        window: 2.0,
        roll: Roll::Absolute,
        capsize_angle: std::f64::consts::PI,
        capsize: Capsize::Restart,
        temporal_level: 0.25,
        temporal_levels: temporal_levels(),
    }
}

/// Eq. (6), written once more.
pub(crate) fn acceleration(ship: &Ship, epsilon_1: f64, x: f64, v: f64, eta: f64) -> f64 {
    let power = match ship.damping {
        Damping::Cubic => v * v,
        Damping::Quadratic => v.abs(),
    };
    let damping = (ship.alpha_1 + ship.alpha_2 * power) * v;
    let restoring = (ship.beta_1 + epsilon_1 * eta + ship.beta_2 * (x * x)) * x;
    ship.epsilon_2 * eta - damping - restoring
}

/// A run at rest or from a state, full step by full step.
pub(crate) struct Trajectory {
    /// The first full step.
    pub(crate) start: i64,
    /// States after a possible restart.
    pub(crate) states: Vec<(f64, f64)>,
    /// Roll as measured, capsize_angle at a capsize.
    pub(crate) measured: Vec<f64>,
    /// The peak inside each step, if any.
    pub(crate) peaks: Vec<Option<f64>>,
    /// Full steps at which the ship capsized.
    pub(crate) capsizes: Vec<i64>,
}

impl Trajectory {
    /// Integrates over full steps start..end; `eta(j)` is the elevation at j h/2.
    pub(crate) fn run(
        (ship, epsilon_1, truth, h): (&Ship, f64, &Truth, f64),
        start: i64,
        end: i64,
        state: (f64, f64),
        eta: impl Fn(i64) -> f64,
    ) -> Self {
        let measure = |x: f64| if truth.roll == Roll::Absolute { x.abs() } else { x };
        let f = |x, v, eta| acceleration(ship, epsilon_1, x, v, eta);
        let (mut x, mut v) = state;
        let mut t = Self {
            start,
            states: vec![state],
            measured: vec![measure(x)],
            peaks: Vec::new(),
            capsizes: Vec::new(),
        };
        for s in start..end {
            let e = [eta(2 * s), eta(2 * s + 1), eta(2 * s + 2)];
            let k1 = f(x, v, e[0]);
            let (x2, v2) = (x + 0.5 * h * v, v + 0.5 * h * k1);
            let k2 = f(x2, v2, e[1]);
            let (x3, v3) = (x + 0.5 * h * v2, v + 0.5 * h * k2);
            let k3 = f(x3, v3, e[1]);
            let (x4, v4) = (x + h * v3, v + h * k3);
            let k4 = f(x4, v4, e[2]);
            let mut x_new = x + h / 6.0 * (v + 2.0 * (v2 + v3) + v4);
            let mut v_new = v + h / 6.0 * (k1 + 2.0 * (k2 + k3) + k4);
            if x_new.abs() <= truth.capsize_angle && v_new.is_finite() {
                t.measured.push(measure(x_new));
            } else {
                (x_new, v_new) = (0.0, 0.0);
                t.measured.push(truth.capsize_angle);
                t.capsizes.push(s + 1);
            }
            let peak = peak(h, x, v, x_new, v_new).map(|p| measure(p).min(truth.capsize_angle));
            t.peaks.push(peak);
            t.states.push((x_new, v_new));
            (x, v) = (x_new, v_new);
        }
        t
    }

    /// The largest roll in [centre - reach, centre + reach].
    pub(crate) fn largest(&self, first: i64, last: i64) -> f64 {
        let (first, last) = ((first - self.start) as usize, (last - self.start) as usize);
        let ends = self.measured[first..=last].iter().copied();
        let inside = self.peaks[first..last].iter().filter_map(|p| *p);
        ends.chain(inside).fold(f64::NEG_INFINITY, f64::max)
    }
}

/// The extremum of the cubic Hermite interpolant where the velocity changes sign.
pub(crate) fn peak(h: f64, x0: f64, v0: f64, x1: f64, v1: f64) -> Option<f64> {
    if !(v0 < 0.0 && v1 > 0.0 || v0 > 0.0 && v1 < 0.0) {
        return None;
    }
    let (p, q, d) = (h * v0, h * v1, x1 - x0);
    let (a, b) = (3.0 * (p + q) - 6.0 * d, 6.0 * d - 4.0 * p - 2.0 * q);
    let root = (b * b - 4.0 * a * p).max(0.0).sqrt();
    let u = 2.0 * p.abs() / (root - if p > 0.0 { b } else { -b });
    let u = u.clamp(0.0, 1.0);
    Some(x0 + u * (p + u * ((3.0 * d - 2.0 * p - q) + u * (p + q - 2.0 * d))))
}
