//! Synthetic input of every figure: plausible shapes, no ship and no sea behind them.

use encounter::numerics::elementary::{cos, erfc, exp};
use encounter::plot::convergence::{Convergence, Estimates};
use encounter::plot::density::Density;
use encounter::plot::exceedance::{Cell, Curve, Exceedance, Row};
use encounter::plot::jonswap_groups::JonswapGroups;
use encounter::plot::method_error::{self, MethodError};
use encounter::plot::response_moments::{Moments, ResponseMoments, Shape};
use encounter::plot::style::Method;
use encounter::plot::table;
use encounter::plot::temporal::{self, Temporal};
use encounter::plot::wave_groups::{Group, Series, WaveGroups};

/// Peak period, s.
pub(crate) const T_P: f64 = 15.0;

/// Groups every eleven periods or so over `periods` T_p.
pub(crate) fn groups(periods: u32) -> Vec<Group> {
    let mut groups = Vec::new();
    let mut t_c = 4.0 * T_P;
    let mut i = 0.0;
    while t_c < T_P * f64::from(periods) {
        groups.push(Group {
            t_c,
            l: T_P * (1.6 + cos(1.7 * i)),
            a: 5.5 + 3.2 * cos(2.3 * i + 0.5),
        });
        t_c += T_P * (8.0 + 2.5 * cos(3.1 * i));
        i += 1.0;
    }
    groups
}

/// A sea made of groups on a common carrier, `per_period` samples a period, and its envelope.
pub(crate) fn sea(groups: &[Group], periods: u32, per_period: u32) -> (Series, Series) {
    let (mut eta, mut rho) = (Series::default(), Series::default());
    for i in 0..=periods * per_period {
        let t = T_P * f64::from(i) / f64::from(per_period);
        let envelope = groups.iter().fold(0.6, |sum, group| sum + group.rho(t)) * (1.0 + 0.05 * cos(0.11 * t));
        eta.t.push(t);
        eta.value.push(envelope * cos(0.41887902 * t + 0.4 * cos(0.01 * t)));
        rho.t.push(t);
        rho.value.push(envelope);
    }
    (eta, rho)
}

/// A correlated bump with a tail towards long groups; `narrow` squeezes its lengths.
pub(crate) fn density(n: u32, narrow: f64) -> Density {
    let (dx, dy) = (5.0 / f64::from(n - 1), 1.2 / f64::from(n - 1));
    let mut p = Vec::new();
    for iy in 0..n {
        for ix in 0..n {
            let (x, y) = (narrow * dx * f64::from(ix), dy * f64::from(iy));
            let u = (x - 1.7 - 1.4 * (y - 0.45)) / (0.35 + 0.25 * x);
            let v = (y - 0.46) / 0.17;
            p.push(1.3 * narrow * exp(-0.5 * (u * u + v * v)));
        }
    }
    Density {
        x0: 0.0,
        dx,
        nx: n,
        y0: 0.0,
        dy,
        ny: n,
        p,
    }
}

/// Gaussian tail probabilities of `n` groups around `centre`, rounded to whole groups.
fn curve(method: Method, centre: f64, width: f64, n: u64) -> Curve {
    let theta_t: Vec<f64> = (0..=48).map(|i| 0.025 * f64::from(i)).collect();
    let count = n as f64;
    let tail =
        |theta: &f64| (0.5 * erfc((theta - centre) / (width * std::f64::consts::SQRT_2)) * count).floor() / count;
    let probability: Vec<f64> = theta_t.iter().map(tail).collect();
    let standard_error = probability.iter().map(|p| (p * (1.0 - p) / count).sqrt()).collect();
    Curve {
        method,
        theta_t,
        probability,
        standard_error,
        n,
    }
}

/// Figure 3 with the given numbers of seas and excitations.
pub(crate) fn exceedance(seas: usize, excitations: usize) -> Exceedance {
    let rows = (0..seas).map(|i| {
        let cells = (0..excitations).map(|j| {
            let centre = 0.38 + 0.05 * i as f64 + 0.03 * j as f64;
            let width = 0.13 + 0.02 * j as f64;
            let curves = vec![
                curve(Method::Truth, centre, width, 40_000),
                curve(Method::Cic, centre - 0.02, 0.8 * width, 200_000),
                curve(Method::Pic, centre + 0.03, 1.25 * width, 200_000),
                curve(Method::Nic, centre, 1.01 * width, 200_000),
                curve(Method::NicGroups, centre, 1.13 * width, 200_000),
            ];
            Cell {
                epsilon_1: 0.002 * j as f64,
                curves,
                capsize_share: Some(0.0004 * j as f64),
            }
        });
        let description = if i == 3 {
            "JONSWAP, γ = 6".to_owned()
        } else {
            format!("Gaussian, bandwidth 0.0{} rad/s", i + 2)
        };
        Row {
            spectrum: format!("S{}", i + 1),
            description,
            density: density(64, 1.0 + 0.2 * i as f64),
            cells: cells.collect(),
        }
    });
    Exceedance {
        ship: "calibrated".to_owned(),
        rows: rows.collect(),
    }
}

