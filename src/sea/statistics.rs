//! What is known of the groups of one sea: the numbers of groups.csv and the joint density of Figures 1 and 3.

use crate::numerics::density::DensityMap;
use serde::{Deserialize, Serialize};

/// Statistics of the groups of one sea.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Statistics {
    /// The sea in words.
    pub description: String,
    /// Fields of the record.
    pub fields: u64,
    /// Groups of the record.
    pub groups: u64,
    /// Groups per peak period.
    pub groups_per_tp: f64,
    /// Mean and standard deviation of L/T_p.
    pub l_over_tp: [f64; 2],
    /// Mean and standard deviation of A/H_s.
    pub a_over_hs: [f64; 2],
    /// Correlation of the two.
    pub correlation: f64,
    /// Share of groups with A > H_s.
    pub share_a_over_hs_gt_1: f64,
    /// Kernel density on (L/T_p, A/H_s).
    pub density: DensityMap,
}
