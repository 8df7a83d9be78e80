//! Figure 5: how the estimate converges with the number of samples, by five methods, and what none that sees (L, A) alone can go below.
//!
//! | paper | code | unit | meaning |
//! |---|---|---|---|
//! | P_est | `mean`, `std` | 1 | over the realisations |
//! | P_true | `p_true` | 1 | from the long record |
//!
//! The shade is the paper's one-sided standard deviation: from the mean to the mean plus one standard deviation; for the
//! three methods that the paper does not have a dashed line in its place, for the floor a dotted one. Tested in `tests/plots/figures.rs`.

use super::axes::Axis;
use super::csv;
use super::legend::{Entry, Sample, strip, strip_height};
use super::panel::Panel;
use super::shapes::Stroke;
use super::svg::Sheet;
use super::{Error, same_length, style};

/// One method's estimates over the number of samples.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Estimates {
    /// Numbers of samples, ascending.
    pub n_samples: Vec<f64>,
    /// Means over the realisations, as many.
    pub mean: Vec<f64>,
    /// Population standard deviations over the realisations, as many.
    pub std: Vec<f64>,
}

/// What Figure 5 shows.
#[derive(Clone, Debug, PartialEq)]
pub struct Convergence {
    /// Name of the ship.
    pub ship: String,
    /// Name of the sea.
    pub spectrum: String,
    /// Threshold, rad.
    pub theta_t: f64,
    /// Parametric excitation, 1/(m s²).
    pub epsilon_1: f64,
    /// Number of realisations behind mean and standard deviation.
    pub realisations: u64,
    /// The truth.
    pub p_true: Option<f64>,
    /// VHGP-Seq.
    pub sequential: Estimates,
    /// Random sampling.
    pub random: Estimates,
    /// The design that looks ahead.
    pub best: Estimates,
    /// The design that looks ahead, the linear response its control.
    pub control: Estimates,
    /// The surrogate on a Latin hypercube.
    pub lhs: Estimates,
    /// The least standard deviation from one sample, relative to the truth: divide by √n.
    pub floor: Option<f64>,
}

/// Width of the sheet, px.
const WIDTH: f64 = 700.0;
/// Upper edge of the legend, px.
const LEGEND: f64 = 404.0;
/// Opacity of the shades.
const SHADE: f64 = 0.22;
/// The dashes of the truth.
const TRUTH: Stroke = Stroke {
    colour: style::BLACK,
    width: 1.4,
    dash: &[5.0, 3.0],
};

/// The dashes of a mean plus standard deviation that has no shade.
const UPPER: Stroke = Stroke {
    colour: style::GREEN,
    width: 1.0,
    dash: &[6.0, 3.0],
};
/// The dots of the floor.
const FLOOR: Stroke = Stroke {
    colour: style::BLACK,
    width: 1.2,
    dash: &[1.5, 3.0],
};

impl Convergence {
    /// Every method's estimates.
    fn all(&self) -> [&Estimates; 5] {
        [&self.sequential, &self.random, &self.best, &self.control, &self.lhs]
    }

    /// (n, standard deviation) of the floor at the sequential design's numbers of samples.
    fn floor_deviations(&self) -> Vec<(f64, f64)> {
        let Some((p_true, floor)) = self.p_true.zip(self.floor) else {
            return Vec::new();
        };
        let sizes = self.sequential.n_samples.iter().filter(|n| **n > 0.0);
        sizes.map(|n| (*n, p_true * floor / n.sqrt())).collect()
    }

    /// The truth plus the floor.
    fn floor_line(&self) -> Vec<(f64, f64)> {
        let above = self.floor_deviations().into_iter();
        above.map(|(n, std)| (n, self.p_true.unwrap_or(0.0) + std)).collect()
    }
}

impl Estimates {
    /// The points (n, mean).
    fn means(&self) -> Vec<(f64, f64)> {
        self.n_samples.iter().copied().zip(self.mean.iter().copied()).collect()
    }

    /// The shade (n, mean, mean + std), where both are known.
    fn shade(&self) -> Vec<(f64, f64, f64)> {
        let all = self.n_samples.iter().zip(&self.mean).zip(&self.std);
        let shade = all.map(|((n, mean), std)| (*n, *mean, mean + std));
        shade
            .filter(|(n, mean, upper)| n.is_finite() && mean.is_finite() && upper.is_finite())
            .collect()
    }

    /// Checks that the three are as many.
    fn check(&self) -> Result<(), Error> {
        same_length("mean of the estimates", self.n_samples.len(), self.mean.len())?;
        same_length(
            "standard deviation of the estimates",
            self.n_samples.len(),
            self.std.len(),
        )
    }
}

