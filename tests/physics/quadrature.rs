//! Claims about the quadrature over all inputs and the sums over its grid, against their plain twins.

use encounter::design::estimate::{exceedance, probability};
use encounter::design::quadrature::Quadrature;
use encounter::gp::grid::{Axes, Pair, covariances_on, means_on};
use encounter::gp::vhgp::Vhgp;
use encounter::numerics::elementary::{exp, sin};
use encounter::numerics::normal::from_uniform;
use encounter::numerics::random::uniform;
use nalgebra::{DMatrix, DVector};
use rand_chacha::ChaCha12Rng;
use rand_chacha::rand_core::SeedableRng;

const JITTER: f64 = 1e-6;
/// log k_f, log k_g, μ₀.
const HYPER: [f64; 7] = [0.2, 0.3, -1.2, -0.5, 0.4, -0.8, -1.5];

/// 20,000 inputs like groups, in (ln L, A).
fn inputs() -> Vec<[f64; 2]> {
    let mut s = ChaCha12Rng::seed_from_u64(3);
    let mut normal = || from_uniform(uniform(&mut s));
    (0..20_000)
        .map(|_| {
            let (u, v) = (normal(), normal());
            [0.3 + 0.45 * u, 0.48 + 0.16 * (0.5 * u + 0.87 * v)]
        })
        .collect()
}

/// A model of n samples at hand-picked parameters: no fit is needed to hold sums against sums.
fn model(n: usize) -> (Vhgp<2>, Vec<f64>) {
    let x = inputs()[..n].to_vec();
    let y: Vec<f64> = x.iter().map(|x| sin(2.0 * x[0]) + 3.0 * (x[1] - 0.5)).collect();
    let mut theta: Vec<f64> = (0..n).map(|i| -0.7 + 0.03 * (i % 11) as f64).collect();
    let lambda = theta.iter().map(|l| exp(*l)).collect();
    theta.extend(HYPER);
    (Vhgp::new(&x, &y, &theta, JITTER).expect("positive definite"), lambda)
}

#[test]
fn the_weights_carry_the_mass_the_means_and_every_bilinear_function() {
    let points = inputs();
    let q = Quadrature::new(&points, [23, 31]);
    let over =
        |h: &dyn Fn([f64; 2]) -> f64| -> f64 { q.support.iter().map(|i| q.weight[*i] * h(q.axes.node(*i))).sum() };
    let direct = |h: &dyn Fn([f64; 2]) -> f64| points.iter().map(|x| h(*x)).sum::<f64>() / points.len() as f64;
    assert!((over(&|_| 1.0) - 1.0).abs() < 1e-12);
    for h in [
        |x: [f64; 2]| x[0],
        |x: [f64; 2]| x[1],
        |x: [f64; 2]| (x[0] - 1.0) * (x[1] + 2.0),
    ] {
        assert!((over(&h) - direct(&h)).abs() < 1e-11);
    }
    let value: Vec<f64> = points.iter().map(|x| x[0]).collect();
    let shared: f64 = q.shared_out(&points, &value).iter().sum();
    assert!((shared - direct(&|x| x[0])).abs() < 1e-12);
    assert!(q.support.iter().all(|i| q.weight[*i] > 0.0));
}

#[test]
fn inputs_on_a_line_or_at_one_point_have_a_quadrature() {
    let line = Quadrature::new(&[[0.0, 2.0], [1.0, 2.0], [0.25, 2.0]], [5, 7]);
    assert_eq!((line.axes.first.len(), line.axes.second.len()), (5, 1));
    assert_eq!(line.support, [0, 1, 4]);
    let point = Quadrature::new(&[[3.0, 4.0]], [5, 7]);
    assert_eq!((point.axes.nodes(), point.weight), (1, vec![1.0]));
    assert_eq!(point.axes.node(0), [3.0, 4.0]);
}

#[test]
fn the_estimate_over_64_by_64_nodes_is_the_one_over_all_inputs() {
    let (points, (model, _)) = (inputs(), model(60));
    let q = Quadrature::new(&points, [64, 64]);
    for threshold in [0.5, 1.0, 1.5] {
        let mut whole = 0.0;
        model.means(&points, |f, g| {
            whole += exceedance(f, g, threshold) / points.len() as f64;
        });
        let p = probability(&model, &q, threshold);
        assert!((p / whole - 1.0).abs() < 2e-3, "{p} {whole}");
    }
}

