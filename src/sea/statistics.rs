//! What is known of the groups of one sea: the numbers of groups.csv and the joint density of Figures 1 and 3.

use crate::numerics::density::DensityMap;
use crate::numerics::invariant;
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

impl Statistics {
    /// Checks that shares, means and correlation can be those of groups.
    ///
    /// # Errors
    /// The first number that cannot.
    pub fn check(&self) -> Result<(), String> {
        let any = 0.0..=f64::MAX;
        invariant::within("groups_per_tp", self.groups_per_tp, any.clone())?;
        invariant::all_within("l_over_tp", &self.l_over_tp, &any)?;
        invariant::all_within("a_over_hs", &self.a_over_hs, &any)?;
        // Rounding may lift the correlation of equal series a little above 1.
        invariant::within("correlation", self.correlation, -1.000_001..=1.000_001)?;
        invariant::within("share_a_over_hs_gt_1", self.share_a_over_hs_gt_1, 0.0..=1.0)
    }
}
