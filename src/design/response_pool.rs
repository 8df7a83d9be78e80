//! What one case of the sequential design draws from: groups with known responses, and their density.

use serde::{Deserialize, Serialize};

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
