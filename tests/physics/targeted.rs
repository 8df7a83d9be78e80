//! Claims about the targeted estimate.

use crate::common::paper;
use encounter::design::estimate;
use encounter::design::look_ahead;
use encounter::design::pool::{Pool, Used};
use encounter::design::quadrature::Quadrature;
use encounter::design::response_scale::ResponseScale;
use encounter::design::sequential::{Input, sequential};
use encounter::design::settings::{LookAhead, Shared};
use encounter::design::targeted::{Targeted, log_odds, weights};
use encounter::gp::vhgp::Vhgp;
use encounter::numerics::elementary::{exp, ln};
use encounter::numerics::normal::{density, distribution, from_uniform};
use encounter::numerics::random::{below, uniform};
use encounter::numerics::sums::{mean, standard_deviation};
use rand_chacha::ChaCha12Rng;
use rand_chacha::rand_core::SeedableRng;

fn odds(q: f64) -> f64 {
    q / (1.0 - q)
}

#[test]
fn the_odds_solve_their_equation() {
    let q = [0.1, 0.4, 0.02, 0.7, 0.3];
    let above = [false, true, false, true, true];
    let weight = [0.5, 1.0, 2.0, 0.7, 1.3];
    for deviation in [0.3, 2.0, 50.0] {
        let found = log_odds(&q, &above, &weight, deviation);
        let mut left = 0.0;
        for i in 0..5 {
            let raised = odds(q[i]) * exp(found);
            left += weight[i] * (f64::from(above[i]) - raised / (1.0 + raised));
        }
        let right = found / (deviation * deviation);
        assert!((left - right).abs() < 1e-12, "s = {deviation}: {left} against {right}");
    }
}

#[test]
fn equal_probabilities_become_the_share_of_exceedances() {
    let above: Vec<bool> = (0..40).map(|i| i % 8 == 0).collect();
    let found = log_odds(&[0.5; 40], &above, &[1.0; 40], 1e6);
    assert!((exp(found) - odds(0.125)).abs() < 1e-9);
}

#[test]
fn samples_that_all_or_none_exceed_leave_the_odds_finite() {
    for (above, sign) in [(true, 1.0), (false, -1.0)] {
        let found = log_odds(&[0.1; 30], &[above; 30], &[1.0; 30], 2.0);
        assert!(found * sign > 0.0 && found.abs() < 10.0, "{found}");
    }
    // A model that is sure, and wrong.
    assert!(log_odds(&[0.0; 30], &[true; 30], &[1.0; 30], 2.0).is_finite());
    assert!(log_odds(&[1.0; 30], &[false; 30], &[1.0; 30], 2.0).is_finite());
    // No weight, no correction.
    assert!(log_odds(&[0.1; 3], &[true; 3], &[0.0; 3], 2.0).abs() < 1e-12);
}

/// 20,000 points of a standard normal pair.
fn points() -> Vec<[f64; 2]> {
    let mut s = ChaCha12Rng::seed_from_u64(3);
    let mut normal = || from_uniform(uniform(&mut s));
    (0..20_000).map(|_| [normal(), normal()]).collect()
}

#[test]
fn samples_of_the_input_weigh_alike_and_others_by_their_ratio() {
    let points = points();
    let q = Quadrature::new(&points, [64, 64]);
    let of_the_input = weights(&points[..400], &q);
    assert!(
        standard_deviation(&of_the_input) < 0.25,
        "{}",
        standard_deviation(&of_the_input)
    );
    assert!((mean(&of_the_input) - 1.0).abs() < 0.1);
    // Drawn from N(1, 1) along the first coordinate: p/q = exp(1/2 - x).
    let moved: Vec<[f64; 2]> = points[..2000].iter().map(|x| [x[0] + 1.0, x[1]]).collect();
    let found = weights(&moved, &q);
    let slope = {
        let logs: Vec<f64> = found.iter().map(|w| ln(*w)).collect();
        let inner: Vec<usize> = (0..2000).filter(|i| (moved[*i][0] - 0.5).abs() < 1.5).collect();
        let (x, y): (Vec<f64>, Vec<f64>) = inner.iter().map(|i| (moved[*i][0], logs[*i])).unzip();
        let (mx, my) = (mean(&x), mean(&y));
        let along: f64 = x.iter().zip(&y).map(|(x, y)| (x - mx) * (y - my)).sum();
        along / x.iter().map(|x| (x - mx) * (x - mx)).sum::<f64>()
    };
    assert!((slope + 1.0).abs() < 0.15, "{slope}");
    // Kish: the weights tell as much as so many equal ones.
    let (first, second): (f64, f64) = (found.iter().sum(), found.iter().map(|w| w * w).sum());
    assert!((first - second).abs() < 1e-9 * first && first < 2000.0);
}

