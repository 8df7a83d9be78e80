//! Claims about the sequential design: the published 1-D case, pools, densities, random sampling.

use crate::common::paper;
use encounter::design::acquisition::{Candidates, doubt};
use encounter::design::estimate::{exceedance, random_relative_deviation, random_sampling, share_above};
use encounter::design::pool::{Pool, Used};
use encounter::design::quadrature::Quadrature;
use encounter::design::sequential::{Design, Input, Realisation, sequential};
use encounter::design::settings::VhgpSeq;
use encounter::gp::fit::{Fitting, KernelSpan, Span};
use encounter::gp::vhgp::Vhgp;
use encounter::numerics::elementary::{exp, ln};
use encounter::numerics::latin_hypercube::latin_hypercube;
use encounter::numerics::normal::{density, from_uniform, quantile};
use encounter::numerics::random::uniform;
use encounter::numerics::sums::{mean, standard_deviation};
use rand_chacha::ChaCha12Rng;
use rand_chacha::rand_core::SeedableRng;

/// The true probability of the 1-D case, by quadrature.
const TRUTH: f64 = 0.016144;

fn stream(seed: u64) -> ChaCha12Rng {
    ChaCha12Rng::seed_from_u64(seed)
}

fn span(start: f64, from: f64, to: f64) -> Span {
    Span { start, from, to }
}

/// The published settings of the 1-D case; a second coordinate that is always 0 changes nothing.
fn reference() -> VhgpSeq {
    VhgpSeq {
        initial: 40,
        batch: 3,
        total: 100,
        neighbours: 1,
        case: Vec::new(),
        epsilon_1_index: 0,
        domain: [[0.0, 10.0], [0.0, 0.0]],
        grid: [100, 1],
        tau: [0.02_f64.sqrt(), 0.0],
        bandwidth: [1.0, 1.0],
        least_density: 0.0,
        quadrature: [1, 1],
        cap: 1e9,
        standardise: false,
        fit: Fitting {
            k_f: KernelSpan {
                variance: span(100.0, 0.1, 2000.0),
                length: vec![span(5.0, 0.1, 10.0), span(1.0, 0.1, 10.0)],
            },
            k_g: KernelSpan {
                variance: span(2.0, 0.1, 4.0),
                length: vec![span(5.0, 0.1, 100.0), span(1.0, 0.1, 10.0)],
            },
            mu_0: [-2.0, 4.0],
            log_lambda: [-2.0, 2.0],
            jitter: 1e-4,
            restarts: 6,
            fresh_start_every: 5,
            iterations: 200,
            memory: 10,
            gradient_tolerance: 1e-2,
            value_tolerance: 1e-7,
        },
    }
}

/// x ~ N(5, 1): candidates on [0, 10], a quadrature from one point in each of 20,000 equal strata.
fn reference_input() -> Input {
    let grid = reference().candidates();
    let p = grid.points().iter().map(|x| density(x[0] - 5.0)).collect();
    let x: Vec<[f64; 2]> = (0..20_000)
        .map(|i| [5.0 + quantile((f64::from(i) + 0.5) / 20_000.0), 0.0])
        .collect();
    Input::new(grid, p, Quadrature::new(&x, [400, 1]))
}

/// y = (x - 5)² + N(0, (0.1 + 0.1 x²)²).
fn reference_response(x: f64, stream: &mut ChaCha12Rng) -> f64 {
    (x - 5.0) * (x - 5.0) + (0.1 + 0.1 * x * x) * from_uniform(uniform(stream))
}

fn reference_trial(seed: u64, input: &Input) -> Realisation {
    let respond = |x: [f64; 2], s: &mut ChaCha12Rng| Some((x, reference_response(x[0], s)));
    sequential(&reference().design(), input, 9.0, respond, &mut stream(seed))
}

#[test]
fn the_published_1d_case_converges_to_its_probability() {
    let input = reference_input();
    let trials: Vec<Realisation> = (0..6).map(|seed| reference_trial(seed, &input)).collect();
    let last: Vec<f64> = trials.iter().map(|t| t.estimate[t.estimate.len() - 1]).collect();
    for t in &trials {
        assert_eq!(t.n_samples, (40..=100).step_by(3).collect::<Vec<u32>>());
        assert_eq!((t.points.len(), t.y.len(), t.failed_fits), (100, 100, 0));
    }
    // Six of the published trials have mean .0171 +- .0018 and sd .0043.
    let (m, sd) = (mean(&last), standard_deviation(&last));
    assert!((m - TRUTH).abs() < 0.005 && sd < 0.009, "{m} +- {sd}: {last:?}");
}

