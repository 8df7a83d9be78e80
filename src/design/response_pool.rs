//! What one case of the sequential design draws from: groups with known responses, and their density.

use crate::numerics::invariant;
use serde::{Deserialize, Serialize};

/// No group is so many T_p long or H_s high: squares of differences stay finite.
const LARGEST: f64 = 1e12;

/// The groups of one ship and sea, as the design sees them.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ResponsePool {
    /// epsilon_1 of the responses, 1/(m s^2).
    pub epsilon_1: f64,
    /// (L/T_p, A/H_s) of every group (N).
    pub points: Vec<[f64; 2]>,
    /// Response to every group (N), rad.
    pub r: Vec<f64>,
    /// p at the candidates of the acquisition, in their order.
    pub density: Vec<f64>,
}

impl ResponsePool {
    /// Checks that every group has a size above zero and a response, and every one of `candidates` a density.
    ///
    /// # Errors
    /// The first thing that is missing.
    pub fn check(&self, candidates: usize) -> Result<(), String> {
        invariant::holds("points", !self.points.is_empty(), "at least one group")?;
        invariant::length("r", &self.r, self.points.len())?;
        let sizes = self.points.iter().flatten();
        invariant::all_within("points", sizes, &(f64::MIN_POSITIVE..=LARGEST))?;
        invariant::length("density", &self.density, candidates)?;
        invariant::all_within("density", &self.density, &(0.0..=f64::MAX))
    }

    /// (z/θ_t, A/H_s) of every group (N), `z` (N) their linear responses, rad.
    ///
    /// # Errors
    /// Another number of responses than of groups.
    pub fn with_control(&self, z: &[f64], theta_t: f64) -> Result<Vec<[f64; 2]>, String> {
        let (expected, found) = (self.points.len(), z.len());
        if found != expected {
            return Err(format!(
                "expected a linear response to each of {expected} groups, found {found}"
            ));
        }
        let both = z.iter().zip(&self.points);
        Ok(both.map(|(z, x)| [z / theta_t, x[1]]).collect())
    }
}

/// One realisation of random sampling.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RandomEstimates {
    /// Numbers of samples, ascending.
    pub n_samples: Vec<u32>,
    /// P_est after each.
    pub estimate: Vec<f64>,
}

impl RandomEstimates {
    /// Checks that the numbers of samples ascend and that each has an estimate from 0 to 1.
    ///
    /// # Errors
    /// The first thing that is not so.
    pub fn check(&self) -> Result<(), String> {
        invariant::ascending("n_samples", &self.n_samples)?;
        invariant::length("estimate", &self.estimate, self.n_samples.len())?;
        invariant::all_within("estimate", &self.estimate, &(0.0..=1.0))
    }
}
