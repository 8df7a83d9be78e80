//! Lines, polygons, discs and arrows on the sheet, in px of the sheet; plotters draws them.
//!
//! Tested in `tests/plots` through the figures.

use plotters::element::{Circle, PathElement, Polygon};
use plotters::style::{Color, RGBColor, ShapeStyle};

use crate::numerics::elementary::sin_cos;

use super::Error;
use super::clip::Point;
use super::svg::{self, Sheet};

/// How a line is drawn.
#[derive(Clone, Copy, Debug)]
pub struct Stroke {
    /// Colour.
    pub colour: RGBColor,
    /// Width, px.
    pub width: f64,
    /// Lengths of dash and gap in turn, px; empty for a solid line.
    pub dash: &'static [f64],
}

/// Draws polylines given in px of the sheet.
pub fn paths(sheet: &mut Sheet, attributes: &str, lines: &[Vec<Point>], look: Stroke) -> Result<(), Error> {
    let dashes = if look.dash.is_empty() {
        String::new()
    } else {
        svg::dashes(look.dash)
    };
    let attributes = [attributes, &dashes].join(" ");
    sheet.shapes(attributes.trim(), |area| {
        for line in lines {
            let line: Vec<(i32, i32)> = line.iter().map(|&(x, y)| (svg::units(x), svg::units(y))).collect();
            drawn(area.draw(&PathElement::new(line, outline(look))))?;
        }
        Ok(())
    })
}

/// Fills polygons given in px of the sheet.
pub fn polygons(sheet: &mut Sheet, attributes: &str, shapes: &[(Vec<Point>, RGBColor)]) -> Result<(), Error> {
    sheet.shapes(attributes, |area| {
        for (around, colour) in shapes {
            let around: Vec<(i32, i32)> = around.iter().map(|&(x, y)| (svg::units(x), svg::units(y))).collect();
            drawn(area.draw(&Polygon::new(around, colour.filled())))?;
        }
        Ok(())
    })
}

/// Fills circles given in px of the sheet.
pub fn discs(sheet: &mut Sheet, centres: &[Point], radius: f64, colour: RGBColor) -> Result<(), Error> {
    sheet.shapes("", |area| {
        for &(x, y) in centres {
            let centre = (svg::units(x), svg::units(y));
            drawn(area.draw(&Circle::new(centre, svg::units(radius), colour.filled())))?;
        }
        Ok(())
    })
}

/// A straight arrow along an axis, its tip at `to`.
pub fn arrow(sheet: &mut Sheet, from: Point, to: Point, colour: RGBColor) -> Result<(), Error> {
    let (dx, dy) = (to.0 - from.0, to.1 - from.1);
    let length = (dx * dx + dy * dy).sqrt();
    let (ex, ey) = (dx / length, dy / length);
    let neck = (to.0 - 7.0 * ex, to.1 - 7.0 * ey);
    paths(
        sheet,
        "",
        &[vec![from, neck]],
        Stroke {
            colour,
            width: 1.5,
            dash: &[],
        },
    )?;
    let side = |s: f64| (neck.0 - s * 4.0 * ey, neck.1 + s * 4.0 * ex);
    polygons(sheet, "", &[(vec![to, side(1.0), side(-1.0)], colour)])
}

/// The outline of a box with round corners.
pub fn rounded((left, top): Point, (width, height): Point, radius: f64) -> Vec<Point> {
    let (right, bottom) = (left + width, top + height);
    let corners = [
        (right - radius, bottom - radius),
        (left + radius, bottom - radius),
        (left + radius, top + radius),
        (right - radius, top + radius),
    ];
    let mut around = Vec::new();
    for (quarter, (x, y)) in corners.into_iter().enumerate() {
        for i in 0..=6 {
            let (sin, cos) = sin_cos(std::f64::consts::FRAC_PI_2 * (quarter as f64 + f64::from(i) / 6.0));
            around.push((x + radius * cos, y + radius * sin));
        }
    }
    around
}

/// plotters' style of a line.
pub fn outline(look: Stroke) -> ShapeStyle {
    ShapeStyle {
        color: look.colour.to_rgba(),
        filled: false,
        stroke_width: svg::stroke(look.width),
    }
}

/// plotters' answer as ours.
pub fn drawn<T, E: std::error::Error>(result: Result<T, E>) -> Result<(), Error> {
    result.map(|_| ()).map_err(|error| Error::Plotters(error.to_string()))
}
