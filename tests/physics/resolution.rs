//! What a step resolves: refused where RK4 is unstable and nowhere before, by runs in waves of a millimetre.

use crate::physics::roll_twin::{printed, truth};
use crate::physics::seas::{detection, four_seas, gaussian, record};
use encounter::numerics::elementary::{cos, sin};
use encounter::numerics::rk4;
use encounter::sea::resolution::{of_detection, of_modes};
use encounter::sea::wave_field::Record;
use encounter::ship::continuous_roll::{Timing, continuous_record};
use encounter::ship::resolution::{ACCURATE, Grid, STABLE, check, of_oscillator, warnings};
use encounter::ship::roll_equation::{Damping, Ship};
use encounter::ship::simulation::Simulation;
use num_complex::Complex;
use std::f64::consts::{PI, TAU};

const T_P: f64 = 15.0;

/// The paper's grid at so many samples per T_p, in waves of this height.
fn grid(samples_per_period: u32, h_s: f64) -> Grid {
    Grid {
        t_p: T_P,
        h_s,
        highest_group: 0.0,
        samples_per_period,
        most_samples: 16_384,
        field_period: 256.0 * T_P,
        lead_in: 500.0,
    }
}

fn calibrated() -> Ship {
    Ship {
        beta_1: 0.1466,
        beta_2: -0.106,
        epsilon_1: vec![0.0, 0.0024, 0.0048],
        epsilon_2: 0.00239,
        ..printed()
    }
}

/// A ship without parametric excitation, nearly linear in small waves.
fn plain() -> Ship {
    Ship {
        alpha_1: 0.01,
        alpha_2: 0.0,
        beta_2: 0.0,
        epsilon_1: vec![0.0],
        ..printed()
    }
}

/// Capsizes in 64 T_p of regular waves of half a millimetre.
fn capsizes(ship: &Ship, samples_per_period: u32) -> u32 {
    let samples = 64 * samples_per_period;
    let height = |j: u32| 5e-4 * cos(TAU * f64::from(j) / f64::from(samples_per_period));
    let eta: Vec<[f64; 8]> = (0..samples).map(|j| [height(j); 8]).collect();
    let timing = Timing::new(64.0 * T_P, samples, 0.0, 0.0);
    let truth = truth();
    let rolled = continuous_record(&Simulation::new(ship, &truth, timing.h), &timing, &eta, &[Vec::new()]);
    rolled.responses.iter().map(|fields| fields[0].capsizes).sum()
}

#[test]
fn rk4_is_stable_in_the_half_disc_that_its_limit_says() {
    let growth = |z: Complex<f64>| {
        (1.0 + z * (1.0 + z / 2.0 * (1.0 + z / 3.0 * (1.0 + z / 4.0))))
            .norm_sqr()
            .sqrt()
    };
    let polar = |r: f64, angle: f64| Complex::new(r * cos(angle), r * sin(angle));
    for step in 0..=180 {
        let angle = PI / 2.0 + PI / 180.0 * f64::from(step);
        for share in [0.1, 0.5, 0.9, 1.0] {
            let z = polar(share * STABLE, angle);
            assert!(growth(z) <= 1.0 + 1e-9, "{z}: {}", growth(z));
        }
    }
    assert!(growth(polar(STABLE + 0.01, 122.0 / 180.0 * PI)) > 1.0);
    assert!(growth(Complex::new(-2.79, 0.0)) > 1.0);
    assert!(growth(Complex::new(0.0, 2.83)) > 1.0);
}

#[test]
fn rk4_of_a_velocity_that_is_damped_by_itself_grows_from_where_the_factor_says() {
    let grows = |z: f64, is_cubic: bool| {
        // h = alpha_2 = 1, so z is v^2 or v.
        let mut v = if is_cubic { z.sqrt() } else { z };
        let start = v;
        let damped = |_: [f64; 1], v: [f64; 1], (): ()| {
            [if is_cubic {
                -v[0] * v[0] * v[0]
            } else {
                -v[0].abs() * v[0]
            }]
        };
        for _ in 0..20 {
            (_, [v]) = rk4::step(damped, 1.0, [0.0], [v], [(); 3]);
        }
        // A velocity that has overflowed is none.
        v.abs() > start || !v.is_finite()
    };
    for share in [0.1, 0.5, 0.8, 0.9, 1.0] {
        assert!(!grows(share * STABLE / 1.12, true), "cubic at {share} of the limit");
        assert!(
            !grows(share * STABLE / 1.12, false),
            "quadratic at {share} of the limit"
        );
    }
    assert!(grows(2.4, true) && grows(2.5, false));
}

#[test]
fn a_step_is_refused_where_waves_of_a_millimetre_capsize_the_ship_and_not_before() {
    let h = 2.0 * T_P / 32.0;
    let stiff = |h_omega: f64| Ship {
        beta_1: (h_omega / h) * (h_omega / h),
        ..plain()
    };
    let damped = |h_alpha: f64| Ship {
        alpha_1: h_alpha / h,
        ..plain()
    };
    // Where the region of RK4 is narrowest: a swing damped by half.
    let between = |h_omega: f64| Ship {
        alpha_1: 1.06 * h_omega / h,
        ..stiff(h_omega)
    };
    for (ship, is_stable) in [
        (stiff(2.6), true),
        (stiff(2.9), false),
        (damped(2.6), true),
        (damped(2.9), false),
        (between(2.4), true),
        (between(2.75), false),
    ] {
        let found = check(&ship, PI, &grid(32, 0.001));
        assert_eq!(found.is_ok(), is_stable, "{ship:?}: {found:?}");
        assert_eq!(capsizes(&ship, 32) == 0, is_stable, "{ship:?}");
    }
}

