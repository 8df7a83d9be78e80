//! Claims about the normal distribution: table values, round trips, symmetry.

use encounter::numerics::normal::{density, distribution, from_uniform, quantile};

#[test]
fn known_values_are_met() {
    // mpmath, 20 digits.
    let quantiles = [
        (0.975, 1.959_963_984_540_054),
        (0.5, 0.0),
        (0.9, 1.281_551_565_544_600_4),
        (0.01, -2.326_347_874_040_841),
        (1e-10, -6.361_340_902_404_056),
        (1e-300, -37.047_096_299_361_2),
    ];
    for (p, x) in quantiles {
        let error = (quantile(p) - x).abs();
        assert!(
            error <= 3e-15 * x.abs().max(0.1),
            "quantile({p}) = {}, off by {error}",
            quantile(p)
        );
    }
    assert!((distribution(1.0) - 0.841_344_746_068_542_9).abs() < 2e-16);
    assert!((distribution(-10.0) / 7.619_853_024_160_527e-24 - 1.0).abs() < 1e-14);
    assert!((density(0.5) - 0.352_065_326_764_299_5).abs() < 1e-16);
}

#[test]
fn the_quantile_undoes_the_distribution() {
    for k in -370..=60 {
        let x = f64::from(k) / 10.0;
        let p = distribution(x);
        // An error of p in the last bit moves x by eps p / density(x).
        let blur = f64::EPSILON * p / density(x);
        let error = (quantile(p) - x).abs();
        assert!(error <= 4.0 * blur + 4e-15 * x.abs(), "x = {x}: off by {error}");
    }
}

#[test]
fn the_quantile_is_odd_about_one_half_and_infinite_at_the_ends() {
    for p in [0.25, 0.125, 1.0 / 1024.0] {
        assert_eq!(quantile(1.0 - p), -quantile(p));
    }
    assert_eq!((quantile(0.0), quantile(1.0)), (f64::NEG_INFINITY, f64::INFINITY));
}

#[test]
fn every_uniform_gives_a_finite_normal_number() {
    for u in [0.0, 1.0 - f64::EPSILON / 2.0, 0.5, 0.499_999] {
        assert!(from_uniform(u).is_finite(), "{u}");
    }
    let n = 10_000;
    let mut squares = 0.0;
    for i in 0..n {
        let x = from_uniform((f64::from(i) + 0.5) / f64::from(n));
        squares += x * x / f64::from(n);
    }
    assert!((squares - 1.0).abs() < 1e-3, "variance {squares}");
}
