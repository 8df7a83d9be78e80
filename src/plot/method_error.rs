//! Figure 8 (ours): how far each method lies from the truth, its probability over P_true per threshold, one row per sea.
//!
//! | paper | code | unit | meaning |
//! |---|---|---|---|
//! | P_est / P_true | `ratio` | 1 | 1 where a method is right |
//! | - | `relative_error` | 1 | P_est / P_true - 1 |
//!
//! Its standard error takes the two probabilities for independent; NIC and truth meet the same waves, so that theirs is less.
//! Tested in `tests/plots/method_error.rs`.

use super::axes::Axis;
use super::csv;
use super::exceedance::{Cell, Curve};
use super::legend::{Entry, Sample, method, strip, strip_height};
use super::panel::Panel;
use super::shapes::Stroke;
use super::style::{self, Method};
use super::svg::{Anchor, PLAIN, Sheet, Type, shorten};
use super::{Error, same_length};
use crate::text::number::short;

/// One row: a sea.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// Name of the sea.
    pub spectrum: String,
    /// What it is, such as "Gaussian, bandwidth 0.02 rad/s".
    pub description: String,
    /// One panel per epsilon_1, the same in every row.
    pub cells: Vec<Cell>,
}

/// What Figure 8 shows.
#[derive(Clone, Debug, PartialEq)]
pub struct MethodError {
    /// Name of the ship.
    pub ship: String,
    /// The seas.
    pub rows: Vec<Row>,
}

/// One method at one threshold.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point {
    /// Threshold, rad.
    pub theta_t: f64,
    /// P_est / P_true.
    pub ratio: f64,
    /// Standard error of the ratio; none if either probability has none.
    pub standard_error: Option<f64>,
}

/// Width of a panel, px.
const WIDTH: f64 = 262.0;
/// Height of a panel, px.
const HEIGHT: f64 = 128.0;
/// Left border of the first panel, px.
const LEFT: f64 = 62.0;
/// Distance of columns, px.
const COLUMN: f64 = 290.0;
/// Upper border of the first row, px.
const TOP: f64 = 74.0;
/// Distance of rows, px.
const ROW: f64 = 178.0;

/// A method's probabilities over those of the truth, where the truth exceeds a threshold at all.
///
/// # Errors
/// Curves over different thresholds, or without standard errors.
pub fn ratios(curve: &Curve, truth: &Curve) -> Result<Vec<Point>, Error> {
    for known in [curve, truth] {
        same_length("probability", truth.theta_t.len(), known.probability.len())?;
        same_length("standard_error", truth.theta_t.len(), known.standard_error.len())?;
    }
    let mut points = Vec::new();
    for (k, theta_t) in truth.theta_t.iter().enumerate() {
        let (p, p_true) = (curve.probability[k], truth.probability[k]);
        if p_true > 0.0 {
            let ratio = p / p_true;
            let spread = |(of_p, of_true): (f64, f64)| of_p * of_p + ratio * ratio * of_true * of_true;
            let errors = curve.known_error(k).zip(truth.known_error(k));
            points.push(Point {
                theta_t: *theta_t,
                ratio,
                standard_error: errors.map(|errors| spread(errors).sqrt() / p_true),
            });
        }
    }
    Ok(points)
}

/// Every method of a panel but the truth, each with its points; none where there is no truth.
fn compared(cell: &Cell) -> Result<Vec<(Method, Vec<Point>)>, Error> {
    let is_known = |curve: &&Curve| curve.method == Method::Truth && !curve.probability.is_empty();
    let Some(truth) = cell.curves.iter().find(is_known) else {
        return Ok(Vec::new());
    };
    // The order in which they are drawn: NIC last, over the others.
    let mut found = Vec::new();
    for wanted in [Method::Cic, Method::Pic, Method::NicGroups, Method::Nic] {
        for curve in cell.curves.iter().filter(|curve| curve.method == wanted) {
            if !curve.probability.is_empty() {
                found.push((wanted, ratios(curve, truth)?));
            }
        }
    }
    Ok(found)
}

/// Draws Figure 8.
///
/// # Errors
/// Arrays that do not belong together.
pub fn draw(figure: &MethodError) -> Result<String, Error> {
    let columns = figure.rows.iter().map(|row| row.cells.len()).max().unwrap_or(0).max(1);
    let width = LEFT + COLUMN * columns as f64 - (COLUMN - WIDTH) + 14.0;
    let legend = legend();
    let foot = TOP + ROW * figure.rows.len().max(1) as f64;
    let mut sheet = Sheet::new(width, foot + 14.0 + strip_height(&legend, width - 20.0));
    heads(&mut sheet, figure);
    let y = Axis::decades(-1, 1, "*P*_{est} / *P*_{true}");
    let x = threshold_axis(figure);
    for (i, row) in figure.rows.iter().enumerate() {
        let letter = char::from(b'a' + (i % 26) as u8);
        for (j, cell) in row.cells.iter().enumerate() {
            let mut x = x.clone();
            if i + 1 < figure.rows.len() {
                x.label.clear();
            }
            let panel = Panel {
                left: LEFT + COLUMN * j as f64,
                top: TOP + ROW * i as f64,
                width: WIDTH,
                height: HEIGHT,
                x,
                y: if j == 0 { y.clone() } else { y.clone().bare() },
            };
            panel.frame(&mut sheet)?;
            let title = if j == 0 {
                format!("{}  {}", row.spectrum, row.description)
            } else {
                String::new()
            };
            panel.title(&mut sheet, &format!("({letter}{})", j + 1), &title);
            draw_cell(&mut sheet, &panel, cell)?;
        }
    }
    strip(&mut sheet, width / 2.0, foot, width - 20.0, &legend)?;
    let what = format!(
        "Ship: {}. One row per sea, one column per epsilon_1: probability of each method over that of the truth against the \
         threshold, on a decimal logarithmic axis; what lies beyond a factor of ten is not drawn. Grey band: two standard errors \
         of the truth and of an estimate from as many groups as the methods run on, together. Green dash-dotted: CIC. Orange: PIC. Blue: NIC in the record's waves. Blue dashed: NIC in reconstructed groups.",
        figure.ship
    );
    Ok(sheet.finish("Figure 8: error of each method", &what))
}

