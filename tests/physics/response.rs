//! Claims about continuous roll: lanes against a scalar run that keeps its whole trajectory, bit for bit.

use super::roll_twin::{Trajectory, printed, truth};
use encounter::numerics::elementary::cos;
use encounter::numerics::lanes::Level;
use encounter::ship::continuous_roll::{Rolled, Timing, continuous_record, continuous_states};
use encounter::ship::encounter::Encounter;
use encounter::ship::initial_condition::RollState;
use encounter::ship::response::{Capsize, Response, Roll, Truth};
use encounter::ship::roll_equation::{Damping, Ship};
use encounter::ship::simulation::Simulation;
use std::f64::consts::TAU;

const SAMPLES: usize = 3072;
const LEVELS: [Level; 3] = [Level::Base, Level::Avx2, Level::Avx512];

/// Eight fields of 24 T_p: a few cosines each, the last columns high enough to capsize even at epsilon_1 = 0.
fn elevation() -> Vec<[f64; 8]> {
    let row = |j: usize| {
        [0, 1, 2, 3, 4, 5, 6, 7].map(|c: usize| {
            let height = if c > 5 { 6.0 } else { 1.2 };
            let turns = |k: usize| (k * j % SAMPLES) as f64 / SAMPLES as f64;
            let wave = |k: usize| cos(turns(k) * TAU + (k * k * (c + 3)) as f64);
            (18..31).map(wave).sum::<f64>() * height
        })
    };
    (0..SAMPLES).map(row).collect()
}

fn timing() -> Timing {
    Timing::new(24.0 * 15.0, SAMPLES as u32, 130.0, 2.0 * 45.0)
}

/// Groups of every length, at both ends of the record too.
fn groups() -> Vec<Vec<Encounter>> {
    let group = |c: usize, i: usize| Encounter {
        t_c: 360.0 * (i as f64 + 0.11 * c as f64) / 6.0 + 0.03,
        l: 9.5 + ((5 * i + c) % 8) as f64 * 5.0,
        a: 4.0,
    };
    (0..7).map(|c| (0..6).map(|i| group(c, i)).collect()).collect()
}

fn twin(ship: &Ship, truth: &Truth, eta: &[[f64; 8]], groups: &[Vec<Encounter>]) -> Rolled {
    let timing = timing();
    let of_field = |epsilon_1: f64, column: usize, list: &[Encounter]| {
        let wave = |j: i64| eta[j.rem_euclid(SAMPLES as i64) as usize][column];
        let rules = (ship, epsilon_1, truth, timing.h);
        let t = Trajectory::run(rules, -timing.lead_in, timing.steps + timing.tail, (0.0, 0.0), wave);
        let dropped = truth.capsize == Capsize::DiscardField && !t.capsizes.is_empty();
        let r = |g: &Encounter| {
            let reach = truth.window * g.l;
            let first = ((g.t_c - reach) / timing.h).ceil() as i64;
            t.largest(first, ((g.t_c + reach) / timing.h).floor() as i64)
        };
        let record = |s: &i64| (0..timing.steps).contains(s);
        let is_above = |s: &i64| {
            let (theta, _) = t.states[(s + timing.lead_in) as usize];
            theta.abs() > truth.temporal_level || t.capsizes.contains(s)
        };
        let angle = |s: i64| {
            let (theta, _) = t.states[(s + timing.lead_in) as usize];
            let capsized = t.capsizes.contains(&s);
            if capsized { truth.capsize_angle } else { theta.abs() }
        };
        let angles = (0..timing.steps).step_by(16).map(angle).collect();
        let response = Response {
            r: if dropped {
                Vec::new()
            } else {
                list.iter().map(r).collect()
            },
            capsizes: t.capsizes.iter().copied().filter(record).count() as u32,
            time_above: (0..timing.steps).filter(is_above).count() as f64 / timing.steps as f64,
            dropped,
        };
        (response, angles)
    };
    let at = |epsilon_1: &f64| {
        let fields = groups.iter().enumerate();
        fields.map(|(c, list)| of_field(*epsilon_1, c, list)).unzip()
    };
    let (responses, angles) = ship.epsilon_1.iter().map(at).unzip();
    Rolled { responses, angles }
}

