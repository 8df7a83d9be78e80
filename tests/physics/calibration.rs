//! Claims about the calibration study.

use crate::physics::exceedance::of_fields;
use encounter::calibration::bench::{Bench, Fields, Sea as SeaOfBench, Tally};
use encounter::calibration::candidate::{Candidate, NAMES, Reading, magnitudes, significant};
use encounter::calibration::choice::{Chosen, Found, Trial, chosen};
use encounter::calibration::evolution::{Effort, minimise};
use encounter::calibration::methods::{Layout, interpolated_cic, methods};
use encounter::calibration::misfit::{misfit, ranking};
use encounter::calibration::polish::least_squares;
use encounter::calibration::settings::{Known, Search, Settings, Target};
use encounter::calibration::spread::spread;
use encounter::calibration::study::Study;
use encounter::numerics::elementary::ln;
use encounter::numerics::normal;
use encounter::numerics::random::uniform;
use encounter::sea::detection::{Detection, detect};
use encounter::sea::envelope::Envelopes;
use encounter::sea::spectrum::{Form, Sea};
use encounter::sea::wave_field::{Record, WaveFields};
use encounter::ship::exceedance::Thresholds;
use encounter::ship::initial_condition::Estimate;
use encounter::ship::response::{Capsize, Roll, Truth};
use encounter::ship::roll_equation::{Damping, Ship};
use rand_chacha::ChaCha12Rng;
use rand_chacha::rand_core::SeedableRng;
use std::sync::Arc;

fn stream(item: u64) -> ChaCha12Rng {
    let mut stream = ChaCha12Rng::seed_from_u64(7);
    stream.set_stream(item);
    stream
}

fn printed() -> Ship {
    Ship {
        alpha_1: 0.01,
        alpha_2: 0.052,
        damping: Damping::Cubic,
        beta_1: 0.1175,
        beta_2: -0.09,
        epsilon_1: vec![0.0, 0.02, 0.04],
        epsilon_2: 0.004,
    }
}

const RECORD: Record = Record {
    periods_per_field: 256,
    modes: 1024,
    samples_per_period: 128,
    envelope_samples_per_period: 8,
    lead_in: 500.0,
};

const TRUTH: Truth = Truth {
    window: 2.0,
    roll: Roll::Absolute,
    capsize_angle: std::f64::consts::PI,
    capsize: Capsize::Restart,
    temporal_level: 0.25,
    temporal_levels: Thresholds {
        from: 0.0,
        to: 1.2,
        step: 0.025,
    },
};

const ESTIMATE: Estimate = Estimate {
    samples: 1,
    window: 3.0,
};

fn settings() -> Settings {
    Settings {
        search_fields: 8,
        polish_fields: 16,
        method_fields: 8,
        bounds: [
            [0.001, 0.3],
            [0.005, 5.0],
            [0.06, 0.2],
            [0.012, 0.45],
            [2e-4, 0.04],
            [0.001, 0.02],
        ],
        population: 6,
        generations: 6,
        hopeless: 1e9,
        polish_rounds: 4,
        relative_error: 0.05,
        ranking_weight: 0.0,
        size_weight: 0.0,
        accepted: 9.49,
        digits: 3,
        reading_changes: vec!["beta_1".into(), "epsilon_2".into()],
        known: vec![Known {
            name: "known".into(),
            values: [0.01, 0.4, 0.13, 0.06, 0.002, 0.0043],
        }],
    }
}

/// Fields of one narrow sea and their groups.
fn fields(count: u64) -> Fields {
    let sea = Sea {
        spectrum: Form::Gaussian,
        significant_wave_height: 12.0,
        peak_period: 15.0,
        bandwidth: Some(0.03),
        gamma: None,
        sigma_low: None,
        sigma_high: None,
    };
    let detection = Detection {
        scales: 100,
        similarity_threshold: 0.75,
        precheck_threshold: 0.4,
        longest: 80.0,
        shortest: 5.0,
        smallest_amplitude: 1.0,
        overlap_factor: 1.5,
        overlap_similarity_margin: 0.075,
    };
    let waves = WaveFields::draw(&sea, &RECORD, (0..count).map(stream));
    let groups = detect(&Envelopes::of(&waves, &RECORD), &detection);
    Fields {
        waves,
        groups: [groups.clone(), groups],
    }
}

