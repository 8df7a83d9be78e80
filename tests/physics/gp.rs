//! Claims about the Gaussian processes: the published vector, every derivative, recovery of a known function.

use encounter::gp::elbo::Elbo;
use encounter::gp::fit::{Fitting, KernelSpan, Span};
use encounter::gp::kernel::Ard;
use encounter::gp::left_out::left_out;
use encounter::gp::standard::{Likelihood, Standard};
use encounter::gp::vhgp::Vhgp;
use encounter::numerics::elementary::{exp, ln, sin};
use encounter::numerics::normal::from_uniform;
use encounter::numerics::random::uniform;
use nalgebra::{DMatrix, DVector};
use rand_chacha::ChaCha12Rng;
use rand_chacha::rand_core::SeedableRng;

const X: [[f64; 2]; 6] = [[0.0, 0.0], [1.0, 0.5], [2.0, -1.0], [0.5, 2.0], [-1.5, 1.0], [1.5, 1.5]];
const Y: [f64; 6] = [0.3, 1.2, -0.7, 0.9, 2.1, 0.1];
const LAMBDA: [f64; 6] = [0.5, 0.6, 0.4, 0.7, 0.3, 0.55];

/// The published parameters: isotropic, so both lengths of a kernel are equal.
fn published() -> Vec<f64> {
    let mut theta: Vec<f64> = LAMBDA.iter().map(|l| ln(*l)).collect();
    for v in [2.0_f64, 1.5, 1.5, 0.8, 2.0, 2.0] {
        theta.push(ln(v));
    }
    theta.push(-1.2);
    theta
}

fn close(name: &str, found: &[f64], expected: &[f64], tolerance: f64) {
    assert_eq!(found.len(), expected.len());
    for (a, b) in found.iter().zip(expected) {
        assert!(
            (a - b).abs() < tolerance,
            "{name}: found {found:?}, expected {expected:?}"
        );
    }
}

fn random_problem(n: usize) -> (Vec<[f64; 2]>, Vec<f64>, Vec<f64>, ChaCha12Rng) {
    let mut stream = ChaCha12Rng::seed_from_u64(n as u64);
    let x: Vec<[f64; 2]> = (0..n)
        .map(|_| [4.0 * uniform(&mut stream), uniform(&mut stream)])
        .collect();
    let y: Vec<f64> = x
        .iter()
        .map(|x| sin(2.0 * x[0]) + 3.0 * x[1] + 0.3 * x[0] * from_uniform(uniform(&mut stream)))
        .collect();
    let mut theta: Vec<f64> = (0..n).map(|_| 2.0 * uniform(&mut stream) - 1.5).collect();
    theta.extend([0.7, 0.1, -0.9, -0.2, 0.5, -0.3, -1.4]);
    (x, y, theta, stream)
}

/// Conditional mean of a zero-mean normal vector with covariance `k` at place i, from the others' observations of their own
/// places with these variances: by elimination, as in a textbook.
fn conditional(k: &DMatrix<f64>, i: usize, observed: &[f64], variance: &[f64]) -> f64 {
    let others: Vec<usize> = (0..k.nrows()).filter(|j| *j != i).collect();
    let n = others.len();
    let covariance = DMatrix::from_fn(n, n, |a, b| {
        k[(others[a], others[b])] + if a == b { variance[others[a]] } else { 0.0 }
    });
    let y = DVector::from_fn(n, |a, _| observed[others[a]]);
    let weights = covariance.lu().solve(&y).expect("positive definite");
    (0..n).map(|a| k[(i, others[a])] * weights[a]).sum()
}

#[test]
fn a_sample_left_out_is_predicted_from_the_others() {
    // The jitter is noise like any other.
    for jitter in [1e-9, 1e-4, 1e-2] {
        left_out_is_conditional(25, jitter);
    }
}

