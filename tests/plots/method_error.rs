//! Claims about Figure 8.

use encounter::plot::exceedance::Curve;
use encounter::plot::method_error::{csv, draw, ratios};
use encounter::plot::style::Method;

use super::samples;

fn curve(method: Method, probability: &[f64], standard_error: &[f64]) -> Curve {
    Curve {
        method,
        theta_t: vec![0.1, 0.2, 0.3],
        probability: probability.to_vec(),
        standard_error: standard_error.to_vec(),
        n: 100,
    }
}

#[test]
fn a_ratio_has_the_errors_of_both_and_none_where_the_truth_is_zero() {
    let truth = curve(Method::Truth, &[0.5, 0.1, 0.0], &[0.05, 0.01, 0.0]);
    let cic = curve(Method::Cic, &[0.25, 0.0, 0.2], &[0.025, 0.0, 0.01]);
    let found = ratios(&cic, &truth).expect("they belong together");
    assert_eq!(found.len(), 2);
    assert_eq!((found[0].theta_t, found[0].ratio, found[1].ratio), (0.1, 0.5, 0.0));
    let error = found[0].standard_error.expect("both are known");
    assert!((error - 0.5 * 0.02_f64.sqrt()).abs() < 1e-15);
    // None of many: its own error is unknown, and so is that of the ratio.
    assert_eq!(found[1].standard_error, None);
    assert!(ratios(&curve(Method::Cic, &[0.1], &[0.1]), &truth).is_err());
}

#[test]
fn the_data_hold_every_method_but_the_truth() {
    let text = csv(&samples::method_error()).expect("the samples are sound");
    assert!(text.starts_with("ship,spectrum,epsilon_1,theta_t,method,relative_error,standard_error\n"));
    assert!(!text.contains(",truth,") && text.contains(",nic_groups,"));
    assert!(!text.contains("NaN") && !text.contains("inf"));
}

#[test]
fn a_sea_without_truth_is_an_empty_panel() {
    let mut figure = samples::method_error();
    for cell in figure.rows.iter_mut().flat_map(|row| &mut row.cells) {
        let truth = cell.curves.iter_mut().find(|curve| curve.method == Method::Truth);
        let truth = truth.expect("the samples have a truth");
        // As where every field was discarded.
        for values in [&mut truth.theta_t, &mut truth.probability, &mut truth.standard_error] {
            values.clear();
        }
    }
    assert!(draw(&figure).is_ok());
    assert_eq!(csv(&figure).expect("nothing to refuse").lines().count(), 1);
}
