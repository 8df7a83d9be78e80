//! Figure 5: how the estimate converges with the number of samples, by five methods, and what an unbiased one over (L, A) cannot go
//! below.
//!
//! | paper | code | unit | meaning |
//! |---|---|---|---|
//! | P_est | `mean`, `std` | 1 | over the realisations |
//! | P_true | `p_true` | 1 | from the long record |
//!
//! (a) is the paper's figure; the shade is its one-sided standard deviation, from the mean to the mean plus one standard
//! deviation. (b) is ours: the root-mean-square error over P_true, which counts the bias too, of every method, and the floor.
//! Tested in `tests/plots/figures.rs`.

use plotters::style::RGBColor;

use super::axes::Axis;
use super::csv;
use super::legend::{Entry, Sample, strip, strip_height};
use super::panel::Panel;
use super::shapes::Stroke;
use super::svg::{PLAIN, Sheet, Type, shorten};
use super::{Error, same_length, style};
use crate::text::count::counted;
use crate::text::number::short;

/// One method's estimates over the number of samples.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Estimates {
    /// Numbers of samples, ascending.
    pub n_samples: Vec<f64>,
    /// Means over the realisations, as many.
    pub mean: Vec<f64>,
    /// Population standard deviations over the realisations, as many; none where the realisations have no spread.
    pub std: Vec<Option<f64>>,
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
const WIDTH: f64 = 960.0;
/// Left borders of the panels, px.
const LEFTS: [f64; 2] = [66.0, 546.0];
/// Upper edge of the legend, px.
const LEGEND: f64 = 366.0;
/// Opacity of the shades.
const SHADE: f64 = 0.22;
/// The dashes of the truth.
const TRUTH: Stroke = Stroke {
    colour: style::BLACK,
    width: 1.4,
    dash: &[5.0, 3.0],
};
/// The dots of the floor.
const FLOOR: Stroke = Stroke {
    colour: style::BLACK,
    width: 1.3,
    dash: &[1.5, 3.0],
};
/// VHGP-Seq.
const SEQUENTIAL: Stroke = solid(style::BLUE);
/// Random sampling.
const RANDOM: Stroke = solid(style::ORANGE);
/// The design that looks ahead.
const BEST: Stroke = Stroke {
    dash: &[7.0, 2.0, 1.5, 2.0],
    ..solid(style::TEAL)
};
/// The design that looks ahead, with a control.
const CONTROL: Stroke = Stroke {
    dash: &[6.0, 2.5],
    ..solid(style::PURPLE)
};
/// The Latin hypercube.
const HYPERCUBE: Stroke = Stroke {
    dash: &[2.5, 2.0],
    ..solid(style::RED)
};

/// A line without dashes.
const fn solid(colour: RGBColor) -> Stroke {
    Stroke {
        colour,
        width: style::LINE,
        dash: &[],
    }
}

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

    /// The floor's standard deviation over the truth, %.
    fn floor_errors(&self) -> Vec<(f64, f64)> {
        let p_true = self.p_true.unwrap_or(0.0);
        let all = self.floor_deviations().into_iter();
        all.map(|(n, std)| (n, 100.0 * std / p_true)).collect()
    }

    /// The lines of (b): every method's errors with its look, in the order in which they are drawn.
    fn errors(&self) -> Vec<(Vec<(f64, f64)>, Stroke)> {
        let Some(p_true) = self.p_true.filter(|p_true| *p_true > 0.0) else {
            return Vec::new();
        };
        vec![
            (self.floor_errors(), FLOOR),
            (self.lhs.errors(p_true), HYPERCUBE),
            (self.best.errors(p_true), BEST),
            (self.control.errors(p_true), CONTROL),
            (self.random.errors(p_true), RANDOM),
            (self.sequential.errors(p_true), SEQUENTIAL),
        ]
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
        let shade = all.filter_map(|((n, mean), std)| Some((*n, *mean, mean + (*std)?)));
        shade
            .filter(|(n, mean, upper)| n.is_finite() && mean.is_finite() && upper.is_finite())
            .collect()
    }

    /// The points (n, root-mean-square error over the truth in %).
    fn errors(&self, p_true: f64) -> Vec<(f64, f64)> {
        let all = self.n_samples.iter().zip(&self.mean).zip(&self.std);
        let square = |mean: f64, std: f64| (mean - p_true) * (mean - p_true) + std * std;
        all.filter_map(|((n, mean), std)| Some((*n, 100.0 * square(*mean, (*std)?).sqrt() / p_true)))
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
    let look = Type {
        size: style::LABEL_SIZE,
        colour: style::GREY,
        ..PLAIN
    };
    let whose = format!(
        "ship: {}, sea: {}, *θ*_{{t}} = {} rad, *ε*_{{1}} = {} {}, {}",
        figure.ship,
        figure.spectrum,
        short(figure.theta_t),
        short(figure.epsilon_1),
        style::EPSILON_UNIT,
        counted(figure.realisations, "realisation")
    );
    let room = WIDTH - LEFTS[0] - 16.0;
    sheet.text(LEFTS[0], 18.0, look, &shorten(&whose, look.size, room));
    estimates_panel(&mut sheet, figure)?;
    errors_panel(&mut sheet, figure)?;
    strip(&mut sheet, WIDTH / 2.0, LEGEND, WIDTH - 20.0, &legend())?;
    let what = format!(
        "Ship: {}. Sea: {}, threshold {} rad, epsilon_1 {}. (a) Estimated group exceeding probability against the number of \
         samples (logarithmic axis): VHGP-Seq blue, random sampling orange; line: mean over {}; shade: the one-sided \
         standard deviation, from the mean to the mean plus one standard deviation; black dashed: truth. (b) Root-mean-square \
         error over the truth in per cent, both axes logarithmic: the same two, the look-ahead design teal dash-dotted, the same \
         with a control purple dashed, VHGP-Seq's surrogate on a Latin hypercube red, short dashes; black dotted: the least that a normal \
         law over length and amplitude allows.",
        figure.ship,
        figure.spectrum,
        short(figure.theta_t),
        short(figure.epsilon_1),
        counted(figure.realisations, "realisation")
    );
    Ok(sheet.finish("Figure 5: convergence of VHGP-Seq and of random sampling", &what))
}