fn left_out_is_conditional(n: usize, jitter: f64) {
    let (x, y, theta, _) = random_problem(n);
    let model = Vhgp::new(&x, &y, &theta, jitter).expect("positive definite");
    let kernel = |k: &Ard| {
        let one = |a: &[f64; 2], b: &[f64; 2]| {
            let steps = (0..2).map(|d| (a[d] - b[d]) / k.length[d]);
            let squares = steps.map(|step| step * step);
            k.variance * exp(-0.5 * squares.sum::<f64>())
        };
        DMatrix::from_fn(n, n, |i, j| one(&x[i], &x[j]))
    };
    let (k_f, k_g) = (kernel(&model.parameters.k_f), kernel(&model.parameters.k_g));
    let known = model.predict(&x);
    let noise: Vec<f64> = known.iter().map(|p| exp(p.g_m - 0.5 * p.g_v) + jitter).collect();
    // q(g) is the prior times a normal term per sample: precision λ, and what makes the mean μ.
    let mu_0 = model.parameters.mu_0;
    let lambda = &model.parameters.lambda;
    let terms: Vec<f64> = known
        .iter()
        .zip(lambda)
        .map(|(p, l)| (p.g_m - mu_0) + (l - 0.5) / l)
        .collect();
    let variances: Vec<f64> = lambda.iter().map(|l| 1.0 / l).collect();
    let found = left_out(&model, &y);
    for i in 0..n {
        let f = conditional(&k_f, i, &y, &noise);
        let g = mu_0 + conditional(&k_g, i, &terms, &variances);
        // R stems from the fit, whose K_g has the jitter too.
        close("f left out", &[found.f[i]], &[f], 1e-6 + jitter);
        close("g left out", &[found.g[i]], &[g], 1e-6 + 5.0 * jitter);
    }
}

#[test]
fn a_sample_far_from_all_others_is_left_to_the_prior() {
    // Hardly any noise, so that f_v and R differ by rounding alone.
    let x = [[0.0, 0.0], [0.2, 0.0], [100.0, 0.0], [0.0, 300.0]];
    let y = [0.4, 0.5, -1.2, 2.0];
    let mut theta = vec![ln(0.5); 4];
    theta.extend([ln(20.0), 0.0, 0.0, ln(0.1), 0.0, 0.0, -14.0]);
    let model = Vhgp::new(&x, &y, &theta, 1e-6).expect("positive definite");
    let found = left_out(&model, &y);
    for i in [2, 3] {
        close("alone", &[found.f[i], found.g[i]], &[0.0, -14.0], 1e-8);
    }
    // The two neighbours know each other.
    assert!(
        (found.f[0] - 0.5).abs() < 0.1 && (found.f[1] - 0.4).abs() < 0.1,
        "{found:?}"
    );
}

#[test]
fn the_published_bound_is_met_number_by_number() {
    let mut bound = Elbo::new(&X, &Y, 1e-4);
    let mut gradient = [0.0; 13];
    let f = bound.evaluate(&published(), &mut gradient).expect("positive definite");
    close("F, KL", &[f, bound.kl], &[-10.048373220, 0.243542297], 1e-8);
    let mu = [
        -1.164125805,
        -1.093008745,
        -1.190746365,
        -1.052483608,
        -1.236785545,
        -1.040558140,
    ];
    close("mu", &bound.mu, &mu, 1e-8);
    let sigma: Vec<f64> = (0..6).map(|i| bound.sigma_g.at(i, i)).collect();
    let expected = [
        0.395837927,
        0.325355486,
        0.510437183,
        0.373886683,
        0.532743784,
        0.364845594,
    ];
    close("Sigma_ii", &sigma, &expected, 1e-8);
    let r = [
        0.256136501,
        0.284880214,
        0.235518702,
        0.289550097,
        0.222426752,
        0.294351415,
    ];
    close("R", &bound.r_noise, &r, 1e-8);
    let by_lambda = [
        0.086905097,
        0.048505434,
        0.052692542,
        -0.048060543,
        0.059903653,
        -0.029275177,
    ];
    close("dF/dlog lambda", &gradient[..6], &by_lambda, 1e-8);
    // The published lengths are isotropic: both coordinates' derivatives add up.
    let g = &gradient[6..];
    let hyper = [g[0], g[1] + g[2], g[3], g[4] + g[5], g[6]];
    let expected = [-0.844424659, 0.558281723, -0.678081829, 0.296402087, 0.231565300];
    close("dF/dhyper", &hyper, &expected, 1e-8);
}

