//! Claims about the floor: closed forms, and laws that any floor obeys.

use encounter::design::floor::{Floor, floor};
use encounter::design::quadrature::Quadrature;
use encounter::numerics::normal::{density, distribution, from_uniform};
use encounter::numerics::optimal_design::{Unknown, c_optimal};
use encounter::numerics::random::uniform;
use rand_chacha::ChaCha12Rng;
use rand_chacha::rand_core::SeedableRng;

/// Inputs uniform in a box, r normal with mean `slope` x_1 and standard deviation 1.
fn pool(slope: f64) -> (Vec<[f64; 2]>, Vec<f64>) {
    let mut s = ChaCha12Rng::seed_from_u64(5);
    let x: Vec<[f64; 2]> = (0..100_000)
        .map(|_| [uniform(&mut s), 2.0 * uniform(&mut s) - 1.0])
        .collect();
    let r = x.iter().map(|x| slope * x[1] + from_uniform(uniform(&mut s))).collect();
    (x, r)
}

fn of(slope: f64, threshold: f64, degree: u32) -> Floor {
    let (x, r) = pool(slope);
    let q = Quadrature::new(&x, [24, 24]);
    floor((&x, &r), (threshold, 1e9), &q, [0.1, 0.1], degree).expect("some exceed")
}

fn close(name: &str, found: f64, expected: f64, relative: f64) {
    assert!(
        (found / expected - 1.0).abs() < relative,
        "{name}: {found}, expected {expected}"
    );
}

#[test]
fn without_any_influence_of_the_input_every_floor_is_a_closed_form() {
    let (threshold, found) = (1.5, of(0.0, 1.5, 0));
    let p = distribution(-threshold);
    close("P", found.probability, p, 0.02);
    close("model P", found.model_probability, p, 0.03);
    let random = ((1.0 - p) / p).sqrt();
    close("random", found.random, random, 0.02);
    // Nothing to choose: importance and strata are random sampling, up to the noise of the local shares.
    close("importance", found.importance, random, 0.04);
    close("stratified", found.stratified, random, 0.04);
    // Mean and variance unknown: φ² (1 + u²/2).
    let model = density(threshold) * (1.0 + threshold * threshold / 2.0).sqrt() / p;
    close("model", found.model, model, 0.03);
}

#[test]
fn the_floors_stand_in_their_order() {
    let [constant, plane, cubic] = [0, 1, 3].map(|degree| of(2.0, 3.0, degree));
    for found in [constant, plane, cubic] {
        assert!(found.stratified <= found.importance && found.importance < found.random);
        close("model P", found.model_probability, found.probability, 0.12);
    }
    assert!(
        constant.model < plane.model && plane.model < cubic.model,
        "more to find costs more"
    );
    assert!(plane.model < plane.stratified, "a model that holds beats counting");
    // By quadrature over x_1: √((E√π)² - P²)/P.
    let steps = 2000;
    let share = |i: i32| distribution(2.0 * (2.0 * (f64::from(i) + 0.5) / f64::from(steps) - 1.0) - 3.0);
    let over = |h: fn(f64) -> f64| (0..steps).map(|i| h(share(i))).sum::<f64>() / f64::from(steps);
    let (p, root) = (over(|p| p), over(f64::sqrt));
    close("importance", plane.importance, (root * root - p * p).sqrt() / p, 0.1);
    close(
        "stratified",
        plane.stratified,
        over(|p| (p * (1.0 - p)).sqrt()) / p,
        0.1,
    );
}

#[test]
fn the_plane_s_floor_is_reached_by_its_own_best_design_only() {
    // One coordinate matters: a design at two places cannot be beaten by one spread evenly.
    let found = of(2.0, 3.0, 1).model;
    let (nodes, slope, threshold) = (400, 2.0, 3.0);
    let at = |i: i32| 2.0 * (f64::from(i) + 0.5) / f64::from(nodes) - 1.0;
    let (mut m, mut c_f, mut c_g, mut p) = ([0.0; 2], [0.0; 2], [0.0; 2], 0.0);
    for i in 0..nodes {
        let (z, u) = (at(i), slope * at(i) - threshold);
        let w = 1.0 / f64::from(nodes);
        p += w * distribution(u);
        for (k, b) in [1.0, z].into_iter().enumerate() {
            c_f[k] += w * density(u) * b;
            c_g[k] -= 0.5 * w * u * density(u) * b;
            m[k] += w * b * b;
        }
    }
    // Spread evenly M is diagonal: 1 and 1/3, half of it for g.
    let even = (0..2)
        .map(|k| (c_f[k] * c_f[k] + 2.0 * c_g[k] * c_g[k]) / m[k])
        .sum::<f64>();
    assert!(found < 0.9 * even.sqrt() / p, "{found} {}", even.sqrt() / p);
}

#[test]
fn a_threshold_that_nothing_exceeds_has_no_floor() {
    let (x, r) = pool(0.0);
    let q = Quadrature::new(&x, [8, 8]);
    assert_eq!(floor((&x, &r), (99.0, 1e9), &q, [0.1, 0.1], 1), None);
}

#[test]
fn extrapolating_a_polynomial_costs_what_elfving_s_design_does() {
    // Degree d on [-1, 1], wanted at 2: the Chebyshev polynomial's value there, squared.
    for (degree, expected) in [(1, 4.0), (2, 49.0)] {
        let powers = |x: f64| vec![1.0, x, x * x][..=degree].to_vec();
        let nodes: Vec<f64> = (0..41).map(|i| f64::from(i) / 20.0 - 1.0).collect();
        let basis: Vec<Vec<f64>> = nodes.iter().map(|x| powers(*x)).collect();
        let unknown = Unknown {
            precision: vec![1.0; 41],
            c: powers(2.0),
        };
        let found = c_optimal(&basis, &[unknown]).expect("regular");
        close("variance", found, expected, 2e-3);
    }
}

#[test]
fn rounding_makes_no_share_above_one() {
    // 23 spacings do not add up to the last bit, and narrow kernels leave each node to itself.
    let mut s = ChaCha12Rng::seed_from_u64(9);
    for round in 0..40 {
        let x: Vec<[f64; 2]> = (0..300)
            .map(|_| [0.1 + 3.7 * uniform(&mut s), 0.2 + uniform(&mut s)])
            .collect();
        let r: Vec<f64> = x.iter().map(|_| uniform(&mut s)).collect();
        let q = Quadrature::new(&x, [24, 24]);
        let found = floor((&x, &r), (0.4, 1e9), &q, [0.025, 0.02], 1).expect("some exceed");
        let all = [found.random, found.importance, found.stratified, found.model];
        assert!(all.iter().all(|v| v.is_finite() && *v >= 0.0), "{round}: {found:?}");
    }
}
