//! Figure 3: exceeding probabilities of the four methods and the truth, one row per sea, one column per ε₁.
//!
//! | paper | code | unit | meaning |
//! |---|---|---|---|
//! | P_true, P_est | `probability` | 1 | share of groups whose response exceeds θ_t, eqs. (1), (3), (4) |
//! | θ_t | `theta_t` | rad | threshold |
//! | ε₁ | `epsilon_1` | 1/(m s²) | parametric excitation |
//!
//! Tested in `tests/plots/figures.rs`.

use super::axes::{Axis, fixed};
use super::csv;
use super::density::{Density, lying_bar};
use super::legend::{Entry, method, strip, strip_height};
use super::panel::Panel;
use super::shapes::Stroke;
use super::style::{self, Method};
use super::svg::{Anchor, PLAIN, Sheet, Type, shorten, text_width};
use super::wave_groups::density_axes;
use super::{Error, same_length};
use crate::text::number::short;

/// One method's probabilities.
#[derive(Clone, Debug, PartialEq)]
pub struct Curve {
    /// Whose they are.
    pub method: Method,
    /// Thresholds, rad.
    pub theta_t: Vec<f64>,
    /// Probabilities, as many.
    pub probability: Vec<f64>,
    /// Their standard errors, as many, or none at all; 0 where nothing tells it: where none or all of the groups exceed, and where
    /// all groups lie in one field.
    pub standard_error: Vec<f64>,
    /// Number of groups behind them.
    pub n: u64,
}

impl Curve {
    /// The standard error in place `i`, if there is one that tells anything.
    pub fn known_error(&self, i: usize) -> Option<f64> {
        self.standard_error.get(i).copied().filter(|error| *error > 0.0)
    }

    /// The standard error in place `i` as the data of the figure have it. Where none or all of the groups exceed, the estimate
    /// (T1) is 0, which is written: the number of groups beside it says how far it can be trusted. Where it is 0 for another
    /// reason, as for groups of a single field, it is unknown.
    fn written_error(&self, i: usize) -> Option<f64> {
        let p = self.probability.get(i).copied()?;
        if p > 0.0 && p < 1.0 {
            self.known_error(i)
        } else {
            self.standard_error.get(i).copied()
        }
    }
}

/// One panel: all methods at one ε₁.
#[derive(Clone, Debug, PartialEq)]
pub struct Cell {
    /// Parametric excitation, 1/(m s²).
    pub epsilon_1: f64,
    /// The methods' curves.
    pub curves: Vec<Curve>,
    /// Share of the truth's groups in which the ship capsizes, if known.
    pub capsize_share: Option<f64>,
}

/// One row: a sea.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// Name of the sea.
    pub spectrum: String,
    /// What it is, such as "Gaussian, bandwidth 0.02 rad/s".
    pub description: String,
    /// Joint density of its groups over (L/T_p, A/H_s).
    pub density: Density,
    /// One panel per ε₁, the same in every row.
    pub cells: Vec<Cell>,
}

/// What Figure 3 shows.
#[derive(Clone, Debug, PartialEq)]
pub struct Exceedance {
    /// Name of the ship.
    pub ship: String,
    /// The seas.
    pub rows: Vec<Row>,
}

/// Width of a panel of probabilities, px.
const WIDTH: f64 = 200.0;
/// Height of a row's panels, px.
const HEIGHT: f64 = 168.0;
/// Distance of rows, px.
const ROW: f64 = 224.0;
/// Left border of the densities, px.
const DENSITY_LEFT: f64 = 56.0;
/// Width of the densities, px.
const DENSITY_WIDTH: f64 = 186.0;
/// Left border of the first panel of probabilities, px.
const LEFT: f64 = 312.0;
/// Distance of columns, px.
const COLUMN: f64 = 228.0;
/// Room below the legend, and for the colour bar where the legend is one line high, px.
const FOOT: f64 = 28.0;
/// Upper border of the first row's panels, px.
const TOP: f64 = 78.0;

