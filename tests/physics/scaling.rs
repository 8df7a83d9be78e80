//! Claims about units: a sea and a ship of another size, on another clock, have the same groups and the same roll.
//!
//! Lengths and times are scaled by powers of two, by which every product, quotient and square root scales exactly: results
//! are then equal to the last bit but for the scale itself. A tolerance in metres or seconds anywhere on the way shows.

use crate::physics::roll_twin::{printed, truth};
use crate::physics::seas::{detection, fields, four_seas, record};
use encounter::numerics::fourier::{Synthesis, WIDTH};
use encounter::numerics::rows::Rows;
use encounter::sea::detection::unit::unit_of;
use encounter::sea::detection::{Detection, detect};
use encounter::sea::envelope::Envelopes;
use encounter::sea::spectrum::Sea;
use encounter::sea::wave_field::{Record, WaveFields};
use encounter::sea::wave_group::{Groups, WaveGroup};
use encounter::ship::continuous_roll::{Timing, continuous_record};
use encounter::ship::encounter::{
    Approach, Encounter, GroupRun, RecordRun, max_roll_along_record, max_roll_through_groups,
};
use encounter::ship::initial_condition::RollState;
use encounter::ship::linear_response::{Oscillator, largest_about};
use encounter::ship::response::{Capsize, Response, Roll, Truth};
use encounter::ship::roll_equation::{Damping, Ship};
use encounter::ship::sample::Selection;
use encounter::ship::simulation::Simulation;
use std::f64::consts::TAU;

/// Lengths and times in shares of those of the paper.
#[derive(Clone, Copy, Debug)]
struct Scale {
    length: f64,
    time: f64,
}

const FULL: Scale = Scale { length: 1.0, time: 1.0 };

/// Fields of a sea: the lanes of one block.
const FIELDS: u64 = WIDTH as u64;

impl Scale {
    /// The elevation alone by 2^k.
    fn of_height(k: i32) -> Self {
        Self {
            length: power_of_two(k),
            time: 1.0,
        }
    }

    /// By Froude's law lengths are scaled by 4^k, and times by 2^k.
    fn froude(k: i32) -> Self {
        Self {
            length: power_of_two(2 * k),
            time: power_of_two(k),
        }
    }

    fn sea(self, sea: &Sea) -> Sea {
        Sea {
            significant_wave_height: sea.significant_wave_height * self.length,
            peak_period: sea.peak_period * self.time,
            bandwidth: sea.bandwidth.map(|bandwidth| bandwidth / self.time),
            ..sea.clone()
        }
    }

    fn record(self) -> Record {
        Record {
            lead_in: record().lead_in * self.time,
            ..record()
        }
    }

    fn detection(self) -> Detection {
        Detection {
            smallest_amplitude: detection().smallest_amplitude * self.length,
            ..detection()
        }
    }

    /// Eq. (6) in the scaled units: the roll is an angle, so only times and the elevation matter.
    fn ship(self, ship: &Ship) -> Ship {
        let excitation = 1.0 / (self.length * self.time * self.time);
        Ship {
            alpha_1: ship.alpha_1 / self.time,
            alpha_2: match ship.damping {
                Damping::Cubic => ship.alpha_2 * self.time,
                Damping::Quadratic => ship.alpha_2,
            },
            damping: ship.damping,
            beta_1: ship.beta_1 / (self.time * self.time),
            beta_2: ship.beta_2 / (self.time * self.time),
            epsilon_1: ship.epsilon_1.iter().map(|epsilon_1| epsilon_1 * excitation).collect(),
            epsilon_2: ship.epsilon_2 * excitation,
        }
    }

    fn group(self, group: &WaveGroup) -> WaveGroup {
        WaveGroup {
            t_c: group.t_c * self.time,
            l: group.l * self.time,
            a: group.a * self.length,
            similarity: group.similarity,
        }
    }

    fn waves(self, sea: &Sea) -> WaveFields {
        fields(&self.sea(sea), &self.record(), 300, FIELDS)
    }

    fn groups(self, waves: &WaveFields) -> Groups {
        detect(&Envelopes::of(waves, &self.record()), &self.detection())
    }
}

fn power_of_two(k: i32) -> f64 {
    f64::from_bits(u64::try_from(1023 + k).expect("k is small") << 52)
}

/// The groups of every field, scaled.
fn scaled(groups: &Groups, scale: Scale) -> Groups {
    let field = |field: &Vec<WaveGroup>| field.iter().map(|group| scale.group(group)).collect();
    Groups {
        fields: groups.fields.iter().map(field).collect(),
    }
}

