//! What a search finds, and which of it is checked on other fields.
//!
//! Checked are, in this order: the ships named in `[calibration] known`; the best of each number of changes under the plain
//! reading; the best of each other reading. Tested in `tests/physics/calibration.rs`.

use crate::calibration::candidate::{Candidate, NAMES, Reading};
use crate::calibration::methods::Methods;
use crate::calibration::settings::{Search, Settings, Target};
use crate::numerics::invariant;
use crate::ship::roll_equation::Ship;
use serde::{Deserialize, Serialize};

/// A candidate and how it did.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Trial {
    /// The candidate.
    pub candidate: Candidate,
    /// (C1).
    pub misfit: f64,
    /// (C2).
    pub ranking: f64,
    /// What the search minimises: misfit, ranking and size, weighted.
    pub cost: f64,
}

/// What one search found.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Found {
    /// The search.
    pub search: Search,
    /// The best of its last generation.
    pub best: Trial,
    /// Every trial that agrees with Table 1 within the errors, in the order of the search.
    pub accepted: Vec<Trial>,
    /// Candidates evaluated.
    pub evaluations: u64,
}

/// What a checked candidate did in one sea, on fields that no search has seen.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct InSea {
    /// What was to be met.
    pub target: Target,
    /// P_true, per epsilon_1; empty if no group is in the statistics.
    pub p_true: Vec<f64>,
    /// Its standard error at the epsilon_1 of Table 1.
    pub standard_error: f64,
    /// CIC, PIC, NIC.
    pub methods: Methods,
    /// Capsizes per field.
    pub capsizes_per_field: f64,
    /// (C3), rad; none if no group is near the threshold.
    pub spread: Option<f64>,
}

/// A candidate, checked.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Checked {
    /// What it is called.
    pub name: String,
    /// The candidate, rounded.
    pub candidate: Candidate,
    /// Its coefficients, beta_2 with its sign.
    pub values: [f64; 6],
    /// (C1) on the fields checked.
    pub misfit: f64,
    /// Fields checked.
    pub fields: u64,
    /// Every sea.
    pub seas: Vec<InSea>,
}

impl Trial {
    fn check(&self) -> Result<(), String> {
        self.candidate.check().map_err(|why| format!("candidate.{why}"))?;
        let numbers = [self.misfit, self.ranking, self.cost];
        invariant::all_within("misfit, ranking, cost", &numbers, &(0.0..=f64::MAX))
    }
}

impl Found {
    /// Checks that it is what a search found: its own coefficients, and trials of candidates.
    ///
    /// # Errors
    /// The first thing that is not so.
    pub fn check(&self, search: &Search) -> Result<(), String> {
        invariant::equal("search", &self.search, search)?;
        self.best.check().map_err(|why| format!("best.{why}"))?;
        let mut accepted = self.accepted.iter().enumerate();
        accepted.try_for_each(|(i, trial)| trial.check().map_err(|why| format!("accepted[{i}].{why}")))
    }
}

impl Checked {
    /// Checks that every sea has the probabilities of so many epsilon_1 by every method.
    ///
    /// # Errors
    /// The first that is missing, or none.
    pub fn check(&self, epsilons: usize) -> Result<(), String> {
        self.candidate.check().map_err(|why| format!("candidate.{why}"))?;
        invariant::within("misfit", self.misfit, 0.0..=f64::MAX)?;
        for (i, sea) in self.seas.iter().enumerate() {
            let place = |key: &str| format!("seas[{i}].{key}");
            let lists = [
                ("p_true", &sea.p_true),
                ("methods.cic", &sea.methods.cic),
                ("methods.pic", &sea.methods.pic),
                ("methods.nic", &sea.methods.nic),
            ];
            for (key, list) in lists {
                invariant::length(&place(key), list, epsilons)?;
                invariant::all_within(&place(key), list, &(0.0..=1.0))?;
            }
            invariant::within(&place("standard_error"), sea.standard_error, 0.0..=1.0)?;
            invariant::within(&place("capsizes_per_field"), sea.capsizes_per_field, 0.0..=f64::MAX)?;
            invariant::within(&place("spread"), sea.spread.unwrap_or_default(), 0.0..=f64::MAX)?;
        }
        Ok(())
    }
}

/// A candidate to be checked.
#[derive(Clone, Debug, PartialEq)]
pub struct Chosen {
    /// What it is called.
    pub name: String,
    /// The candidate as found.
    pub candidate: Candidate,
    /// Whether it is to be polished.
    pub polish: bool,
}

/// The item-th candidate to be checked; none if no search found one.
pub fn chosen<'a>(
    settings: &Settings,
    printed: &Ship,
    found: impl Iterator<Item = &'a Found>,
    item: u64,
) -> Option<Chosen> {
    if let Some(known) = settings.known.get(item as usize) {
        return Some(Chosen {
            name: known.name.clone(),
            candidate: Candidate::of_values(&known.values, printed, Reading::Plain),
            polish: false,
        });
    }
    let place = item as usize - settings.known.len();
    let most = NAMES.len();
    let reading = *Reading::ALL.get(if place < most { 0 } else { place - most + 1 })?;
    let wanted = |it: &&Found| it.search.reading == reading && (place >= most || it.search.free.len() == place + 1);
    let mut best: Option<&Found> = None;
    for it in found.filter(wanted) {
        if best.is_none_or(|best| it.best.cost < best.best.cost) {
            best = Some(it);
        }
    }
    best.map(|it| Chosen {
        name: if place < most {
            format!("{} changed", place + 1)
        } else {
            reading.name().to_owned()
        },
        candidate: it.best.candidate,
        polish: true,
    })
}
