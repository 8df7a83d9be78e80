//! What the fixed step of RK4 resolves: where the integration of Eq. (6) is stable, and where its error is small.
//!
//! | symbol | code | unit | meaning |
//! |---|---|---|---|
//! | h | `h` | s | RK4 step, two samples of the elevation |
//! | - | `rate` | 1/s | the fastest rate of a motion: the modulus of its eigenvalue |
//! | - | `highest` | m | the highest crest that can be expected |
//!
//! ```text
//! linear about a state:  x'' + c x' + k x = 0,  rate = sqrt(k) if c^2 <= 4 k, else c/2 + sqrt(c^2/4 - k)
//! stiffness:             k = beta_1 + epsilon_1 eta + 3 beta_2 theta^2, largest at the highest crest
//! damping:               c = alpha_1 + 1.12 alpha_2 v^2 (cubic) or alpha_1 + 1.12 alpha_2 |v| (quadratic)
//! ```
//! RK4 is stable for h rate up to 2.828 on the imaginary axis and up to 2.785 on the negative real axis, but between them,
//! where a swing is damped by half, up to 2.616 alone: the half disc of radius 2.61 lies within its region. With a
//! larger step the computed motion grows even when the true motion does not, and the growth would be counted as capsizes. The factor 1.12 stands for RK4 of
//! v' = -alpha_2 v^3, which grows beyond h alpha_2 v^2 = 2.38 (quadratic: 2.45), a little above 2.61/1.12. Motions whose
//! stiffness is negative grow in truth, so they set no limit.
//!
//! The error of r, relative, as its median over 3,360 windows of 120 fields in S1 and S2, both ships, against T_p/256:
//!
//! | h | T_p/128 | T_p/64 | T_p/32 | T_p/16 | T_p/8 |
//! |---|---|---|---|---|---|
//! | h rate | 0.05 | 0.10 | 0.20 | 0.39 | 0.79 |
//! | error of r | 2e-7 | 3e-6 | 5e-5 | 9e-4 | 2e-2 |
//!
//! It is 0.04 (h rate)^4. In the tail P changes by some 30 times the relative change of r, and the standard error of P over
//! the paper's record is about one per cent of P: the test of Decision 3 holds up to h rate = 0.3. From 0.25 on a run
//! warns. Tested in `tests/physics/resolution.rs` against runs in waves of a millimetre.

use crate::ship::roll_equation::{Damping, Ship};
use std::f64::consts::{PI, TAU};

/// Largest h rate at which RK4 is stable, for every angle of the eigenvalue.
pub const STABLE: f64 = 2.61;
/// Largest h rate at which the error of P stays below its standard error over the paper's record.
pub const ACCURATE: f64 = 0.25;
/// The highest crest in H_s: by Rayleigh's law one crest in exp(8 x 1.5^2) = 6.6e7 is higher, one in eight of the
/// paper's records.
const CREST: f64 = 1.5;
/// The factor of alpha_2 v^2 with which the limit of linear motion also covers the nonlinear damping under RK4, see above.
const SECANT: f64 = 1.12;
/// The lead-in has to be this many memories long: what a start at rest leaves then is e^-2 of the motion.
const FORGOTTEN: f64 = 2.0;
/// A field has to be this many memories long, so that the ship does not meet its own past in the periodic record.
const MEMORIES: f64 = 5.0;
/// The swing at which the memory is measured, rad: with no linear damping the nonlinear one alone forgets.
const SWING: f64 = 0.5;
/// The swing up to which the error is looked at, rad: thresholds lie below it.
const LARGE_SWING: f64 = 1.0;

/// The grid of a run in one sea.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Grid {
    /// T_p, s.
    pub t_p: f64,
    /// H_s, m.
    pub h_s: f64,
    /// The highest amplitude of a group that is met beside the sea's own waves, m; 0 for none.
    pub highest_group: f64,
    /// Samples of the elevation per T_p.
    pub samples_per_period: u32,
    /// The most samples per T_p that a field may have.
    pub most_samples: u32,
    /// T_f, s.
    pub field_period: f64,
    /// `[record] lead_in`, s.
    pub lead_in: f64,
}

