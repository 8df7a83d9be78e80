//! The test bench of candidates: fields and groups of every sea, the same for all of them.
//!
//! Elevation is synthesised once per block of eight fields, and every candidate of a batch rolls on it.
//! Tested in `tests/physics/calibration.rs`.

use crate::calibration::candidate::{Candidate, TABLE};
use crate::calibration::settings::Target;
use crate::numerics::fourier::WIDTH;
use crate::numerics::rows::Rows;
use crate::sea::wave_field::{Record, WaveFields};
use crate::sea::wave_group::{Groups, WaveGroup};
use crate::ship::continuous_roll::{Timing, continuous_record};
use crate::ship::encounter::Encounter;
use crate::ship::exceedance::Exceedances;
use crate::ship::response::{Response, Truth};
use crate::ship::roll_equation::Ship;
use crate::ship::simulation::Simulation;
use serde::{Deserialize, Serialize};
use std::ops::Range;
use std::sync::Arc;

/// Some fields of one sea, and their groups by two similarity thresholds.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Fields {
    /// Modes and phases.
    pub waves: WaveFields,
    /// The pipeline's groups, and those of the other threshold.
    pub groups: [Groups; 2],
}

/// One sea of the bench.
pub struct Sea {
    /// What is to be met.
    pub target: Target,
    /// All fields, in pieces of whole blocks of eight.
    pub pieces: Vec<Arc<Fields>>,
}

/// Everything that candidates share.
pub struct Bench<'a> {
    /// The ship that candidates are measured from.
    pub printed: &'a Ship,
    /// How fields are represented.
    pub record: &'a Record,
    /// What counts as a response, under the plain reading.
    pub truth: &'a Truth,
    /// Longest group, envelope samples.
    pub longest: f64,
    /// The seas.
    pub seas: Vec<Sea>,
}

/// What a candidate did in one sea.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Tally {
    /// Exceedances of the target's threshold, per epsilon_1.
    pub counts: Vec<Exceedances>,
    /// Capsizes in the epsilon_1 of Table 1.
    pub capsizes: u64,
    /// Fields.
    pub fields: u64,
    /// Groups of all fields, also of those that left the statistics.
    pub met: u64,
}

/// A block of eight fields in memory.
pub struct Block<'a> {
    /// Elevation, m: one period in eight columns.
    pub eta: &'a [[f64; WIDTH]],
    /// Groups of the fields in use, by the two thresholds.
    pub groups: [Vec<Vec<Encounter>>; 2],
    /// The first field, counted over the sea.
    pub first: usize,
}

impl Sea {
    /// Peak period, s.
    pub fn t_p(&self) -> f64 {
        self.pieces.first().map_or(1.0, |piece| piece.waves.t_p)
    }

    /// Significant wave height, m: four standard deviations, the same in every field.
    pub fn h_s(&self) -> f64 {
        let squares = |sum: f64, amplitude: &f64| sum + amplitude * amplitude;
        let of = |piece: &Arc<Fields>| 4.0 * (0.5 * piece.waves.amplitude.iter().fold(0.0, squares)).sqrt();
        self.pieces.first().map_or(1.0, of)
    }
}