#[test]
fn samples_that_do_not_differ_or_lie_far_off_break_nothing() {
    let q = Quadrature::new(&points(), [16, 16]);
    for n in [1, 5, 7, 30] {
        // Their standard deviation may be one of rounding.
        for value in [0.1, 0.3, 0.7] {
            let found = weights(&vec![[value, 0.2]; n], &q);
            assert!(
                found.iter().all(|w| (*w - 1.0).abs() < 1e-9),
                "{n} times {value}: {found:?}"
            );
        }
    }
    for samples in [
        vec![[0.3, 0.2]; 5],
        vec![[1e6, 1.0], [1e6 + 1e-3, 2.0]],
        vec![[0.0, 0.0]],
    ] {
        let found = weights(&samples, &q);
        assert!(found.iter().all(|w| w.is_finite() && *w >= 0.0), "{found:?}");
    }
}

#[test]
fn what_is_left_of_a_model_s_error_is_what_moves_the_estimate() {
    // A constant law: moving the threshold that the model sees, not the exceedances, is an error of the model everywhere.
    let points = points();
    let q = Quadrature::new(&points, [16, 16]);
    let x = &points[..100];
    let y: Vec<f64> = x.iter().map(|x| x[1]).collect();
    let mut theta = vec![ln(0.5); 100];
    theta.extend([ln(1e-9), 0.0, 0.0, ln(1e-9), 0.0, 0.0, 0.0]);
    let model = Vhgp::new(x, &y, &theta, 1e-12).expect("positive definite");
    for (share, s) in [(25, 0.5), (40, 1.0), (3, 2.0)] {
        let above: Vec<bool> = (0..100).map(|i| i < share).collect();
        let at = |threshold: f64| {
            let targeted = Targeted::new(&model, (&y, &above), &q, threshold, s);
            (targeted.probability(&model, &q, threshold), targeted)
        };
        let (step, threshold) = (1e-4, 1.3);
        let found = (at(threshold + step).0 - at(threshold - step).0) / (2.0 * step);
        // Q = Φ(-1.3); the slope of Q(ω) in Q is ω/(1 - Q + ωQ)².
        let (known, targeted) = (distribution(-threshold), at(threshold).1);
        let odds = exp(targeted.log_odds);
        let lowered = 1.0 - known + odds * known;
        let slope = -density(threshold) * odds / (lowered * lowered);
        let ratio = found / slope;
        assert!(
            (targeted.log_odds.abs() > 0.1) && (ratio / targeted.left - 1.0).abs() < 0.05,
            "{ratio}: {targeted:?}"
        );
    }
}

#[test]
fn a_fit_that_fails_leaves_the_estimate_to_the_samples_before() {
    let points = points();
    let (shared, own): (Shared, LookAhead) = (paper::table("vhgp_seq"), paper::table("vhgp_control"));
    let input = Input::on_nodes(Quadrature::new(&points, own.quadrature));
    let mut told = 0;
    let respond = |query: [f64; 2], _: &mut _| {
        told += 1;
        // No model fits what is not a number.
        Some((
            query,
            if told > 60 {
                f64::NAN
            } else {
                0.5 + 0.2 * query[0] + 0.01 * f64::from(told % 7)
            },
        ))
    };
    let mut stream = ChaCha12Rng::seed_from_u64(2);
    let found = sequential(&own.design(&shared, 0.9), &input, 0.9, respond, &mut stream);
    assert_eq!(found.failed_fits, 20);
    assert!(
        found.estimate.iter().all(|p| (0.0..=1.0).contains(p)),
        "{:?}",
        found.estimate
    );
    let last = found.estimate.len() - 1;
    assert_eq!(found.estimate[last].to_bits(), found.estimate[last - 19].to_bits());
}

/// Responses whose law is not normal: a number less an exponential one, so that a normal tail promises too much.
fn skewed(points: &[[f64; 2]]) -> Vec<f64> {
    let mut s = ChaCha12Rng::seed_from_u64(8);
    let scatter = |s: &mut ChaCha12Rng| 1.0 + ln(1.0 - uniform(s));
    points
        .iter()
        .map(|x| 1.0 + 0.5 * x[0] + 0.2 * x[1] + 0.4 * scatter(&mut s))
        .collect()
}