#[test]
fn crests_hardening_and_nonlinear_damping_are_looked_at_too() {
    let refused = |ship: &Ship, h_s: f64| check(ship, PI, &grid(128, h_s)).is_err();
    let parametric = Ship {
        epsilon_1: vec![0.0, 10.0],
        ..plain()
    };
    assert!(refused(&parametric, 12.0) && !refused(&parametric, 0.01));
    let hardening = Ship { beta_2: 8.0, ..plain() };
    assert!(refused(&hardening, 12.0));
    assert!(
        check(&hardening, 0.5, &grid(128, 12.0)).is_ok(),
        "it capsizes before it is stiff"
    );
    for damping in [Damping::Cubic, Damping::Quadratic] {
        let damped = |alpha_2: f64| Ship {
            alpha_2,
            damping,
            ..printed()
        };
        assert!(
            !refused(&damped(1.0), 12.0) && refused(&damped(1e7), 12.0),
            "{damping:?}"
        );
    }
}

#[test]
fn the_number_that_would_do_is_the_smallest_that_does() {
    for beta_1 in [200.0, 1000.0, 30_000.0] {
        let ship = Ship { beta_1, ..plain() };
        let why = check(&ship, PI, &grid(128, 12.0)).expect_err("a step far too long");
        let (_, rest) = why.split_once("expected at least ").expect("a number");
        let enough: u32 = rest.split(' ').next().and_then(|n| n.parse().ok()).expect("a number");
        assert!(enough.is_power_of_two());
        assert!(check(&ship, PI, &grid(enough, 12.0)).is_ok(), "{enough}");
        assert!(check(&ship, PI, &grid(enough / 2, 12.0)).is_err(), "{enough}/2");
    }
    let far = Ship { beta_1: 1e9, ..plain() };
    let why = check(&far, PI, &grid(128, 12.0)).expect_err("no step is short enough");
    assert!(
        why.contains("more samples than a field may have (16384 per period)"),
        "{why}"
    );
}

#[test]
fn the_paper_s_grid_resolves_both_ships_and_one_four_times_as_coarse_does_not() {
    for ship in [printed(), calibrated()] {
        assert_eq!(check(&ship, PI, &grid(128, 12.0)), Ok(()));
        assert_eq!(warnings(&ship, PI, &grid(128, 12.0)), Vec::<String>::new());
        let coarse = warnings(&ship, PI, &grid(32, 12.0));
        assert!(
            coarse.len() == 1 && coarse[0].starts_with("record.samples_per_period: expected at least "),
            "{coarse:?}"
        );
    }
    // The waves themselves want a step, whatever the ship.
    let slow = Ship {
        beta_1: 1e-4,
        ..plain()
    };
    let h_omega = TAU * 2.0 / f64::from(grid(32, 12.0).samples_per_period);
    assert!(h_omega > ACCURATE);
    assert!(warnings(&slow, PI, &grid(32, 12.0))[0].contains("`sea.peak_period`"));
}

#[test]
fn a_ship_that_does_not_forget_is_told_of() {
    let lasting = Ship {
        alpha_1: 0.0,
        alpha_2: 0.0,
        ..printed()
    };
    let told = warnings(&lasting, PI, &grid(128, 12.0));
    assert!(
        told[0].starts_with("record.lead_in: ") && told[1].starts_with("record.periods_per_field: "),
        "{told:?}"
    );
    let short = Grid {
        lead_in: 100.0,
        ..grid(128, 12.0)
    };
    let told = warnings(&printed(), PI, &short);
    assert!(
        told.len() == 1 && told[0].contains("record.lead_in: expected at least 359 s, found 100"),
        "{told:?}"
    );
}

#[test]
fn an_oscillator_narrower_than_the_modes_lie_apart_is_told_of() {
    let delta_omega = TAU / T_P / 256.0;
    assert_eq!(of_oscillator(0.01, delta_omega), None);
    let told = of_oscillator(0.5 * delta_omega, delta_omega).expect("half a spacing");
    assert!(
        told.starts_with("record.periods_per_field: expected at least 2 times"),
        "{told}"
    );
}

#[test]
fn the_modes_and_the_detection_of_the_paper_resolve_its_seas() {
    for sea in four_seas() {
        assert_eq!(of_modes(&sea, &record()), Vec::<String>::new(), "{sea:?}");
        assert_eq!(of_detection(sea.bandwidth, T_P / 8.0, &detection()), None, "{sea:?}");
    }
    let starts = |told: &[String], key: &str| told.len() == 1 && told[0].starts_with(key);
    let told = of_modes(&gaussian(0.005), &record());
    assert!(
        starts(&told, "record.periods_per_field: expected at least 512, found 256"),
        "{told:?}"
    );
    let few = Record { modes: 280, ..record() };
    let told = of_modes(&gaussian(0.04), &few);
    assert!(
        starts(&told, "record.modes: expected at least 560, found 280"),
        "{told:?}"
    );
    let told = of_detection(Some(0.2), T_P / 8.0, &detection()).expect("groups of two samples");
    assert!(told.starts_with("detection.shortest: "), "{told}");
    let told = of_detection(Some(0.004), T_P / 8.0, &detection()).expect("groups of ninety samples");
    assert!(told.starts_with("detection.longest: "), "{told}");
}
