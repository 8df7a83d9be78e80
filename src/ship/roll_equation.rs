//! Eq. (6), the roll equation of a ship in irregular waves (after Umeda et al. 2004), and the `[ship.NAME]` table.
//!
//! | paper | code | unit | meaning |
//! |---|---|---|---|
//! | theta, theta' | theta, theta_dot | rad, rad/s | roll angle, roll velocity |
//! | alpha_1, alpha_2 | same | 1/s; s (cubic) or 1 (quadratic) | damping |
//! | beta_1, beta_2 | same | 1/s^2 | linear and cubic restoring |
//! | epsilon_1, epsilon_2 | same | 1/(m s^2) | parametric and direct excitation |
//! | eta | eta | m | surface elevation |
//!
//! Tested in `tests/physics/roll_equation.rs` against a scalar transcription and the exact damped linear roll.

use crate::numerics::domain;
use serde::{Deserialize, Serialize};

/// The form of the nonlinear damping term.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Damping {
    /// alpha_2 v^3, as the paper prints it.
    Cubic,
    /// alpha_2 v |v|.
    Quadratic,
}

/// Most epsilon_1 of a ship; the paper has three.
const MOST_EXCITATIONS: u64 = 64;

/// The `[ship.NAME]` table: the coefficients of Eq. (6).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Ship {
    /// Linear damping, 1/s, >= 0.
    #[serde(deserialize_with = "domain::non_negative")]
    pub alpha_1: f64,
    /// Nonlinear damping, s (cubic) or 1 (quadratic), >= 0.
    #[serde(deserialize_with = "domain::non_negative")]
    pub alpha_2: f64,
    /// Form of the nonlinear damping.
    pub damping: Damping,
    /// Linear restoring, 1/s^2, > 0.
    #[serde(deserialize_with = "domain::positive")]
    pub beta_1: f64,
    /// Cubic restoring, 1/s^2; negative: the well softens.
    #[serde(deserialize_with = "domain::finite")]
    pub beta_2: f64,
    /// The parametric excitations to be compared, 1/(m s^2), >= 0, strictly ascending.
    pub epsilon_1: Vec<f64>,
    /// Direct excitation, 1/(m s^2).
    #[serde(deserialize_with = "domain::finite")]
    pub epsilon_2: f64,
}

impl Ship {
    /// Checks the list of epsilon_1: at least one, finite, >= 0, strictly ascending.
    pub fn check(&self) -> Result<(), String> {
        if self.epsilon_1.is_empty() {
            return Err("epsilon_1: expected at least one number, found none".to_string());
        }
        let number = self.epsilon_1.len() as u64;
        let since = "the ship rolls along the whole record at each of them";
        domain::at_most("epsilon_1", number, MOST_EXCITATIONS, since).map_err(|why| format!("{why} numbers"))?;
        if let Some(bad) = self.epsilon_1.iter().find(|e| !(e.is_finite() && **e >= 0.0)) {
            return Err(format!("epsilon_1: expected numbers >= 0, found {bad}"));
        }
        domain::all_within("epsilon_1", &self.epsilon_1, 0.0, domain::LARGEST)?;
        if let Some(pair) = self.epsilon_1.windows(2).find(|pair| pair[0] >= pair[1]) {
            let (low, high) = (pair[0], pair[1]);
            return Err(format!(
                "epsilon_1: expected strictly ascending numbers, found {low} before {high}"
            ));
        }
        Ok(())
    }
}

/// Eq. (6) with an epsilon_1 of its own in every lane; the damping form is fixed at compile time, for speed alone.
#[derive(Clone, Copy, Debug)]
pub struct RollEquation<const L: usize, const CUBIC: bool> {
    alpha_1: f64,
    alpha_2: f64,
    beta_1: f64,
    beta_2: f64,
    epsilon_1: [f64; L],
    epsilon_2: f64,
}

/// The terms of Eq. (6) that hold the elevation, in every lane.
#[derive(Clone, Copy, Debug)]
pub struct Forcing<const L: usize> {
    /// epsilon_2 eta, 1/s^2.
    direct: [f64; L],
    /// beta_1 + epsilon_1 eta, 1/s^2.
    stiffness: [f64; L],
}

impl<const L: usize, const CUBIC: bool> RollEquation<L, CUBIC> {
    /// The equation of a ship; its list of epsilon_1 gives way to one value per lane.
    pub fn new(ship: &Ship, epsilon_1: [f64; L]) -> Self {
        Self {
            alpha_1: ship.alpha_1,
            alpha_2: ship.alpha_2,
            beta_1: ship.beta_1,
            beta_2: ship.beta_2,
            epsilon_1,
            epsilon_2: ship.epsilon_2,
        }
    }

    /// What the elevation eta in m puts into Eq. (6): the same for every state at an instant.
    #[inline(always)]
    pub fn forcing(&self, eta: [f64; L]) -> Forcing<L> {
        let [mut direct, mut stiffness] = [[0.0; L]; 2];
        for i in 0..L {
            direct[i] = self.epsilon_2 * eta[i];
            stiffness[i] = self.beta_1 + self.epsilon_1[i] * eta[i];
        }
        Forcing { direct, stiffness }
    }

    /// Eq. (6), the roll equation, solved for the acceleration theta'' in rad/s^2.
    ///
    /// ```text
    /// theta'' = epsilon_2 eta - (alpha_1 + alpha_2 v^2) v - (beta_1 + epsilon_1 eta + beta_2 theta^2) theta,  v = theta'
    /// ```
    /// `quadratic` damping has |v| in place of v^2.
    #[inline(always)]
    pub fn acceleration(&self, theta: [f64; L], theta_dot: [f64; L], forcing: Forcing<L>) -> [f64; L] {
        let mut result = [0.0; L];
        for i in 0..L {
            let (x, v) = (theta[i], theta_dot[i]);
            let power = if CUBIC { v * v } else { v.abs() };
            let damping = (self.alpha_1 + self.alpha_2 * power) * v;
            let restoring = (forcing.stiffness[i] + self.beta_2 * (x * x)) * x;
            result[i] = forcing.direct[i] - damping - restoring;
        }
        result
    }
}
