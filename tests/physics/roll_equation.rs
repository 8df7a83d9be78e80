//! Claims about Eq. (6) and the `[ship.NAME]` table.

use super::roll_twin::{acceleration, printed};
use encounter::numerics::elementary::{cos, exp, sin};
use encounter::numerics::rk4;
use encounter::ship::roll_equation::{Damping, RollEquation, Ship};

#[test]
fn every_lane_is_the_equation_with_its_own_epsilon_1() {
    let epsilon_1 = [0.0, 0.02, 0.04, -0.01];
    let (x, v, eta) = ([0.3, -0.8, 1.2, 0.0], [0.2, -0.1, 0.4, -0.3], [5.0, -7.0, 0.0, 2.0]);
    let cubic = printed();
    let quadratic = Ship {
        damping: Damping::Quadratic,
        ..printed()
    };
    let a = RollEquation::<4, true>::new(&cubic, epsilon_1);
    let b = RollEquation::<4, false>::new(&quadratic, epsilon_1);
    let a = a.acceleration(x, v, a.forcing(eta));
    let b = b.acceleration(x, v, b.forcing(eta));
    for i in 0..4 {
        assert_eq!(a[i], acceleration(&cubic, epsilon_1[i], x[i], v[i], eta[i]));
        assert_eq!(b[i], acceleration(&quadratic, epsilon_1[i], x[i], v[i], eta[i]));
    }
    assert_ne!(a, b);
}

#[test]
fn linear_roll_decays_as_its_exact_solution() {
    let ship = Ship {
        alpha_1: 0.05,
        alpha_2: 0.0,
        beta_2: 0.0,
        epsilon_2: 0.0,
        ..printed()
    };
    let equation = RollEquation::<1, true>::new(&ship, [0.0]);
    let h = 15.0 / 64.0;
    let (mut x, mut v) = ([0.4], [0.0]);
    let omega = (ship.beta_1 - 0.025 * 0.025_f64).sqrt();
    for k in 1..=640 {
        (x, v) = rk4::step(
            |x, v, e| equation.acceleration(x, v, equation.forcing(e)),
            h,
            x,
            v,
            [[0.0]; 3],
        );
        let t = f64::from(k) * h;
        let exact = 0.4 * exp(-0.025 * t) * (cos(omega * t) + 0.025 / omega * sin(omega * t));
        assert!((x[0] - exact).abs() < 2e-6, "t = {t}: {} for {exact}", x[0]);
    }
}

#[test]
fn rest_stays_rest_without_direct_excitation() {
    let ship = Ship {
        epsilon_2: 0.0,
        ..printed()
    };
    let equation = RollEquation::<2, true>::new(&ship, [0.0, 0.04]);
    let (mut x, mut v) = ([0.0; 2], [0.0; 2]);
    for k in 0..16_384 {
        let eta = |j: i32| [9.0 * sin(f64::from(2 * k + j)); 2];
        let forcing = [eta(0), eta(1), eta(2)];
        (x, v) = rk4::step(
            |x, v, e| equation.acceleration(x, v, equation.forcing(e)),
            15.0 / 64.0,
            x,
            v,
            forcing,
        );
        assert_eq!((x, v), ([0.0; 2], [0.0; 2]));
    }
}

#[test]
fn a_ship_refuses_what_is_no_ship() {
    let good = r#"{"alpha_1":0.01,"alpha_2":0.4,"damping":"cubic","beta_1":0.13,"beta_2":-0.06,
        "epsilon_1":[0.0,0.002],"epsilon_2":0.0043}"#;
    let ship: Ship = serde_json::from_str(good).expect("a valid ship");
    assert_eq!(ship.check(), Ok(()));
    for (key, bad) in [
        ("\"alpha_1\":0.01", "\"alpha_1\":-1"),
        ("0.13", "0.0"),
        ("cubic", "linear"),
    ] {
        assert!(serde_json::from_str::<Ship>(&good.replace(key, bad)).is_err(), "{bad}");
    }
    let list = |epsilon_1: &[f64]| Ship {
        epsilon_1: epsilon_1.to_vec(),
        ..printed()
    };
    assert_eq!(
        list(&[0.0, 0.02, 0.02]).check(),
        Err("epsilon_1: expected strictly ascending numbers, found 0.02 before 0.02".to_string())
    );
    assert!(list(&[]).check().is_err());
    assert!(list(&[-0.1]).check().is_err());
    assert!(list(&[f64::NAN]).check().is_err());
}