fn bench(printed: &Ship, fields: Fields, theta_t: f64, p_true: f64) -> Bench<'_> {
    let target = Target {
        sea: "S".into(),
        theta_t,
        p_true,
    };
    Bench {
        printed,
        record: &RECORD,
        truth: &TRUTH,
        longest: 80.0,
        seas: vec![SeaOfBench {
            target,
            pieces: vec![Arc::new(fields)],
        }],
    }
}

#[test]
fn a_candidate_without_changes_is_the_printed_ship() {
    let printed = printed();
    let none = Candidate {
        x: [0.0; 6],
        reading: Reading::Plain,
    };
    assert_eq!(none.ship(&printed), printed);
    assert_eq!((none.changes(), none.size()), (0, 0.0));
    let mut hardening = none;
    hardening.reading = Reading::HardeningRestoring;
    assert_eq!(hardening.ship(&printed).beta_2, 0.09);
}

#[test]
fn a_slip_by_a_power_of_ten_is_one_change_of_size_ln_ten() {
    let printed = printed();
    let mut values = magnitudes(&printed);
    values[4] = 0.002;
    let slipped = Candidate::of_values(&values, &printed, Reading::Plain);
    assert_eq!(slipped.changes(), 1);
    assert!((slipped.size() - std::f64::consts::LN_10).abs() < 1e-12);
    let ship = slipped.ship(&printed);
    assert_eq!((ship.epsilon_1[0], ship.alpha_1, ship.beta_1), (0.0, 0.01, 0.1175));
    assert!((ship.epsilon_1[1] - 0.002).abs() < 1e-16 && (ship.epsilon_1[2] - 0.004).abs() < 1e-16);
}

#[test]
fn rounding_keeps_the_digits_asked_for() {
    assert_eq!(significant(0.014_649, 3), 0.0146);
    assert_eq!(significant(1234.5, 2), 1200.0);
    let printed = printed();
    let candidate = Candidate {
        x: [0.0, 0.0, 0.2237, 0.0, 0.0, -0.5],
        reading: Reading::Plain,
    };
    let values = candidate.rounded(&printed, 3).values(&printed);
    assert!(
        (values[2] - 0.147).abs() < 1e-15 && (values[5] - 0.00243).abs() < 1e-17,
        "{values:?}"
    );
    assert_eq!(values[1], 0.052);
}

#[test]
fn the_searches_take_every_reading_and_every_subset_once() {
    let settings = settings();
    let searches: Vec<Search> = (0..68).map(|item| settings.search(item)).collect();
    let plain: Vec<&Search> = searches.iter().filter(|it| it.reading == Reading::Plain).collect();
    let mut subsets: Vec<_> = plain.iter().map(|it| it.free.clone()).collect();
    subsets.sort();
    subsets.dedup();
    assert_eq!((plain.len(), subsets.len()), (63, 63));
    assert_eq!(searches[0].free, [2, 5]);
    assert_eq!(settings.search(68), searches[0]);
    assert_eq!(searches[5].free, [0, 1, 2, 3, 4, 5]);
}

#[test]
fn evolution_finds_the_bottom_of_a_curved_valley() {
    let rosenbrock = |x: &Vec<f64>| (1.0 - x[0]) * (1.0 - x[0]) + 100.0 * (x[1] - x[0] * x[0]) * (x[1] - x[0] * x[0]);
    let effort = Effort {
        population: 24,
        generations: 120,
        hopeless: f64::INFINITY,
    };
    let bounds = [[-2.0, 2.0], [-1.0, 3.0]];
    let members = minimise(&bounds, effort, &mut stream(1), |points| {
        points.iter().map(rosenbrock).collect()
    });
    assert!(members[0].cost < 1e-6, "{:?}", members[0]);
    assert!(members.windows(2).all(|pair| pair[0].cost <= pair[1].cost));
    let mut batches = 0;
    let hopeless = Effort {
        hopeless: 0.0,
        ..effort
    };
    minimise(&bounds, hopeless, &mut stream(1), |points| {
        batches += 1;
        points.iter().map(rosenbrock).collect()
    });
    assert_eq!(batches, 1);
}

