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

/// One realisation of random sampling.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RandomEstimates {
    /// Numbers of samples, ascending.
    pub n_samples: Vec<u32>,
    /// P_est after each.
    pub estimate: Vec<f64>,
}