/// Draws Figure 3.
pub fn draw(figure: &Exceedance) -> Result<String, Error> {
    let columns = figure.rows.iter().map(|row| row.cells.len()).max().unwrap_or(0).max(1);
    let width = LEFT + COLUMN * columns as f64;
    let legend = legend(figure);
    let beside = width - DENSITY_LEFT - DENSITY_WIDTH - 30.0;
    let foot = TOP + ROW * figure.rows.len().max(1) as f64;
    let mut sheet = Sheet::new(width, foot + 12.0 + strip_height(&legend, beside) + FOOT);
    heads(&mut sheet, figure);
    let axes = (threshold_axis(figure), probability_axis(figure));
    for (i, row) in figure.rows.iter().enumerate() {
        draw_row(&mut sheet, row, i, i + 1 == figure.rows.len(), &axes)?;
    }
    lying_bar(
        &mut sheet,
        (DENSITY_LEFT + 18.0, foot + 14.0),
        DENSITY_WIDTH - 36.0,
        "density / its maximum",
    )?;
    strip(&mut sheet, width - beside / 2.0 - 8.0, foot + 9.0, beside, &legend)?;
    Ok(sheet.finish("Figure 3: group exceeding probabilities", &description(figure)))
}

/// The text for those who cannot see the figure.
fn description(figure: &Exceedance) -> String {
    let seas: Vec<String> = figure
        .rows
        .iter()
        .map(|row| format!("{} ({})", row.spectrum, row.description))
        .collect();
    format!(
        "Ship: {}. One row per sea: {}. First column: joint density of group length and amplitude, over its maximum. Other \
         columns: probability that the largest roll in a group exceeds the threshold, on a decimal logarithmic axis, one \
         column per epsilon_1. Black dots with bars of one standard error, at some of the thresholds: truth. Green dash-dotted: CIC. Orange: PIC. Blue: \
         NIC in the record's waves. Blue dashed: NIC in reconstructed groups. Zero probabilities are not drawn. The seas \
         share their random phases.",
        figure.ship,
        seas.join("; ")
    )
}

/// The methods that occur, in the order of legends.
fn legend(figure: &Exceedance) -> Vec<Entry> {
    let occurs = |wanted: Method| {
        let cells = figure.rows.iter().flat_map(|row| &row.cells);
        cells.flat_map(|cell| &cell.curves).any(|curve| curve.method == wanted)
    };
    let mut entries: Vec<Entry> = Method::ALL
        .into_iter()
        .filter(|wanted| occurs(*wanted))
        .map(method)
        .collect();
    for entry in entries.iter_mut().filter(|entry| entry.name.contains("true")) {
        entry.name.push_str(" ± standard error");
    }
    entries
}

/// The ship's name and the columns' heads.
fn heads(sheet: &mut Sheet, figure: &Exceedance) {
    let look = Type {
        size: style::TITLE_SIZE,
        bold: true,
        anchor: Anchor::Middle,
        ..PLAIN
    };
    let ship = Type {
        size: style::LABEL_SIZE,
        colour: style::GREY,
        ..PLAIN
    };
    let room = sheet.width() - DENSITY_LEFT - 16.0;
    sheet.text(
        DENSITY_LEFT,
        18.0,
        ship,
        &shorten(&format!("ship: {}", figure.ship), ship.size, room),
    );
    let y = 42.0;
    sheet.text(DENSITY_LEFT + DENSITY_WIDTH / 2.0, y, look, "joint density");
    let Some(row) = figure.rows.first() else { return };
    for (j, cell) in row.cells.iter().enumerate() {
        let head = format!("*ε*_{{1}} = {} {}", short(cell.epsilon_1), style::EPSILON_UNIT);
        sheet.text(LEFT + COLUMN * j as f64 + WIDTH / 2.0, y, look, &head);
    }
}