#[test]
#[ignore = "minutes: the whole published table, printed"]
fn the_published_1d_table_is_reproduced_over_100_trials() {
    let input = reference_input();
    let started = std::time::Instant::now();
    let half = |from: u64| {
        (from..from + 50)
            .map(|seed| reference_trial(seed, &input))
            .collect::<Vec<_>>()
    };
    let trials = std::thread::scope(|scope| {
        let other = scope.spawn(|| half(50));
        let mut trials = half(0);
        trials.extend(other.join().expect("no trial panics"));
        trials
    });
    for n in [40, 70, 100] {
        let at = (n - 40) / 3;
        let p: Vec<f64> = trials.iter().map(|t| t.estimate[at]).collect();
        println!("sequential n = {n}: {:.4} +- {:.4}", mean(&p), standard_deviation(&p));
    }
    let total = |f: fn(&Realisation) -> u32| trials.iter().map(f).sum::<u32>();
    println!(
        "{:.1} s; failed {}, unconverged {}, evaluations {}",
        started.elapsed().as_secs_f64(),
        total(|t| t.failed_fits),
        total(|t| t.unconverged_fits),
        total(|t| t.evaluations)
    );
    // Published mean and sd, and the kurtosis of the estimate that the error of an sd depends on. 500 trials of ours
    // at n = 40 gave .0219 +- .0119, standard errors .0005 and .0005, kurtosis 3.9: with the published ones' own errors,
    // .0011 and .0009, both agree.
    for (at, m, sd, kurtosis) in [(0, 0.0211, 0.0105, 3.9), (20, 0.0171, 0.0043, 3.0_f64)] {
        let p: Vec<f64> = trials.iter().map(|t| t.estimate[at]).collect();
        let (found, spread) = (mean(&p), standard_deviation(&p));
        let both = ((sd * sd + spread * spread) / 100.0).sqrt();
        assert!((found - m).abs() < 2.0 * both, "{found} against {m} +- {both}");
        let error = both * ((kurtosis - 1.0) / 4.0).sqrt();
        assert!((spread - sd).abs() < 2.0 * error, "{spread} against {sd} +- {error}");
    }
}

type Change = fn(&mut VhgpSeq);

fn ship_settings() -> VhgpSeq {
    paper::table("vhgp_seq")
}

/// 20,000 groups like S2's in (L/T_p, A/H_s), and a roll that grows with both and scatters most for high groups.
fn groups() -> (Vec<[f64; 2]>, Vec<f64>) {
    let mut s = stream(11);
    let mut normal = || from_uniform(uniform(&mut s));
    let mut pool = (Vec::new(), Vec::new());
    while pool.0.len() < 20_000 {
        let (u, v, w) = (normal(), normal(), normal());
        let x = [1.4 * exp(0.45 * u), 0.48 + 0.16 * (0.5 * u + 0.87 * v)];
        if x[1] > 0.08 {
            pool.1
                .push(0.9 * x[1] + 0.1 * (x[0] - 1.5) + (0.03 + 0.15 * x[1] * x[1]) * w);
            pool.0.push(x);
        }
    }
    pool
}

fn roll(x: &[f64; 2]) -> f64 {
    0.9 * x[1] + 0.1 * (x[0] - 1.5)
}

fn scatter(x: &[f64; 2]) -> f64 {
    0.03 + 0.15 * x[1] * x[1]
}

/// (Q2) of the true roll and scatter over the Monte-Carlo set of `ship_input`.
fn pool_truth(points: &[[f64; 2]], threshold: f64) -> f64 {
    let q: Vec<f64> = points[..5000]
        .iter()
        .map(|x| exceedance(roll(x), 2.0 * ln(scatter(x)), threshold))
        .collect();
    mean(&q)
}

fn ship_input(settings: &VhgpSeq, points: &[[f64; 2]]) -> Input {
    let grid = settings.candidates();
    let density = grid.density(points, settings.bandwidth);
    Input::new(grid, density, Quadrature::new(&points[..5000], settings.quadrature))
}

fn ship_realisation(
    settings: &Design,
    input: &Input,
    pool: &Pool,
    y: &[f64],
    threshold: f64,
    seed: u64,
) -> Realisation {
    let mut used = Used::default();
    let respond = |x: [f64; 2], s: &mut ChaCha12Rng| {
        let index = pool.draw(&x, 8, &mut used, s)?;
        Some((pool.point(index), y[index as usize]))
    };
    sequential(settings, input, threshold, respond, &mut stream(seed))
}

