//! §2: wave fields, periodic sums of modes with random phases.
//!
//! | paper | code | unit or shape | meaning |
//! |---|---|---|---|
//! | delta omega | `delta_omega` | rad/s | omega_p / `periods_per_field` |
//! | A_k, phi_k | `amplitude`, `phase` | (modes) m, (fields)(modes) rad | |
//! | eta | `elevation` | m | surface elevation |
//!
//! ```text
//! (W4)  eta(t) = sum_k A_k cos(omega_k t + phi_k),  phi_k = 2 pi u_k
//! ```
//! A field's variance is (H_s/4)^2 exactly: only the phases are random. Tested in `tests/physics/wave_field.rs`.

use crate::numerics::fourier::{LONGEST, Lanes, Synthesis, WIDTH};
use crate::numerics::lanes::{Kernel, dispatch};
use crate::numerics::{domain, elementary, invariant, random};
use crate::sea::spectrum::Sea;
use num_complex::Complex;
use num_traits::Zero;
use rand_chacha::ChaCha12Rng;
use serde::{Deserialize, Serialize};

/// Most samples of one field's series; its buffers for eight fields then take 268 MB.
const MOST_SAMPLES: u64 = 1 << 22;

/// Most steps of the roll before t = 0.
const MOST_LEAD_IN: f64 = 1e7;

/// The table `[record]` but for its count of fields: how each field is represented.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Record {
    /// Length of a field, T_p.
    #[serde(deserialize_with = "domain::power_of_two")]
    pub periods_per_field: u32,
    /// Modes k = 1, 2, ... of a field.
    #[serde(deserialize_with = "domain::count")]
    pub modes: u32,
    /// Samples of eta per T_p; a Runge-Kutta step is two of them.
    #[serde(deserialize_with = "domain::power_of_two")]
    pub samples_per_period: u32,
    /// Samples of the envelope per T_p.
    #[serde(deserialize_with = "domain::power_of_two")]
    pub envelope_samples_per_period: u32,
    /// Time at rest before t = 0 on the periodic extension, s.
    #[serde(deserialize_with = "domain::non_negative")]
    pub lead_in: f64,
}

impl Record {
    /// Checks that the modes reach past the peak and that both grids represent them all.
    ///
    /// # Errors
    /// Names the key, what was expected and what was found.
    pub fn check(&self) -> Result<(), String> {
        let (periods, modes) = (u64::from(self.periods_per_field), u64::from(self.modes));
        let expect = |ok: bool, key: &str, expected: String, found: u64| {
            if ok {
                return Ok(());
            }
            Err(format!("{key}: expected {expected}, found {found}"))
        };
        let most = LONGEST as u64;
        expect(
            periods < most,
            "periods_per_field",
            format!("less than {most}"),
            periods,
        )?;
        let reach = format!("more than periods_per_field, {periods}, and at most {most}");
        expect(modes > periods && modes <= most, "modes", reach, modes)?;
        let (eta, rho) = (self.samples_per_period, self.envelope_samples_per_period);
        let many = |n: u64, low: u64, high: u64| n >= low && n <= high;
        expect(
            many(periods * u64::from(eta), 2 * modes + 1, MOST_SAMPLES),
            "samples_per_period",
            format!(
                "more than 2 x {modes} and at most {MOST_SAMPLES} samples per field of `periods_per_field` = {periods}"
            ),
            u64::from(eta),
        )?;
        expect(
            many(periods * u64::from(rho), 2 * modes, most),
            "envelope_samples_per_period",
            format!("from 2 x {modes} to {most} samples per field of `periods_per_field` = {periods}"),
            u64::from(rho),
        )
    }

    /// Checks that a ship on waves of peak period `t_p` (s) gets through the lead-in.
    ///
    /// # Errors
    /// Names the key, what was expected and what was found.
    pub fn check_lead_in(&self, t_p: f64) -> Result<(), String> {
        let most = MOST_LEAD_IN * self.h(t_p);
        if self.lead_in <= most {
            return Ok(());
        }
        let found = self.lead_in;
        Err(format!(
            "lead_in: expected at most {most} s, {MOST_LEAD_IN} steps of the roll before each field, found {found}"
        ))
    }

    /// Samples of eta in one field.
    pub fn samples(&self) -> usize {
        self.periods_per_field as usize * self.samples_per_period as usize
    }

    /// The most samples of eta per T_p that a field of this length may have.
    pub fn most_samples_per_period(&self) -> u32 {
        (MOST_SAMPLES / u64::from(self.periods_per_field)) as u32
    }

    /// Samples of the envelope in one field.
    pub fn envelope_samples(&self) -> usize {
        self.periods_per_field as usize * self.envelope_samples_per_period as usize
    }

    /// The period T_f of a field, s.
    pub fn field_period(&self, t_p: f64) -> f64 {
        t_p * f64::from(self.periods_per_field)
    }

    /// The RK4 step h, s: two samples of eta.
    pub fn h(&self, t_p: f64) -> f64 {
        self.field_period(t_p) / (self.samples() / 2) as f64
    }

