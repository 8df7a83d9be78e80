//! What counts as the response to a wave group: the `[truth]` table, and the roll that one field leaves behind (Eq. 1).
//!
//! | paper | code | unit | meaning |
//! |---|---|---|---|
//! | r_i | r | rad | maximum roll in the segment of group i |
//! | - | window | L | half-width of a group's segment (Decision 4) |
//! | - | capsize_angle | rad | beyond it the ship has capsized (Decision 5) |
//!
//! A capsize is a value: the groups whose segment holds it have r = capsize_angle, which exceeds every threshold.

use crate::numerics::{domain, invariant, sums};
use crate::ship::exceedance::{Exceedances, Thresholds};
use serde::{Deserialize, Serialize};

/// Which roll is compared with a threshold.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Roll {
    /// max |theta|.
    Absolute,
    /// max theta; a capsize to either side counts.
    Signed,
}

/// What a capsize does to the statistics.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Capsize {
    /// The ship is set upright at rest and goes on; the group exceeds every threshold.
    Restart,
    /// The whole field leaves the statistics.
    DiscardField,
}

/// The largest angle at which a ship may be said to have capsized: sixteen turns, rad.
const LARGEST_ANGLE: f64 = 100.0;

fn temporal_level() -> f64 {
    0.25
}

/// The temporal levels unless given: the thresholds of Figure 3, rad.
pub fn temporal_levels() -> Thresholds {
    Thresholds {
        from: 0.0,
        to: 1.2,
        step: 0.025,
    }
}

/// The `[truth]` table.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Truth {
    /// Half-width of a group's segment, in L.
    #[serde(deserialize_with = "domain::positive")]
    pub window: f64,
    /// Absolute or signed roll.
    pub roll: Roll,
    /// |theta| beyond which the ship has capsized, rad.
    #[serde(deserialize_with = "domain::positive")]
    pub capsize_angle: f64,
    /// What a capsize does.
    pub capsize: Capsize,
    /// Level of |theta| whose share of time is reported, rad; 0.25 unless given.
    #[serde(default = "temporal_level", deserialize_with = "domain::positive")]
    pub temporal_level: f64,
    /// Levels of |theta| whose share of time is counted, rad; those of Figure 3 unless given.
    #[serde(default = "temporal_levels")]
    pub temporal_levels: Thresholds,
}

impl Truth {
    /// Checks that the temporal levels lie below the capsize angle.
    ///
    /// # Errors
    /// `key: expected .., found ..`.
    pub fn check(&self) -> Result<(), String> {
        let limit = self.capsize_angle;
        if limit > LARGEST_ANGLE {
            return Err(format!(
                "capsize_angle: expected at most {LARGEST_ANGLE} rad, since the cubic restoring grows beyond all bounds, found {limit}"
            ));
        }
        self.temporal_levels
            .check()
            .map_err(|why| format!("temporal_levels.{why}"))?;
        let highest = self.temporal_levels.to;
        if highest >= limit {
            return Err(format!(
                "temporal_levels.to: expected a number below capsize_angle = {limit}, found {highest}"
            ));
        }
        if self.temporal_level >= limit {
            let level = self.temporal_level;
            return Err(format!(
                "temporal_level: expected a number below capsize_angle = {limit}, found {level}"
            ));
        }
        Ok(())
    }
}

/// What one field's roll leaves behind at one epsilon_1.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Response {
    /// r_i of each group of the field, rad, in the order of the groups; empty if the field is dropped.
    pub r: Vec<f64>,
    /// Capsizes in [0, T_f).
    pub capsizes: u32,
    /// Share of the time in [0, T_f) with |theta| above the temporal level.
    pub time_above: f64,
    /// True if the field leaves the statistics: a capsize anywhere in its run, lead-in and tail included, under
    /// `discard_field`.
    pub dropped: bool,
}

impl Response {
    /// Checks that no roll is above the capsize angle, and that a dropped field has no responses.
    ///
    /// # Errors
    /// The first thing that a field's roll does not leave behind.
    fn check(&self, truth: &Truth) -> Result<(), String> {
        let (least, most) = (-truth.capsize_angle, truth.capsize_angle);
        let least = if truth.roll == Roll::Absolute { 0.0 } else { least };
        invariant::all_within("r", &self.r, &(least..=most))?;
        invariant::within("time_above", self.time_above, 0.0..=1.0)?;
        invariant::holds(
            "r",
            !self.dropped || self.r.is_empty(),
            "no responses of a dropped field",
        )
    }

    /// The number of groups whose segment holds a capsize.
    pub fn capsized_groups(&self, capsize_angle: f64) -> usize {
        self.r.iter().filter(|r| **r >= capsize_angle).count()
    }
}

/// Mean and spread of some responses: a point of Figure 4.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Moments {
    /// The mean, rad.
    pub mean: f64,
    /// The population standard deviation, rad.
    pub standard_deviation: f64,
    /// The number of responses.
    pub n: u64,
}

impl Moments {
    /// The moments of some responses; none of none.
    pub fn of(r: &[f64]) -> Option<Self> {
        if r.is_empty() {
            return None;
        }
        Some(Self {
            mean: sums::mean(r),
            standard_deviation: sums::standard_deviation(r),
            n: r.len() as u64,
        })
    }
}

/// Responses of the fields of a piece.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Truths {
    /// The ship's epsilon_1, 1/(m s^2).
    pub epsilon_1: Vec<f64>,
    /// (epsilon_1)(fields).
    pub fields: Vec<Vec<Response>>,
    /// Instants at T_p/4 with |theta| above each of `temporal_levels`, by field, dropped fields left out; (epsilon_1).
    pub temporal: Vec<Exceedances>,
}

impl Truths {
    /// Checks that these are the responses of a ship's list of epsilon_1 in so many fields, whose |theta| was counted at
    /// `instants` a field over `levels` thresholds.
    ///
    /// # Errors
    /// The first thing that the roll of a ship does not leave behind.
    pub fn check(&self, epsilon_1: &[f64], fields: usize, truth: &Truth, instants: u64) -> Result<(), String> {
        invariant::equal("epsilon_1", &self.epsilon_1[..], epsilon_1)?;
        invariant::length("fields", &self.fields, epsilon_1.len())?;
        invariant::length("temporal", &self.temporal, epsilon_1.len())?;
        let levels = truth.temporal_levels.values().len();
        for (e, (own, temporal)) in self.fields.iter().zip(&self.temporal).enumerate() {
            invariant::length(&format!("fields[{e}]"), own, fields)?;
            for (field, (response, other)) in own.iter().zip(&self.fields[0]).enumerate() {
                let place = |key: &str| format!("fields[{e}][{field}].{key}");
                response.check(truth).map_err(|why| place(&why))?;
                if !response.dropped && !other.dropped {
                    invariant::length(&place("r"), &response.r, other.r.len())?;
                }
            }
            let kept = own.iter().filter(|response| !response.dropped).map(|_| instants);
            temporal
                .check(levels, kept)
                .map_err(|why| format!("temporal[{e}].{why}"))?;
        }
        Ok(())
    }
}

/// One point of Figure 4.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Point {
    /// epsilon_1, 1/(m s^2).
    pub epsilon_1: f64,
    /// (L/T_p, A/H_s).
    pub group: [f64; 2],
    /// truth, cic, pic or nic.
    pub method: String,
    /// Mean, spread and number of responses; none if the bin is empty.
    pub moments: Option<Moments>,
}
