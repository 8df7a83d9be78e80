//! §2, eq. (7): the spectra of the four seas and the amplitudes of their modes.
//!
//! | paper | code | unit | meaning |
//! |---|---|---|---|
//! | H_s, T_p | `significant_wave_height`, `peak_period` | m, s | |
//! | omega_p | `omega_p` | rad/s | 2 pi/T_p |
//! | K | `bandwidth` | rad/s | width of the Gaussian spectrum |
//! | gamma, sigma | `gamma`, `sigma_low`, `sigma_high` | 1 | JONSWAP's peakedness and peak widths |
//! | S | `density` | m^2 s, up to its scale | one-sided spectrum |
//! | A_k | `amplitudes` | (modes), m | amplitude of the mode k delta_omega |
//!
//! ```text
//! (W1)  S = exp(-(omega - omega_p)^2/(2 K^2))
//! (W2)  S = omega^-5 exp(-1.25 (omega_p/omega)^4) gamma^exp(-(omega - omega_p)^2/(2 sigma^2 omega_p^2))
//! (W3)  A_k = sqrt(2 S(omega_k) delta_omega), scaled so that the variance is (H_s/4)^2 exactly
//! ```
//! Eq. (7) is read as a density in angular frequency. Tested in `tests/physics/wave_field.rs`.

use crate::numerics::{domain, elementary, sums};
use serde::{Deserialize, Serialize};

/// JONSWAP's peak width at and below the peak where the table gives none (Hasselmann et al. 1973; Decision 1).
const SIGMA_LOW: f64 = 0.07;
/// JONSWAP's peak width above the peak where the table gives none (Hasselmann et al. 1973; Decision 1).
const SIGMA_HIGH: f64 = 0.09;

/// The shape of a spectrum.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Form {
    /// (W1), seas S1 to S3.
    Gaussian,
    /// (W2), sea S4.
    Jonswap,
}

/// The table `[sea.NAME]`: one sea state.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Sea {
    /// Shape: "gaussian" or "jonswap".
    pub spectrum: Form,
    /// H_s, m.
    #[serde(deserialize_with = "domain::positive")]
    pub significant_wave_height: f64,
    /// T_p, s.
    #[serde(deserialize_with = "domain::positive")]
    pub peak_period: f64,
    /// Width K of the Gaussian spectrum, rad/s; for "gaussian" alone.
    #[serde(default)]
    pub bandwidth: Option<f64>,
    /// Peakedness of JONSWAP, 1 to 100; for "jonswap" alone.
    #[serde(default)]
    pub gamma: Option<f64>,
    /// Peak width of JONSWAP for omega <= omega_p; 0.07 if absent.
    #[serde(default)]
    pub sigma_low: Option<f64>,
    /// Peak width of JONSWAP for omega > omega_p; 0.09 if absent.
    #[serde(default)]
    pub sigma_high: Option<f64>,
}

impl Sea {
    /// The sea in words, for a figure: "Gaussian, bandwidth 0.02 rad/s".
    pub fn description(&self) -> String {
        match self.spectrum {
            Form::Gaussian => format!("Gaussian, bandwidth {} rad/s", self.bandwidth.unwrap_or_default()),
            Form::Jonswap => format!("JONSWAP, γ = {}", self.gamma.unwrap_or_default()),
        }
    }

    /// Checks which keys belong to which form, and ranges wide enough for any sea.
    ///
    /// # Errors
    /// Names the key, what was expected and what was found.
    pub fn check(&self) -> Result<(), String> {
        let required = Some(self.significant_wave_height);
        within("significant_wave_height", required, 1e-3, 1e3)?;
        within("peak_period", Some(self.peak_period), 1e-2, 1e4)?;
        match self.spectrum {
            Form::Gaussian => {
                within("bandwidth", self.bandwidth, 1e-9, 1e3)?;
                absent("gamma", self.gamma)?;
                absent("sigma_low", self.sigma_low)?;
                absent("sigma_high", self.sigma_high)
            }
            Form::Jonswap => {
                within("gamma", self.gamma, 1.0, 100.0)?;
                within("sigma_low", self.sigma_low.or(Some(SIGMA_LOW)), 1e-3, 10.0)?;
                within("sigma_high", self.sigma_high.or(Some(SIGMA_HIGH)), 1e-3, 10.0)?;
                absent("bandwidth", self.bandwidth)
            }
        }
    }

    /// Peak frequency, rad/s.
    pub fn omega_p(&self) -> f64 {
        std::f64::consts::TAU / self.peak_period
    }

    /// JONSWAP's relative width below its peak.
    pub fn peak_width(&self) -> f64 {
        self.sigma_low.unwrap_or(SIGMA_LOW)
    }

    /// (W1) or (W2) up to a constant, 1 or less at the peak of (W1); omega in rad/s, > 0.
    pub fn density(&self, omega: f64) -> f64 {
        let omega_p = self.omega_p();
        match self.spectrum {
            Form::Gaussian => bell((omega - omega_p) / self.bandwidth.unwrap_or(omega_p)),
            Form::Jonswap => {
                let sigma = if omega <= omega_p {
                    self.sigma_low.unwrap_or(SIGMA_LOW)
                } else {
                    self.sigma_high.unwrap_or(SIGMA_HIGH)
                };
                let ratio = omega_p / omega;
                let fourth = ratio * ratio * ratio * ratio;
                let peak = elementary::pow(self.gamma.unwrap_or(1.0), bell((omega - omega_p) / (sigma * omega_p)));
                fourth * ratio * elementary::exp(-1.25 * fourth) * peak
            }
        }
    }

    /// (W3) A_k, k = 1..=modes, at multiples of `delta_omega` (rad/s), m.
    pub fn amplitudes(&self, modes: u32, delta_omega: f64) -> Vec<f64> {
        let shape: Vec<f64> = (1..=modes).map(|k| self.density(f64::from(k) * delta_omega)).collect();
        let wanted = self.significant_wave_height / 4.0;
        // Half the sum of 2 S is the sum of S; delta_omega cancels.
        let scale = 2.0 * wanted * wanted / sums::sum(&shape);
        shape.iter().map(|s| (s * scale).sqrt()).collect()
    }
}

/// exp(-u^2/2).
fn bell(u: f64) -> f64 {
    elementary::exp(-0.5 * u * u)
}

fn within(key: &str, value: Option<f64>, low: f64, high: f64) -> Result<(), String> {
    match value {
        Some(x) if x >= low && x <= high => Ok(()),
        Some(x) => Err(format!("{key}: expected {low} to {high}, found {x}")),
        None => Err(format!("{key}: expected {low} to {high}, found nothing")),
    }
}

fn absent(key: &str, value: Option<f64>) -> Result<(), String> {
    value.map_or(Ok(()), |x| {
        Err(format!("{key}: expected nothing for this spectrum, found {x}"))
    })
}