fn agrees_with_its_twin(ship: &Ship, truth: &Truth) -> Vec<Vec<Response>> {
    let (eta, groups) = (elevation(), groups());
    let expected = twin(ship, truth, &eta, &groups);
    for level in LEVELS {
        let simulation = Simulation {
            level,
            ..Simulation::new(ship, truth, timing().h)
        };
        let found = continuous_record(&simulation, &timing(), &eta, &groups);
        assert_eq!(found, expected, "{level:?}");
    }
    expected.responses
}

#[test]
fn responses_are_those_of_the_whole_trajectory() {
    let expected = agrees_with_its_twin(&printed(), &truth());
    let capsizes = |e: usize| expected[e].iter().map(|f| f.capsizes).sum::<u32>();
    assert!(capsizes(0) > 0 && capsizes(2) > capsizes(0), "both fates must occur");
    let upright = |f: &&Response| f.capsized_groups(truth().capsize_angle) == 0;
    assert!(expected[0].iter().filter(upright).count() >= 4);
}

#[test]
fn signed_roll_is_the_largest_to_one_side() {
    let signed = Truth {
        roll: Roll::Signed,
        ..truth()
    };
    let signed = agrees_with_its_twin(&printed(), &signed);
    let absolute = agrees_with_its_twin(&printed(), &truth());
    let pairs = signed.iter().flatten().zip(absolute.iter().flatten());
    let mut lower = 0;
    for (s, a) in pairs {
        assert!(s.r.iter().zip(&a.r).all(|(s, a)| s <= a));
        assert_eq!((s.capsizes, s.time_above), (a.capsizes, a.time_above));
        lower += s.r.iter().zip(&a.r).filter(|(s, a)| s < a).count();
    }
    assert!(lower > 5, "only {lower} lower");
}

#[test]
fn a_discarded_field_leaves_no_response() {
    let discard = Truth {
        capsize: Capsize::DiscardField,
        ..truth()
    };
    let found = agrees_with_its_twin(&printed(), &discard);
    let dropped = found.iter().flatten().filter(|f| f.dropped).count();
    assert!(dropped > 0 && dropped < 21);
    assert!(found.iter().flatten().all(|f| f.r.is_empty() == f.dropped));
}

#[test]
fn any_number_of_epsilon_1_and_either_damping_agrees() {
    for epsilon_1 in [vec![0.02], vec![0.0, 0.01], vec![0.0, 0.01, 0.02, 0.03]] {
        let damping = if epsilon_1.len() == 2 {
            Damping::Quadratic
        } else {
            Damping::Cubic
        };
        let found = agrees_with_its_twin(
            &Ship {
                epsilon_1,
                damping,
                ..printed()
            },
            &truth(),
        );
        assert!(found.iter().flatten().any(|f| f.r.iter().any(|r| *r > 0.1)));
    }
}

#[test]
fn a_capsize_leaves_its_neighbours_alone() {
    let (ship, truth, groups) = (printed(), truth(), groups());
    let simulation = Simulation::new(&ship, &truth, timing().h);
    let calm = elevation();
    let mut wild = calm.clone();
    for row in &mut wild {
        row[2] *= 1e150;
    }
    let [before, after] = [&calm, &wild].map(|eta| continuous_record(&simulation, &timing(), eta, &groups));
    for (before, after) in before.responses.iter().zip(&after.responses) {
        assert!(after[2].capsizes > 100 && after[2].r.iter().all(|r| *r == truth.capsize_angle));
        assert!([0, 1, 3, 4, 5, 6].iter().all(|c| before[*c] == after[*c]));
    }
}

