//! The probabilities of one sea as the panels of Figures 3 and 8.

use crate::plot::exceedance::{Cell, Curve};
use crate::plot::style::Method;
use crate::ship::exceedance::{Counts, Probabilities};

/// The probabilities of one sea as panels, one per epsilon_1.
pub fn cells(probabilities: &Probabilities) -> Vec<Cell> {
    let counts = probabilities.counts.iter();
    counts.map(|counts| cell(counts, probabilities)).collect()
}

fn cell(counts: &Counts, probabilities: &Probabilities) -> Cell {
    let own = probabilities
        .curves
        .iter()
        .filter(|curve| curve.epsilon_1 == counts.epsilon_1);
    let curves = own.filter_map(|curve| {
        Some(Curve {
            method: Method::named(&curve.method)?,
            theta_t: curve.theta_t[..curve.probability.len()].to_vec(),
            probability: curve.probability.clone(),
            standard_error: curve.standard_error.clone(),
            n: curve.n,
        })
    });
    let share = counts.capsized_groups as f64 / counts.groups.max(1) as f64;
    Cell {
        epsilon_1: counts.epsilon_1,
        curves: curves.collect(),
        capsize_share: (counts.groups > 0).then_some(share),
    }
}
