//! How long do one bound, one fit and one realisation take, and what would plain dense algebra need for the bound?

use std::hint::black_box;
use std::sync::OnceLock;

use divan::{Bencher, counter::ItemsCount};
use encounter::design::estimate::{exceedance, probability};
use encounter::design::pool::{Pool, Used};
use encounter::design::quadrature::Quadrature;
use encounter::design::sequential::{Design, Input, sequential};
use encounter::design::settings::{LookAhead, Shared, VhgpSeq};
use encounter::gp::elbo::Elbo;
use encounter::gp::fit::Fit;
use encounter::gp::vhgp::Vhgp;
use encounter::numerics::elementary::{exp, ln};
use encounter::numerics::normal::from_uniform;
use encounter::numerics::random::uniform;
use nalgebra::{DMatrix, DVector};
use rand_chacha::ChaCha12Rng;
use rand_chacha::rand_core::SeedableRng;
use serde::de::DeserializeOwned;

const JITTER: f64 = 1e-6;
const THRESHOLD: f64 = 0.85;
/// A table of the paper's parameters.
fn table<T: DeserializeOwned>(name: &str) -> T {
    let file: toml::Table = toml::from_str(include_str!("../../stages/paper.toml")).expect("TOML");
    file[name].clone().try_into().expect("a table")
}

fn seeded(seed: u64) -> ChaCha12Rng {
    ChaCha12Rng::seed_from_u64(seed)
}

fn shared() -> VhgpSeq {
    table("vhgp_seq")
}

fn best() -> Design {
    table::<LookAhead>("vhgp_best").design(&table::<Shared>("vhgp_seq"), 0.9)
}

/// 200,000 groups in (ln L/T_p, A/H_s) and a roll with scatter, about as many exceedances as S2 has.
fn groups() -> &'static (Vec<[f64; 2]>, Vec<f64>) {
    static GROUPS: OnceLock<(Vec<[f64; 2]>, Vec<f64>)> = OnceLock::new();
    GROUPS.get_or_init(|| {
        let mut s = seeded(11);
        let mut normal = || from_uniform(uniform(&mut s));
        (0..200_000)
            .map(|_| {
                let (u, v, w) = (normal(), normal(), normal());
                let x = [0.3 + 0.45 * u, 0.48 + 0.16 * (0.5 * u + 0.87 * v)];
                (x, 0.9 * x[1] + 0.12 * x[0] + (0.05 + 0.05 * x[1]) * w)
            })
            .unzip()
    })
}

fn scaled(n: usize) -> (Vec<[f64; 2]>, Vec<f64>) {
    let (x, r) = groups();
    (x[..n].to_vec(), r[..n].iter().map(|r| (r - 0.47) / 0.2).collect())
}

fn fitted(n: usize) -> Fit {
    let (x, y) = scaled(n);
    best().fit.fit(&x, &y, None, &mut seeded(1)).expect("fits")
}

/// F and all its derivatives at 120 samples.
#[divan::bench]
fn bound_of_120_samples(bencher: Bencher) {
    let ((x, y), fit) = (scaled(120), fitted(120));
    let mut bound = Elbo::new(&x, &y, JITTER);
    let mut gradient = vec![0.0; fit.theta.len()];
    bencher.bench_local(|| bound.evaluate(black_box(&fit.theta), &mut gradient));
}

/// The same number from the formulas as they stand, in nalgebra.
#[divan::bench]
fn bound_of_120_samples_nalgebra(bencher: Bencher) {
    let ((x, y), fit) = (scaled(120), fitted(120));
    let mut gradient = vec![0.0; fit.theta.len()];
    let expected = Elbo::new(&x, &y, JITTER).evaluate(&fit.theta, &mut gradient);
    let (f, plain) = straightforward(&x, &y, &fit.theta);
    assert!(
        (f - expected.expect("positive definite")).abs() < 1e-6,
        "{f} {expected:?}"
    );
    assert!(plain.iter().zip(&gradient).all(|(a, b)| (a - b).abs() < 1e-5));
    bencher.bench_local(|| straightforward(black_box(&x), &y, &fit.theta));
}

/// A fit of 120 samples that starts from the optimum of the first 117.
#[divan::bench]
fn warm_fit_of_120_samples(bencher: Bencher) {
    let ((x, y), warm, design) = (scaled(120), fitted(117), best());
    bencher.bench_local(|| design.fit.fit(black_box(&x), &y, Some(&warm), &mut seeded(1)));
}

/// P_est over 64 x 64 nodes that stand for 200,000 groups.
#[divan::bench]
fn estimate_over_nodes(bencher: Bencher) {
    let ((x, y), fit) = (scaled(120), fitted(120));
    let model = Vhgp::new(&x, &y, &fit.theta, JITTER).expect("positive definite");
    let quadrature = Quadrature::new(&groups().0, [64, 64]);
    bencher.bench_local(|| probability(black_box(&model), &quadrature, 1.5));
}

/// P_est over 10,000 of the groups, one by one.
#[divan::bench]
fn estimate_over_10_000_groups(bencher: Bencher) {
    let ((x, y), fit) = (scaled(120), fitted(120));
    let model = Vhgp::new(&x, &y, &fit.theta, JITTER).expect("positive definite");
    let some = &groups().0[..10_000];
    bencher.bench_local(|| {
        let mut total = 0.0;
        model.means(black_box(some), |f, g| total += exceedance(f, g, 1.5));
        total
    });
}

