//! §4 The temporal exceeding probability, the share of time that |theta| spends above a level, and the part of it that lies
//! within the segments of the detected groups.
//!
//! | paper | code | unit | meaning |
//! |---|---|---|---|
//! | P_temp | - | 1 | share of time with absolute roll above theta_t |
//! | - | within | 1 | whether an instant lies in the segment of a group, centre +- window L |
//!
//! P_temp itself does not know what a group is. What of it the groups hold tells whether a detection misses extreme roll.
//! Tested in `tests/physics/temporal.rs`.

use crate::numerics::invariant;
use crate::ship::continuous_roll::Rolled;
use crate::ship::encounter::Encounter;
use crate::ship::exceedance::{Curve, Exceedances};
use serde::{Deserialize, Serialize};

/// Whether each of `n` instants, `spacing` s apart from t = 0 over one period of the record, lies in a group's segment.
pub fn within(groups: &[Encounter], window: f64, spacing: f64, n: usize) -> Vec<bool> {
    let mut inside = vec![false; n];
    for group in groups {
        let reach = window * group.l;
        let first = ((group.t_c - reach) / spacing).ceil() as i64;
        let last = ((group.t_c + reach) / spacing).floor() as i64;
        for instant in first..=last.min(first + n as i64 - 1) {
            inside[instant.rem_euclid(n as i64) as usize] = true;
        }
    }
    inside
}

/// Exceedances by groups and by time of the same roll, per epsilon_1.
#[derive(Clone)]
pub struct Counts {
    /// Groups, by their largest roll.
    pub by_groups: Vec<Exceedances>,
    /// Instants, by their roll.
    pub by_time: Vec<Exceedances>,
    /// Instants, by their roll where it lies within a group's segment, 0 elsewhere.
    pub within_groups: Vec<Exceedances>,
}

impl Counts {
    /// Nothing counted yet, for so many levels and epsilon_1.
    pub fn none(levels: usize, epsilons: usize) -> Self {
        let none = vec![Exceedances::none(levels); epsilons];
        Self {
            by_groups: none.clone(),
            by_time: none.clone(),
            within_groups: none,
        }
    }

    /// Counts the roll of some fields above `levels` (rad); `window` in L, `period` T_f in s.
    pub fn add(&mut self, rolled: &Rolled, groups: &[Vec<Encounter>], levels: &[f64], window: f64, period: f64) {
        for (e, (responses, angles)) in rolled.responses.iter().zip(&rolled.angles).enumerate() {
            for ((response, angles), groups) in responses.iter().zip(angles).zip(groups) {
                if response.dropped {
                    continue;
                }
                let inside = within(groups, window, period / angles.len() as f64, angles.len());
                let held = |(angle, inside): (&f64, bool)| if inside { *angle } else { 0.0 };
                let held: Vec<f64> = angles.iter().zip(inside).map(held).collect();
                self.by_groups[e].add_field(levels, &response.r);
                self.by_time[e].add_field(levels, angles);
                self.within_groups[e].add_field(levels, &held);
            }
        }
    }
}

/// Probabilities of one ship in one sea by groups and by time, for several settings of the detection.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct DetectionStudy {
    /// Fields of the record that were looked at.
    pub fields: u64,
    /// The share of time above each level, per epsilon_1; it knows no groups.
    pub temporal: Vec<Curve>,
    /// One entry per similarity threshold.
    pub detections: Vec<StudiedDetection>,
}

impl DetectionStudy {
    /// Checks that every similarity threshold has its curves, one for each of so many epsilon_1 over the given levels.
    ///
    /// # Errors
    /// The first curve that is missing, or none of probabilities.
    pub fn check(&self, similarity_thresholds: &[f64], epsilons: usize, levels: &[f64]) -> Result<(), String> {
        let all = |place: String, curves: &[Curve]| {
            invariant::length(&place, curves, epsilons)?;
            let mut curves = curves.iter().enumerate();
            curves.try_for_each(|(e, curve)| curve.check(levels).map_err(|why| format!("{place}[{e}].{why}")))
        };
        all("temporal".to_owned(), &self.temporal)?;
        invariant::length("detections", &self.detections, similarity_thresholds.len())?;
        for (i, (own, threshold)) in self.detections.iter().zip(similarity_thresholds).enumerate() {
            let place = |key: &str| format!("detections[{i}].{key}");
            invariant::equal(&place("similarity_threshold"), &own.similarity_threshold, threshold)?;
            all(place("by_groups"), &own.by_groups)?;
            all(place("within_groups"), &own.within_groups)?;
        }
        Ok(())
    }
}

/// What one similarity threshold makes of the same record.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct StudiedDetection {
    /// C_thr.
    pub similarity_threshold: f64,
    /// Eq. (1), the share of groups above each level, per epsilon_1.
    pub by_groups: Vec<Curve>,
    /// The share of time above each level and within a group's segment, per epsilon_1.
    pub within_groups: Vec<Curve>,
}
