//! Contours enclose what they should: circles, rings and everything cut by the border of the grid.

use encounter::plot::contour::loops;

/// The grid of a function over n x n nodes.
fn grid(n: usize, f: impl Fn(f64, f64) -> f64) -> Vec<f64> {
    (0..n * n).map(|i| f((i % n) as f64, (i / n) as f64)).collect()
}

fn radius(x: f64, y: f64) -> f64 {
    ((x - 50.0) * (x - 50.0) + (y - 50.0) * (y - 50.0)).sqrt()
}

#[test]
fn the_contour_of_a_cone_is_a_circle() {
    let found = loops(&grid(101, |x, y| 60.0 - radius(x, y)), 101, 101, 30.0);
    assert_eq!(found.len(), 1);
    let circle = std::f64::consts::PI * 900.0;
    assert!((found[0].area - circle).abs() < 2e-3 * circle, "{}", found[0].area);
    for &(x, y) in &found[0].points {
        assert!((radius(x, y) - 30.0).abs() < 0.02);
    }
}

#[test]
fn a_ring_has_a_hollow_of_negative_area() {
    let found = loops(&grid(101, |x, y| 20.0 - (radius(x, y) - 30.0).abs()), 101, 101, 10.0);
    let areas: Vec<f64> = found.iter().map(|l| (l.area / std::f64::consts::PI).round()).collect();
    assert_eq!(areas.len(), 2);
    assert!(
        (areas[0] - 1600.0).abs() < 5.0 && (areas[1] + 400.0).abs() < 5.0,
        "{areas:?}"
    );
}

#[test]
fn a_contour_that_leaves_the_grid_is_closed_along_its_border() {
    let found = loops(&grid(11, |_, _| 1.0), 11, 11, 0.5);
    assert_eq!(found.len(), 1);
    assert!((found[0].area - 100.0).abs() < 1e-9, "the whole grid is enclosed");
    let found = loops(&grid(101, |x, y| 60.0 - (x * x + y * y).sqrt()), 101, 101, 30.0);
    let quarter = std::f64::consts::PI * 900.0 / 4.0;
    assert!((found[0].area - quarter).abs() < 2e-3 * quarter);
}

#[test]
fn a_saddle_is_joined_or_parted_by_its_centre() {
    let high = [3.0, 0.9, 0.9, 3.0];
    assert_eq!(loops(&high, 2, 2, 1.0).len(), 1, "the mean 1.95 joins the hills");
    let low = [1.2, 0.0, 0.0, 1.2];
    assert_eq!(loops(&low, 2, 2, 1.0).len(), 2, "the mean 0.6 parts them");
}

#[test]
fn an_empty_or_misshapen_grid_has_no_contour() {
    assert!(loops(&[], 0, 0, 1.0).is_empty());
    assert!(loops(&[1.0, 2.0], 2, 2, 1.0).is_empty());
    assert!(loops(&[1.0; 4], 2, 2, 2.0).is_empty());
}
