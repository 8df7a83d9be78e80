//! The kernel density against its direct double sum.

use encounter::numerics::density::{DensityMap, Grid, kernel_density};
use encounter::numerics::elementary::exp;
use std::f64::consts::TAU;

const X: [f64; 5] = [0.3, 1.0, 1.1, 2.0, 7.0];
const Y: [f64; 5] = [0.1, 0.5, 0.45, 0.9, 3.0];

fn map() -> DensityMap {
    kernel_density(&X, &Y, [0.2, 0.05], &Grid::spanning([0.0, 5.0], 41, [0.0, 1.2], 61))
}

#[test]
fn the_density_is_the_direct_double_sum() {
    let map = map();
    for iy in 0..61 {
        for ix in 0..41 {
            let (x, y) = (0.125 * ix as f64, 0.02 * iy as f64);
            let term = |(x_i, y_i): (&f64, &f64)| {
                let (u, v) = ((x - x_i) / 0.2, (y - y_i) / 0.05);
                exp(-0.5 * (u * u + v * v)) / (TAU * 0.2 * 0.05)
            };
            let direct = X.iter().zip(&Y).map(term).sum::<f64>() / 5.0;
            assert!((map.p[iy * 41 + ix] - direct).abs() < 1e-6, "({x}, {y})");
        }
    }
}

#[test]
fn the_density_integrates_to_the_share_of_points_inside() {
    // A fifth of the points lies far outside; the one near y = 0.1 loses 2.3 % below the axis.
    let map = map();
    let integral = map.p.iter().sum::<f64>() * map.dx * map.dy;
    assert!((integral - 0.8).abs() < 0.02, "{integral}");
}

#[test]
fn between_grid_points_the_density_is_bilinear_and_outside_zero() {
    let map = DensityMap {
        x0: 1.0,
        dx: 2.0,
        nx: 2,
        y0: 0.0,
        dy: 1.0,
        ny: 2,
        p: vec![1.0, 3.0, 5.0, 11.0],
    };
    assert_eq!(
        [map.at(1.0, 0.0), map.at(3.0, 0.0), map.at(1.0, 1.0), map.at(3.0, 1.0)],
        [1.0, 3.0, 5.0, 11.0]
    );
    assert_eq!(map.at(2.0, 0.5), 5.0);
    assert_eq!(
        [
            map.at(0.9, 0.0),
            map.at(3.1, 0.0),
            map.at(2.0, -0.1),
            map.at(2.0, f64::NAN)
        ],
        [0.0; 4]
    );
    assert_eq!(map.max(), 11.0);
}

#[test]
fn no_points_have_no_density() {
    let map = kernel_density(&[], &[], [1.0, 1.0], &Grid::spanning([0.0, 1.0], 3, [0.0, 1.0], 2));
    assert_eq!(map.p, vec![0.0; 6]);
}