/// Figure 3 of a ship that nearly always capsizes, in a sea with a long name, no curve with errors.
pub(crate) fn hostile() -> Exceedance {
    let mut figure = exceedance(1, 2);
    "printed".clone_into(&mut figure.ship);
    "a_sea_with_quite_a_long_name".clone_into(&mut figure.rows[0].spectrum);
    let description = "Gaussian, bandwidth 0.02 rad/s, significant wave height 12 m, peak period 15 s";
    description.clone_into(&mut figure.rows[0].description);
    for curve in figure.rows[0].cells.iter_mut().flat_map(|cell| &mut cell.curves) {
        for p in &mut curve.probability {
            *p = 0.85 + 0.15 * *p;
        }
        curve.standard_error.clear();
    }
    figure.rows[0].cells[1].capsize_share = Some(0.853);
    figure
}

/// Figure 1.
pub(crate) fn wave_groups() -> WaveGroups {
    let groups = groups(64);
    let (eta, rho) = sea(&groups, 64, 16);
    WaveGroups {
        sea: "S1: Gaussian, bandwidth 0.02 rad/s".to_owned(),
        t_p: T_P,
        eta,
        rho,
        groups,
        density: density(128, 1.0),
    }
}

/// Figure 6.
pub(crate) fn jonswap_groups() -> JonswapGroups {
    let groups = groups(100);
    let (eta, _) = sea(&groups, 100, 16);
    JonswapGroups {
        sea: "S4: JONSWAP, γ = 6".to_owned(),
        t_p: T_P,
        eta,
        groups,
    }
}

/// Figure 4.
pub(crate) fn response_moments() -> ResponseMoments {
    let shapes = [(1.5, 0.35), (2.0, 0.5), (3.0, 0.65)]
        .into_iter()
        .map(|(l_over_tp, a_over_hs)| {
            let base = 0.9 * a_over_hs;
            let moments = [
                (Method::Truth, 0.0, 0.08),
                (Method::Cic, 0.01, 0.0),
                (Method::Pic, 0.12, 0.14),
                (Method::Nic, 0.005, 0.082),
            ];
            let moments = moments.into_iter().map(|(method, shift, std)| Moments {
                method,
                epsilon_1: vec![0.0, 0.002, 0.004],
                mean: vec![base + shift, base + 0.02 + 0.7 * shift, base + 0.05 + 0.4 * shift],
                std: vec![std, 1.2 * std, 1.3 * std],
                n: vec![1234; 3],
            });
            Shape {
                l_over_tp,
                a_over_hs,
                groups: 1234,
                moments: moments.collect(),
            }
        });
    ResponseMoments {
        ship: "calibrated".to_owned(),
        spectrum: "S1".to_owned(),
        shapes: shapes.collect(),
    }
}

/// Figure 5.
pub(crate) fn convergence() -> Convergence {
    let p_true = 0.0187;
    let mut sequential = Estimates::default();
    for n in (30..=120).step_by(3) {
        let n = f64::from(n);
        sequential.n_samples.push(n);
        sequential.mean.push(p_true * (1.0 + 0.35 * exp(-(n - 30.0) / 15.0)));
        sequential
            .std
            .push(Some(p_true * (0.07 + 0.6 * exp(-(n - 30.0) / 20.0))));
    }
    let mut random = Estimates::default();
    for n in (30..=3000).step_by(30) {
        let n = f64::from(n);
        random.n_samples.push(n);
        random.mean.push(p_true * (1.0 + 0.04 * cos(0.02 * n)));
        random.std.push(Some(((1.0 - p_true) * p_true / n).sqrt()));
    }
    Convergence {
        ship: "calibrated".to_owned(),
        spectrum: "S2".to_owned(),
        theta_t: 0.9,
        epsilon_1: 0.002,
        realisations: 100,
        p_true: Some(p_true),
        best: Estimates {
            std: sequential.std.iter().map(|std| std.map(|std| 0.8 * std)).collect(),
            ..sequential.clone()
        },
        control: Estimates {
            std: sequential.std.iter().map(|std| std.map(|std| 0.5 * std)).collect(),
            ..sequential.clone()
        },
        lhs: Estimates {
            std: sequential.std.iter().map(|std| std.map(|std| 2.0 * std)).collect(),
            ..sequential.clone()
        },
        floor: Some(1.4),
        sequential,
        random,
    }
}

