//! Figure 6: a segment of the JONSWAP sea and the Gaussian groups detected in it.
//!
//! Symbols as in `wave_groups`. Tested in `tests/plots/figures.rs`.

use super::axes::Axis;
use super::csv::{self, Cell};
use super::legend::{Entry, Sample, strip};
use super::panel::Panel;
use super::shapes::Stroke;
use super::svg::Sheet;
use super::wave_groups::{ETA, GROUP, Group, Series, elevation_limit};
use super::{Error, style};
use crate::text::count::counted;

/// What Figure 6 shows.
#[derive(Clone, Debug, PartialEq)]
pub struct JonswapGroups {
    /// Name and description of the sea.
    pub sea: String,
    /// Peak period, s.
    pub t_p: f64,
    /// Elevation over the segment; 16 samples per T_p are plenty.
    pub eta: Series,
    /// The groups whose centres lie near the segment.
    pub groups: Vec<Group>,
}

/// Draws Figure 6.
pub fn draw(figure: &JonswapGroups) -> Result<String, Error> {
    figure.eta.check("elevation")?;
    let mut sheet = Sheet::new(960.0, 300.0);
    let (low, high) = figure.eta.span(figure.t_p);
    let limit = elevation_limit(figure.eta.largest());
    let x = Axis::linear(low, high, 12, "time *t* / *T*_{p}");
    let y = Axis::linear(-limit, limit, 5, "elevation *η* (m)");
    let panel = Panel {
        left: 58.0,
        top: 30.0,
        width: 880.0,
        height: 200.0,
        x,
        y,
    };
    panel.frame(&mut sheet)?;
    panel.title(&mut sheet, "", &figure.sea);
    panel.line(&mut sheet, &figure.eta.points(figure.t_p), ETA)?;
    for group in &figure.groups {
        panel.line(&mut sheet, &group.curve(figure.t_p), GROUP)?;
    }
    strip(
        &mut sheet,
        panel.left + panel.width / 2.0,
        274.0,
        panel.width,
        &legend(),
    )?;
    let what = format!(
        "Sea: {}. Surface elevation (blue) against time in peak periods, and the {} detected in its \
         envelope (black).",
        figure.sea,
        counted(figure.groups.len(), "Gaussian group")
    );
    Ok(sheet.finish("Figure 6: groups in the JONSWAP sea", &what))
}

/// The two lines' names.
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
        entry(GROUP, "detected Gaussian groups *ρ*_{i}"),
    ]
}

/// The data of Figure 6: series `eta` (x = t in s, y in m) and `group` (x = t_i in s, y = a_i in m, z = l_i in s).
pub fn csv(figure: &JonswapGroups) -> String {
    let eta = figure.eta.t.iter().zip(&figure.eta.value);
    let eta = eta.map(|(t, value)| ["eta".into(), (*t).into(), (*value).into(), Cell::Unknown]);
    let groups = figure
        .groups
        .iter()
        .map(|g| ["group".into(), g.t_c.into(), g.a.into(), g.l.into()]);
    csv::write(["series", "x", "y", "z"], eta.chain(groups))
}
