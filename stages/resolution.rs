//! Whether the step of a run resolves its ship and its waves: what every stage that integrates Eq. (6) asks first.
//!
//! A ship and a sea meet in a case, so the stages read both tables, and the engine asks for every case of a run.

use serde::{Deserialize, Serialize};

use crate::numerics::domain;
use crate::sea::wave_field::Record;
use crate::ship::resolution::{self, Grid};
use crate::ship::response::Truth;
use crate::ship::roll_equation::Ship;

/// The part of `[sea.NAME]` that a step and the crests are measured against.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub struct Waves {
    /// T_p, s.
    #[serde(deserialize_with = "domain::positive")]
    pub peak_period: f64,
    /// H_s, m.
    #[serde(deserialize_with = "domain::positive")]
    pub significant_wave_height: f64,
}

impl Waves {
    /// The grid of a record in these waves.
    pub fn grid(&self, record: &Record) -> Grid {
        Grid {
            t_p: self.peak_period,
            h_s: self.significant_wave_height,
            highest_group: 0.0,
            samples_per_period: record.samples_per_period,
            most_samples: record.most_samples_per_period(),
            field_period: record.field_period(self.peak_period),
            lead_in: record.lead_in,
        }
    }
}

/// Whether a step resolves a ship: the warnings of a case.
///
/// # Errors
/// A step at which the integration is unstable.
pub fn of_roll(ship: &Ship, truth: &Truth, grid: &Grid) -> Result<Vec<String>, String> {
    resolution::check(ship, truth.capsize_angle, grid)?;
    Ok(resolution::warnings(ship, truth.capsize_angle, grid))
}

/// Refuses an envelope that is finer than the roll: states are kept at full steps.
///
/// # Errors
/// `record.envelope_samples_per_period: expected .., found ..`.
pub fn of_states(record: &Record) -> Result<(), String> {
    let (steps, found) = (record.samples_per_period / 2, record.envelope_samples_per_period);
    if found <= steps {
        return Ok(());
    }
    Err(format!(
        "record.envelope_samples_per_period: expected at most {steps}, one at each RK4 step (half of \
         `record.samples_per_period`), found {found}"
    ))
}
