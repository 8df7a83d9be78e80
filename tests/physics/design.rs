//! Claims about the sequential design: the published 1-D case, pools, densities, random sampling.

use encounter::design::estimate::{exceedance, probability, random_relative_deviation, random_sampling, share_above};
use encounter::design::input_density::Grid;
use encounter::design::pool::{Pool, Used};
use encounter::design::sequential::{Input, Realisation, sequential};
use encounter::design::settings::{Case, VhgpSeq};
use encounter::gp::fit::{Fitting, KernelSpan, Span};
use encounter::gp::vhgp::Vhgp;
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
        monte_carlo: 1,
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
            iterations: 200,
            memory: 10,
            gradient_tolerance: 1e-2,
            value_tolerance: 1e-7,
        },
    }
}

/// x ~ N(5, 1): candidates on [0, 10], a stratified Monte-Carlo set.
fn reference_input(monte_carlo: u32) -> Input {
    let grid = reference().candidates();
    let p = grid.points().iter().map(|x| density(x[0] - 5.0)).collect();
    let strata = f64::from(monte_carlo);
    let x = (0..monte_carlo)
        .map(|i| [5.0 + quantile((f64::from(i) + 0.5) / strata), 0.0])
        .collect();
    Input::new(grid, p, x)
}

/// y = (x - 5)² + N(0, (0.1 + 0.1 x²)²).
fn reference_response(x: f64, stream: &mut ChaCha12Rng) -> f64 {
    (x - 5.0) * (x - 5.0) + (0.1 + 0.1 * x * x) * from_uniform(uniform(stream))
}

fn reference_trial(seed: u64, input: &Input) -> Realisation {
    let respond = |x: [f64; 2], s: &mut ChaCha12Rng| Some((x, reference_response(x[0], s)));
    sequential(&reference(), input, 9.0, respond, &mut stream(seed))
}

#[test]
fn the_published_1d_case_converges_to_its_probability() {
    let input = reference_input(4000);
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
    let input = reference_input(20_000);
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
    let p: Vec<f64> = trials.iter().map(|t| t.estimate[20]).collect();
    let m = mean(&p);
    assert!((m - 0.0171).abs() < 0.0018 || (m - TRUTH).abs() < 0.0171 - TRUTH, "{m}");
    assert!(standard_deviation(&p) < 0.0056);
}