#[test]
fn least_squares_solves_what_it_can_and_stays_in_bounds() {
    let residuals = |x: &Vec<f64>| vec![x[0] + x[1] - 0.3, 10.0 * (x[0] - x[1]), x[0] * x[0] - 0.0225];
    let batch = |points: &[Vec<f64>]| points.iter().map(residuals).collect();
    let wide = [[-1.0, 1.0]; 2];
    let x = least_squares(&[0.6, -0.4], &wide, 30, batch);
    assert!((x[0] - 0.15).abs() < 1e-3 && (x[1] - 0.15).abs() < 1e-3, "{x:?}");
    let x = least_squares(&[0.6, -0.4], &[[0.2, 1.0], [-1.0, 1.0]], 30, batch);
    assert!(x[0] >= 0.2, "{x:?}");
}

#[test]
fn a_long_step_is_shortened_as_a_whole_and_keeps_its_direction() {
    let residuals = |x: &Vec<f64>| vec![100.0 * (x[0] - 1.5), 3.0 * (x[1] - 0.3)];
    let batch = |points: &[Vec<f64>]| points.iter().map(residuals).collect();
    let x = least_squares(&[0.0, 0.0], &[[-2.0, 2.0]; 2], 1, batch);
    assert!((x[0] - 0.15).abs() < 1e-3 && (x[1] - 0.03).abs() < 1e-3, "{x:?}");
}

fn tally(above: [usize; 3], groups: usize) -> Tally {
    let counts = above.map(|above| {
        let r: Vec<f64> = (0..groups).map(|i| if i < above { 1.0 } else { 0.0 }).collect();
        of_fields(&[0.5], [r.as_slice()])
    });
    Tally {
        counts: counts.to_vec(),
        capsizes: 0,
        fields: 1,
        met: 1000,
    }
}

#[test]
fn misfit_and_ranking_are_what_their_formulas_say() {
    let target = Target {
        sea: "S".into(),
        theta_t: 0.5,
        p_true: 0.1,
    };
    let near = misfit(&[tally([5, 100, 200], 1000)], &[&target], 0.05);
    assert!(near < 0.01, "{near}");
    let d = ln(200.5 / 1001.0 / 0.1);
    let far = misfit(&[tally([5, 200, 300], 1000)], &[&target], 0.05);
    assert!((far - d * d / (0.05 * 0.05 + 0.01)).abs() < 1e-9);
    // Whoever discards every field has nothing in the statistics, and is far away all the same.
    assert!(misfit(&[tally([0, 0, 0], 0)], &[&target], 0.05) > 100.0);
    // CIC at a quarter of the truth, which doubles with epsilon_1: nothing to complain about.
    assert_eq!(ranking(&[tally([50, 100, 200], 1000)], &[0.025]), 0.0);
    // CIC as high as the truth: ln 2 too high.
    let high = ranking(&[tally([50, 100, 200], 1000)], &[0.1]);
    let expected = ln(2.0) * ln(2.0) / 0.25;
    assert!((high - expected).abs() < 1e-9);
    // The truth falls with epsilon_1.
    assert!(ranking(&[tally([200, 100, 50], 1000)], &[0.01]) > 10.0);
}

#[test]
fn the_spread_is_the_noise_about_a_smooth_mean() {
    let mut s = stream(3);
    let points: Vec<[f64; 3]> = (0..40_000)
        .map(|_| {
            let (l, a) = (1.0 + 3.0 * uniform(&mut s), 0.3 + 0.4 * uniform(&mut s));
            let noise = 0.05 * normal::quantile(0.5 * (uniform(&mut s) + uniform(&mut s)).clamp(1e-9, 1.0 - 1e-9));
            [l, a, 0.2 + a + noise]
        })
        .collect();
    let mut squares = 0.0;
    for [_, a, r] in &points {
        squares += (r - 0.2 - a) * (r - 0.2 - a) / points.len() as f64;
    }
    let found = spread(&points, 0.7, 1.25).expect("groups are near the threshold");
    assert!(
        (found / squares.sqrt() - 1.0).abs() < 0.15,
        "{found} {}",
        squares.sqrt()
    );
    assert_eq!(spread(&points, 3.0, 1.25), None);
}

