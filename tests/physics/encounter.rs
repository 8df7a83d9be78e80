//! Claims about single runs through wave groups.

use super::roll_twin::{Trajectory, printed, truth};
use encounter::numerics::elementary::{cos, exp, ln};
use encounter::numerics::lanes::Level;
use encounter::ship::encounter::{
    Approach, Encounter, GroupRun, RecordRun, max_roll_along_record, max_roll_through_groups,
};
use encounter::ship::initial_condition::{Pic, RollState, predecessor};
use encounter::ship::roll_equation::Ship;
use encounter::ship::segments::Segment;
use encounter::ship::simulation::Simulation;
use std::f64::consts::TAU;

const H: f64 = 15.0 / 64.0;
const LEVELS: [Level; 3] = [Level::Base, Level::Avx2, Level::Avx512];

fn approach(h: f64) -> Approach {
    Approach {
        h,
        field_period: 360.0,
        truth_window: 2.0,
        estimate_window: 3.0,
        groups_ahead: 2,
    }
}

fn field(seed: usize) -> Vec<Encounter> {
    let group = |i: usize| Encounter {
        t_c: 60.0 * i as f64 + 7.0 * seed as f64 + 0.4,
        l: 10.0 + ((3 * i + seed) % 5) as f64 * 4.0,
        a: 5.0 + ((i + seed) % 4) as f64,
    };
    (0..5).map(group).collect()
}

/// The sum of groups on the carrier, by its formula.
fn elevation(run: &GroupRun, t: f64) -> f64 {
    let bump = |g: &Encounter| g.a * exp(-0.5 * ((t - g.t_c) / g.l) * ((t - g.t_c) / g.l));
    cos(TAU / 15.0 * t) * run.groups.iter().map(bump).sum::<f64>()
}

#[test]
fn single_groups_give_the_table_of_section_15() {
    let table = [
        (4.0, [0.390, 0.383, 0.323, 0.276, 0.263, 0.260]),
        (6.0, [0.574, 0.533, 0.438, 0.373, 0.367, 0.363]),
        (8.0, [0.727, 0.629, 0.523, 0.447, 0.457, 0.449]),
        (10.0, [0.878, 0.737, 0.585, 0.534, 0.532, 0.523]),
        (12.0, [1.125, 0.786, 0.638, 0.608, 0.594, 0.589]),
    ];
    let lengths = [10.0, 20.0, 30.0, 45.0, 60.0, 90.0];
    let alone = |(a, _): &(f64, [f64; 6])| lengths.map(|l| approach(H).alone(Encounter { t_c: 77.0, l, a: *a }));
    let runs: Vec<GroupRun> = table.iter().flat_map(alone).collect();
    let (ship, truth) = (printed(), truth());
    let found = max_roll_through_groups(&Simulation::new(&ship, &truth, H), 15.0, &runs, &[]);
    for (found, expected) in found[0].iter().zip(table.iter().flat_map(|(_, row)| row)) {
        assert!((found - expected).abs() < 1e-3, "{found} for {expected}");
    }
}

#[test]
fn groups_are_met_as_by_a_scalar_run_through_the_formula() {
    let (ship, truth) = (printed(), truth());
    let natural = (0..4).flat_map(|f| (0..5).map(move |i| approach(H).through_groups(&field(f), i)));
    let mut runs: Vec<GroupRun> = natural.collect();
    runs.extend(field(4).into_iter().map(|g| approach(H).alone(g)));
    let of_run = |run: usize, e: usize| RollState {
        theta: 0.01 * run as f64,
        theta_dot: -0.02 * e as f64,
    };
    let initial: Vec<Vec<RollState>> = (0..3)
        .map(|e| (0..runs.len()).map(|run| of_run(run, e)).collect())
        .collect();
    for states in [Vec::new(), initial] {
        let all = LEVELS.map(|level| {
            let simulation = Simulation {
                level,
                ..Simulation::new(&ship, &truth, H)
            };
            max_roll_through_groups(&simulation, 15.0, &runs, &states)
        });
        assert_eq!(all[0], all[1]);
        assert_eq!(all[0], all[2]);
        for (e, epsilon_1) in ship.epsilon_1.iter().enumerate() {
            for (k, run) in runs.iter().enumerate() {
                let state = states
                    .get(e)
                    .map_or((0.0, 0.0), |list| (list[k].theta, list[k].theta_dot));
                let eta = |j: i64| elevation(run, run.start + j as f64 * H / 2.0);
                let rules = (&ship, *epsilon_1, &truth, H);
                let t = Trajectory::run(rules, 0, run.segment.last, state, eta);
                let expected = t.largest(run.segment.first, run.segment.last);
                // A capsize makes the run chaotic; everything else agrees to rounding.
                let tolerance = if t.capsizes.is_empty() { 1e-10 } else { 1e-6 };
                assert!(
                    (all[0][e][k] - expected).abs() < tolerance,
                    "{} for {expected}",
                    all[0][e][k]
                );
            }
        }
    }
}

fn record() -> Vec<[f64; 8]> {
    let row = |j: usize| {
        [0, 1, 2, 3, 4, 5, 6, 7].map(|c: usize| {
            let wave = |k: usize| cos((k * j % 3072) as f64 / 3072.0 * TAU + (k * k * (c + 3)) as f64);
            (18..31).map(wave).sum::<f64>() * 1.3
        })
    };
    (0..3072).map(row).collect()
}

fn natural_runs() -> Vec<RecordRun> {
    let runs = |column: usize| (0..5).map(move |i| approach(H).through_record(column as u32, &field(column), i));
    (0..8).flat_map(runs).take(37).collect()
}