#[test]
fn the_published_predictions_are_met_without_jitter() {
    let model = Vhgp::new(&X, &Y, &published(), 0.0).expect("positive definite");
    let p = model.predict(&[[0.2, 0.3], [3.0, 3.0]]);
    close("f_m", &[p[0].f_m, p[1].f_m], &[0.821216939, -0.288858658], 1e-8);
    close("f_v", &[p[0].f_v, p[1].f_v], &[0.164726470, 1.698952778], 1e-8);
    close("g_m", &[p[0].g_m, p[1].g_m], &[-1.137291272, -1.107623128], 1e-8);
    close("g_v", &[p[0].g_v, p[1].g_v], &[0.355680465, 0.697283923], 1e-8);
    assert_eq!(p[0].mean(), p[0].f_m);
    assert!((p[0].variance() - (p[0].f_v + exp(p[0].g_m + p[0].g_v / 2.0))).abs() < 1e-14);
    let mut means = Vec::new();
    model.means(&[[0.2, 0.3], [3.0, 3.0]], |f, g| means.extend([f, g]));
    close("means", &means, &[p[0].f_m, p[0].g_m, p[1].f_m, p[1].g_m], 1e-14);
}

#[test]
fn every_derivative_of_the_bound_is_its_finite_difference() {
    for n in [3, 8, 21] {
        let (x, y, theta, _) = random_problem(n);
        let mut bound = Elbo::new(&x, &y, 1e-5);
        let mut gradient = vec![0.0; theta.len()];
        let mut unused = gradient.clone();
        bound.evaluate(&theta, &mut gradient).expect("positive definite");
        for i in 0..theta.len() {
            let mut at = |step: f64| {
                let mut moved = theta.clone();
                moved[i] += step;
                bound.evaluate(&moved, &mut unused).expect("positive definite")
            };
            let h = 1e-3;
            let slope = (8.0 * (at(h) - at(-h)) - (at(2.0 * h) - at(-2.0 * h))) / (12.0 * h);
            // Jitter is not scaled by the variances: the derivative of K has none, so the two agree to 1e-8 here.
            assert!(
                (slope - gradient[i]).abs() < 1e-7 * (1.0 + slope.abs()),
                "n = {n}, parameter {i}: {slope} {}",
                gradient[i]
            );
        }
    }
}

#[test]
fn the_bound_s_bits_are_those_of_every_level_and_machine() {
    let (x, y, theta, _) = random_problem(21);
    let mut gradient = vec![0.0; theta.len()];
    let f = Elbo::new(&x, &y, 1e-5)
        .evaluate(&theta, &mut gradient)
        .expect("positive definite");
    let model = Vhgp::new(&x, &y, &theta, 1e-5).expect("positive definite");
    let mut bits = blake3::Hasher::new();
    for v in std::iter::once(&f).chain(&gradient) {
        bits.update(&v.to_bits().to_le_bytes());
    }
    for p in model.predict(&x[..11]) {
        for v in [p.f_m, p.f_v, p.g_m, p.g_v] {
            bits.update(&v.to_bits().to_le_bytes());
        }
    }
    // Found alike with ENCOUNTER_LEVEL = base, avx2 and avx512.
    assert_eq!(&bits.finalize().to_hex()[..16], "f7cee7eac99bb78f");
}

#[test]
fn every_derivative_of_the_standard_likelihood_is_its_finite_difference() {
    let (x, y, _, _) = random_problem(21);
    let theta = [0.4, 0.2, -0.8, -1.0];
    let mut likelihood = Likelihood::new(&x, &y);
    let (mut gradient, mut unused) = ([0.0; 4], [0.0; 4]);
    likelihood.evaluate(&theta, &mut gradient).expect("positive definite");
    for i in 0..4 {
        let mut at = |step: f64| {
            let mut moved = theta;
            moved[i] += step;
            likelihood.evaluate(&moved, &mut unused).expect("positive definite")
        };
        let slope = (8.0 * (at(1e-3) - at(-1e-3)) - (at(2e-3) - at(-2e-3))) / 12e-3;
        assert!(
            (slope - gradient[i]).abs() < 1e-7 * (1.0 + slope.abs()),
            "parameter {i}"
        );
    }
}