/// A panel of the figure.
fn panel(place: usize, x: Axis, y: Axis) -> Panel {
    Panel {
        left: LEFTS[place],
        top: 56.0,
        width: 390.0,
        height: 264.0,
        x,
        y,
    }
}

/// (a): means and shades of the paper's two methods, and the truth.
fn estimates_panel(sheet: &mut Sheet, figure: &Convergence) -> Result<(), Error> {
    let panel = panel(
        0,
        samples_axis(&[&figure.sequential, &figure.random]),
        estimate_axis(figure),
    );
    panel.frame(sheet)?;
    panel.title(sheet, "(a)", "estimate of the probability");
    let both = [(&figure.random, RANDOM), (&figure.sequential, SEQUENTIAL)];
    for (estimates, look) in both {
        panel.band(sheet, &estimates.shade(), look.colour, SHADE)?;
    }
    for (estimates, look) in both {
        panel.line(sheet, &estimates.means(), look)?;
    }
    if let Some(p_true) = figure.p_true {
        let ends = [(unlog(&panel, 0.0), p_true), (unlog(&panel, 1.0), p_true)];
        panel.line(sheet, &ends, TRUTH)?;
    }
    Ok(())
}

/// (b): the relative error of every method.
fn errors_panel(sheet: &mut Sheet, figure: &Convergence) -> Result<(), Error> {
    let lines = figure.errors();
    let panel = panel(1, samples_axis(&figure.all()), error_axis(&lines));
    panel.frame(sheet)?;
    let title = if figure.realisations == 1 {
        "error of the estimate: one realisation tells none"
    } else {
        "error of the estimate, bias and spread"
    };
    panel.title(sheet, "(b)", title);
    for (points, look) in lines {
        panel.line(sheet, &points, look)?;
    }
    Ok(())
}

/// Errors from a little below the smallest to a little above the largest, 1 to 1000 % at most.
fn error_axis(lines: &[(Vec<(f64, f64)>, Stroke)]) -> Axis {
    let (mut low, mut high) = (30.0, 30.0);
    for (_, error) in lines.iter().flat_map(|(points, _)| points) {
        low = if *error < low { *error } else { low };
        high = if *error > high { *error } else { high };
    }
    let low = if low > 1.0 { low } else { 1.0 };
    let high = if high < 1000.0 { high } else { 1000.0 };
    Axis::counts(low / 1.2, high * 1.2, "rms error / *P*_{true} (%)")
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
    // Means are no less than zero, so that where they have a spread it reaches above them.
    let drawn = |estimates: &Estimates| {
        let tops = estimates.shade().into_iter().map(|(_, _, upper)| upper);
        tops.chain(estimates.mean.clone()).collect::<Vec<f64>>()
    };
    let tops = [&figure.sequential, &figure.random].into_iter().flat_map(drawn);
    let bound = figure.p_true.map_or(f64::INFINITY, |p_true| 5.0 * p_true);
    let tops = tops.map(|upper| if bound > 0.0 && upper > bound { bound } else { upper });
    Axis::from_zero(tops.chain(figure.p_true), 6, "*P*_{est}(*r* > *θ*_{t})")
}

/// The lines' and shades' names.
fn legend() -> Vec<Entry> {
    let entry = |sample, name: &str| Entry {
        sample,
        name: name.to_owned(),
    };
    vec![
        entry(Sample::Line(SEQUENTIAL), "VHGP-Seq, mean"),
        entry(Sample::Patch(style::BLUE, SHADE), "VHGP-Seq + std. deviation"),
        entry(Sample::Line(RANDOM), "random sampling, mean"),
        entry(Sample::Patch(style::ORANGE, SHADE), "random + std. deviation"),
        entry(Sample::Line(TRUTH), "*P*_{true}"),
        entry(Sample::Line(BEST), "look-ahead"),
        entry(Sample::Line(CONTROL), "look-ahead with control"),
        entry(Sample::Line(HYPERCUBE), "Latin hypercube"),
        entry(Sample::Line(FLOOR), "least by a normal law over (*L*, *A*)"),
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
            let (mean, std) = (estimates.mean.get(i).copied(), estimates.std.get(i).copied().flatten());
            rows.push([method.into(), (*n).into(), mean.into(), std.into()]);
        }
    }
    for (n, std) in figure.floor_deviations() {
        rows.push(["floor".into(), n.into(), figure.p_true.into(), Some(std).into()]);
    }
    csv::write(["method", "n_samples", "mean", "std"], rows)
}