#[test]
fn it_removes_most_of_the_bias_that_a_wrong_law_leaves() {
    let points = points();
    let r = skewed(&points);
    let threshold = 2.0;
    let p_true = estimate::share_above(&r, threshold);
    let (shared, mut own): (Shared, LookAhead) = (paper::table("vhgp_seq"), paper::table("vhgp_control"));
    own.cap = 1e9;
    own.response_scale = ResponseScale::Identity;
    let input = Input::on_nodes(Quadrature::new(&points, own.quadrature));
    let pool = Pool::new(&points);
    let mut mean_over = |deviation: f64| {
        own.log_odds_deviation = deviation;
        let design = own.design(&shared, threshold);
        let last = |seed| {
            let mut used = Used::default();
            let respond = |query: [f64; 2], stream: &mut _| {
                let index = pool.draw(&query, 8, &mut used, stream)?;
                Some((pool.point(index), r[index as usize]))
            };
            let mut stream = ChaCha12Rng::seed_from_u64(seed);
            let realisation = sequential(&design, &input, threshold, respond, &mut stream);
            *realisation.estimate.last().expect("120 samples")
        };
        let all: Vec<f64> = (0..24).map(last).collect();
        (mean(&all) / p_true - 1.0, standard_deviation(&all) / p_true)
    };
    let ((by_model, _), (targeted, deviation)) = (mean_over(0.0), mean_over(2.0));
    // 24 realisations: a standard error of a fifth of the deviation.
    assert!(by_model.abs() > 0.15, "the law does not mislead: {by_model}");
    assert!(
        targeted.abs() < 0.5 * by_model.abs(),
        "{targeted} (std {deviation}) against {by_model}"
    );
}

#[test]
fn a_model_that_is_right_keeps_its_estimate() {
    let points = points();
    let mut s = ChaCha12Rng::seed_from_u64(21);
    let y: Vec<f64> = points[..150]
        .iter()
        .map(|x| x[0] + 0.3 * from_uniform(uniform(&mut s)))
        .collect();
    let shared: Shared = paper::table("vhgp_seq");
    let fit = shared.fit.fit(&points[..150], &y, None, &mut s).expect("fits");
    let model = Vhgp::new(&points[..150], &y, &fit.theta, shared.fit.jitter).expect("positive definite");
    let q = Quadrature::new(&points, [48, 48]);
    let above: Vec<bool> = y.iter().map(|y| *y > 1.0).collect();
    let own = estimate::probability(&model, &q, 1.0);
    let targeted = |s| Targeted::new(&model, (&y, &above), &q, 1.0, s);
    let found = targeted(2.0).probability(&model, &q, 1.0);
    assert!((found / own - 1.0).abs() < 0.25, "{found} against {own}");
    // The smaller s, the nearer to the model.
    let near = targeted(0.01).probability(&model, &q, 1.0);
    assert!((near / own - 1.0).abs() < 1e-3, "{near} against {own}");
    // And the nearer its deviation to the model's own.
    let variance = look_ahead::variance(&model, &q, 1.0, |_| 1.0);
    let deviation = targeted(0.01).deviation(&model, &q, 1.0);
    assert!((deviation / variance.sqrt() - 1.0).abs() < 1e-2);
}

#[test]
fn its_deviation_is_the_spread_of_many_estimates() {
    // Random samples, a model that knows nothing but a constant law: the share of exceedances, its deviation (R1).
    let points = points();
    let q = Quadrature::new(&points, [32, 32]);
    let mut s = ChaCha12Rng::seed_from_u64(4);
    let mut estimates = Vec::new();
    let mut deviations = Vec::new();
    for _ in 0..40 {
        let x: Vec<[f64; 2]> = (0..80).map(|_| points[below(&mut s, points.len())]).collect();
        let y: Vec<f64> = x.iter().map(|x| x[0] + from_uniform(uniform(&mut s))).collect();
        let above: Vec<bool> = y.iter().map(|y| *y > 1.2).collect();
        // λ = 1/2, kernels of hardly any variance: a normal law about 0 whatever x is.
        let mut theta = vec![ln(0.5); 80];
        theta.extend([ln(1e-4), 0.0, 0.0, ln(1e-4), 0.0, 0.0, ln(2.0)]);
        let model = Vhgp::new(&x, &y, &theta, 1e-6).expect("positive definite");
        let targeted = Targeted::new(&model, (&y, &above), &q, 1.2, 20.0);
        estimates.push(targeted.probability(&model, &q, 1.2));
        deviations.push(targeted.deviation(&model, &q, 1.2));
    }
    let (found, expected) = (mean(&deviations), standard_deviation(&estimates));
    // The deviation of 40 estimates is known to a ninth of it.
    assert!((found / expected - 1.0).abs() < 0.35, "{found} against {expected}");
    // P(N(0, 2) > 1.2) = 0.198.
    assert!(
        (mean(&estimates) - 0.198).abs() < 3.0 * expected / 40.0_f64.sqrt(),
        "{}",
        mean(&estimates)
    );
}