impl Bench<'_> {
    /// The time grid of a run in a sea.
    pub fn timing(&self, sea: &Sea) -> Timing {
        let t_p = sea.t_p();
        let spacing = t_p / f64::from(self.record.envelope_samples_per_period);
        let reach = self.truth.window * self.longest * spacing;
        let samples = self.record.samples() as u32;
        Timing::new(self.record.field_period(t_p), samples, self.record.lead_in, reach)
    }

    /// Shows the blocks of some fields of a sea, in order; the range starts and ends with a block.
    pub fn blocks(&self, sea: &Sea, fields: &Range<usize>, mut show: impl FnMut(&Block<'_>)) {
        let mut synthesis = self.record.synthesis();
        let mut eta = Rows::new(self.record.samples());
        let mut first = 0;
        for piece in &sea.pieces {
            let count = piece.waves.phase.len();
            for start in (0..count).step_by(WIDTH) {
                if !fields.contains(&(first + start)) {
                    continue;
                }
                piece.waves.elevation(start, &mut synthesis, &mut eta);
                let used = start..(start + WIDTH).min(count);
                let of = |groups: &Groups| {
                    groups.fields[used.clone()]
                        .iter()
                        .map(|list| encounters(list))
                        .collect()
                };
                show(&Block {
                    eta: &eta,
                    groups: [of(&piece.groups[0]), of(&piece.groups[1])],
                    first: first + start,
                });
            }
            first += count;
        }
    }

    /// Shows the responses of every candidate: its place, its groups, and what they did, `[epsilon_1][field]`.
    pub fn roll(
        &self,
        sea: &Sea,
        fields: &Range<usize>,
        candidates: &[Candidate],
        mut show: impl FnMut(usize, &[Vec<Encounter>], &[Vec<Response>]),
    ) {
        let timing = self.timing(sea);
        let ships: Vec<(Ship, Truth)> = candidates
            .iter()
            .map(|it| (it.ship(self.printed), it.reading.truth(self.truth)))
            .collect();
        self.blocks(sea, fields, |block| {
            for (place, (ship, truth)) in ships.iter().enumerate() {
                let groups = &block.groups[candidates[place].group_list()];
                let simulation = Simulation::new(ship, truth, timing.h);
                show(
                    place,
                    groups,
                    &continuous_record(&simulation, &timing, block.eta, groups).responses,
                );
            }
        });
    }

    /// What every candidate did in every sea, `[candidate][sea]`.
    pub fn tallies(&self, fields: &Range<usize>, candidates: &[Candidate]) -> Vec<Vec<Tally>> {
        let epsilons = self.printed.epsilon_1.len();
        let mut all = vec![Vec::new(); candidates.len()];
        for sea in &self.seas {
            let mut tallies = vec![Tally::none(epsilons); candidates.len()];
            self.roll(sea, fields, candidates, |place, groups, responses| {
                tallies[place].add(sea.target.theta_t, groups, responses);
            });
            for (own, tally) in all.iter_mut().zip(tallies) {
                own.push(tally);
            }
        }
        all
    }
}

impl Tally {
    /// Nothing yet.
    pub fn none(epsilons: usize) -> Self {
        Self {
            counts: vec![Exceedances::none(1); epsilons],
            capsizes: 0,
            fields: 0,
            met: 0,
        }
    }

    /// Adds the responses of a block, `[epsilon_1][field]`, to its groups.
    pub fn add(&mut self, theta_t: f64, groups: &[Vec<Encounter>], responses: &[Vec<Response>]) {
        self.met += groups.iter().map(|list| list.len() as u64).sum::<u64>();
        for (e, (counts, fields)) in self.counts.iter_mut().zip(responses).enumerate() {
            for field in fields {
                counts.add_field(&[theta_t], &field.r);
                if e == TABLE {
                    self.capsizes += u64::from(field.capsizes);
                    self.fields += 1;
                }
            }
        }
    }

    /// Exceedance probability at one epsilon_1, 0 without groups.
    pub fn probability(&self, e: usize) -> f64 {
        self.counts.get(e).and_then(|it| it.probability(0)).unwrap_or_default()
    }

    /// Its standard error by fields.
    pub fn standard_error(&self, e: usize) -> f64 {
        self.counts
            .get(e)
            .and_then(|it| it.standard_error(0))
            .unwrap_or_default()
    }

    /// Groups in the statistics at one epsilon_1.
    pub fn groups(&self, e: usize) -> f64 {
        self.counts.get(e).map_or(0.0, |it| it.n as f64)
    }
}

/// A field's groups as the ship sees them.
fn encounters(list: &[WaveGroup]) -> Vec<Encounter> {
    let of = |group: &WaveGroup| Encounter {
        t_c: group.t_c,
        l: group.l,
        a: group.a,
    };
    list.iter().map(of).collect()
}
