//! The `[calibration]` table: bounds, sizes and weights of the study, and the searches it consists of.

use crate::calibration::candidate::{NAMES, Reading, magnitudes};
use crate::numerics::domain;
use crate::numerics::elementary::ln;
use crate::ship::roll_equation::Ship;
use serde::{Deserialize, Serialize};

/// A row of Table 1 that a candidate has to meet.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Target {
    /// Name of the sea.
    pub sea: String,
    /// Threshold, rad.
    pub theta_t: f64,
    /// The paper's P_true.
    pub p_true: f64,
}

/// A ship to be checked besides those found.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Known {
    /// What it is called in the table.
    pub name: String,
    /// Magnitudes of its coefficients, in the order of [`NAMES`].
    pub values: [f64; 6],
}

/// The `[calibration]` table but for its counts.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Settings {
    /// First fields of each sea on which candidates are searched.
    #[serde(deserialize_with = "domain::count")]
    pub search_fields: u32,
    /// First fields on which the best are polished; all others serve to check them.
    #[serde(deserialize_with = "domain::count")]
    pub polish_fields: u32,
    /// First of the other fields on which CIC, PIC and NIC are computed.
    #[serde(deserialize_with = "domain::count")]
    pub method_fields: u32,
    /// Bounds of the magnitudes, in the order of [`NAMES`].
    pub bounds: [[f64; 2]; 6],
    /// Candidates of a generation, per changed coefficient.
    #[serde(deserialize_with = "domain::count")]
    pub population: u32,
    /// Generations, per changed coefficient.
    #[serde(deserialize_with = "domain::count")]
    pub generations: u32,
    /// A search whose first generation holds nothing below this misfit stops there.
    #[serde(deserialize_with = "domain::positive")]
    pub hopeless: f64,
    /// Rounds of least squares.
    #[serde(deserialize_with = "domain::count")]
    pub polish_rounds: u32,
    /// Relative error within which the paper's P_true and a reading of its methods can be expected to agree.
    #[serde(deserialize_with = "domain::positive")]
    pub relative_error: f64,
    /// Weight of the ranking of Figure 3 in the search.
    #[serde(deserialize_with = "domain::non_negative")]
    pub ranking_weight: f64,
    /// Weight of the size of changes in the search.
    #[serde(deserialize_with = "domain::non_negative")]
    pub size_weight: f64,
    /// Misfit below which a candidate agrees with Table 1 within the errors.
    #[serde(deserialize_with = "domain::positive")]
    pub accepted: f64,
    /// Significant digits of the coefficients checked.
    #[serde(deserialize_with = "domain::count")]
    pub digits: u32,
    /// The coefficients searched under each reading other than the plain one.
    pub reading_changes: Vec<String>,
    /// Ships to be checked besides those found.
    pub known: Vec<Known>,
}

/// Largest magnitude of a coefficient, and of its inverse.
const MAGNITUDE: f64 = 1e9;
/// Most candidates of a generation per coefficient, generations and rounds.
const MOST_ROUNDS: u64 = 1000;

/// A number has no more significant digits.
const MOST_DIGITS: u32 = 17;

/// One search: the coefficients it may change, and the reading.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Search {
    /// Places in [`NAMES`] of the coefficients that may change, ascending.
    pub free: Vec<u32>,
    /// The reading.
    pub reading: Reading,
}

impl Settings {
    /// Checks bounds and names.
    ///
    /// # Errors
    /// `key: expected .., found ..`.
    pub fn check(&self) -> Result<(), String> {
        if let Some([low, high]) = self.bounds.iter().find(|[low, high]| !(*low > 0.0 && low < high)) {
            return Err(format!("bounds: expected pairs 0 < low < high, found [{low}, {high}]"));
        }
        domain::all_within("bounds", self.bounds.as_flattened(), 1.0 / MAGNITUDE, MAGNITUDE)?;
        for known in &self.known {
            domain::all_within("known", &known.values, 1.0 / MAGNITUDE, MAGNITUDE)?;
        }
        let since = "the time of the study grows with it";
        for (key, found) in [
            ("population", self.population),
            ("generations", self.generations),
            ("polish_rounds", self.polish_rounds),
        ] {
            domain::at_most(key, u64::from(found), MOST_ROUNDS, since)?;
        }
        if self.reading_changes.is_empty() {
            return Err("reading_changes: expected at least one name of a coefficient, found none".to_owned());
        }
        if let Some(name) = self.reading_changes.iter().find(|name| !NAMES.contains(&name.as_str())) {
            return Err(format!("reading_changes: expected names of coefficients, found {name}"));
        }
        if self.polish_fields < self.search_fields {
            let (polish, search) = (self.polish_fields, self.search_fields);
            return Err(format!(
                "polish_fields: expected at least {search} (`search_fields`), found {polish}"
            ));
        }
        if self.digits > MOST_DIGITS {
            let digits = self.digits;
            return Err(format!("digits: expected at most {MOST_DIGITS}, found {digits}"));
        }
        Ok(())
    }

    /// The i-th search: readings other than the plain one first, then subsets of coefficients, the largest ones first;
    /// beyond them the same again, from other random numbers.
    pub fn search(&self, item: u64) -> Search {
        let others = Reading::ALL.len() as u64 - 1;
        let mut subsets: Vec<u64> = (1..1_u64 << NAMES.len()).collect();
        subsets.sort_by_key(|subset| (std::cmp::Reverse(subset.count_ones()), *subset));
        let place = item % (others + subsets.len() as u64);
        if place < others {
            let named = |i: &u32| self.reading_changes.iter().any(|name| name == NAMES[*i as usize]);
            return Search {
                free: (0..NAMES.len() as u32).filter(named).collect(),
                reading: Reading::ALL[1 + place as usize],
            };
        }
        let subset = subsets[(place - others) as usize];
        Search {
            free: (0..NAMES.len() as u32).filter(|i| subset >> i & 1 == 1).collect(),
            reading: Reading::Plain,
        }
    }

    /// Bounds of ln(value / printed value) of the coefficients in a search.
    pub fn log_bounds(&self, free: &[u32], printed: &Ship) -> Vec<[f64; 2]> {
        let printed = magnitudes(printed);
        let of = |i: &u32| self.bounds[*i as usize].map(|bound| ln(bound / printed[*i as usize]));
        free.iter().map(of).collect()
    }
}