/// Table 1, its last row without ours and its third without the paper's.
pub(crate) fn table() -> table::Table {
    let printed = |p_true, sequential_mean, sequential_std_percent, random_mean, random_std_percent| {
        Some(table::Printed {
            p_true,
            sequential_mean,
            sequential_std_percent,
            random_mean,
            random_std_percent,
        })
    };
    let estimate = |mean, std| {
        let std = Some(std);
        Some(table::Estimate { mean, std })
    };
    let row = |spectrum: &str, theta_t, p_true, sequential, random, paper| table::Row {
        spectrum: spectrum.to_owned(),
        theta_t,
        p_true: Some(p_true),
        p_true_se: Some(0.00024),
        p_true_groups: 500_000,
        reached: 120,
        sequential,
        random,
        best: sequential,
        control: sequential,
        lhs: random,
        floor: sequential.map(|_| table::Floor {
            importance: 3.0,
            model: 1.5,
        }),
        control_floor: sequential.map(|_| table::Floor {
            importance: 2.0,
            model: 1.0,
        }),
        paper,
    };
    let mut rows = vec![
        row(
            "S1",
            0.7,
            0.0459,
            estimate(0.0451, 0.0027),
            estimate(0.0462, 0.0201),
            printed(0.0421, 0.0416, 5.0, 0.042, 44.0),
        ),
        row(
            "S2",
            0.9,
            0.0191,
            estimate(0.0187, 0.0016),
            estimate(0.0189, 0.013),
            printed(0.0172, 0.0174, 8.0, 0.0156, 67.0),
        ),
        row(
            "S3",
            1.0,
            0.0254,
            estimate(0.0251, 0.0021),
            estimate(0.026, 0.0149),
            None,
        ),
        row(
            "S4",
            1.05,
            0.0065,
            None,
            None,
            printed(0.0076, 0.0082, 12.0, 0.0105, 101.0),
        ),
    ];
    rows[3].p_true = None;
    rows[3].p_true_se = None;
    table::Table {
        ship: "calibrated".to_owned(),
        epsilon_1: Some(0.002),
        samples: 120,
        realisations: 100,
        rows,
    }
}

/// The error of every method, from the same curves as Figure 3.
pub(crate) fn method_error() -> MethodError {
    let figure = exceedance(4, 3);
    let row = |row: Row| method_error::Row {
        spectrum: row.spectrum,
        description: row.description,
        cells: row.cells,
    };
    MethodError {
        ship: figure.ship,
        rows: figure.rows.into_iter().map(row).collect(),
    }
}

/// Two detections that differ by a factor of two.
pub(crate) fn temporal() -> Temporal {
    let line = |scale: f64| {
        let theta_t: Vec<f64> = (0..=12).map(|k| 0.1 * f64::from(k)).collect();
        let probability: Vec<f64> = theta_t.iter().map(|theta_t| scale * erfc(2.5 * theta_t)).collect();
        temporal::Line {
            standard_error: probability.iter().map(|p| 0.05 * p).collect(),
            theta_t,
            probability,
        }
    };
    let detection = |similarity_threshold: f64, scale: f64| temporal::Detection {
        similarity_threshold,
        by_groups: line(scale),
        within_groups: line(0.9 * scale),
    };
    Temporal {
        ship: "calibrated".to_owned(),
        wholes: vec![temporal::Whole {
            spectrum: "S1".to_owned(),
            epsilon_1: 0.002,
            fields: 31250,
            by_time: line(0.8),
        }],
        spectrum: "S2".to_owned(),
        fields: 960,
        studies: vec![temporal::Study {
            epsilon_1: 0.002,
            by_time: line(0.8),
            detections: vec![detection(0.75, 0.8), detection(0.85, 0.4)],
        }],
        drawn: 0,
        reference: Some(0),
    }
}
