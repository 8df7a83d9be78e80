//! The statistics of detected groups agree with the two prototypes of science section 15.

use crate::physics::seas::{detection, fields, gaussian, record};
use encounter::numerics::sums::{mean, standard_deviation};
use encounter::sea::detection::detect;
use encounter::sea::envelope::Envelopes;
use encounter::sea::spectrum::Sea;

struct Statistics {
    groups_per_tp: f64,
    l_over_tp: [f64; 5], // mean, sd, quantiles .05 .50 .95
    a_over_hs: [f64; 5],
    correlation: f64,
}

fn summary(mut x: Vec<f64>) -> [f64; 5] {
    x.sort_by(f64::total_cmp);
    let quantile = |p: f64| x[(p * x.len() as f64) as usize];
    [
        mean(&x),
        standard_deviation(&x),
        quantile(0.05),
        quantile(0.5),
        quantile(0.95),
    ]
}

fn statistics(sea: &Sea, count: u64) -> Statistics {
    let envelopes = Envelopes::of(&fields(sea, &record(), 0, count), &record());
    let groups: Vec<_> = detect(&envelopes, &detection()).fields.concat();
    let l: Vec<f64> = groups.iter().map(|g| g.l / 15.0).collect();
    let a: Vec<f64> = groups.iter().map(|g| g.a / 12.0).collect();
    let (l_mean, a_mean) = (mean(&l), mean(&a));
    let product: Vec<f64> = l.iter().zip(&a).map(|(l, a)| (l - l_mean) * (a - a_mean)).collect();
    let correlation = mean(&product) / (standard_deviation(&l) * standard_deviation(&a));
    Statistics {
        groups_per_tp: groups.len() as f64 / (256.0 * count as f64),
        l_over_tp: summary(l),
        a_over_hs: summary(a),
        correlation,
    }
}

/// Against the mean of the two prototypes: 3 % for counts and means, wider by the sampling error of 240 fields for the
/// spread and the quantiles.
fn agrees(found: &Statistics, groups_per_tp: f64, l: [f64; 5], a: [f64; 5], correlation: f64) {
    let close = |x: f64, y: f64, tolerance: f64| assert!((x / y - 1.0).abs() < tolerance, "{x} is not near {y}");
    close(found.groups_per_tp, groups_per_tp, 0.03);
    for ((x, y), tolerance) in found.l_over_tp.iter().zip(l).zip([0.03, 0.06, 0.04, 0.04, 0.06]) {
        close(*x, y, tolerance);
    }
    for ((x, y), tolerance) in found.a_over_hs.iter().zip(a).zip([0.03, 0.05, 0.06, 0.04, 0.04]) {
        close(*x, y, tolerance);
    }
    assert!((found.correlation - correlation).abs() < 0.06, "{}", found.correlation);
}

#[test]
fn groups_of_s1_have_the_prototypes_statistics() {
    let (l, a) = (
        [2.221, 1.170, 0.993, 1.930, 4.475],
        [0.465, 0.1695, 0.203, 0.4565, 0.7595],
    );
    agrees(&statistics(&gaussian(0.02), 240), 0.0934, l, a, 0.515);
}

#[test]
fn groups_of_s2_have_the_prototypes_statistics() {
    let (l, a) = (
        [1.542, 0.815, 0.7265, 1.3295, 3.075],
        [0.479, 0.164, 0.231, 0.466, 0.7665],
    );
    agrees(&statistics(&gaussian(0.03), 240), 0.1305, l, a, 0.46);
}