fn fitting() -> Fitting {
    let span = |start, from, to| Span { start, from, to };
    Fitting {
        k_f: KernelSpan {
            variance: span(1.0, 0.01, 100.0),
            length: vec![span(1.0, 0.1, 20.0), span(0.5, 0.1, 20.0)],
        },
        k_g: KernelSpan {
            variance: span(1.0, 0.05, 9.0),
            length: vec![span(1.0, 0.2, 20.0), span(0.5, 0.2, 20.0)],
        },
        mu_0: [-8.0, 4.0],
        log_lambda: [-4.0, 3.0],
        jitter: 1e-6,
        restarts: 2,
        fresh_start_every: 1,
        iterations: 200,
        memory: 10,
        gradient_tolerance: 1e-2,
        value_tolerance: 1e-7,
    }
}

/// y = sin 2 x_0 + x_1 + e, sd(e) from 0.05 (x_0 = 0) to 0.8 (x_0 = 4).
fn known(n: usize, seed: u64) -> (Vec<[f64; 2]>, Vec<f64>) {
    let mut stream = ChaCha12Rng::seed_from_u64(seed);
    let x: Vec<[f64; 2]> = (0..n)
        .map(|_| [4.0 * uniform(&mut stream), uniform(&mut stream)])
        .collect();
    let y = x
        .iter()
        .map(|x| mean(x) + noise(x) * from_uniform(uniform(&mut stream)))
        .collect();
    (x, y)
}

fn mean(x: &[f64; 2]) -> f64 {
    sin(2.0 * x[0]) + x[1] - 0.5
}

fn noise(x: &[f64; 2]) -> f64 {
    0.05 * exp(x[0] * ln(16.0) / 4.0)
}

#[test]
fn a_known_function_and_its_noise_are_recovered() {
    let (x, y) = known(160, 3);
    let mut stream = ChaCha12Rng::seed_from_u64(1);
    let fit = fitting().fit(&x, &y, None, &mut stream).expect("some start succeeds");
    let model = Vhgp::new(&x, &y, &fit.theta, 1e-6).expect("positive definite");
    assert_eq!(model.elbo, fit.elbo);
    let standard = fitting().fit_standard(&x, &y).expect("converges");
    let constant = Standard::new(&x, &y, &standard).expect("positive definite");
    for x0 in [0.3, 1.0, 2.0, 3.0, 3.7] {
        let point = [x0, 0.5];
        let p = model.predict(&[point])[0];
        let tolerance = 0.1 + 0.6 * noise(&point);
        assert!((p.f_m - mean(&point)).abs() < tolerance, "f at {x0}: {p:?}");
        let ratio = exp(0.5 * p.g_m) / noise(&point);
        assert!((0.5..2.0).contains(&ratio), "noise at {x0} is {ratio} of the truth");
        assert!((constant.predict(&[point])[0].0 - mean(&point)).abs() < 0.5);
    }
    assert!(
        (0.2..0.6).contains(&constant.noise.sqrt()),
        "one noise for all: {}",
        constant.noise.sqrt()
    );
}

#[test]
fn a_warm_start_finds_the_optimum_again_in_few_evaluations() {
    let (x, y) = known(60, 4);
    let mut stream = ChaCha12Rng::seed_from_u64(1);
    let first = fitting().fit(&x, &y, None, &mut stream).expect("succeeds");
    let again = fitting().fit(&x, &y, Some(&first), &mut stream).expect("succeeds");
    assert!(again.elbo >= first.elbo - 1e-9);
    assert!(
        again.evaluations < first.evaluations,
        "{} {}",
        again.evaluations,
        first.evaluations
    );
    let (x, y) = known(63, 4);
    assert!(
        fitting().fit(&x, &y, Some(&first), &mut stream).is_some(),
        "new samples join a warm start"
    );
}

#[test]
fn a_fit_that_fails_is_a_value() {
    let (x, mut y) = known(12, 5);
    y[3] = f64::NAN;
    assert_eq!(fitting().fit(&x, &y, None, &mut ChaCha12Rng::seed_from_u64(1)), None);
}

#[test]
fn spans_that_do_not_hold_their_start_are_refused() {
    let mut wrong = fitting();
    wrong.k_g.variance.start = 10.0;
    assert!(
        wrong
            .check(2)
            .expect_err("outside")
            .starts_with("fit.k_g.variance: expected 0 < from <= start <= to")
    );
    assert!(
        fitting()
            .check(3)
            .expect_err("two lengths")
            .starts_with("fit.k_f.length: expected 3 spans, found 2")
    );
    assert_eq!(fitting().check(2), Ok(()));
}