/// H_s = 1.5 mm to 768 m: all powers of two that the range of `significant_wave_height`, 1 mm to 1 km, leaves from 12 m.
#[test]
fn at_every_height_by_a_power_of_two_the_groups_are_the_same_to_the_bit() {
    for sea in four_seas() {
        let expected = FULL.groups(&FULL.waves(&sea));
        assert!(expected.fields.concat().len() > 100);
        for scale in (-13..=6).map(Scale::of_height) {
            let scaled_sea = scale.sea(&sea);
            assert_eq!(scaled_sea.check(), Ok(()));
            let found = scale.groups(&scale.waves(&sea));
            assert_eq!(found, scaled(&expected, scale), "{scaled_sea:?}");
        }
    }
}

/// A field of the paper's seas keeps all its bits, and with them the groups that the public code's settings give.
#[test]
fn a_field_of_twelve_metres_is_measured_in_metres_exactly() {
    for sea in four_seas() {
        let waves = fields(&sea, &record(), 0, 64);
        for rho in Envelopes::of(&waves, &record()).rho {
            assert_eq!(unit_of(&rho).to_bits(), 1.0_f64.to_bits());
        }
    }
}

#[test]
fn an_envelope_of_nothing_or_out_of_range_has_the_unit_one() {
    for rho in [vec![], vec![0.0; 8], vec![1e-200; 8], vec![1e200; 8]] {
        assert_eq!(unit_of(&rho).to_bits(), 1.0_f64.to_bits());
    }
    // A carry of the rounding runs on into the exponent: 12 units in the last bit below 2 are 2.
    let almost_two = 2.0 - 12.0 * f64::EPSILON;
    let rho = vec![12.0 / 8.0_f64.sqrt() * almost_two; 16];
    assert_eq!(unit_of(&rho).to_bits(), 2.0_f64.to_bits());
}

/// The share of the expected groups that have a found one with the same centre, length and amplitude within 1e-6.
fn share_found(expected: &Groups, found: &Groups) -> f64 {
    let is_near = |p: &WaveGroup, q: &WaveGroup| {
        let differences = [(p.t_c - q.t_c) / q.l, (p.l - q.l) / q.l, (p.a - q.a) / q.a];
        differences.iter().all(|difference| difference.abs() < 1e-6)
    };
    let (mut all, mut near) = (0.0, 0.0);
    for (expected, found) in expected.fields.iter().zip(&found.fields) {
        for group in expected {
            all += 1.0;
            near += f64::from(found.iter().any(|other| is_near(other, group)));
        }
    }
    near / all
}

/// By another factor the division rounds, and (G1) has kinks at which the last bit decides which way a fit goes.
#[test]
fn at_any_other_height_the_groups_are_the_same_within_rounding() {
    for height in [0.001, 0.0123, 0.3, 1.0, 5.7, 11.0, 12.1, 100.0, 1000.0] {
        let scale = Scale {
            length: height / 12.0,
            time: 1.0,
        };
        for sea in four_seas() {
            let expected = FULL.groups(&FULL.waves(&sea));
            let found = scale.groups(&scale.waves(&sea));
            let counts = [&expected, &found].map(|groups| groups.fields.concat().len());
            let share = share_found(&scaled(&expected, scale), &found);
            assert!(
                share > 0.99 && counts[0] == counts[1],
                "{height} m: {share} of {counts:?}"
            );
        }
    }
}

/// All that the stages make of a sea and a ship, in units without a scale: rad, shares of time, counts.
#[derive(Debug, PartialEq)]
struct Outcome {
    truth: Vec<Vec<Response>>,
    angles: Vec<Vec<Vec<f64>>>,
    nic_record: Vec<Vec<f64>>,
    nic_groups: Vec<Vec<f64>>,
    cic: Vec<Vec<f64>>,
    pic: Vec<Vec<f64>>,
    linear: Vec<f64>,
}

