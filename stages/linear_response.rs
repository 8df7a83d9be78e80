//! §4 What linear oscillators like the ship do about each sampled group: known without running the ship.

use std::f64::consts::TAU;
use std::ops::Range;
use std::sync::Arc;

use serde::{Deserialize, Serialize};

use crate::design::settings::Case;
use crate::engine::arrow::{Each, One};
use crate::engine::error::{Error, Result};
use crate::engine::stage::{Here, Pieces, Select, Stage};
use crate::numerics::domain::at_most;
use crate::numerics::fourier::{Synthesis, WIDTH};
use crate::sea::wave_field::{Record, WaveFields};
use crate::sea::wave_group::{Groups, Sample};
use crate::ship::linear_response::{LinearResponses, Oscillator, geometric_means, largest_about};
use crate::ship::resolution::of_oscillator;
use crate::ship::response::Truth;
use crate::ship::roll_equation::Ship;
use crate::stages::axes::SEA;
use crate::stages::group_detection::GroupDetection;
use crate::stages::group_sample::GroupSample;
use crate::stages::resolution::Waves;
use crate::stages::wave_synthesis::WaveSynthesis;

/// The largest roll of the oscillators in the original waves, their geometric mean group by group.
pub struct LinearResponse;

/// Largest amplitude of the harmonic balance, in theta_t.
const LARGEST: f64 = 10.0;

/// Most amplitudes.
const MOST_AMPLITUDES: u64 = 32;

/// Parameters of the linear response.
#[derive(Serialize, Deserialize)]
pub struct Params {
    ship: Ship,
    sea: Waves,
    record: Record,
    truth: Truth,
    vhgp_seq: Row,
    linear_response: Settings,
}

/// The part of `[vhgp_seq]` that the oscillators are made for.
#[derive(Serialize, Deserialize)]
pub struct Row {
    /// The row of Table 1.
    case: Vec<Case>,
}

/// The `[linear_response]` table.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Settings {
    /// Amplitudes of the harmonic balance, in theta_t.
    amplitudes: Vec<f64>,
}

impl Params {
    /// The ship balanced at every amplitude and the frequency `omega` (rad/s); none without a row of Table 1.
    fn oscillators(&self, omega: f64) -> Vec<Oscillator> {
        let rows = self.vhgp_seq.case.iter().take(1);
        let amplitudes = rows.flat_map(|row| self.linear_response.amplitudes.iter().map(move |a| a * row.theta_t));
        amplitudes
            .map(|theta_a| Oscillator::balanced(&self.ship, theta_a, omega))
            .collect()
    }
}

impl Stage for LinearResponse {
    const NAME: &'static str = "linear_response";
    const PAPER: &'static str = "§4";
    const PIECES: Pieces = Pieces::AsUpstream;
    const SELECTS: &'static [Select] = &[Select::Rows(SEA, "vhgp_seq.case")];
    const SCHEMA: &'static str = "linear-responses/1";
    type Params = Params;
    type Inputs = (Each<WaveSynthesis>, Each<GroupDetection>, One<GroupSample>);
    type Output = LinearResponses;

    fn check(p: &Params) -> std::result::Result<(), String> {
        p.ship.check().map_err(|why| format!("ship.{why}"))?;
        p.truth.check().map_err(|why| format!("truth.{why}"))?;
        let found = &p.linear_response.amplitudes;
        let since = "the waves of every group go through an oscillator for each";
        at_most("linear_response.amplitudes", found.len() as u64, MOST_AMPLITUDES, since)?;
        if !found.is_empty() && found.iter().all(|a| *a > 0.0 && *a <= LARGEST) {
            return Ok(());
        }
        Err(format!(
            "linear_response.amplitudes: expected numbers above 0 and up to {LARGEST}, at least one, found {found:?}"
        ))
    }

    fn resolution(p: &Params) -> std::result::Result<Vec<String>, String> {
        let omega_p = TAU / p.sea.peak_period;
        let delta_omega = omega_p / f64::from(p.record.periods_per_field);
        let oscillators = p.oscillators(omega_p);
        // The one that is damped least has the narrowest resonance.
        let least = oscillators.iter().map(|own| own.alpha).fold(f64::INFINITY, f64::min);
        Ok(of_oscillator(least, delta_omega).into_iter().collect())
    }

    fn check_output(_: &Params, _: Range<u64>, output: &LinearResponses) -> std::result::Result<(), String> {
        output.check()
    }

    fn run(
        p: &Params,
        (waves, groups, sample): (Arc<WaveFields>, Arc<Groups>, Arc<Sample>),
        here: Here<'_>,
    ) -> Result<LinearResponses> {
        let places = sample.of(here.first, &groups).map_err(Error::stage)?;
        if p.vhgp_seq.case.is_empty() {
            return Err(Error::stage("no row of vhgp_seq.case names this sea"));
        }
        let oscillators = p.oscillators(TAU / waves.t_p);
        let samples = p.record.envelope_samples();
        let spacing = p.record.field_period(waves.t_p) / samples as f64;
        let mut synthesis = Synthesis::new(waves.amplitude.len(), samples);
        let mut block = vec![[0.0; WIDTH]; samples];
        let mut z = Vec::new();
        let fields: Vec<_> = groups.fields.iter().zip(places).collect();
        for (block_index, fields) in fields.chunks(WIDTH).enumerate() {
            let spectrum = waves.spectrum(block_index * WIDTH);
            let largest = |oscillator: &Oscillator| {
                let mut response = spectrum.clone();
                oscillator.respond(&mut response, waves.delta_omega);
                synthesis.modulus(&response, &mut block);
                let mut own = Vec::new();
                for (lane, (groups, places)) in fields.iter().enumerate() {
                    for group in places.iter().map(|place| &groups[*place as usize]) {
                        let reach = p.truth.window * group.l;
                        own.push(largest_about(|i| block[i][lane], samples, spacing, group.t_c, reach));
                    }
                }
                own
            };
            let of_each: Vec<Vec<f64>> = oscillators.iter().map(largest).collect();
            z.extend(geometric_means(&of_each));
        }
        Ok(LinearResponses { z })
    }
}
