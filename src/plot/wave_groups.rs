//! Figure 1: a segment of the sea, the groups found in its envelope, and the joint density of their lengths and heights.
//!
//! | paper | code | unit | meaning |
//! |---|---|---|---|
//! | η(t) | `eta` | m | surface elevation |
//! | ρ(t) | `rho` | m | its envelope |
//! | ρ_i(t) | `Group::rho` | m | a Gaussian group, eq. (2) |
//!
//! Tested in `tests/plots/figures.rs`.

use crate::numerics::elementary::exp;

use super::axes::{Axis, round_step};
use super::clip::Point;
use super::csv::{self, Cell};
use super::density::{Density, upright_bar};
use super::legend::{Entry, Sample, strip};
use super::panel::Panel;
use super::shapes::Stroke;
use super::svg::Sheet;
use super::{Error, same_length, style};
use crate::text::count::counted;

/// A detected Gaussian group.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Group {
    /// Centre t_i, s.
    pub t_c: f64,
    /// Length l_i, s.
    pub l: f64,
    /// Amplitude a_i, m.
    pub a: f64,
}

/// A sampled series.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Series {
    /// Times, s, ascending.
    pub t: Vec<f64>,
    /// Values, m, as many.
    pub value: Vec<f64>,
}

/// What Figure 1 shows.
#[derive(Clone, Debug, PartialEq)]
pub struct WaveGroups {
    /// Name and description of the sea.
    pub sea: String,
    /// Peak period, s.
    pub t_p: f64,
    /// Elevation over the segment; 16 samples per T_p are plenty.
    pub eta: Series,
    /// Envelope over the segment.
    pub rho: Series,
    /// The groups whose centres lie near the segment.
    pub groups: Vec<Group>,
    /// Joint density over (L/T_p, A/H_s).
    pub density: Density,
}

impl Group {
    /// Eq. (2), the envelope of a Gaussian group.
    ///
    /// ```text
    /// ρ_i(t) = a_i exp(−(t − t_i)²/(2 l_i²))
    /// ```
    pub fn rho(&self, t: f64) -> f64 {
        let u = (t - self.t_c) / self.l;
        self.a * exp(-0.5 * u * u)
    }

    /// The group within three lengths of its centre, time in units of `t_p`.
    pub fn curve(&self, t_p: f64) -> Vec<Point> {
        let steps = (-48..=48).map(|i| self.t_c + self.l * f64::from(i) / 16.0);
        steps.map(|t| (t / t_p, self.rho(t))).collect()
    }
}

impl Series {
    /// The points with time in units of `t_p`.
    pub fn points(&self, t_p: f64) -> Vec<Point> {
        self.t
            .iter()
            .zip(&self.value)
            .map(|(t, value)| (t / t_p, *value))
            .collect()
    }

    /// The first and last time in units of `t_p`; 0 and 1 if there is none.
    pub fn span(&self, t_p: f64) -> (f64, f64) {
        match (self.t.first(), self.t.last()) {
            (Some(first), Some(last)) => (first / t_p, last / t_p),
            _ => (0.0, 1.0),
        }
    }

    /// The largest absolute value.
    pub fn largest(&self) -> f64 {
        let mut largest = 0.0;
        for size in self.value.iter().map(|value| value.abs()) {
            largest = if size.is_finite() && size > largest {
                size
            } else {
                largest
            };
        }
        largest
    }

    /// Checks that times and values are as many.
    pub fn check(&self, what: &str) -> Result<(), Error> {
        same_length(what, self.t.len(), self.value.len())
    }
}

/// The line of the elevation.
pub const ETA: Stroke = Stroke {
    colour: style::BLUE,
    width: style::FINE_LINE,
    dash: &[],
};
/// The line of the envelope.
pub const RHO: Stroke = Stroke {
    colour: style::RED,
    width: 1.3,
    dash: &[],
};
/// The line of a Gaussian group.
pub const GROUP: Stroke = Stroke {
    colour: style::BLACK,
    width: 1.3,
    dash: &[],
};

/// The end of a symmetric axis of elevations: the next even number of metres; the next round number of a smaller sea.
pub fn elevation_limit(largest: f64) -> f64 {
    let wanted = largest * 1.05;
    if wanted > 1.0 || wanted <= 0.0 {
        let limit = 2.0 * (wanted / 2.0).ceil();
        return if limit > 2.0 { limit } else { 2.0 };
    }
    let (step, _) = round_step(wanted, 5);
    step * (wanted / step).ceil()
}

