//! §4 What linear oscillators would do about each sampled group: free, and near what the ship does.

use std::f64::consts::TAU;
use std::sync::Arc;

use serde::{Deserialize, Serialize};

use crate::engine::arrow::{Each, One};
use crate::engine::error::Result;
use crate::engine::stage::{Here, Pieces, Stage};
use crate::numerics::fourier::{Synthesis, WIDTH};
use crate::sea::wave_field::{Record, WaveFields};
use crate::sea::wave_group::{Groups, Sample};
use crate::ship::linear_response::{LinearResponses, Oscillator};
use crate::ship::response::Truth;
use crate::ship::roll_equation::Ship;
use crate::stages::group_detection::GroupDetection;
use crate::stages::group_sample::GroupSample;
use crate::stages::wave_synthesis::WaveSynthesis;

/// Largest rolls of linear oscillators.
pub struct LinearResponse;

/// Parameters of the linear responses.
#[derive(Serialize, Deserialize)]
pub struct Params {
    ship: Ship,
    record: Record,
    truth: Truth,
    linear_response: Settings,
}

/// The `[linear_response]` table.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Settings {
    amplitudes: Vec<f64>,
}

impl Stage for LinearResponse {
    const NAME: &'static str = "linear_response";
    const PAPER: &'static str = "§4";
    const PIECES: Pieces = Pieces::AsUpstream;
    const SCHEMA: &'static str = "linear-responses/1";
    type Params = Params;
    type Inputs = (Each<WaveSynthesis>, Each<GroupDetection>, One<GroupSample>);
    type Output = LinearResponses;

    fn run(
        p: &Params,
        (waves, groups, sample): (Arc<WaveFields>, Arc<Groups>, Arc<Sample>),
        here: Here<'_>,
    ) -> Result<LinearResponses> {
        let samples = p.record.envelope_samples();
        let spacing = waves.t_p / f64::from(p.record.envelope_samples_per_period);
        let mut synthesis = Synthesis::new(waves.amplitude.len(), samples);
        let mut block = vec![[0.0; WIDTH]; samples];
        let omega_p = TAU / waves.t_p;
        let places = sample.of(here.first, here.items);
        let mut z = vec![Vec::new(); p.linear_response.amplitudes.len()];
        for first in (0..places.len()).step_by(WIDTH) {
            let spectrum = waves.spectrum(first);
            for (z, theta_a) in z.iter_mut().zip(&p.linear_response.amplitudes) {
                let oscillator = Oscillator::balanced(&p.ship, *theta_a, omega_p);
                let mut own = spectrum.clone();
                oscillator.respond(&mut own, waves.delta_omega);
                synthesis.modulus(&own, &mut block);
                for lane in 0..WIDTH.min(places.len() - first) {
                    for place in &places[first + lane] {
                        let group = &groups.fields[first + lane][*place as usize];
                        let reach = p.truth.window * group.l;
                        let from = ((group.t_c - reach) / spacing).ceil() as i64;
                        let to = ((group.t_c + reach) / spacing).floor() as i64;
                        let mut largest = 0.0;
                        for i in from..=to {
                            let v = block[i.rem_euclid(samples as i64) as usize][lane];
                            largest = if v > largest { v } else { largest };
                        }
                        z.push(largest);
                    }
                }
            }
        }
        Ok(LinearResponses { z })
    }
}
