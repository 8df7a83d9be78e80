//! What linear oscillators like the ship do in the same waves: known from the modes, without a run.
//!
//! ```text
//! harmonic balance of Eq. (6) without epsilon_1 at the amplitude θ_a and the frequency ω_p:
//! alpha = alpha_1 + 3/4 alpha_2 ω_p² θ_a²  (cubic)  or  alpha_1 + 8/(3π) alpha_2 ω_p θ_a  (quadratic)
//! beta  = beta_1 + 3/4 beta_2 θ_a²
//! H(ω)  = epsilon_2/(beta - ω² + i alpha ω),   Z(t) = sum_k H(ω_k) A_k e^(i(ω_k t + phi_k)),   z_i = max |Z| about group i
//! ```
//! |Z| is the envelope of the oscillator's steady roll. A softening ship is tuned to other waves at every amplitude; on its
//! way to the threshold a swing passes all of them, so a group is known by the geometric mean of z over some. Nayfeh &
//! Mook, *Nonlinear Oscillations* (1979), section 4.1. Tested against the roll equation itself, run linear, in
//! `tests/physics/linear_response.rs`.

use crate::numerics::elementary::{exp, ln};
use crate::numerics::fourier::{Lanes, WIDTH};
use crate::numerics::invariant;
use crate::ship::roll_equation::{Damping, Ship};
use num_complex::Complex;
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

/// A linear oscillator: the ship balanced at one amplitude.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Oscillator {
    /// Damping, 1/s.
    pub alpha: f64,
    /// Restoring, 1/s².
    pub beta: f64,
    /// Direct excitation, 1/(m s²).
    pub epsilon_2: f64,
}

impl Oscillator {
    /// The ship by harmonic balance at the amplitude `theta_a`, rad, and the frequency `omega`, rad/s.
    pub fn balanced(ship: &Ship, theta_a: f64, omega: f64) -> Self {
        let nonlinear = match ship.damping {
            Damping::Cubic => 0.75 * (omega * theta_a) * (omega * theta_a),
            Damping::Quadratic => 8.0 / (3.0 * PI) * omega * theta_a,
        };
        Self {
            alpha: ship.alpha_1 + ship.alpha_2 * nonlinear,
            beta: ship.beta_1 + 0.75 * ship.beta_2 * (theta_a * theta_a),
            epsilon_2: ship.epsilon_2,
        }
    }

    /// H(ω), rad/m.
    pub fn transfer(&self, omega: f64) -> Complex<f64> {
        let (re, im) = (self.beta - omega * omega, self.alpha * omega);
        let scale = self.epsilon_2 / (re * re + im * im);
        Complex::new(scale * re, -scale * im)
    }

    /// Z's modes from those of eta, `spectrum[k - 1]` at k `delta_omega`, in place.
    pub fn respond(&self, spectrum: &mut [Complex<Lanes>], delta_omega: f64) {
        for (k, c) in spectrum.iter_mut().enumerate() {
            let h = self.transfer((k + 1) as f64 * delta_omega);
            let splat = |v| Lanes([v; WIDTH]);
            *c = *c * Complex::new(splat(h.re), splat(h.im));
        }
    }
}

/// z_i: the largest of a periodic series in [centre - reach, centre + reach], times in s; `spacing` that of the series.
pub fn largest_about(series: impl Fn(usize) -> f64, samples: usize, spacing: f64, centre: f64, reach: f64) -> f64 {
    let (from, to) = ((centre - reach) / spacing, (centre + reach) / spacing);
    let mut largest = 0.0;
    for i in from.ceil() as i64..=to.floor() as i64 {
        let z = series(i.rem_euclid(samples as i64) as usize);
        largest = if z > largest { z } else { largest };
    }
    largest
}

/// The geometric mean of every group over some oscillators, `z` (oscillators, groups); 0 where one of them is at rest.
pub fn geometric_means(z: &[Vec<f64>]) -> Vec<f64> {
    let groups = z.first().map_or(0, Vec::len);
    let mean = |i: usize| exp(z.iter().fold(0.0, |sum, own| sum + ln(own[i])) / z.len() as f64);
    (0..groups).map(mean).collect()
}

/// The oscillators' response to each sampled group of a piece.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct LinearResponses {
    /// z (groups), rad, in the order of the sample.
    pub z: Vec<f64>,
}

impl LinearResponses {
    /// Checks that no response is below zero.
    ///
    /// # Errors
    /// The first that is.
    pub fn check(&self) -> Result<(), String> {
        invariant::all_within("z", &self.z, &(0.0..=f64::MAX))
    }
}