/// The methods and the band.
fn legend() -> Vec<Entry> {
    let mut entries: Vec<Entry> = [Method::Cic, Method::Pic, Method::Nic, Method::NicGroups]
        .map(method)
        .into();
    entries.push(Entry {
        sample: Sample::Patch(style::BLACK, BAND),
        name: "± 2 standard errors of truth and method".to_owned(),
    });
    entries
}

/// Opacity of the band.
const BAND: f64 = 0.18;

/// The ship's name and the columns' heads.
fn heads(sheet: &mut Sheet, figure: &MethodError) {
    let ship = Type {
        size: style::LABEL_SIZE,
        colour: style::GREY,
        ..PLAIN
    };
    let room = sheet.width() - LEFT - 16.0;
    sheet.text(
        LEFT,
        18.0,
        ship,
        &shorten(&format!("ship: {}", figure.ship), ship.size, room),
    );
    let look = Type {
        size: style::TITLE_SIZE,
        bold: true,
        anchor: Anchor::Middle,
        ..PLAIN
    };
    let Some(row) = figure.rows.first() else { return };
    for (j, cell) in row.cells.iter().enumerate() {
        let head = format!("*ε*_{{1}} = {} {}", short(cell.epsilon_1), style::EPSILON_UNIT);
        sheet.text(LEFT + COLUMN * j as f64 + WIDTH / 2.0, 42.0, look, &head);
    }
}

/// Thresholds from zero to the largest of all.
fn threshold_axis(figure: &MethodError) -> Axis {
    let cells = figure.rows.iter().flat_map(|row| &row.cells);
    let curves = cells.flat_map(|cell| &cell.curves);
    Axis::thresholds(curves.flat_map(|curve| &curve.theta_t).copied())
}

/// The band, the line where a method is right, and the methods.
fn draw_cell(sheet: &mut Sheet, panel: &Panel, cell: &Cell) -> Result<(), Error> {
    let sampled = cell.curves.iter().filter(|curve| curve.method != Method::Truth);
    let n = sampled.map(|curve| curve.n).max().unwrap_or(0) as f64;
    for truth in cell.curves.iter().filter(|curve| curve.method == Method::Truth) {
        let known = truth.theta_t.iter().zip(&truth.probability).zip(&truth.standard_error);
        let band: Vec<(f64, f64, f64)> = known
            // Where every group exceeds, the band closes; elsewhere, without an error there is none.
            .filter(|((_, p), error)| **p >= 1.0 || (**p > 0.0 && **error > 0.0))
            .map(|((theta_t, p), error)| {
                let chance = if n > 0.0 && *p < 1.0 { p * (1.0 - p) / n } else { 0.0 };
                let part = 2.0 * (error * error + chance).sqrt() / p;
                // A band that reaches zero ends at the frame.
                (*theta_t, if part < 0.99 { 1.0 - part } else { 0.01 }, 1.0 + part)
            })
            .collect();
        panel.band(sheet, &band, style::BLACK, BAND)?;
        let look = Stroke {
            colour: style::BLACK,
            width: 0.7,
            dash: &[],
        };
        let ends: Vec<(f64, f64)> = band.iter().map(|(theta_t, ..)| (*theta_t, 1.0)).collect();
        panel.line(sheet, &ends, look)?;
    }
    for (method, points) in compared(cell)? {
        let look = Stroke {
            colour: method.colour(),
            width: style::LINE,
            dash: method.dash(),
        };
        let values: Vec<(f64, f64)> = points.iter().map(|point| (point.theta_t, point.ratio)).collect();
        panel.line(sheet, &values, look)?;
    }
    Ok(())
}

/// The data of Figure 8: the relative error P_est / P_true - 1 and its standard error, where P_true > 0.
///
/// # Errors
/// Arrays that do not belong together.
pub fn csv(figure: &MethodError) -> Result<String, Error> {
    let header = [
        "ship",
        "spectrum",
        "epsilon_1",
        "theta_t",
        "method",
        "relative_error",
        "standard_error",
    ];
    let mut rows = Vec::new();
    for row in &figure.rows {
        for cell in &row.cells {
            for (method, points) in compared(cell)? {
                rows.extend(points.into_iter().map(|point| {
                    [
                        figure.ship.as_str().into(),
                        row.spectrum.as_str().into(),
                        cell.epsilon_1.into(),
                        point.theta_t.into(),
                        method.name().into(),
                        (point.ratio - 1.0).into(),
                        point.standard_error.into(),
                    ]
                }));
            }
        }
    }
    Ok(csv::write(header, rows))
}