/// Thresholds from zero to the largest of all.
fn threshold_axis(figure: &Exceedance) -> Axis {
    Axis::thresholds(all_curves(figure).flat_map(|curve| &curve.theta_t).copied())
}

/// Probabilities from the decade below the smallest positive one, five decades at most, to 1.
fn probability_axis(figure: &Exceedance) -> Axis {
    let mut smallest = 0.1;
    for p in all_curves(figure).flat_map(|curve| &curve.probability) {
        smallest = if *p > 0.0 && *p < smallest { *p } else { smallest };
    }
    let mut decade = -1;
    let mut bound = 0.1;
    while bound > smallest * (1.0 + 1e-9) && decade > -5 {
        decade -= 1;
        bound /= 10.0;
    }
    Axis::decades(decade, 0, "*P*(*r* > *θ*_{t})")
}

/// Every curve of the figure.
fn all_curves(figure: &Exceedance) -> impl Iterator<Item = &Curve> {
    figure
        .rows
        .iter()
        .flat_map(|row| &row.cells)
        .flat_map(|cell| &cell.curves)
}

/// Draws one sea; the last one carries the names of the horizontal axes.
fn draw_row(sheet: &mut Sheet, row: &Row, i: usize, last: bool, axes: &(Axis, Axis)) -> Result<(), Error> {
    let top = TOP + ROW * i as f64;
    let letter = char::from(b'a' + (i % 26) as u8);
    row_title(sheet, row, letter, top);
    let named = |mut axis: Axis| {
        if !last {
            axis.label.clear();
        }
        axis
    };
    let (x, y) = density_axes();
    let panel = Panel {
        left: DENSITY_LEFT,
        top,
        width: DENSITY_WIDTH,
        height: HEIGHT,
        x: named(x),
        y,
    };
    panel.frame(sheet)?;
    row.density.draw(sheet, &panel, &row.density.relative_levels())?;
    note(sheet, panel.left + 8.0, top + 15.0, &format!("{letter}1"), "");
    for (j, cell) in row.cells.iter().enumerate() {
        let left = LEFT + COLUMN * j as f64;
        let y = if j == 0 { axes.1.clone() } else { axes.1.clone().bare() };
        let panel = Panel {
            left,
            top,
            width: WIDTH,
            height: HEIGHT,
            x: named(axes.0.clone()),
            y,
        };
        panel.frame(sheet)?;
        draw_cell(sheet, &panel, cell)?;
        let capsizes = cell
            .capsize_share
            .map_or(String::new(), |share| format!("capsize in {}", percent(share)));
        note(
            sheet,
            left + 8.0,
            top + HEIGHT - 9.0,
            &format!("{letter}{}", j + 2),
            &capsizes,
        );
    }
    Ok(())
}

/// The sea's letter, name and description above its row.
fn row_title(sheet: &mut Sheet, row: &Row, letter: char, top: f64) {
    let y = top - 9.0;
    let room = sheet.width() - DENSITY_LEFT - 16.0;
    let look = Type {
        size: style::TITLE_SIZE,
        bold: true,
        ..PLAIN
    };
    let name = shorten(&format!("({letter}) {}", row.spectrum), 1.1 * look.size, room / 2.0);
    sheet.text(DENSITY_LEFT, y, look, &name);
    let used = text_width(&name, 1.1 * look.size) + 8.0;
    let look = Type {
        size: style::LABEL_SIZE,
        colour: style::GREY,
        ..PLAIN
    };
    sheet.text(
        DENSITY_LEFT + used,
        y,
        look,
        &shorten(&row.description, look.size, room - used),
    );
}

/// A panel's letter, and a small note behind it.
fn note(sheet: &mut Sheet, x: f64, y: f64, letter: &str, text: &str) {
    let look = Type {
        size: style::TICK_SIZE,
        bold: true,
        ..PLAIN
    };
    sheet.text(x, y, look, letter);
    let look = Type {
        size: style::NOTE_SIZE,
        colour: style::GREY,
        ..PLAIN
    };
    sheet.text(x + 20.0, y, look, text);
}