#[test]
fn natural_runs_are_a_scalar_run_bit_for_bit() {
    let (truth, eta, runs) = (truth(), record(), natural_runs());
    for epsilon_1 in [vec![0.02], vec![0.0, 0.02, 0.03, 0.04]] {
        let ship = Ship { epsilon_1, ..printed() };
        let mut capsized = 0;
        for level in LEVELS {
            let simulation = Simulation {
                level,
                ..Simulation::new(&ship, &truth, H)
            };
            let found = max_roll_along_record(&simulation, &eta, &runs);
            for (epsilon_1, found) in ship.epsilon_1.iter().zip(&found) {
                for (run, found) in runs.iter().zip(found) {
                    let wave = |j: i64| eta[(j + 2 * run.start).rem_euclid(3072) as usize][run.column as usize];
                    let t = Trajectory::run((&ship, *epsilon_1, &truth, H), 0, run.segment.last, (0.0, 0.0), wave);
                    assert_eq!(*found, t.largest(run.segment.first, run.segment.last));
                    capsized += usize::from(*found == truth.capsize_angle);
                }
            }
        }
        assert!(capsized > 0 && capsized < 3 * runs.len() * ship.epsilon_1.len());
    }
}

#[test]
fn a_run_does_not_depend_on_its_neighbours() {
    let (ship, truth, eta, runs) = (printed(), truth(), record(), natural_runs());
    let simulation = Simulation::new(&ship, &truth, H);
    let together = max_roll_along_record(&simulation, &eta, &runs);
    for (k, run) in runs.iter().enumerate() {
        let alone = max_roll_along_record(&simulation, &eta, &[*run]);
        assert!((0..3).all(|e| alone[e][0] == together[e][k]));
    }
    assert_eq!(
        max_roll_along_record(&simulation, &eta, &[]),
        vec![Vec::<f64>::new(); 3]
    );
}

#[test]
fn natural_starts_follow_the_groups_ahead() {
    let groups = field(0);
    let run = approach(H).through_record(3, &groups, 3);
    // Group 1 is centred at 60.4 s, 22 s long.
    assert_eq!(run.start, ((60.4 - 66.0) / H).floor() as i64);
    let segment = Segment::around(groups[3].t_c, 2.0 * groups[3].l, H);
    assert_eq!(
        (run.start + run.segment.first, run.start + run.segment.last),
        (segment.first, segment.last)
    );
    assert_eq!(approach(H).through_groups(&groups, 3).groups, groups[1..=3]);
}

#[test]
fn predecessors_of_the_first_groups_come_from_the_end_of_the_field() {
    let groups = field(0);
    let shifted = |i: usize, periods: f64| groups[i].t_c - 360.0 * periods;
    assert_eq!(predecessor(&groups, 0, 1, 360.0).t_c, shifted(4, 1.0));
    assert_eq!(predecessor(&groups, 1, 2, 360.0).t_c, shifted(4, 1.0));
    assert_eq!(predecessor(&groups, 0, 6, 360.0).t_c, shifted(4, 2.0));
    assert_eq!(predecessor(&groups[..1], 0, 2, 360.0).t_c, shifted(0, 2.0));
    // A record that repeats gives the run of group 0 in the next period, too.
    let (ship, truth, eta) = (printed(), truth(), record());
    let simulation = Simulation::new(&ship, &truth, H);
    let run = approach(H).through_record(0, &groups, 0);
    let later = RecordRun {
        start: run.start + 1536,
        ..run
    };
    let found = max_roll_along_record(&simulation, &eta, &[run, later]);
    assert!(run.start < 0 && found.iter().all(|r| r[0] == r[1]));
}

#[test]
fn halving_the_step_lowers_the_error_of_the_response_by_sixteen() {
    let (ship, truth) = (
        Ship {
            epsilon_1: vec![0.002],
            ..printed()
        },
        truth(),
    );
    let r = |parts: f64| {
        let h = H / parts;
        let run = approach(h).alone(Encounter {
            t_c: 0.0,
            l: 33.3,
            a: 7.0,
        });
        max_roll_through_groups(&Simulation::new(&ship, &truth, h), 15.0, &[run], &[])[0][0]
    };
    let reference = r(32.0);
    let error = |parts: f64| (r(parts) - reference).abs();
    let order = ln(error(0.5) / error(2.0)) / ln(4.0);
    assert!(
        (order - 4.0).abs() < 0.5,
        "observed order {order}: {} {} {}",
        error(0.5),
        error(1.0),
        error(2.0)
    );
    assert!(error(1.0) < 1e-4 * reference);
}

#[test]
fn the_pre_computed_ensemble_ends_within_a_field() {
    let pic = Pic { periods: 30_000 };
    assert_eq!((pic.fields(256, 31_250), pic.fields(256, 20)), (118, 20));
    let states: usize = (0..118).map(|f| pic.states_of_field(f, 256, 8)).sum();
    assert_eq!(
        (
            states,
            pic.states_of_field(117, 256, 8),
            pic.states_of_field(118, 256, 8)
        ),
        (240_000, 384, 0)
    );
}

#[test]
fn a_segment_wider_than_its_run_is_cut_off_at_the_start() {
    let wide = Approach {
        truth_window: 4.0,
        ..approach(H)
    };
    let run = wide.alone(Encounter {
        t_c: 0.0,
        l: 20.0,
        a: 5.0,
    });
    assert_eq!(
        run.segment,
        Segment {
            first: 0,
            last: (140.0 / H).floor() as i64
        }
    );
    assert_eq!(Segment::around(10.0, 0.01, H), Segment { first: 42, last: 43 });
}