#[test]
fn the_design_beats_random_sampling_on_a_pool_of_groups() {
    let settings = ship_settings();
    let (points, y) = groups();
    let (input, pool) = (ship_input(&settings, &points), Pool::new(&points));
    let threshold = 0.8;
    let truth = pool_truth(&points, threshold);
    assert!((truth / share_above(&y, threshold) - 1.0).abs() < 0.15, "{truth}");
    let p: Vec<f64> = (0..4)
        .map(|seed| {
            let r = ship_realisation(&settings.design(), &input, &pool, &y, threshold, seed);
            assert_eq!((r.failed_fits, r.n_samples.len(), r.points.len()), (0, 31, 120));
            r.estimate[30]
        })
        .collect();
    let (m, sd) = (mean(&p) / truth, standard_deviation(&p) / truth);
    println!(
        "{m:.3} +- {sd:.3} of P = {truth}; random {:.3}",
        random_relative_deviation(truth, 120)
    );
    assert!((m - 1.0).abs() < 0.2 && sd < 0.3, "{m} +- {sd}: {p:?}");
}

#[test]
#[ignore = "a minute: accuracy and time of the ship case's settings, printed"]
fn the_design_s_accuracy_on_a_pool_of_groups_over_40_realisations() {
    let settings = ship_settings();
    let (points, y) = groups();
    let (input, pool) = (ship_input(&settings, &points), Pool::new(&points));
    for threshold in [0.8, 0.95] {
        let truth = pool_truth(&points, threshold);
        let started = std::time::Instant::now();
        let runs: Vec<Realisation> = (0..20)
            .map(|seed| ship_realisation(&settings.design(), &input, &pool, &y, threshold, seed))
            .collect();
        let seconds = started.elapsed().as_secs_f64() / 20.0;
        let evaluations = runs.iter().map(|r| r.evaluations).sum::<u32>() / 20;
        let unconverged = runs.iter().map(|r| r.unconverged_fits).sum::<u32>();
        println!("P = {truth:.4}: {seconds:.2} s, {evaluations} evaluations each, unconverged {unconverged}");
        for (k, n) in [(0, 30), (10, 60), (20, 90), (30, 120)] {
            let p: Vec<f64> = runs.iter().map(|r| r.estimate[k] / truth).collect();
            let random = random_relative_deviation(truth, n);
            println!(
                "  n = {n}: {:.3} +- {:.3}, random {random:.3}",
                mean(&p),
                standard_deviation(&p)
            );
        }
    }
}

#[test]
fn a_realisation_is_its_stream_and_nothing_else() {
    let mut settings = ship_settings();
    settings.total = 39;
    let (points, y) = groups();
    let (input, pool) = (ship_input(&settings, &points), Pool::new(&points));
    let run = |seed| ship_realisation(&settings.design(), &input, &pool, &y, 0.8, seed);
    let first = [run(1), run(2)];
    let again = [run(2), run(1)];
    assert_eq!(first[0], again[1]);
    assert_eq!(first[1], again[0]);
    assert_ne!(first[0], first[1]);
    assert_eq!(first[0].n_samples, [30, 33, 36, 39]);
    let mut distinct = first[0].points.clone();
    distinct.sort_by(|a, b| a[0].total_cmp(&b[0]));
    distinct.dedup();
    assert_eq!(distinct.len(), 39, "no group is used twice");
    let text = toml::to_string(&first[0]).expect("serialises");
    assert_eq!(toml::from_str::<Realisation>(&text).expect("reads back"), first[0]);
}

#[test]
fn samples_move_to_groups_and_keep_the_responses_above_the_cap() {
    let mut settings = ship_settings();
    (settings.total, settings.initial) = (24, 20);
    let (points, mut y) = groups();
    for (x, y) in points.iter().zip(&mut y) {
        *y = if x[1] > 0.6 { std::f64::consts::PI } else { *y };
    }
    let (input, pool) = (ship_input(&settings, &points), Pool::new(&points));
    let r = ship_realisation(&settings.design(), &input, &pool, &y, 0.8, 3);
    assert_eq!(r.n_samples, [20, 23, 24]);
    assert!(r.points.iter().all(|x| points.contains(x)));
    assert!(
        r.y.contains(&std::f64::consts::PI),
        "the record is not capped, only what the model sees"
    );
    assert!(r.estimate.iter().all(|p| (0.0..=1.0).contains(p)));
}

