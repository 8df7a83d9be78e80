//! How the estimates of every method spread over their realisations, by the number of samples.
//!
//! Tested in `tests/physics/convergence.rs`.

use super::floor::Floors;
use crate::numerics::invariant;
use crate::numerics::sums::{mean, standard_deviation};
use serde::{Deserialize, Serialize};

/// One method's estimates: mean and population standard deviation over the realisations.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Spread {
    /// Numbers of samples that every realisation reached, ascending.
    pub n_samples: Vec<u32>,
    /// Mean at each.
    pub mean: Vec<f64>,
    /// Standard deviation at each.
    pub std: Vec<f64>,
}

impl Spread {
    /// Of some realisations, each (numbers of samples, estimates).
    pub fn of(realisations: &[(Vec<u32>, Vec<f64>)]) -> Self {
        let mut spread = Self::default();
        let sizes = realisations.first().map_or(&[] as &[u32], |(sizes, _)| sizes);
        for n in sizes {
            let at = |(sizes, estimates): &(Vec<u32>, Vec<f64>)| {
                let place = sizes.iter().position(|size| size == n)?;
                estimates.get(place).copied()
            };
            let values: Option<Vec<f64>> = realisations.iter().map(at).collect();
            if let Some(values) = values {
                spread.n_samples.push(*n);
                spread.mean.push(mean(&values));
                spread.std.push(standard_deviation(&values));
            }
        }
        spread
    }

    /// (mean, standard deviation) at so many samples.
    pub fn at(&self, n: u32) -> Option<(f64, f64)> {
        let place = self.n_samples.iter().position(|size| *size == n)?;
        Some((self.mean[place], self.std[place]))
    }
}

impl Spread {
    /// Checks that every number of samples has a mean and a deviation.
    ///
    /// # Errors
    /// The first thing that is missing, or no estimate of a probability.
    fn check(&self) -> Result<(), String> {
        invariant::ascending("n_samples", &self.n_samples)?;
        for (place, list) in [("mean", &self.mean), ("std", &self.std)] {
            invariant::length(place, list, self.n_samples.len())?;
            invariant::all_within(place, list, &(-1e-9..=1.0 + 1e-9))?;
        }
        Ok(())
    }
}

impl Convergence {
    /// Checks every method's line, and the floors.
    ///
    /// # Errors
    /// The first thing that is not so.
    pub fn check(&self) -> Result<(), String> {
        let lines = [
            ("sequential", &self.sequential),
            ("best", &self.best),
            ("control", &self.control),
            ("lhs", &self.lhs),
            ("random", &self.random),
        ];
        let mut lines = lines.into_iter();
        lines.try_for_each(|(place, line)| line.check().map_err(|why| format!("{place}.{why}")))?;
        self.floors.check().map_err(|why| format!("floors.{why}"))
    }
}

/// All methods of one case of Table 1.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Convergence {
    /// Realisations of each.
    pub realisations: u64,
    /// VHGP-Seq.
    pub sequential: Spread,
    /// The design that looks ahead.
    pub best: Spread,
    /// The same with the linear response as a control.
    pub control: Spread,
    /// The surrogate on a Latin hypercube.
    pub lhs: Spread,
    /// Random sampling.
    pub random: Spread,
    /// What no unbiased estimate goes below.
    pub floors: Floors,
}

impl Convergence {
    /// A standard deviation over the realisations, if it says anything: that of a single realisation is 0 whatever the method does,
    /// and so is that of realisations which all saw nothing.
    pub fn deviation(&self, std: f64) -> Option<f64> {
        (self.realisations > 1 && std > 0.0).then_some(std)
    }
}