impl Grid {
    /// The RK4 step, s.
    fn h(&self) -> f64 {
        2.0 * self.t_p / f64::from(self.samples_per_period)
    }

    /// The highest crest, m.
    fn crest(&self) -> f64 {
        let of_sea = CREST * self.h_s;
        if self.highest_group > of_sea {
            self.highest_group
        } else {
            of_sea
        }
    }

    /// The smallest allowed `samples_per_period`, a power of two, at which h rate is at most a limit.
    fn samples_for(&self, rate: f64, limit: f64) -> Option<u32> {
        let mut samples = self.samples_per_period;
        while 2.0 * self.t_p * rate > limit * f64::from(samples) {
            samples = samples.checked_mul(2).filter(|samples| *samples <= self.most_samples)?;
        }
        Some(samples)
    }
}

/// The modulus of the larger eigenvalue of x'' + c x' + k x = 0 for k >= 0, 1/s.
fn rate(c: f64, k: f64) -> f64 {
    let discriminant = 0.25 * c * c - k;
    if discriminant > 0.0 {
        0.5 * c + discriminant.sqrt()
    } else {
        k.sqrt()
    }
}

/// The largest stiffness up to an angle at the highest crest, 1/s^2.
fn stiffness(ship: &Ship, crest: f64, angle: f64) -> f64 {
    let hardening = if ship.beta_2 > 0.0 {
        3.0 * ship.beta_2 * angle * angle
    } else {
        0.0
    };
    let parametric = ship
        .epsilon_1
        .iter()
        .fold(0.0, |most, e| if *e > most { *e } else { most });
    ship.beta_1 + parametric * crest + hardening
}

/// The damping moment per inertia at a roll velocity, 1/s^2.
fn resistance(ship: &Ship, v: f64) -> f64 {
    (ship.alpha_1 + ship.alpha_2 * power(ship, v)) * v
}

/// v^2 or v, as the damping form says.
fn power(ship: &Ship, v: f64) -> f64 {
    match ship.damping {
        Damping::Cubic => v * v,
        Damping::Quadratic => v,
    }
}

/// The largest swing that waves can keep up in a well that hardens, rad: there the damping takes in a cycle what the
/// excitation can give at most.
///
/// ```text
/// taken  pi omega x^2 (alpha_1 + 3/4 alpha_2 omega^2 x^2)       quadratic: 8/(3 pi) alpha_2 omega x
/// given  4 epsilon_2 eta x + 2 epsilon_1 eta x^2                twice this, since crests vary
/// ```
fn reach(ship: &Ship, crest: f64, capsize_angle: f64) -> f64 {
    let parametric = stiffness(ship, crest, 0.0) - ship.beta_1;
    let direct = ship.epsilon_2.abs() * crest;
    let is_kept_up = |x: f64| {
        let omega = (ship.beta_1 + 0.75 * ship.beta_2 * x * x).sqrt();
        let taken = PI * omega * x * x * balanced(ship, omega * x);
        taken <= 2.0 * (4.0 * direct * x + 2.0 * parametric * x * x)
    };
    if is_kept_up(capsize_angle) {
        return capsize_angle;
    }
    halved(capsize_angle, |x| !is_kept_up(x))
}

/// The linear damping that takes as much as the ship's own at a velocity of this amplitude, 1/s, by harmonic balance.
fn balanced(ship: &Ship, v: f64) -> f64 {
    let share = match ship.damping {
        Damping::Cubic => 0.75,
        Damping::Quadratic => 8.0 / (3.0 * PI),
    };
    ship.alpha_1 + share * ship.alpha_2 * power(ship, v)
}

/// The least of the numbers up to `high` that are too large, which holds of `high` and of all above the least.
fn halved(mut high: f64, is_too_large: impl Fn(f64) -> bool) -> f64 {
    let mut low = 0.0;
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if is_too_large(middle) {
            high = middle;
        } else {
            low = middle;
        }
    }
    high
}