#[test]
fn an_empty_pool_ends_the_realisation() {
    let settings = ship_settings();
    let (points, y) = groups();
    let (input, small) = (ship_input(&settings, &points), Pool::new(&points[..35]));
    let r = ship_realisation(&settings.design(), &input, &small, &y, 0.8, 1);
    assert_eq!((r.points.len(), r.n_samples), (35, vec![30, 33]));
}

#[test]
fn the_pool_draws_uniformly_from_the_nearest_unused() {
    let (points, _) = groups();
    let pool = Pool::new(&points);
    let sd = [0, 1].map(|d| standard_deviation(&points.iter().map(|x| x[d]).collect::<Vec<_>>()));
    let x = [2.0, 0.5];
    let mut sorted: Vec<(f64, u32)> = (0..points.len() as u32)
        .map(|i| {
            let p = points[i as usize];
            let (u, v) = ((p[0] - x[0]) / sd[0], (p[1] - x[1]) / sd[1]);
            (u * u + v * v, i)
        })
        .collect();
    sorted.sort_by(|a, b| a.0.total_cmp(&b.0));
    let used = Used {
        indices: vec![sorted[0].1, sorted[3].1],
    };
    let expected: Vec<u32> = [1, 2, 4, 5, 6, 7, 8, 9].map(|i| sorted[i].1).to_vec();
    let found: Vec<u32> = pool.nearest(&x, 8, &used).iter().map(|(_, i)| *i).collect();
    assert_eq!(found, expected);
    let mut counts = [0.0; 8];
    let mut s = stream(5);
    for _ in 0..4000 {
        let drawn = pool.draw(&x, 8, &mut used.clone(), &mut s).expect("not empty");
        counts[expected.iter().position(|i| *i == drawn).expect("a neighbour")] += 1.0;
    }
    // Binomial: 500 +- 21.
    assert!(counts.iter().all(|c| (c - 500.0_f64).abs() < 90.0), "{counts:?}");
}

#[test]
fn the_density_on_the_grid_is_the_whole_kernel_sum() {
    let (points, _) = groups();
    let (grid, few) = (ship_settings().candidates(), &points[..300]);
    let (b, found) = ([0.12, 0.03], grid.density(few, [0.12, 0.03]));
    let mut largest = 0.0_f64;
    for (x, p) in grid.points().iter().zip(&found) {
        let mut expected = 0.0;
        for c in few {
            let (u, v) = ((x[0] - c[0]) / b[0], (x[1] - c[1]) / b[1]);
            expected += density(u) * density(v) / (b[0] * b[1] * 300.0);
        }
        largest = largest.max((p - expected).abs());
    }
    assert!(largest < 1e-4, "kernels end at 5 bandwidths: {largest}");
    let cell = 5.6 / 39.0 * 1.05 / 39.0;
    assert!((grid.density(&points, b).iter().sum::<f64>() * cell - 1.0).abs() < 0.02);
    for (i, x) in grid.points().iter().enumerate().step_by(97) {
        assert_eq!(grid.nearest(x), i);
        assert_eq!(grid.nearest(&[x[0] + 0.05, x[1] - 0.01]), i);
    }
    assert_eq!(grid.nearest(&[-5.0, -5.0]), 0);
    assert_eq!(grid.nearest(&[50.0, 50.0]), 1599);
}

#[test]
fn the_pruned_argmax_is_the_whole_scan_s() {
    let settings = ship_settings();
    let (points, y) = groups();
    let (x, y) = (
        &points[..40],
        y[..40].iter().map(|y| (y - 0.45) / 0.2).collect::<Vec<_>>(),
    );
    let fit = settings.fit.fit(x, &y, None, &mut stream(1)).expect("fits");
    let model = Vhgp::new(x, &y, &fit.theta, settings.fit.jitter).expect("positive definite");
    let grid = settings.candidates();
    let p = grid.density(&points, settings.bandwidth);
    let values: Vec<f64> = model
        .predict(&grid.points())
        .iter()
        .zip(&p)
        .map(|(m, p)| p * doubt(m, 1.5))
        .collect();
    let best = (0..values.len())
        .max_by(|a, b| values[*a].total_cmp(&values[*b]))
        .expect("points");
    assert_eq!(
        Candidates::new(&grid.points(), &p).best(&model, 1.5),
        Some(grid.points()[best])
    );
}