/// A share as a percentage with two significant digits or so.
pub fn percent(share: f64) -> String {
    let percent = 100.0 * share;
    match percent {
        p if !p.is_finite() => "–".to_owned(),
        p if p <= 0.0 => "0 %".to_owned(),
        p if p < 0.01 => "< 0.01 %".to_owned(),
        p if p < 0.1 => format!("{} %", fixed(p, 2)),
        p if p < 10.0 => format!("{} %", fixed(p, 1)),
        p => format!("{} %", fixed(p, 0)),
    }
}

/// Draws the methods' lines, then the truth's bars and dots over them.
fn draw_cell(sheet: &mut Sheet, panel: &Panel, cell: &Cell) -> Result<(), Error> {
    for curve in &cell.curves {
        same_length("probability", curve.theta_t.len(), curve.probability.len())?;
        if !curve.standard_error.is_empty() {
            same_length("standard_error", curve.theta_t.len(), curve.standard_error.len())?;
        }
    }
    let drawn_last = [Method::Cic, Method::Pic, Method::NicGroups, Method::Nic];
    for wanted in drawn_last {
        for curve in cell.curves.iter().filter(|curve| curve.method == wanted) {
            let look = Stroke {
                colour: wanted.colour(),
                width: style::LINE,
                dash: wanted.dash(),
            };
            panel.line(sheet, &points(curve), look)?;
        }
    }
    for curve in cell.curves.iter().filter(|curve| curve.method == Method::Truth) {
        let look = Stroke {
            colour: style::BLACK,
            width: 0.7,
            dash: &[],
        };
        panel.bars(sheet, &error_bars(curve), look)?;
        let dots: Vec<(f64, f64)> = points(curve).into_iter().step_by(dotted(curve)).collect();
        panel.dots(sheet, &dots, style::DOT, style::BLACK)?;
    }
    Ok(())
}

/// One threshold in how many carries a dot: dots that touch would hide the line that they stand upon.
fn dotted(curve: &Curve) -> usize {
    1 + curve.theta_t.len() / 40
}

/// The points (θ_t, P).
fn points(curve: &Curve) -> Vec<(f64, f64)> {
    curve
        .theta_t
        .iter()
        .copied()
        .zip(curve.probability.iter().copied())
        .collect()
}

/// One standard error on either side of every positive probability that carries a dot.
fn error_bars(curve: &Curve) -> Vec<(f64, f64, f64)> {
    let points = curve.theta_t.iter().zip(&curve.probability).zip(&curve.standard_error);
    points
        .step_by(dotted(curve))
        .filter(|((_, p), e)| **p > 0.0 && **e > 0.0)
        .map(|((theta_t, p), e)| (*theta_t, p - e, p + e))
        .collect()
}

/// The columns of the data.
#[rustfmt::skip]
const HEADER: [&str; 8] = ["ship", "spectrum", "epsilon_1", "theta_t", "method", "probability", "standard_error", "n"];

/// The data of Figure 3, columns as in the contract of published files.
pub fn csv(figures: &[&Exceedance]) -> String {
    let mut rows = Vec::new();
    for figure in figures {
        for row in &figure.rows {
            for cell in &row.cells {
                for curve in &cell.curves {
                    for (i, (theta_t, p)) in curve.theta_t.iter().zip(&curve.probability).enumerate() {
                        rows.push([
                            figure.ship.as_str().into(),
                            row.spectrum.as_str().into(),
                            cell.epsilon_1.into(),
                            (*theta_t).into(),
                            curve.method.name().into(),
                            (*p).into(),
                            curve.written_error(i).into(),
                            curve.n.into(),
                        ]);
                    }
                }
            }
        }
    }
    csv::write(HEADER, rows)
}