/// Draws Figure 5.
pub fn draw(figure: &Convergence) -> Result<String, Error> {
    for estimates in figure.all() {
        estimates.check()?;
    }
    let mut sheet = Sheet::new(WIDTH, LEGEND + strip_height(&legend(), WIDTH - 20.0) + 8.0);
    let both = [(&figure.random, style::ORANGE), (&figure.sequential, style::BLUE)];
    let others = [
        (&figure.lhs, style::GREY),
        (&figure.best, style::GREEN),
        (&figure.control, style::RED),
    ];
    let panel = Panel {
        left: 70.0,
        top: 34.0,
        width: 590.0,
        height: 330.0,
        x: samples_axis(&figure.all()),
        y: estimate_axis(figure),
    };
    panel.frame(&mut sheet)?;
    let title = format!(
        "{}, ship {}: *θ*_{{t}} = {} rad, *ε*_{{1}} = {}, {} realisations",
        figure.spectrum, figure.ship, figure.theta_t, figure.epsilon_1, figure.realisations
    );
    panel.title(&mut sheet, "", &title);
    for (estimates, colour) in both {
        panel.band(&mut sheet, &estimates.shade(), colour, SHADE)?;
    }
    if let Some(p_true) = figure.p_true {
        let ends = [(unlog(&panel, 0.0), p_true), (unlog(&panel, 1.0), p_true)];
        panel.line(&mut sheet, &ends, TRUTH)?;
    }
    for (estimates, colour) in others {
        let tops: Vec<(f64, f64)> = estimates.shade().iter().map(|(n, _, upper)| (*n, *upper)).collect();
        panel.line(&mut sheet, &tops, Stroke { colour, ..UPPER })?;
    }
    panel.line(&mut sheet, &figure.floor_line(), FLOOR)?;
    for (estimates, colour) in others.into_iter().chain(both) {
        panel.line(
            &mut sheet,
            &estimates.means(),
            Stroke {
                colour,
                width: style::LINE,
                dash: &[],
            },
        )?;
        if estimates.mean.len() == 1 {
            panel.dots(&mut sheet, &estimates.means(), style::DOT, colour)?;
        }
    }
    strip(&mut sheet, WIDTH / 2.0, LEGEND, WIDTH - 20.0, &legend())?;
    let what = format!(
        "Ship: {}. Sea: {}, threshold {} rad, epsilon_1 {}. Estimated group exceeding probability against the number of \
         samples (logarithmic axis): VHGP-Seq blue, random sampling orange, look-ahead design green, the same with a control red, \
         Latin hypercube with the same surrogate grey; line: mean over {} realisations; shade or dashed line: the one-sided standard \
         deviation, from the mean to the mean plus one standard deviation. Black dashed: truth; black dotted: the least \
         standard deviation of what sees length and amplitude alone, above it.",
        figure.ship, figure.spectrum, figure.theta_t, figure.epsilon_1, figure.realisations
    );
    Ok(sheet.finish("Figure 5: convergence of VHGP-Seq and of random sampling", &what))
}

/// The number of samples at a fraction of the axis.
fn unlog(panel: &Panel, fraction: f64) -> f64 {
    let at = panel.x.low + fraction * (panel.x.high - panel.x.low);
    crate::numerics::elementary::pow(10.0, at)
}

/// Numbers of samples from the smallest to the largest.
fn samples_axis(all: &[&Estimates]) -> Axis {
    let (mut low, mut high) = (f64::INFINITY, 0.0);
    for &n in all.iter().flat_map(|estimates| &estimates.n_samples) {
        if n.is_finite() && n > 0.0 {
            low = if n < low { n } else { low };
            high = if n > high { n } else { high };
        }
    }
    let label = "number of samples";
    if high <= 0.0 {
        Axis::counts(10.0, 1000.0, label)
    } else {
        Axis::counts(low, if high > low { high } else { 10.0 * low }, label)
    }
}

/// Estimates from zero over the largest mean plus standard deviation, but not over five times the truth.
fn estimate_axis(figure: &Convergence) -> Axis {
    let shades = figure.all().into_iter().flat_map(Estimates::shade);
    let bound = figure.p_true.map_or(f64::INFINITY, |p_true| 5.0 * p_true);
    let tops = shades.map(|(_, _, upper)| if bound > 0.0 && upper > bound { bound } else { upper });
    Axis::from_zero(tops.chain(figure.p_true), 6, "*P*_{est}(*r* > *θ*_{t})")
}

/// The lines' and shades' names.
fn legend() -> Vec<Entry> {
    let line = |colour, name: &str| Entry {
        sample: Sample::Line(Stroke {
            colour,
            width: style::LINE,
            dash: &[],
        }),
        name: name.to_owned(),
    };
    let shade = |colour, name: &str| Entry {
        sample: Sample::Patch(colour, SHADE),
        name: name.to_owned(),
    };
    vec![
        line(style::BLUE, "VHGP-Seq, mean"),
        shade(style::BLUE, "VHGP-Seq, mean + std. deviation"),
        line(style::ORANGE, "random sampling, mean"),
        shade(style::ORANGE, "random, mean + std. deviation"),
        line(style::GREEN, "look-ahead (dashed: + std. deviation)"),
        line(style::RED, "look-ahead with control (dashed alike)"),
        line(style::GREY, "Latin hypercube (dashed: + std. dev.)"),
        Entry {
            sample: Sample::Line(FLOOR),
            name: "*P*_{true} + least std. dev. from (L, A)".to_owned(),
        },
        Entry {
            sample: Sample::Line(TRUTH),
            name: "*P*_{true}".to_owned(),
        },
    ]
}

/// The data of Figure 5, columns as in the contract of published files.
pub fn csv(figure: &Convergence) -> String {
    let mut rows = Vec::new();
    let methods = [
        ("sequential", &figure.sequential),
        ("random", &figure.random),
        ("best", &figure.best),
        ("lhs", &figure.lhs),
        ("control", &figure.control),
    ];
    for (method, estimates) in methods {
        for (i, n) in estimates.n_samples.iter().enumerate() {
            let (mean, std) = (estimates.mean.get(i).copied(), estimates.std.get(i).copied());
            rows.push([method.into(), (*n).into(), mean.into(), std.into()]);
        }
    }
    for (n, std) in figure.floor_deviations() {
        rows.push(["floor".into(), n.into(), figure.p_true.into(), Some(std).into()]);
    }
    csv::write(["method", "n_samples", "mean", "std"], rows)
}