/// The largest roll velocity that can be expected, rad/s: that of a swing from rest at the rim of the well through all of
/// it, helped by the direct excitation all the way, and never above the velocity at which the damping holds every moment.
///
/// Past the rim of a softening well the ship is capsizing, whatever its damping then does.
fn velocity(ship: &Ship, crest: f64, capsize_angle: f64) -> f64 {
    let k = stiffness(ship, crest, 0.0);
    let beta_2 = ship.beta_2;
    let rim = if beta_2 < 0.0 {
        (k / -beta_2).sqrt()
    } else {
        reach(ship, crest, capsize_angle)
    };
    let rim = if rim < capsize_angle { rim } else { capsize_angle };
    // The moment of a softening well is largest where its slope vanishes.
    let steepest = if beta_2 < 0.0 {
        (k / (-3.0 * beta_2)).sqrt()
    } else {
        rim
    };
    let steepest = if steepest < rim { steepest } else { rim };
    let direct = ship.epsilon_2.abs() * crest;
    let moment = (k + beta_2 * steepest * steepest) * steepest + direct;
    let energy = (0.5 * k + 0.25 * beta_2 * rim * rim) * rim * rim + 2.0 * direct * rim;
    let free = (2.0 * energy).sqrt();
    if resistance(ship, free) <= moment {
        return free;
    }
    halved(free, |v| resistance(ship, v) > moment)
}

/// The fastest rate of a ship's motion up to an angle, 1/s: of its stiffness or of its damping.
fn fastest(ship: &Ship, crest: f64, angle: f64, capsize_angle: f64) -> f64 {
    let k = stiffness(ship, crest, angle);
    let nonlinear = SECANT * ship.alpha_2 * power(ship, velocity(ship, crest, capsize_angle));
    let (swinging, sliding) = (rate(ship.alpha_1, k), ship.alpha_1 + nonlinear);
    if swinging > sliding { swinging } else { sliding }
}

/// Refuses a step at which RK4 is unstable for the ship anywhere up to its capsize angle.
///
/// # Errors
/// `record.samples_per_period: expected .., found ..`, with the number that would do.
pub fn check(ship: &Ship, capsize_angle: f64, grid: &Grid) -> Result<(), String> {
    let rate = fastest(ship, grid.crest(), capsize_angle, capsize_angle);
    let (h, found) = (grid.h(), grid.samples_per_period);
    if h * rate <= STABLE {
        return Ok(());
    }
    if !rate.is_finite() {
        return Err(format!(
            "record.samples_per_period: expected a ship whose motion has a finite rate, since no step resolves another, found \
             {}, `truth.capsize_angle` = {capsize_angle:e}, `sea.significant_wave_height` = {:?}, `sea.peak_period` = {:?}",
            told(ship, rate),
            short(grid.h_s),
            short(grid.t_p)
        ));
    }
    let expected = match (grid.samples_for(rate, STABLE), grid.samples_for(rate, ACCURATE)) {
        (Some(stable), Some(accurate)) => {
            format!("expected at least {stable} for a stable integration, or {accurate} for an accurate one")
        }
        (Some(stable), None) => format!("expected at least {stable} for a stable integration"),
        (None, _) => format!(
            "expected more samples than a field may have ({} per period), so a slower ship or a shorter `sea.peak_period`",
            grid.most_samples
        ),
    };
    Err(format!(
        "record.samples_per_period: {expected}, found {found}: the step of {h} s (`sea.peak_period` = {:?}) times the fastest rate \
         of the ship, {}, `sea.significant_wave_height` = {:?}, `truth.capsize_angle` = {:?}, must be at most {STABLE}, or the \
         integration itself grows",
        short(grid.t_p),
        told(ship, rate),
        short(grid.h_s),
        short(capsize_angle)
    ))
}