/// Draws Figure 1.
pub fn draw(figure: &WaveGroups) -> Result<String, Error> {
    figure.eta.check("elevation")?;
    figure.rho.check("envelope")?;
    let mut sheet = Sheet::new(960.0, 420.0);
    let (left, width) = (58.0, 470.0);
    let (low, high) = figure.eta.span(figure.t_p);
    let time = Axis::linear(low, high, 8, "time *t* / *T*_{p}");
    let limit = elevation_limit(figure.eta.largest());
    let inside = |group: &&Group| (low..=high).contains(&(group.t_c / figure.t_p));
    let highest = figure.groups.iter().filter(inside).map(|group| group.a);
    let ceiling = elevation_limit(highest.fold(figure.rho.largest(), f64::max));

    let y = Axis::linear(-limit, limit, 5, "elevation *η* (m)");
    let a = Panel {
        left,
        top: 34.0,
        width,
        height: 140.0,
        x: time.clone().bare(),
        y,
    };
    a.frame(&mut sheet)?;
    a.title(&mut sheet, "(a)", &figure.sea);
    a.line(&mut sheet, &figure.eta.points(figure.t_p), ETA)?;
    a.line(&mut sheet, &figure.rho.points(figure.t_p), RHO)?;

    let y = Axis::linear(0.0, ceiling, 5, "envelope *ρ* (m)");
    let b = Panel {
        left,
        top: 206.0,
        width,
        height: 140.0,
        x: time,
        y,
    };
    b.frame(&mut sheet)?;
    b.title(&mut sheet, "(b)", "envelope and its Gaussian groups");
    b.line(&mut sheet, &figure.rho.points(figure.t_p), RHO)?;
    for group in &figure.groups {
        b.line(&mut sheet, &group.curve(figure.t_p), GROUP)?;
    }

    let (x, y) = density_axes();
    let c = Panel {
        left: 600.0,
        top: 34.0,
        width: 270.0,
        height: 312.0,
        x,
        y,
    };
    let levels = figure.density.round_levels(8);
    c.frame(&mut sheet)?;
    c.title(&mut sheet, "(c)", "joint density of length and amplitude");
    figure.density.draw(&mut sheet, &c, &levels)?;
    upright_bar(
        &mut sheet,
        (886.0, 34.0),
        312.0,
        &levels,
        "*p*(*L*/*T*_{p}, *A*/*H*_{s})",
    )?;

    strip(&mut sheet, left + width / 2.0, 394.0, width, &legend())?;
    let what = format!(
        "Sea: {}. (a) Surface elevation (blue) with its envelope (red) against time in peak periods. (b) The envelope \
         (red) and the {} fitted to it (black). (c) Joint probability density of group length over peak \
         period and group amplitude over significant wave height, blue low, red high.",
        figure.sea,
        counted(figure.groups.len(), "Gaussian group")
    );
    Ok(sheet.finish("Figure 1: wave groups", &what))
}

/// The axes of every joint density: L/T_p from 0 to 6, A/H_s from 0 to 1.2.
pub fn density_axes() -> (Axis, Axis) {
    (
        Axis::linear(0.0, 6.0, 6, "*L* / *T*_{p}"),
        Axis::linear(0.0, 1.2, 6, "*A* / *H*_{s}"),
    )
}

/// The three lines' names.
fn legend() -> Vec<Entry> {
    let entry = |look: Stroke, name: &str| Entry {
        sample: Sample::Line(Stroke {
            width: style::LINE,
            ..look
        }),
        name: name.to_owned(),
    };
    vec![
        entry(ETA, "elevation *η*"),
        entry(RHO, "envelope *ρ*"),
        entry(GROUP, "Gaussian groups *ρ*_{i}"),
    ]
}

/// The data of Figure 1: series `eta` and `rho` (x = t in s, y in m), `group` (x = t_i in s, y = a_i in m, z = l_i in s)
/// and `density` (x = L/T_p, y = A/H_s, z = density).
pub fn csv(figure: &WaveGroups) -> String {
    let mut rows: Vec<[Cell; 4]> = Vec::new();
    for (name, series) in [("eta", &figure.eta), ("rho", &figure.rho)] {
        for (t, value) in series.t.iter().zip(&series.value) {
            rows.push([name.into(), (*t).into(), (*value).into(), Cell::Unknown]);
        }
    }
    for group in &figure.groups {
        rows.push(["group".into(), group.t_c.into(), group.a.into(), group.l.into()]);
    }
    let density = &figure.density;
    for (i, p) in density.p.iter().enumerate() {
        let (ix, iy) = (i % density.nx.max(1) as usize, i / density.nx.max(1) as usize);
        let (x, y) = (density.x0 + ix as f64 * density.dx, density.y0 + iy as f64 * density.dy);
        rows.push(["density".into(), x.into(), y.into(), (*p).into()]);
    }
    csv::write(["series", "x", "y", "z"], rows)
}
