//! Claims about the fitted surrogate over many seeds: its credible bands, and its homoscedastic twin beside it.

use encounter::gp::fit::{Fitting, KernelSpan, Span};
use encounter::gp::standard::Standard;
use encounter::gp::vhgp::Vhgp;
use encounter::numerics::elementary::{exp, ln, sin};
use encounter::numerics::normal::from_uniform;
use encounter::numerics::random::uniform;
use rand_chacha::ChaCha12Rng;
use rand_chacha::rand_core::SeedableRng;

const SEEDS: u64 = 24;
const JITTER: f64 = 1e-6;

fn fitting() -> Fitting {
    let span = |start, from, to| Span { start, from, to };
    Fitting {
        k_f: KernelSpan {
            variance: span(1.0, 0.01, 100.0),
            length: vec![span(1.0, 0.1, 20.0)],
        },
        k_g: KernelSpan {
            variance: span(1.0, 0.05, 9.0),
            length: vec![span(1.0, 0.2, 20.0)],
        },
        mu_0: [-8.0, 4.0],
        log_lambda: [-4.0, 3.0],
        jitter: JITTER,
        restarts: 1,
        fresh_start_every: 1,
        iterations: 200,
        memory: 10,
        gradient_tolerance: 1e-2,
        value_tolerance: 1e-7,
    }
}

/// f = sin 2x; the noise's standard deviation grows from 0.05 (x = 0) to 0.8 (x = 4).
fn mean(x: f64) -> f64 {
    sin(2.0 * x)
}

fn log_variance(x: f64) -> f64 {
    2.0 * (ln(0.05) + x * ln(16.0) / 4.0)
}

fn sample(n: usize, stream: &mut ChaCha12Rng) -> (Vec<[f64; 1]>, Vec<f64>) {
    (0..n)
        .map(|_| {
            let x = 4.0 * uniform(stream);
            let y = mean(x) + exp(0.5 * log_variance(x)) * from_uniform(uniform(stream));
            ([x], y)
        })
        .unzip()
}

/// -2 log density of a normal.
fn score(y: f64, m: f64, v: f64) -> f64 {
    (y - m) * (y - m) / v + ln(v)
}

#[test]
fn mean_and_noise_lie_in_their_bands_and_the_homoscedastic_twin_predicts_worse() {
    let (mut in_f, mut in_g, mut all) = (0.0, 0.0, 0.0);
    let mut wins = 0;
    for seed in 0..SEEDS {
        let mut stream = ChaCha12Rng::seed_from_u64(seed);
        let (x, y) = sample(80, &mut stream);
        let fit = fitting().fit(&x, &y, None, &mut stream).expect("fits");
        let model = Vhgp::new(&x, &y, &fit.theta, JITTER).expect("positive definite");
        let theta = fitting().fit_standard(&x, &y).expect("fits");
        let twin = Standard::new(&x, &y, &theta).expect("positive definite");
        for i in 0..20 {
            let x = 0.1 + 0.2 * f64::from(i);
            let p = model.predict(&[[x]])[0];
            in_f += f64::from((p.f_m - mean(x)).abs() < 1.96 * p.f_v.sqrt());
            in_g += f64::from((p.g_m - log_variance(x)).abs() < 1.96 * p.g_v.sqrt());
            all += 1.0;
        }
        let (x, y) = sample(200, &mut stream);
        let (mut ours, mut theirs) = (0.0, 0.0);
        for ((p, (m, v)), y) in model.predict(&x).iter().zip(twin.predict(&x)).zip(&y) {
            ours += score(*y, p.mean(), p.variance());
            theirs += score(*y, m, v + twin.noise);
        }
        wins += u64::from(ours < theirs);
    }
    println!(
        "coverage of 95 % bands: f {:.3}, g {:.3}; twin beaten in {wins} of {SEEDS}",
        in_f / all,
        in_g / all
    );
    // Points of one seed move together: 24 seeds know a coverage to about 0.03.
    assert!((0.86..0.995).contains(&(in_f / all)), "f: {}", in_f / all);
    assert!((0.84..=1.0).contains(&(in_g / all)), "g: {}", in_g / all);
    assert_eq!(wins, SEEDS);
}

#[test]
fn constant_noise_is_found_constant() {
    let mut stream = ChaCha12Rng::seed_from_u64(7);
    let x: Vec<[f64; 1]> = (0..80).map(|_| [4.0 * uniform(&mut stream)]).collect();
    let y: Vec<f64> = x
        .iter()
        .map(|x| mean(x[0]) + 0.3 * from_uniform(uniform(&mut stream)))
        .collect();
    let fit = fitting().fit(&x, &y, None, &mut stream).expect("fits");
    let model = Vhgp::new(&x, &y, &fit.theta, JITTER).expect("positive definite");
    let theta = fitting().fit_standard(&x, &y).expect("fits");
    let twin = Standard::new(&x, &y, &theta).expect("positive definite");
    assert!((0.2..0.4).contains(&twin.noise.sqrt()));
    for x in [0.5, 1.5, 2.5, 3.5] {
        let sd = exp(0.5 * model.predict(&[[x]])[0].g_m);
        assert!((0.2..0.42).contains(&sd), "{x}: {sd}");
    }
}