/// What a stable run resolves poorly: `key: expected .., found ..` each.
pub fn warnings(ship: &Ship, capsize_angle: f64, grid: &Grid) -> Vec<String> {
    let swing = if capsize_angle < LARGE_SWING {
        capsize_angle
    } else {
        LARGE_SWING
    };
    let of_ship = fastest(ship, grid.crest(), swing, capsize_angle);
    let of_waves = TAU / grid.t_p;
    let (rate, whose) = if of_ship > of_waves {
        (of_ship, told(ship, of_ship))
    } else {
        (of_waves, format!("2 pi/`sea.peak_period` = {} 1/s", short(of_waves)))
    };
    let mut warnings = Vec::new();
    let (h, found) = (grid.h(), grid.samples_per_period);
    if h * rate > ACCURATE {
        let enough = grid.samples_for(rate, ACCURATE);
        let expected = enough.map_or_else(
            || format!("more than a field may have, {}", grid.most_samples),
            |enough| format!("at least {enough}"),
        );
        warnings.push(format!(
            "record.samples_per_period: expected {expected}, found {found}: the step of {h} s times the fastest rate, \
             {whose}, is above {ACCURATE}, so the error of a probability may exceed its standard error"
        ));
    }
    warnings.extend(forgetting(ship, grid));
    warnings
}

/// Whether the lead-in and the field are long against the ship's memory.
fn forgetting(ship: &Ship, grid: &Grid) -> Vec<String> {
    // Harmonic balance of the damping at a swing of the natural frequency.
    let memory = 2.0 / balanced(ship, SWING * ship.beta_1.sqrt());
    let forgets = if memory.is_finite() {
        format!(
            "the ship forgets within 2/alpha = {} s (`ship.alpha_1`, `ship.alpha_2`)",
            short(memory)
        )
    } else {
        "the ship has no damping and forgets nothing (`ship.alpha_1`, `ship.alpha_2`)".to_owned()
    };
    let mut warnings = Vec::new();
    if grid.lead_in < FORGOTTEN * memory {
        let (expected, found) = (short(FORGOTTEN * memory), grid.lead_in);
        warnings.push(format!(
            "record.lead_in: expected at least {expected} s, found {found}: {forgets}, so the start at rest is still felt"
        ));
    }
    if grid.field_period < MEMORIES * memory {
        let periods = short(MEMORIES * memory / grid.t_p);
        let found = short(grid.field_period / grid.t_p);
        warnings.push(format!(
            "record.periods_per_field: expected at least {periods}, found {found}: {forgets}, and meets its own past in a \
             field that repeats so soon"
        ));
    }
    warnings
}

/// Whether the modes resolve the resonance of a linear oscillator whose damping is alpha (1/s): between two of them its
/// response would depend on where they happen to lie.
pub fn of_oscillator(alpha: f64, delta_omega: f64) -> Option<String> {
    (alpha < delta_omega).then(|| {
        let periods = short(delta_omega / alpha);
        format!(
            "record.periods_per_field: expected at least {periods} times as many: the oscillator's resonance is {} rad/s wide \
             (`ship.alpha_1`, `ship.alpha_2`), the modes lie {} rad/s apart",
            short(alpha),
            short(delta_omega)
        )
    })
}

/// The fastest rate and where it comes from.
fn told(ship: &Ship, rate: f64) -> String {
    let damping = if ship.damping == Damping::Cubic {
        "cubic"
    } else {
        "quadratic"
    };
    format!(
        "{:?} 1/s (`ship.beta_1` = {:?}, `beta_2` = {:?}, `epsilon_1` up to {:?}, `epsilon_2` = {:?}, `alpha_1` = {:?}, {damping} \
         `alpha_2` = {:?})",
        short(rate),
        short(ship.beta_1),
        short(ship.beta_2),
        short(ship.epsilon_1.last().copied().unwrap_or_default()),
        short(ship.epsilon_2),
        short(ship.alpha_1),
        short(ship.alpha_2),
    )
}

/// A number with three significant digits.
fn short(value: f64) -> f64 {
    format!("{value:.2e}").parse().unwrap_or(value)
}