#[test]
fn the_best_of_each_number_of_changes_and_of_each_reading_is_chosen() {
    let settings = settings();
    let found = |free: Vec<u32>, reading, cost| {
        let mut x = [0.0; 6];
        x[free[0] as usize] = cost;
        let trial = Trial {
            candidate: Candidate { x, reading },
            misfit: cost,
            ranking: 0.0,
            cost,
        };
        Found {
            search: Search { free, reading },
            best: trial,
            accepted: Vec::new(),
            evaluations: 1,
        }
    };
    let all = [
        found(vec![2], Reading::Plain, 5.0),
        found(vec![3], Reading::Plain, 4.0),
        found(vec![2, 5], Reading::SignedRoll, 1.0),
    ];
    let of = |item| chosen(&settings, &printed(), all.iter(), item);
    assert_eq!(of(0).expect("known").name, "known");
    assert!(!of(0).expect("known").polish);
    let one = of(1).expect("one change");
    assert_eq!(
        (one.name.as_str(), one.candidate.x[3], one.polish),
        ("1 changed", 4.0, true)
    );
    assert_eq!(of(2), None);
    assert_eq!(of(8).expect("a reading").name, "signed roll");
    assert_eq!(of(99), None);
}

/// The whole of the search, on waves that it has not seen: a ship is planted, its probability is all that is known.
#[test]
fn a_planted_ship_is_found_from_its_own_probability() {
    let printed = printed();
    let mut values = magnitudes(&printed);
    (values[4], values[2]) = (0.002, 0.14);
    let planted = Candidate::of_values(&values, &printed, Reading::Plain);
    values[2] = 0.1175;
    let slipped = Candidate::of_values(&values, &printed, Reading::Plain).ship(&printed);
    let probability = {
        let bench = bench(&printed, fields(24), 0.6, 0.1);
        bench.tallies(&(0..24), &[planted])[0][0].probability(1)
    };
    let settings = settings();
    let study = Study {
        bench: bench(&slipped, fields(24), 0.6, probability),
        settings: &settings,
        layout: Layout {
            estimate: &ESTIMATE,
            groups_ahead: 2,
        },
    };
    let search = Search {
        free: vec![2],
        reading: Reading::Plain,
    };
    let found = study.search(search, &mut stream(5));
    assert!(found.best.misfit < 1.0, "{found:?}");
    let wanted = Chosen {
        name: "planted".into(),
        candidate: found.best.candidate,
        polish: true,
    };
    let checked = study.check(&wanted, &mut stream(6));
    assert!((checked.values[2] / 0.14 - 1.0).abs() < 0.03, "{:?}", checked.values);
    assert_eq!((checked.candidate.changes(), checked.fields, NAMES.len()), (1, 8, 6));
}

#[test]
fn the_table_of_cic_counts_what_single_runs_count() {
    let mut ship = printed();
    ship.epsilon_1 = vec![0.0, 0.002, 0.004];
    let bench = bench(&ship, fields(8), 0.5, 0.1);
    let same = Candidate {
        x: [0.0; 6],
        reading: Reading::Plain,
    };
    let layout = Layout {
        estimate: &ESTIMATE,
        groups_ahead: 2,
    };
    let exact = methods(&bench, (&bench.seas[0], &(0..8)), &same, &layout, &mut stream(1));
    let table = interpolated_cic(&bench, &(0..8), &same, &layout, 1);
    assert!(
        exact.cic[1] > 0.05 && (table[0] - exact.cic[1]).abs() < 0.03,
        "{table:?} {exact:?}"
    );
    // NIC follows the record, so it is the truth up to what the ship has forgotten.
    let truth = bench.tallies(&(0..8), &[same])[0][0].probability(1);
    assert!((exact.nic[1] - truth).abs() < 0.05, "{} {truth}", exact.nic[1]);
}
