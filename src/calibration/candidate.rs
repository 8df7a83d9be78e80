//! Candidates of the calibration study: the printed ship with some coefficients changed, under one reading.
//!
//! | code | unit | meaning |
//! |---|---|---|
//! | `x` | 1 | ln(value / printed value) of each coefficient, in the order of [`NAMES`] |
//! | changes | 1 | how many of the six differ from the printed ones |
//! | size | 1 | sum of \|x\|: a factor of e counts as 1, a slip by a power of ten as ln 10 = 2.30 |
//!
//! `epsilon_1` is the second of the printed list; the whole list is scaled by its ratio.
//! Tested in `tests/physics/calibration.rs`.

use crate::numerics::elementary::{exp, ln};
use crate::numerics::invariant;
use crate::ship::response::{Capsize, Roll, Truth};
use crate::ship::roll_equation::{Damping, Ship};
use serde::{Deserialize, Serialize};

/// The coefficients, in the order of every array over them.
pub const NAMES: [&str; 6] = ["alpha_1", "alpha_2", "beta_1", "beta_2", "epsilon_1", "epsilon_2"];
/// Largest |ln ratio| of a coefficient: e^100 times the printed one is none.
const LARGEST: f64 = 100.0;
/// Place of beta_2 in that order.
const BETA_2: usize = 3;
/// Place of epsilon_1 in that order.
const EPSILON_1: usize = 4;
/// Place in the ship's list of epsilon_1 of the one that Table 1 is about.
pub const TABLE: usize = 1;

/// A choice where the paper is silent or a sign may have slipped.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Reading {
    /// As the pipeline reads the paper.
    Plain,
    /// alpha_2 v |v|.
    QuadraticDamping,
    /// max theta.
    SignedRoll,
    /// A field with a capsize leaves the statistics.
    DiscardField,
    /// Groups at the other similarity threshold.
    OtherSimilarity,
    /// beta_2 > 0.
    HardeningRestoring,
}

impl Reading {
    /// All of them, the plain one first.
    pub const ALL: [Self; 6] = [
        Self::Plain,
        Self::QuadraticDamping,
        Self::SignedRoll,
        Self::DiscardField,
        Self::OtherSimilarity,
        Self::HardeningRestoring,
    ];

    /// The words for it in tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Plain => "plain",
            Self::QuadraticDamping => "quadratic damping",
            Self::SignedRoll => "signed roll",
            Self::DiscardField => "fields with a capsize discarded",
            Self::OtherSimilarity => "other similarity threshold",
            Self::HardeningRestoring => "beta_2 > 0",
        }
    }

    /// What counts as a response.
    pub fn truth(self, plain: &Truth) -> Truth {
        let mut truth = plain.clone();
        match self {
            Self::SignedRoll => truth.roll = Roll::Signed,
            Self::DiscardField => truth.capsize = Capsize::DiscardField,
            _ => {}
        }
        truth
    }
}

/// A ship to be tried.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Candidate {
    /// ln(value / printed value), in the order of [`NAMES`].
    pub x: [f64; 6],
    /// The reading.
    pub reading: Reading,
}

impl Candidate {
    /// The candidate with the given magnitudes of coefficients; one equal to the printed one is unchanged exactly.
    pub fn of_values(values: &[f64; 6], printed: &Ship, reading: Reading) -> Self {
        let printed = magnitudes(printed);
        let ratio = |i: usize| {
            if values[i] == printed[i] {
                0.0
            } else {
                ln(values[i] / printed[i])
            }
        };
        Self {
            x: std::array::from_fn(ratio),
            reading,
        }
    }

    /// Magnitudes of the coefficients, in the order of [`NAMES`].
    pub fn values(&self, printed: &Ship) -> [f64; 6] {
        let printed = magnitudes(printed);
        std::array::from_fn(|i| {
            if self.x[i] == 0.0 {
                printed[i]
            } else {
                printed[i] * exp(self.x[i])
            }
        })
    }

    /// The coefficients, beta_2 with its sign.
    pub fn signed_values(&self, printed: &Ship) -> [f64; 6] {
        let mut values = self.values(printed);
        values[BETA_2] = self.ship(printed).beta_2;
        values
    }