    /// The step h and the field period T_f, s.
    pub fn step_and_period(&self, t_p: f64) -> (f64, f64) {
        (self.h(t_p), self.field_period(t_p))
    }

    /// The plan by which [`WaveFields::elevation`] computes eta.
    pub fn synthesis(&self) -> Synthesis {
        Synthesis::new(self.modes as usize, self.samples())
    }
}

/// What no envelope exceeds, m: all modes in phase, sum A_k <= sqrt(modes sum A_k^2) with sum A_k^2 = H_s^2/8.
pub fn highest_envelope(h_s: f64, modes: u32) -> f64 {
    // The last term stands for rounding.
    h_s * (f64::from(modes) / 8.0).sqrt() * (1.0 + 1e-9)
}

/// Modes and phases of the fields of a piece; the series are made from them when needed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct WaveFields {
    /// Peak period, s.
    pub t_p: f64,
    /// Spacing of the modes, rad/s.
    pub delta_omega: f64,
    /// A_k, the same in every field: (modes), m.
    pub amplitude: Vec<f64>,
    /// phi_k in [0, 2 pi]: (fields)(modes), rad.
    pub phase: Vec<Vec<f64>>,
}

impl WaveFields {
    /// Draws the phases of one field from each stream, k ascending.
    pub fn draw(sea: &Sea, record: &Record, streams: impl Iterator<Item = ChaCha12Rng>) -> Self {
        let delta_omega = sea.omega_p() / f64::from(record.periods_per_field);
        let phases = |mut stream: ChaCha12Rng| {
            (0..record.modes)
                .map(|_| std::f64::consts::TAU * random::uniform(&mut stream))
                .collect()
        };
        Self {
            t_p: sea.peak_period,
            delta_omega,
            amplitude: sea.amplitudes(record.modes, delta_omega),
            phase: streams.map(phases).collect(),
        }
    }

    /// Checks that these are fields of a sea and record, so many of them.
    ///
    /// # Errors
    /// The first thing that is not as the sea and the record make it.
    pub fn check(&self, sea: &Sea, record: &Record, fields: usize) -> Result<(), String> {
        let modes = record.modes as usize;
        let delta_omega = sea.omega_p() / f64::from(record.periods_per_field);
        invariant::equal("t_p", &self.t_p, &sea.peak_period)?;
        invariant::equal("delta_omega", &self.delta_omega, &delta_omega)?;
        invariant::length("amplitude", &self.amplitude, modes)?;
        let highest = highest_envelope(sea.significant_wave_height, record.modes);
        invariant::all_within("amplitude", &self.amplitude, &(0.0..=highest))?;
        invariant::length("phase", &self.phase, fields)?;
        self.phase.iter().enumerate().try_for_each(|(field, phase)| {
            let place = format!("phase[{field}]");
            invariant::length(&place, phase, modes)?;
            invariant::all_within(&place, phase, &(0.0..=std::f64::consts::TAU))
        })
    }

    /// Period of a field, s.
    pub fn field_period(&self) -> f64 {
        std::f64::consts::TAU / self.delta_omega
    }

    /// c_k = A_k e^(i phi_k) of the fields `first`.. in lanes, mode k at k - 1; lanes past the last field are zero.
    pub fn spectrum(&self, first: usize) -> Vec<Complex<Lanes>> {
        dispatch(Spectrum { fields: self, first })
    }

    /// (W4) eta of the fields `first`.. in lanes, `out[j]` at t = j T_f/samples, m.
    pub fn elevation(&self, first: usize, synthesis: &mut Synthesis, out: &mut [[f64; WIDTH]]) {
        synthesis.real_series(&self.spectrum(first), out);
    }
}

/// [`WaveFields::spectrum`] for every instruction set.
struct Spectrum<'a> {
    fields: &'a WaveFields,
    first: usize,
}

impl Kernel for Spectrum<'_> {
    type Output = Vec<Complex<Lanes>>;

    #[inline(always)]
    fn run(self) -> Self::Output {
        let modes = self.fields.amplitude.len();
        let phase = &self.fields.phase[self.first.min(self.fields.phase.len())..];
        let none = vec![0.0; modes];
        let rows: [&[f64]; WIDTH] = std::array::from_fn(|lane| phase.get(lane).map_or(&none[..], |row| &row[..modes]));
        let used: [f64; WIDTH] = std::array::from_fn(|lane| if lane < phase.len() { 1.0 } else { 0.0 });
        let mut spectrum = vec![Complex::zero(); modes];
        for (k, (c, a)) in spectrum.iter_mut().zip(&self.fields.amplitude).enumerate() {
            let phi = std::array::from_fn(|lane| rows[lane][k]);
            let amplitude = Lanes(used.map(|used| used * a));
            let (sin, cos) = elementary::sin_cos_lanes(phi);
            *c = Complex {
                re: Lanes(cos) * amplitude,
                im: Lanes(sin) * amplitude,
            };
        }
        spectrum
    }
}
