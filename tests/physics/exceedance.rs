//! Claims about exceedance probabilities.

use super::roll_twin::truth;
use encounter::ship::exceedance::{Exceedances, Thresholds};
use encounter::ship::response::{Moments, Truth};

fn thresholds(from: f64, to: f64, step: f64) -> Thresholds {
    Thresholds { from, to, step }
}

/// The responses of some fields, counted.
pub(crate) fn of_fields<'a>(theta_t: &[f64], fields: impl IntoIterator<Item = &'a [f64]>) -> Exceedances {
    let mut counts = Exceedances::none(theta_t.len());
    for r in fields {
        counts.add_field(theta_t, r);
    }
    counts
}

const FIELDS: [&[f64]; 3] = [&[0.1, 0.5, 0.9], &[0.5, 0.6], &[]];

#[test]
fn thresholds_are_the_decimals_they_are_written_as() {
    let values = thresholds(0.0, 1.2, 0.025).values();
    assert_eq!(values.len(), 49);
    assert_eq!((values[0], values[7], values[28], values[48]), (0.0, 0.175, 0.7, 1.2));
}

#[test]
fn exceedance_is_strict_and_counted_over_all_groups() {
    let curve = of_fields(&[0.0, 0.5, 0.9], FIELDS).curve("truth", 0.02, &[0.0, 0.5, 0.9]);
    assert_eq!(curve.probability, [1.0, 2.0 / 5.0, 0.0]);
    assert_eq!((curve.n, curve.epsilon_1), (5, 0.02));
    // (T1) at 0.5: c = 1, 1 of n = 3, 2; P = .4: (1 - 1.2)^2 + (1 - .8)^2 = .08.
    assert!((curve.standard_error[1] - (0.08_f64 / 25.0).sqrt()).abs() < 1e-15);
    assert_eq!((curve.standard_error[0], curve.standard_error[2]), (0.0, 0.0));
}

#[test]
fn pieces_add_up_to_the_whole() {
    let theta_t = [0.3, 0.55];
    let mut sum = Exceedances::none(2);
    for field in FIELDS {
        sum.merge(&of_fields(&theta_t, [field]));
    }
    assert_eq!(sum, of_fields(&theta_t, FIELDS));
}

#[test]
fn without_groups_there_is_no_probability() {
    let curve = of_fields(&[0.5], [&[] as &[f64]]).curve("cic", 0.0, &[0.5]);
    assert_eq!((curve.n, curve.theta_t.len()), (0, 1));
    assert!(curve.probability.is_empty() && curve.standard_error.is_empty());
    assert_eq!(Moments::of(&[]), None);
}

#[test]
fn with_one_group_per_field_the_standard_error_is_the_binomial_one() {
    let r: Vec<f64> = (0..1000).map(|i| if i % 10 == 0 { 1.0 } else { 0.0 }).collect();
    let counts = of_fields(&[0.5], r.chunks(1));
    let binomial = (0.1_f64 * 0.9 / 1000.0).sqrt();
    assert!((counts.standard_error(0).expect("n > 0") - binomial).abs() < 1e-15);
}

#[test]
fn moments_are_those_of_the_population() {
    let moments = Moments::of(&[1.0, 2.0, 3.0, 6.0]).expect("four values");
    assert_eq!(
        (moments.mean, moments.standard_deviation, moments.n),
        (3.0, 3.5_f64.sqrt(), 4)
    );
}

#[test]
fn thresholds_ascend_and_are_not_absurdly_many() {
    assert_eq!(thresholds(0.0, 1.2, 0.025).check(), Ok(()));
    for (bad, key) in [(thresholds(1.0, 0.5, 0.1), "to"), (thresholds(0.0, 1.0, 1e-9), "step")] {
        let error = bad.check().expect_err("out of bounds");
        assert!(error.starts_with(key), "{error}");
    }
}

#[test]
fn the_temporal_level_stays_below_the_capsize_angle() {
    assert_eq!(truth().check(), Ok(()));
    let level = Truth {
        temporal_level: 4.0,
        ..truth()
    };
    assert!(level.check().expect_err("too high").starts_with("temporal_level:"));
    let levels = Truth {
        temporal_levels: thresholds(0.0, 3.5, 0.5),
        ..truth()
    };
    assert!(levels.check().expect_err("too high").starts_with("temporal_levels.to:"));
}

#[test]
fn the_temporal_level_may_be_left_out() {
    let text = r#"{"window":2.0,"roll":"absolute","capsize_angle":3.14,"capsize":"discard_field"}"#;
    let decoded: Truth = serde_json::from_str(text).expect("the contract's keys");
    assert_eq!(decoded.temporal_level, 0.25);
    assert!(serde_json::from_str::<Truth>(&text.replace("window", "windows")).is_err());
}