fn realisation(bencher: Bencher, design: &Design, input: &Input, log: bool) {
    let (points, r) = groups();
    let points: Vec<[f64; 2]> = points
        .iter()
        .map(|x| if log { *x } else { [exp(x[0]), x[1]] })
        .collect();
    let pool = Pool::new(&points);
    bencher.counter(ItemsCount::new(1_u32)).bench_local(|| {
        let mut used = Used::default();
        let respond = |x: [f64; 2], s: &mut ChaCha12Rng| {
            let index = pool.draw(&x, 8, &mut used, s)?;
            Some((pool.point(index), r[index as usize]))
        };
        sequential(design, input, THRESHOLD, respond, &mut seeded(1))
    });
}

/// 30 to 120 samples by the paper's method.
#[divan::bench(sample_count = 10)]
fn realisation_of_the_paper_s_method(bencher: Bencher) {
    let settings = shared();
    let points: Vec<[f64; 2]> = groups().0.iter().map(|x| [exp(x[0]), x[1]]).collect();
    let grid = settings.candidates();
    let density = grid.density(&points, settings.bandwidth);
    let input = Input::new(grid, density, Quadrature::new(&points, settings.quadrature));
    realisation(bencher, &settings.design(), &input, false);
}

/// 30 to 120 samples by the design that looks ahead.
#[divan::bench(sample_count = 10)]
fn realisation_that_looks_ahead(bencher: Bencher) {
    let input = Input::on_nodes(Quadrature::new(&groups().0, [64, 64]));
    realisation(bencher, &best(), &input, true);
}

/// (V1), (V2) and the gradient with dense matrices, inverses by Cholesky, no structure used.
fn straightforward(x: &[[f64; 2]], y: &[f64], theta: &[f64]) -> (f64, Vec<f64>) {
    let n = x.len();
    let lambda = DVector::from_fn(n, |i, _| exp(theta[i]));
    let kernel = |h: &[f64]| {
        DMatrix::from_fn(n, n, |i, j| {
            let [u, v] = [0, 1].map(|d| (x[i][d] - x[j][d]) / exp(h[1 + d]));
            exp(h[0] - 0.5 * (u * u + v * v)) + if i == j { JITTER } else { 0.0 }
        })
    };
    let (h_f, h_g, mu_0) = (&theta[n..n + 3], &theta[n + 3..n + 6], theta[n + 6]);
    let (k_f, k_g, y) = (kernel(h_f), kernel(h_g), DVector::from_column_slice(y));
    let s = lambda.map(f64::sqrt);
    let c = DMatrix::identity(n, n) + (&s * s.transpose()).component_mul(&k_g);
    let c = c.cholesky().expect("positive definite");
    let v = c.l().solve_lower_triangular(&DMatrix::identity(n, n)).expect("regular");
    let u = &v * DMatrix::from_diagonal(&s);
    let h = &u * &k_g;
    let sigma = &k_g - h.transpose() * &h;
    let beta = lambda.add_scalar(-0.5);
    let mu = (&k_g * &beta).add_scalar(mu_0);
    let r = DVector::from_fn(n, |i, _| exp(mu[i] - 0.5 * sigma[(i, i)]));
    let logs = |d: DVector<f64>| d.iter().map(|v| ln(*v)).sum::<f64>();
    let kl = 0.5 * beta.dot(&mu.add_scalar(-mu_0)) - logs(v.diagonal()) + 0.5 * v.norm_squared() - 0.5 * n as f64;
    let l = (&k_f + DMatrix::from_diagonal(&r))
        .cholesky()
        .expect("positive definite");
    let (b, alpha) = (l.inverse(), l.solve(&y));
    let log_n = -0.5 * y.dot(&alpha) - logs(l.l().diagonal()) - 0.5 * n as f64 * ln(std::f64::consts::TAU);
    let f = log_n - 0.25 * sigma.trace() - kl;

    let b_hat = DVector::from_fn(n, |i, _| -0.5 * r[i] * (b[(i, i)] - alpha[i] * alpha[i]));
    let lambda_hat = b_hat.add_scalar(0.5);
    let by_lambda = (&k_g + sigma.component_mul(&sigma) * 0.5) * (&lambda - &lambda_hat);
    let mut gradient: Vec<f64> = (0..n).map(|i| -lambda[i] * by_lambda[i]).collect();
    let m = v.transpose() * &u;
    let ratio = DMatrix::from_diagonal(&lambda_hat.component_div(&lambda).add_scalar(-1.0));
    let w_f = &alpha * alpha.transpose() - b;
    let w_g = &beta * beta.transpose() + (&b_hat - &beta) * beta.transpose() * 2.0
        - m.transpose() * ratio * &m
        - u.transpose() * &u;
    for (k, w, h) in [(&k_f, w_f, h_f), (&k_g, w_g, h_g)] {
        let bare = k - DMatrix::identity(n, n) * JITTER;
        gradient.push(0.5 * bare.dot(&w));
        for d in 0..2 {
            let length = exp(h[1 + d]);
            let slope = DMatrix::from_fn(n, n, |i, j| {
                let u = (x[i][d] - x[j][d]) / length;
                bare[(i, j)] * u * u
            });
            gradient.push(0.5 * slope.dot(&w));
        }
    }
    gradient.push(b_hat.sum());
    (f, gradient)
}