#[test]
fn the_local_exceedance_probability_is_a_normal_tail() {
    assert_eq!(exceedance(0.7, -3.0, 0.7), 0.5);
    // One noise sd = e^{-1} below the threshold.
    assert!((exceedance(1.0 - exp(-1.0), -2.0, 1.0) - 0.158_655_253_931_457_05).abs() < 1e-15);
}

#[test]
fn random_sampling_scatters_as_the_binomial_says() {
    let y: Vec<f64> = (0..1000).map(|i| f64::from(i) / 1000.0).collect();
    let mut s = stream(9);
    let p: Vec<Vec<f64>> = (0..400)
        .map(|_| random_sampling(1000, &[60, 120], 0.9495, |i| y[i], &mut s))
        .collect();
    for (k, n) in [(0, 60), (1, 120)] {
        let at: Vec<f64> = p.iter().map(|p| p[k]).collect();
        let (m, relative) = (mean(&at), standard_deviation(&at) / 0.05);
        // s.e. of the mean (R1)/20, of the sd about 4 %.
        assert!(
            (m / 0.05 - 1.0).abs() < 4.0 * random_relative_deviation(0.05, n) / 20.0,
            "{m}"
        );
        assert!(
            (relative / random_relative_deviation(0.05, n) - 1.0).abs() < 0.16,
            "{relative}"
        );
    }
    // Table 1's random column.
    for (p, printed) in [(0.0421, 0.435), (0.0172, 0.690), (0.0232, 0.592), (0.0076, 1.04)] {
        assert!((random_relative_deviation(p, 120) - printed).abs() < 0.005);
    }
}

#[test]
fn initial_samples_lie_where_groups_are() {
    let mut settings = ship_settings();
    settings.total = settings.initial;
    let (points, y) = groups();
    let (input, pool) = (ship_input(&settings, &points), Pool::new(&points));
    let mut queries = Vec::new();
    let mut used = Used::default();
    let respond = |x: [f64; 2], s: &mut ChaCha12Rng| {
        queries.push(x);
        let index = pool.draw(&x, 8, &mut used, s)?;
        Some((pool.point(index), y[index as usize]))
    };
    let r = sequential(&settings.design(), &input, 0.8, respond, &mut stream(2));
    assert_eq!((queries.len(), r.n_samples), (30, vec![30]));
    let grid = settings.candidates();
    let p = grid.density(&points, settings.bandwidth);
    let largest = p.iter().fold(0.0, |a: f64, b| a.max(*b));
    assert!(queries.iter().all(|x| p[grid.nearest(x)] > 1e-3 * largest));
    // The box has corners without groups, which a plain hypercube does not know.
    let plain = latin_hypercube(30, grid.lower, grid.upper, &mut stream(2));
    assert!(plain.iter().any(|x| p[grid.nearest(x)] <= 1e-3 * largest));
}

#[test]
fn the_paper_s_table_decodes_and_wrong_ones_are_refused() {
    let settings = ship_settings();
    assert_eq!(settings.check(), Ok(()));
    let text = toml::to_string(&settings).expect("serialises");
    assert_eq!(toml::from_str::<VhgpSeq>(&text).expect("reads back"), settings);
    for (key, says) in [
        ("cap", "expected a number > 0, found -1"),
        ("least_density", "expected a number >= 0, found -1"),
    ] {
        let mut wrong: toml::Table = paper::table("vhgp_seq");
        wrong[key] = toml::Value::Float(-1.0);
        let error = wrong.try_into::<VhgpSeq>().expect_err("wrong");
        assert!(error.to_string().contains(says), "{error}");
    }
    let changes: [(Change, &str); 6] = [
        (|s| s.total = 20, "total: expected at least initial = 30, found 20"),
        (
            |s| s.cap = 0.8,
            "cap: expected more than theta_t = 0.9 of S2 in `case`, found 0.8",
        ),
        (
            |s| s.domain[1] = [1.0, 1.0],
            "domain[1]: expected two ascending numbers, found [1, 1]",
        ),
        (
            |s| s.quadrature[1] = 0,
            "quadrature: expected whole numbers >= 1, at most 1024 each and 65536 nodes in all, since the model is asked at every node \
             after every fit, found [64, 0]",
        ),
        (|s| s.tau[0] = 0.0, "tau: expected numbers > 0, found [0.0, 0.03]"),
        (
            |s| s.fit.log_lambda = [1.0, 0.0],
            "fit.log_lambda: expected two ascending numbers, found [1, 0]",
        ),
    ];
    for (change, says) in changes {
        let mut wrong = ship_settings();
        change(&mut wrong);
        assert_eq!(wrong.check(), Err(says.to_string()));
    }
}