#[test]
fn rest_without_direct_excitation_has_no_response() {
    let ship = Ship {
        epsilon_2: 0.0,
        ..printed()
    };
    let truth = truth();
    let found = continuous_record(
        &Simulation::new(&ship, &truth, timing().h),
        &timing(),
        &elevation(),
        &groups(),
    );
    assert!(found.angles.iter().flatten().flatten().all(|angle| *angle == 0.0));
    let found = found.responses;
    assert!(found.iter().flatten().all(|f| f.capsizes == 0 && f.time_above == 0.0));
    assert!(found.iter().flatten().flat_map(|f| &f.r).all(|r| *r == 0.0));
}

#[test]
fn the_ensemble_holds_the_states_of_the_same_run() {
    let (ship, truth, eta, timing) = (printed(), truth(), elevation(), timing());
    let found = continuous_states(&Simulation::new(&ship, &truth, timing.h), &timing, &eta, 7, 8);
    for (epsilon_1, fields) in ship.epsilon_1.iter().zip(&found) {
        assert_eq!(fields.len(), 7);
        for (column, states) in fields.iter().enumerate() {
            let wave = |j: i64| eta[j.rem_euclid(SAMPLES as i64) as usize][column];
            let rules = (&ship, *epsilon_1, &truth, timing.h);
            let t = Trajectory::run(rules, -timing.lead_in, timing.steps, (0.0, 0.0), wave);
            let expected = t.states.iter().skip(timing.lead_in as usize).step_by(8).take(192);
            let found: Vec<(f64, f64)> = states.iter().map(|s| (s.theta, s.theta_dot)).collect();
            assert_eq!(found, expected.copied().collect::<Vec<_>>());
        }
    }
}

#[test]
fn the_grid_of_the_paper_has_its_numbers_of_steps() {
    let timing = Timing::new(3840.0, 32_768, 500.0, 300.0);
    assert_eq!((timing.h, timing.steps), (0.234375, 16_384));
    assert_eq!((timing.lead_in, timing.tail), (2134, 1280));
    assert_eq!(Timing::new(3840.0, 32_768, 100.0, 300.0).lead_in, 1280);
}

#[test]
fn a_segment_holds_its_ends_even_where_one_step_capsizes() {
    // One group per step, so short that its segment is that step: blocks, restarts and peaks fall on every border.
    let h = timing().h;
    let step = |s: i64| Encounter {
        t_c: (s as f64 + 0.5) * h,
        l: 0.3 * h,
        a: 1.0,
    };
    let groups: Vec<Vec<Encounter>> = vec![(0..timing().steps).map(step).collect(); 8];
    let eta = elevation();
    for roll in [Roll::Absolute, Roll::Signed] {
        let (ship, truth) = (printed(), Truth { roll, ..truth() });
        let found = continuous_record(&Simulation::new(&ship, &truth, h), &timing(), &eta, &groups);
        assert_eq!(found, twin(&ship, &truth, &eta, &groups));
        assert!(found.responses.iter().flatten().any(|f| f.capsizes > 16));
    }
}

#[test]
fn nothing_infinite_gets_out_of_an_overflow() {
    let ship = Ship {
        epsilon_2: 100.0,
        ..printed()
    };
    let (truth, mut eta) = (truth(), elevation());
    eta[800][0] = 1e308;
    let simulation = Simulation::new(&ship, &truth, timing().h);
    let states = continuous_states(&simulation, &timing(), &eta, 1, 1);
    let is_finite = |s: &RollState| s.theta.is_finite() && s.theta_dot.is_finite();
    assert!(states.iter().flatten().flatten().all(is_finite));
    let found = continuous_record(&simulation, &timing(), &eta, &groups()[..1]);
    assert!(
        found
            .responses
            .iter()
            .flatten()
            .flat_map(|f| &f.r)
            .all(|r| *r <= truth.capsize_angle)
    );
}
