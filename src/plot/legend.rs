//! Legends: a strip of samples, each with its name, centred and broken into lines where the sheet is narrow.
//!
//! plotters guesses a text's width by its bytes and boxes its legends accordingly; this one uses `svg::text_width`.
//! Tested in `tests/plots`.

use plotters::style::RGBColor;

use super::Error;
use super::shapes::{Stroke, discs, paths, polygons};
use super::style::{self, Method};
use super::svg::{PLAIN, Sheet, Type, text_width};

/// What stands before a name.
#[derive(Clone, Copy, Debug)]
pub enum Sample {
    /// A stretch of line.
    Line(Stroke),
    /// A stretch of line with a ring upon it.
    Marked(Stroke),
    /// A dot.
    Dot(RGBColor),
    /// A patch of a band, with its opacity.
    Patch(RGBColor, f64),
}

/// One entry of a legend.
#[derive(Clone, Debug)]
pub struct Entry {
    /// The sample.
    pub sample: Sample,
    /// The marked-up name.
    pub name: String,
}

/// Length of a line's sample, px.
const SAMPLE: f64 = 28.0;
/// Space between entries, px.
const BETWEEN: f64 = 22.0;
/// Distance of a strip's lines, px.
pub const LEADING: f64 = 18.0;

/// The entry of a method, its line plain.
pub fn method(method: Method) -> Entry {
    let name = if method == Method::Truth {
        "*P*_{true}"
    } else {
        method.label()
    };
    Entry {
        sample: method_sample(method),
        name: name.to_owned(),
    }
}

/// The sample of a method: dots for the truth, its line for the others.
pub fn method_sample(method: Method) -> Sample {
    if method == Method::Truth {
        return Sample::Dot(method.colour());
    }
    Sample::Line(Stroke {
        colour: method.colour(),
        width: style::LINE,
        dash: method.dash(),
    })
}

/// The width of an entry, px.
fn entry_width(entry: &Entry) -> f64 {
    SAMPLE + 6.0 + text_width(&entry.name, style::LABEL_SIZE)
}

/// The entries broken into lines no wider than `width` px, one entry at least in each.
fn lines(entries: &[Entry], width: f64) -> Vec<Vec<&Entry>> {
    let mut lines: Vec<Vec<&Entry>> = Vec::new();
    let mut used = 0.0;
    for entry in entries {
        let wanted = entry_width(entry);
        match lines.last_mut() {
            Some(line) if used + BETWEEN + wanted <= width => {
                line.push(entry);
                used += BETWEEN + wanted;
            }
            _ => {
                lines.push(vec![entry]);
                used = wanted;
            }
        }
    }
    lines
}

/// The height of a strip, px.
pub fn strip_height(entries: &[Entry], width: f64) -> f64 {
    LEADING * lines(entries, width).len() as f64
}

/// Draws a strip centred at `centre`, its upper edge at `top`, no wider than `width` px.
pub fn strip(sheet: &mut Sheet, centre: f64, top: f64, width: f64, entries: &[Entry]) -> Result<(), Error> {
    for (i, line) in lines(entries, width).iter().enumerate() {
        let between = BETWEEN * (line.len() - 1) as f64;
        let whole = line.iter().fold(between, |sum, entry| sum + entry_width(entry));
        let mut left = centre - whole / 2.0;
        let y = top + LEADING * (i as f64 + 0.5);
        for entry in line {
            draw_entry(sheet, left, y, entry)?;
            left += entry_width(entry) + BETWEEN;
        }
    }
    Ok(())
}

/// Draws one entry, its middle at height `y`.
fn draw_entry(sheet: &mut Sheet, left: f64, y: f64, entry: &Entry) -> Result<(), Error> {
    let middle = (left + SAMPLE / 2.0, y);
    let stretch = vec![vec![(left, y), (left + SAMPLE, y)]];
    match entry.sample {
        Sample::Line(look) => paths(sheet, "", &stretch, look)?,
        Sample::Marked(look) => {
            paths(sheet, "", &stretch, look)?;
            discs(sheet, &[middle], 3.2, look.colour)?;
            discs(sheet, &[middle], 1.9, style::WHITE)?;
        }
        Sample::Dot(colour) => discs(sheet, &[middle], 2.6, colour)?,
        Sample::Patch(colour, opacity) => {
            let (right, up, down) = (left + SAMPLE, y - 5.0, y + 5.0);
            let around = vec![(left, up), (right, up), (right, down), (left, down)];
            polygons(sheet, &format!("opacity=\"{opacity}\""), &[(around, colour)])?;
        }
    }
    let look = Type {
        size: style::LABEL_SIZE,
        ..PLAIN
    };
    sheet.text(left + SAMPLE + 6.0, y + 0.36 * look.size, look, &entry.name);
    Ok(())
}
