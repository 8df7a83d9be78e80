//! Ticks stand at round values with exact labels; curves are cut at the frame and thinned within their tolerance.

use encounter::numerics::elementary::{cos, sin};
use encounter::plot::axes::{Axis, fixed};
use encounter::plot::clip::{Window, thin};
use encounter::text::number::power_of_ten;

fn labels(axis: &Axis) -> Vec<&str> {
    axis.ticks
        .iter()
        .map(|tick| tick.label.as_str())
        .filter(|label| !label.is_empty())
        .collect()
}

const UNIT: Window = Window {
    left: 0.0,
    right: 1.0,
    low: 0.0,
    high: 1.0,
};

#[test]
fn linear_ticks_are_round() {
    assert_eq!(
        labels(&Axis::linear(0.0, 1.2, 6, "")),
        ["0.0", "0.2", "0.4", "0.6", "0.8", "1.0", "1.2"]
    );
    assert_eq!(labels(&Axis::linear(0.0, 5.0, 5, "")), ["0", "1", "2", "3", "4", "5"]);
    assert_eq!(labels(&Axis::linear(-12.0, 12.0, 5, "")), ["−10", "−5", "0", "5", "10"]);
    assert_eq!(
        labels(&Axis::linear(0.0, 0.05, 5, "")),
        ["0.00", "0.01", "0.02", "0.03", "0.04", "0.05"]
    );
    assert_eq!(
        labels(&Axis::linear(0.0, 10.0, 4, "")),
        ["0.0", "2.5", "5.0", "7.5", "10.0"]
    );
    assert_eq!(
        labels(&Axis::linear(0.0, 0.4, 5, "")),
        ["0.0", "0.1", "0.2", "0.3", "0.4"]
    );
    assert_eq!(
        labels(&Axis::linear(0.0, 3000.0, 6, "")),
        ["0", "500", "1000", "1500", "2000", "2500", "3000"]
    );
}

#[test]
fn decimal_ticks_are_powers_of_ten_in_superscripts() {
    assert_eq!(labels(&Axis::decades(-4, 0, "")), ["10⁻⁴", "10⁻³", "10⁻²", "10⁻¹", "1"]);
    assert_eq!(power_of_ten(-10), "10⁻¹⁰");
    assert_eq!(power_of_ten(3), "10³");
    assert_eq!(Axis::decades(-4, 0, "").ticks.len(), 5 + 4 * 8);
}

#[test]
fn counts_are_labelled_in_plain_digits() {
    assert_eq!(
        labels(&Axis::counts(30.0, 3000.0, "")),
        ["30", "100", "300", "1000", "3000"]
    );
}

#[test]
fn a_logarithm_has_no_place_for_zero() {
    let axis = Axis::decades(-4, 0, "");
    assert_eq!(axis.place(0.0), None);
    assert_eq!(axis.place(-1.0), None);
    assert_eq!(axis.place(f64::NAN), None);
    assert_eq!(axis.place(0.01), Some(-2.0));
}

#[test]
fn zero_has_no_sign() {
    assert_eq!(fixed(-0.0, 1), "0.0");
    assert_eq!(fixed(-0.001, 1), "0.0");
    assert_eq!(fixed(-2.5, 1), "−2.5");
}

#[test]
fn a_degenerate_range_still_has_an_axis() {
    for (low, high) in [(1.0, 1.0), (0.0, 0.0), (2.0, 1.0)] {
        assert!(labels(&Axis::linear(low, high, 5, "")).len() > 2);
    }
    assert!(Axis::counts(30.0, 30.0, "").high > Axis::counts(30.0, 30.0, "").low);
    assert!(labels(&Axis::from_zero(std::iter::empty(), 5, "")).len() > 2);
}

#[test]
fn a_line_is_cut_where_it_meets_the_frame() {
    let parts = UNIT.clip_line(&[(-1.0, 0.5), (2.0, 0.5), (2.0, 2.0), (0.5, 2.0), (0.5, -1.0)]);
    assert_eq!(parts, [vec![(0.0, 0.5), (1.0, 0.5)], vec![(0.5, 1.0), (0.5, 0.0)]]);
    assert!(UNIT.clip_line(&[(2.0, 0.0), (2.0, 1.0)]).is_empty());
    let inside = [(0.1, 0.1), (0.9, 0.9), (0.9, 0.1)];
    assert_eq!(UNIT.clip_line(&inside), [inside.to_vec()]);
}

#[test]
fn a_polygon_is_cut_to_the_area_it_shares_with_the_frame() {
    let cut = UNIT.clip_polygon(&[(-1.0, -1.0), (0.5, -1.0), (0.5, 0.5), (-1.0, 0.5)]);
    let mut twice = 0.0;
    for (i, a) in cut.iter().enumerate() {
        let b = cut[(i + 1) % cut.len()];
        twice += a.0 * b.1 - b.0 * a.1;
    }
    assert!((twice / 2.0 - 0.25).abs() < 1e-12);
    assert!(UNIT.clip_polygon(&[(2.0, 2.0), (3.0, 2.0), (3.0, 3.0)]).is_empty());
}