fn outcome(scale: Scale, sea: &Sea, ship: &Ship, truth: &Truth) -> Outcome {
    let (waves, record, ship) = (scale.waves(sea), scale.record(), scale.ship(ship));
    let groups = scale.groups(&waves);
    let encounters = Selection::new(groups.parameters(), &[]).groups;
    let (h, period) = record.step_and_period(waves.t_p);
    let longest = scale.detection().longest * waves.t_p / f64::from(record.envelope_samples_per_period);
    let timing = Timing::new(period, record.samples() as u32, record.lead_in, truth.window * longest);
    let simulation = Simulation::new(&ship, truth, h);
    let approach = Approach {
        h,
        field_period: period,
        truth_window: truth.window,
        estimate_window: 3.0,
        groups_ahead: 2,
    };
    let mut eta = Rows::new(record.samples());
    waves.elevation(0, &mut record.synthesis(), &mut eta);
    let rolled = continuous_record(&simulation, &timing, &eta, &encounters);

    let places: Vec<(usize, usize)> = encounters
        .iter()
        .enumerate()
        .flat_map(|(field, groups)| (0..groups.len()).map(move |i| (field, i)))
        .collect();
    let along = |(field, i): &(usize, usize)| approach.through_record(*field as u32, &encounters[*field], *i);
    let along: Vec<RecordRun> = places.iter().map(along).collect();
    let through = |(field, i): &(usize, usize)| approach.through_groups(&encounters[*field], *i);
    let through: Vec<GroupRun> = places.iter().map(through).collect();
    let flat: Vec<Encounter> = encounters.concat();
    let alone: Vec<GroupRun> = flat.iter().map(|group| approach.alone(*group)).collect();
    let state = |run: usize| RollState {
        theta: 0.001 * run as f64,
        theta_dot: 0.02 / scale.time,
    };
    let states = vec![(0..alone.len()).map(state).collect(); ship.epsilon_1.len()];
    Outcome {
        truth: rolled.responses,
        angles: rolled.angles,
        nic_record: max_roll_along_record(&simulation, &eta, &along),
        nic_groups: max_roll_through_groups(&simulation, waves.t_p, &through, &[]),
        cic: max_roll_through_groups(&simulation, waves.t_p, &alone, &[]),
        pic: max_roll_through_groups(&simulation, waves.t_p, &alone, &states),
        linear: linear_responses(&waves, &record, &ship, &encounters, truth.window),
    }
}

/// The linear oscillator's largest response to each group.
fn linear_responses(
    waves: &WaveFields,
    record: &Record,
    ship: &Ship,
    groups: &[Vec<Encounter>],
    window: f64,
) -> Vec<f64> {
    let samples = record.envelope_samples();
    let spacing = record.field_period(waves.t_p) / samples as f64;
    let mut spectrum = waves.spectrum(0);
    Oscillator::balanced(ship, 0.5, TAU / waves.t_p).respond(&mut spectrum, waves.delta_omega);
    let mut series = vec![[0.0; WIDTH]; samples];
    Synthesis::new(waves.amplitude.len(), samples).modulus(&spectrum, &mut series);
    let of = |lane: usize, group: &Encounter| {
        largest_about(|i| series[i][lane], samples, spacing, group.t_c, window * group.l)
    };
    let lanes = groups.iter().enumerate();
    lanes
        .flat_map(|(lane, groups)| groups.iter().map(move |group| (lane, group)))
        .map(|(lane, group)| of(lane, group))
        .collect()
}

/// The ship with the printed damping and a tenth of the printed parametric excitation: capsizes are rare.
fn calibrated(damping: Damping) -> Ship {
    Ship {
        damping,
        beta_1: 0.1466,
        beta_2: -0.106,
        epsilon_1: vec![0.0, 0.0024, 0.0048],
        epsilon_2: 0.00239,
        ..printed()
    }
}

#[test]
fn a_model_by_froudes_law_rolls_as_the_ship_to_the_bit() {
    let signed = Truth {
        roll: Roll::Signed,
        capsize: Capsize::DiscardField,
        ..truth()
    };
    for (ship, truth) in [
        (printed(), truth()),
        (calibrated(Damping::Cubic), truth()),
        (calibrated(Damping::Quadratic), signed),
    ] {
        for sea in four_seas() {
            let expected = outcome(FULL, &sea, &ship, &truth);
            assert!(expected.nic_record[0].len() > 100);
            // From 1:4096, waves of 3 mm, to 64 times the paper's ship; with g as it is, and on clocks of any other gravity.
            let scales = [-6, -3, -1, 1, 3].map(Scale::froude);
            let others = [(-5, 2), (3, -4)].map(|(length, time)| Scale {
                length: power_of_two(length),
                time: power_of_two(time),
            });
            for scale in scales.iter().chain(&others) {
                let found = outcome(*scale, &sea, &ship, &truth);
                assert!(found == expected, "{scale:?} {sea:?} {ship:?}");
            }
        }
    }
}