#[test]
fn means_on_a_grid_are_the_means_at_its_nodes() {
    let (model, _) = model(45);
    let axes = Axes {
        first: (0..13).map(|i| -1.0 + 0.2 * f64::from(i)).collect(),
        second: (0..9).map(|i| 0.1 * f64::from(i)).collect(),
    };
    let nodes: Vec<[f64; 2]> = (0..axes.nodes()).map(|i| axes.node(i)).collect();
    let found = means_on(&model, &axes);
    for (i, p) in model.predict(&nodes).iter().enumerate() {
        assert!((found.f[i] - p.f_m).abs() < 1e-11 && (found.g[i] - p.g_m).abs() < 1e-11);
    }
}

#[test]
fn covariances_on_a_grid_are_those_of_the_dense_posterior() {
    let (n, (model, lambda)) = (30, model(30));
    let axes = Axes {
        first: (0..10).map(|i| -0.8 + 0.25 * f64::from(i)).collect(),
        second: (0..6).map(|i| 0.15 * f64::from(i)).collect(),
    };
    let nodes: Vec<[f64; 2]> = (0..60).map(|i| axes.node(i)).collect();
    let weight = Pair {
        f: (0..60).map(|i| f64::from(i % 7) - 2.0).collect(),
        g: (0..60).map(|i| f64::from(i % 5) - 1.0).collect(),
    };
    let found = covariances_on(&model, &axes, &weight);
    let k = |h: &[f64], a: &[f64; 2], b: &[f64; 2]| {
        let [u, v] = [0, 1].map(|d| (a[d] - b[d]) / exp(h[1 + d]));
        exp(h[0] - 0.5 * (u * u + v * v))
    };
    let mean_noise = {
        let mut bound = encounter::gp::elbo::Elbo::new(&model.x, &vec![0.0; n], JITTER);
        let mut theta: Vec<f64> = (0..n).map(|i| -0.7 + 0.03 * (i % 11) as f64).collect();
        theta.extend(HYPER);
        let mut gradient = vec![0.0; theta.len()];
        bound.evaluate(&theta, &mut gradient).expect("positive definite");
        bound.r_noise
    };
    let noise_g: Vec<f64> = lambda.iter().map(|l: &f64| 1.0 / l).collect();
    for (h, noise, weight, found) in [
        (&HYPER[..3], &mean_noise, &weight.f, &found.f),
        (&HYPER[3..6], &noise_g, &weight.g, &found.g),
    ] {
        let extra = |i: usize| noise[i] + JITTER;
        let dense = DMatrix::from_fn(n, n, |i, j| {
            k(h, &model.x[i], &model.x[j]) + if i == j { extra(i) } else { 0.0 }
        });
        let cross = DMatrix::from_fn(n, 60, |i, j| k(h, &model.x[i], &nodes[j]));
        let prior = DMatrix::from_fn(60, 60, |i, j| k(h, &nodes[i], &nodes[j]));
        let posterior = prior - cross.transpose() * dense.cholesky().expect("positive definite").solve(&cross);
        let expected = posterior * DVector::from_column_slice(weight);
        for i in 0..60 {
            assert!(
                (found[i] - expected[i]).abs() < 1e-9,
                "{i}: {} {}",
                found[i],
                expected[i]
            );
        }
    }
}

#[test]
fn the_sums_bits_are_those_of_every_level_and_machine() {
    let (points, (model, _)) = (inputs(), model(45));
    let q = Quadrature::new(&points, [21, 34]);
    let weight = Pair {
        f: q.weight.clone(),
        g: q.weight.clone(),
    };
    let (means, covariances) = (means_on(&model, &q.axes), covariances_on(&model, &q.axes, &weight));
    let mut bits = blake3::Hasher::new();
    for v in [&means.f, &means.g, &covariances.f, &covariances.g]
        .into_iter()
        .flatten()
    {
        bits.update(&v.to_bits().to_le_bytes());
    }
    bits.update(&probability(&model, &q, 1.0).to_bits().to_le_bytes());
    // Found alike with ENCOUNTER_LEVEL = base, avx2 and avx512.
    assert_eq!(&bits.finalize().to_hex()[..16], "ea8f770104686aef");
}