#[test]
fn thinning_keeps_every_point_within_its_tolerance() {
    let points: Vec<(f64, f64)> = (0..2000)
        .map(|i| f64::from(i) * 0.05)
        .map(|x| (x, 20.0 * sin(x) + 3.0 * cos(3.0 * x)))
        .collect();
    let thinned = thin(&points, 0.1);
    assert!(thinned.len() < points.len() / 2);
    assert_eq!((thinned.first(), thinned.last()), (points.first(), points.last()));
    for point in &points {
        let near = thinned.windows(2).any(|pair| {
            let (a, b) = (pair[0], pair[1]);
            point.0 >= a.0 && point.0 <= b.0 && {
                let t = (point.0 - a.0) / (b.0 - a.0);
                let (dx, dy) = (b.0 - a.0, b.1 - a.1);
                (point.1 - a.1 - t * dy).abs() * dx / (dx * dx + dy * dy).sqrt() <= 0.1 + 1e-9
            }
        });
        assert!(near, "{point:?} is lost");
    }
}

#[test]
fn ticks_at_values_are_the_values_in_order_and_written_short() {
    let axis = Axis::at_values([0.0048, 0.0, 0.0024, 0.0024, f64::NAN].into_iter(), "x");
    let labels: Vec<&str> = axis.ticks.iter().map(|tick| tick.label.as_str()).collect();
    assert_eq!(labels, ["0", "0.0024", "0.0048"]);
    assert!(axis.low < 0.0 && axis.high > 0.0048, "no mark stands on the frame");
    let empty = Axis::at_values(std::iter::empty(), "x");
    assert!(empty.low < empty.high && empty.ticks.is_empty());
}

#[test]
fn an_axis_starts_at_zero_unless_all_values_lie_far_from_it() {
    let far = Axis::around([0.41, 0.59].into_iter(), 5, "y");
    assert!(far.low > 0.0 && far.low < 0.41 && far.high > 0.59, "{far:?}");
    let near = Axis::around([0.1, 0.59].into_iter(), 5, "y");
    assert_eq!(near, Axis::from_zero([0.1, 0.59].into_iter(), 5, "y"));
    assert_eq!(Axis::around(std::iter::empty(), 5, "y").low, 0.0);
}

#[test]
fn labels_are_short_in_any_range() {
    for (low, high) in [
        (0.7, 0.7 + 1e-12),
        (0.0, 1e-12),
        (0.0, 5e-7),
        (0.0, 123_456_789.0),
        (1e5, 1e5 + 1e-6),
        (-2e-9, 3e-9),
        (1e-200, 3e-200),
        (1e200, 3e200),
        (12_345.0, 12_345.001),
    ] {
        let axis = Axis::linear(low, high, 6, "h (m)");
        let labels = labels(&axis);
        assert!(
            labels.len() > 2 && labels.iter().all(|label| label.chars().count() < 8),
            "{low} to {high}: {labels:?}"
        );
        let mut different = labels.clone();
        different.dedup();
        assert_eq!(different, labels, "{low} to {high}");
        assert!(
            axis.label.starts_with("h (m), "),
            "{low} to {high} needs words: {}",
            axis.label
        );
    }
    assert_eq!(Axis::linear(0.0, 5e-7, 5, "h").label, "h, in 10⁻⁷");
    assert_eq!(Axis::linear(0.7, 0.7 + 5e-12, 5, "h").label, "h, from 0.7 in 10⁻¹²");
    assert_eq!(Axis::linear(0.0, 1.2, 6, "h").label, "h");
}

#[test]
fn a_logarithmic_axis_within_a_decade_has_labels_too() {
    for (low, high) in [(12.0, 18.0), (21.0, 29.0), (1.0, 1.5)] {
        let axis = Axis::counts(low, high, "n");
        assert!(labels(&axis).len() > 1, "{low} to {high}: {axis:?}");
        assert!(axis.ticks.iter().all(|tick| axis.holds(tick.at)), "{axis:?}");
    }
}

#[test]
fn a_single_threshold_stands_inside_the_frame() {
    let single = Axis::thresholds([0.4, 0.4].into_iter());
    assert!(single.fraction(0.4) < 0.9, "{single:?}");
    assert_eq!(Axis::thresholds([0.0, 0.6, 1.2].into_iter()).high, 1.2);
    assert_eq!(Axis::thresholds(std::iter::empty()).high, 1.0);
}

#[test]
fn a_tick_at_a_value_has_few_digits() {
    let axis = Axis::at_values([0.1 + 0.2, 1e-5, 123_456.0].into_iter(), "x");
    assert_eq!(labels(&axis), ["10⁻⁵", "0.3", "123456"]);
}
