//! §2: the envelope of a wave field, whose bumps are the wave groups.
//!
//! ```text
//! (E1)  z(t) = sum_k A_k e^(i(omega_k t + phi_k)),  eta = Re z,  rho = |z|
//! ```
//! | paper | code | unit or shape | meaning |
//! |---|---|---|---|
//! | rho | `rho` | (fields)(n) m | envelope |
//!
//! The same as the modulus of eta and its Hilbert transform, from coefficients that are known. Tested against groups
//! of known envelope in `tests/physics/envelope.rs`.

use crate::numerics::fourier::{Synthesis, WIDTH};
use crate::numerics::invariant;
use crate::sea::wave_field::{Record, WaveFields, highest_envelope};
use serde::{Deserialize, Serialize};

/// Envelopes of the fields of a piece.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Envelopes {
    /// Time between samples, s.
    pub spacing: f64,
    /// rho at t = j spacing over one period: (fields)(n), m.
    pub rho: Vec<Vec<f64>>,
}

impl Envelopes {
    /// Checks that these are envelopes of waves of T_p (s) and H_s (m) on a record's grid, so many of them.
    ///
    /// # Errors
    /// The first thing that is not as the record makes it.
    pub fn check(&self, t_p: f64, h_s: f64, record: &Record, fields: usize) -> Result<(), String> {
        let spacing = t_p / f64::from(record.envelope_samples_per_period);
        invariant::equal("spacing", &self.spacing, &spacing)?;
        invariant::length("rho", &self.rho, fields)?;
        let highest = highest_envelope(h_s, record.modes);
        self.rho.iter().enumerate().try_for_each(|(field, rho)| {
            let place = format!("rho[{field}]");
            invariant::length(&place, rho, record.envelope_samples())?;
            invariant::all_within(&place, rho, &(0.0..=highest))
        })
    }

    /// (E1) The envelopes of all fields on the record's envelope grid.
    pub fn of(fields: &WaveFields, record: &Record) -> Self {
        let n = record.envelope_samples();
        let mut synthesis = Synthesis::new(fields.amplitude.len(), n);
        let mut block = vec![[0.0; WIDTH]; n];
        let mut rho = Vec::with_capacity(fields.phase.len());
        for first in (0..fields.phase.len()).step_by(WIDTH) {
            synthesis.modulus(&fields.spectrum(first), &mut block);
            for lane in 0..WIDTH.min(fields.phase.len() - first) {
                rho.push(block.iter().map(|sample| sample[lane]).collect());
            }
        }
        Self {
            spacing: fields.t_p / f64::from(record.envelope_samples_per_period),
            rho,
        }
    }
}