    /// The same with every changed coefficient rounded to so many significant digits.
    #[must_use]
    pub fn rounded(&self, printed: &Ship, digits: usize) -> Self {
        let mut values = self.values(printed);
        for (value, x) in values.iter_mut().zip(self.x) {
            if x != 0.0 {
                *value = significant(*value, digits);
            }
        }
        Self::of_values(&values, printed, self.reading)
    }

    /// The ship.
    pub fn ship(&self, printed: &Ship) -> Ship {
        let [alpha_1, alpha_2, beta_1, beta_2, epsilon_1, epsilon_2] = self.values(printed);
        let softens = (printed.beta_2 < 0.0) != (self.reading == Reading::HardeningRestoring);
        let scaled = |(place, e): (usize, &f64)| {
            if place == TABLE {
                epsilon_1
            } else {
                e / magnitudes(printed)[EPSILON_1] * epsilon_1
            }
        };
        Ship {
            alpha_1,
            alpha_2,
            damping: if self.reading == Reading::QuadraticDamping {
                Damping::Quadratic
            } else {
                printed.damping
            },
            beta_1,
            beta_2: if softens { -beta_2 } else { beta_2 },
            epsilon_1: printed.epsilon_1.iter().enumerate().map(scaled).collect(),
            epsilon_2,
        }
    }

    /// Checks that no ratio is beyond what a coefficient may be.
    ///
    /// # Errors
    /// The first that is.
    pub fn check(&self) -> Result<(), String> {
        invariant::all_within("x", &self.x, &(-LARGEST..=LARGEST))
    }

    /// Which of the two lists of groups it meets.
    pub fn group_list(&self) -> usize {
        usize::from(self.reading == Reading::OtherSimilarity)
    }

    /// How many coefficients differ from the printed ones.
    pub fn changes(&self) -> u32 {
        self.x.iter().filter(|x| **x != 0.0).count() as u32
    }

    /// How far they differ: the sum of |ln ratio|.
    pub fn size(&self) -> f64 {
        self.x.iter().fold(0.0, |sum, x| sum + x.abs())
    }
}

/// The ships at the corners of what a search may try: magnitudes at either bound, or as printed where that lies outside
/// them, with the damping and the sign of beta_2 of every reading.
pub fn corners(bounds: &[[f64; 2]; 6], printed: &Ship) -> Vec<Ship> {
    let own = magnitudes(printed);
    let range = |i: usize, high: bool| {
        let bound = bounds[i][usize::from(high)];
        if high == (own[i] > bound) { own[i] } else { bound }
    };
    let mut ships = Vec::new();
    for corner in 0..1_u32 << NAMES.len() {
        let values: [f64; 6] = std::array::from_fn(|i| range(i, corner >> i & 1 == 1));
        let [alpha_1, alpha_2, beta_1, beta_2, epsilon_1, epsilon_2] = values;
        for damping in [printed.damping, Damping::Quadratic] {
            for beta_2 in [beta_2, -beta_2] {
                ships.push(Ship {
                    alpha_1,
                    alpha_2,
                    damping,
                    beta_1,
                    beta_2,
                    epsilon_1: printed
                        .epsilon_1
                        .iter()
                        .map(|e| e / own[EPSILON_1] * epsilon_1)
                        .collect(),
                    epsilon_2,
                });
            }
        }
    }
    ships
}

/// Magnitudes of a ship's coefficients, epsilon_1 that of Table 1.
pub fn magnitudes(ship: &Ship) -> [f64; 6] {
    let epsilon_1 = ship.epsilon_1.get(TABLE).copied().unwrap_or_default();
    [
        ship.alpha_1,
        ship.alpha_2,
        ship.beta_1,
        ship.beta_2.abs(),
        epsilon_1,
        ship.epsilon_2.abs(),
    ]
}

/// A number rounded to significant decimal digits; Rust's formatting is exact.
pub fn significant(value: f64, digits: usize) -> f64 {
    let decimals = digits.saturating_sub(1);
    format!("{value:.decimals$e}").parse().unwrap_or(value)
}
