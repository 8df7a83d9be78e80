//! Initial conditions of a ship that meets a wave group: at rest (CIC), pre-computed (PIC), natural (NIC).
//!
//! | method | starts | in the state |
//! |---|---|---|
//! | CIC | `[estimate] window` L before the centre | at rest |
//! | PIC | there too | a pair drawn from an ensemble of continuous roll |
//! | NIC | `groups_ahead` groups earlier | at rest; the waves bring the state |
//!
//! The three tables `[estimate]`, `[pic]`, `[nic]`, the size of PIC's ensemble, and NIC's predecessors.
//! Tested in `tests/physics/encounter.rs`.

use crate::numerics::{domain, invariant};
use crate::ship::encounter::Encounter;
use serde::{Deserialize, Serialize};

/// A state of roll.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct RollState {
    /// Roll angle, rad.
    pub theta: f64,
    /// Roll velocity, rad/s.
    pub theta_dot: f64,
}

/// The `[estimate]` table.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Estimate {
    /// Random groups per case for CIC, PIC and NIC.
    #[serde(deserialize_with = "domain::count")]
    pub samples: u32,
    /// A single-group run starts this many L before the centre.
    #[serde(deserialize_with = "domain::positive")]
    pub window: f64,
}

impl Estimate {
    /// Checks the sizes of a run.
    ///
    /// # Errors
    /// `key: expected .., found ..`.
    pub fn check(&self) -> Result<(), String> {
        let held = "all sampled groups are held in memory at once";
        domain::at_most("samples", u64::from(self.samples), MOST_SAMPLES, held)?;
        if self.window <= WIDEST {
            return Ok(());
        }
        let found = self.window;
        Err(format!(
            "window: expected at most {WIDEST}, since a group has no waves so far from its centre, found {found}"
        ))
    }
}

/// The largest ensemble, bytes; an artifact of the store may have twice as many.
const LARGEST_ENSEMBLE: u64 = 1 << 29;
/// Most groups of a sample: 240 MB of places and responses.
const MOST_SAMPLES: u64 = 10_000_000;
/// Largest `[estimate] window`, in L; exp(-100^2/2) is nothing.
const WIDEST: f64 = 100.0;
/// Most groups by which a NIC run starts ahead; the paper has two.
const MOST_AHEAD: u64 = 100;

/// Checks `[nic] groups_ahead`.
///
/// # Errors
/// `groups_ahead: expected .., found ..`.
pub fn check_groups_ahead(groups_ahead: u32) -> Result<(), String> {
    let since = "every run goes through all of them, and the ship forgets its state within a few";
    domain::at_most("groups_ahead", u64::from(groups_ahead), MOST_AHEAD, since)
}

/// The `[pic]` table.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Pic {
    /// T_p of continuous roll from which initial conditions are drawn.
    #[serde(deserialize_with = "domain::count")]
    pub periods: u32,
}

impl Pic {
    /// Checks that an ensemble of so many bytes per T_p fits into an artifact.
    ///
    /// # Errors
    /// `periods: expected .., found ..`.
    pub fn check(&self, bytes_per_period: u64) -> Result<(), String> {
        let since = format!("the ensemble takes {bytes_per_period} bytes per T_p and may have {LARGEST_ENSEMBLE}");
        let most = LARGEST_ENSEMBLE / bytes_per_period.max(1);
        domain::at_most("periods", u64::from(self.periods), most, &since)
    }

    /// How many fields the ensemble takes, the last one perhaps in part; at most all there are.
    pub fn fields(&self, periods_per_field: u32, fields: u32) -> u32 {
        self.periods.div_ceil(periods_per_field).min(fields)
    }

    /// How many states the ensemble takes of field f, given so many per T_p.
    pub fn states_of_field(&self, f: u32, periods_per_field: u32, per_period: u32) -> usize {
        let before = u64::from(f) * u64::from(periods_per_field);
        let left = u64::from(self.periods).saturating_sub(before);
        (left.min(u64::from(periods_per_field)) * u64::from(per_period)) as usize
    }
}

/// The waves that NIC runs on (Decision 7).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum NicInput {
    /// The original elevation of the record.
    Record,
    /// Reconstructed Gaussian groups on a common carrier.
    Groups,
}

/// The `[nic]` table.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Nic {
    /// How many groups earlier a run starts.
    #[serde(deserialize_with = "domain::count")]
    pub groups_ahead: u32,
    /// The waves of the run.
    pub input: NicInput,
}

/// The group `ahead` places before group i of a field, on a record that repeats with `field_period` s.
///
/// Predecessors of the first groups are the last ones, one period earlier; a field with too few groups is gone round
/// as often as needed, so that a single group follows its own image.
pub fn predecessor(groups: &[Encounter], i: usize, ahead: usize, field_period: f64) -> Encounter {
    let place = i as i64 - ahead as i64;
    let n = groups.len() as i64;
    let group = groups[place.rem_euclid(n) as usize];
    let rounds = place.div_euclid(n) as f64;
    Encounter {
        t_c: group.t_c + rounds * field_period,
        ..group
    }
}

/// The states that PIC draws from.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Ensemble {
    /// The ship's epsilon_1, 1/(m s^2).
    pub epsilon_1: Vec<f64>,
    /// (epsilon_1)(times), in the order of the record; equal times along epsilon_1.
    pub states: Vec<Vec<RollState>>,
}

impl Ensemble {
    /// Checks that there are states for a ship's list of epsilon_1, equally many for each, none of them a capsize.
    ///
    /// # Errors
    /// No states, another number of them, or one beyond the capsize angle.
    pub fn check(&self, epsilon_1: &[f64], capsize_angle: f64) -> Result<(), String> {
        invariant::equal("epsilon_1", &self.epsilon_1[..], epsilon_1)?;
        invariant::length("states", &self.states, epsilon_1.len())?;
        let times = self.states.first().map_or(0, Vec::len);
        invariant::holds("states", times > 0, "at least one state")?;
        for (e, states) in self.states.iter().enumerate() {
            let place = format!("states[{e}]");
            invariant::length(&place, states, times)?;
            let angles = states.iter().map(|state| &state.theta);
            invariant::all_within(&place, angles, &(-capsize_angle..=capsize_angle))?;
        }
        Ok(())
    }
}
