//! What modes and grids resolve of a sea: whether the modes hold its spectrum, and whether the detection can see its groups.
//!
//! | symbol | code | unit | meaning |
//! |---|---|---|---|
//! | K | `bandwidth` | rad/s | width of the spectrum |
//! | delta omega | `delta_omega` | rad/s | spacing of the modes, 2 pi/T_f |
//! | L | `length` | s | mean length of a group, 0.68/K by the groups of S1 and S2 |
//!
//! Nothing here is unstable, so all of it warns. A field holds T_f/L = 9 K/delta_omega lengths of a group. The groups of S1
//! are 33 s long, 0.67/K, those of S2 23 s, 0.70/K. Tested in `tests/physics/resolution.rs`.

use crate::numerics::fourier::LONGEST;
use crate::sea::detection::Detection;
use crate::sea::spectrum::{Form, Sea};
use crate::sea::wave_field::Record;

/// The spectrum's width is this many spacings of the modes at least; S1 has 12.
const SPACINGS: f64 = 6.0;
/// The share of the variance that may lie outside the modes; JONSWAP has 0.24 % beyond 4 omega_p.
const OUTSIDE: f64 = 0.01;
/// Mean length of a group times K.
const LENGTH: f64 = 0.68;
/// How far beyond the modes the rest of a spectrum is looked for, in their range.
const BEYOND: u32 = 8;

/// What the modes of a record resolve poorly of a sea: `key: expected .., found ..` each.
pub fn of_modes(sea: &Sea, record: &Record) -> Vec<String> {
    let delta_omega = sea.omega_p() / f64::from(record.periods_per_field);
    let width = width(sea);
    let mut warnings = Vec::new();
    let spacings = width / delta_omega;
    if spacings < SPACINGS {
        let mut enough = record.periods_per_field;
        while width * f64::from(enough) < SPACINGS * sea.omega_p() && enough < 1 << 30 {
            enough *= 2;
        }
        let (found, spacings) = (record.periods_per_field, short(spacings));
        warnings.push(format!(
            "record.periods_per_field: expected at least {enough}, found {found}: `sea.spectrum` is {spacings} spacings of the \
             modes wide, so few modes make all the waves of a field and its crests are too low"
        ));
    }
    let outside = outside(sea, record.modes, delta_omega);
    if outside > OUTSIDE {
        let doubled = std::iter::successors(Some(record.modes), |modes| modes.checked_mul(2));
        let enough = doubled
            .take_while(|modes| *modes as usize <= LONGEST)
            .find(|modes| self::outside(sea, *modes, delta_omega) <= OUTSIDE);
        let expected = enough.map_or_else(
            || "a spectrum that modes can hold".to_owned(),
            |modes| format!("at least {modes}"),
        );
        let (found, share) = (record.modes, short(100.0 * outside));
        let up_to = short(f64::from(found) * delta_omega);
        warnings.push(format!(
            "record.modes: expected {expected}, found {found}, up to {up_to} rad/s: {share} % of the variance of \
             `sea.spectrum` lies outside them and is shared out within"
        ));
    }
    warnings
}

/// Whether the groups that a Gaussian spectrum makes lie within the lengths that a detection looks for; `spacing` is that
/// of the envelope in s.
pub fn of_detection(bandwidth: Option<f64>, spacing: f64, detection: &Detection) -> Option<String> {
    let length = LENGTH / bandwidth? / spacing;
    let found = short(length);
    let (shortest, longest) = (detection.shortest, detection.longest);
    if length < shortest {
        return Some(format!(
            "detection.shortest: expected less than {found} envelope samples, the mean length of a group at \
             `sea.bandwidth`, found {shortest}: most groups are too short to be detected"
        ));
    }
    (length > longest).then(|| {
        format!(
            "detection.longest: expected more than {found} envelope samples, the mean length of a group at \
             `sea.bandwidth`, found {longest}: most groups are too long to be detected"
        )
    })
}

/// The width of a spectrum about its peak, rad/s.
fn width(sea: &Sea) -> f64 {
    match sea.spectrum {
        Form::Gaussian => sea.bandwidth.unwrap_or_default(),
        Form::Jonswap => sea.peak_width() * sea.omega_p(),
    }
}

/// The share of a spectrum's variance beyond the modes.
fn outside(sea: &Sea, modes: u32, delta_omega: f64) -> f64 {
    // A step that resolves the peak and does not cost more for more modes.
    let step = 0.25 * width(sea).min(0.1 * sea.omega_p());
    let range = f64::from(modes) * delta_omega;
    let places = (f64::from(BEYOND) * range / step).min(20_000.0);
    let step = f64::from(BEYOND) * range / places;
    let (mut inside, mut all) = (0.0, 0.0);
    for i in 0..places as u32 {
        let omega = (f64::from(i) + 0.5) * step;
        let s = sea.density(omega);
        all += s;
        inside += if omega < range + 0.5 * delta_omega { s } else { 0.0 };
    }
    // What a Gaussian spectrum has below zero frequency is lost too.
    let below = match sea.spectrum {
        Form::Gaussian => (0..places as u32).fold(0.0, |sum, i| sum + sea.density(-(f64::from(i) + 0.5) * step)),
        Form::Jonswap => 0.0,
    };
    let all = all + below;
    if all > 0.0 { 1.0 - inside / all } else { 0.0 }
}

/// A number with three significant digits.
fn short(value: f64) -> f64 {
    format!("{value:.2e}").parse().unwrap_or(value)
}
