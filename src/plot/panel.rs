//! A panel: a frame with two axes, into which plotters draws series on linear coordinates.
//!
//! The axes' words, ticks and grid are set here; lines, bands, dots and bars go through plotters' chart of the panel,
//! after clipping: what lies outside the frame is cut, what is not finite or has no logarithm breaks the line.
//! Tested in `tests/plots`.

use plotters::backend::SVGBackend;
use plotters::chart::{ChartBuilder, ChartContext};
use plotters::coord::cartesian::Cartesian2d;
use plotters::coord::types::RangedCoordf64;
use plotters::element::{Circle, PathElement, Polygon};
use plotters::style::{Color, RGBColor};

use super::axes::{Axis, Tick};
use super::clip::{Point, Window, thin};
use super::shapes::{Stroke, discs, drawn, outline, paths};
use super::svg::{self, Anchor, PLAIN, Sheet, Type};
use super::{Error, style};

/// Curves are thinned to this deviation, px.
const TOLERANCE: f64 = 0.06;

/// Least distance of the tick labels of a horizontal axis, px.
const BETWEEN_LABELS: f64 = 3.0;

/// Width of a band over a single abscissa, px.
const LONELY_BAND: f64 = 3.0;

/// Least room for the tick labels of a vertical axis, px.
const LABEL_ROOM: f64 = 26.0;

/// A frame on the sheet with its axes; lengths in px.
#[derive(Clone, Debug)]
pub struct Panel {
    /// Left border.
    pub left: f64,
    /// Upper border.
    pub top: f64,
    /// Width of the frame.
    pub width: f64,
    /// Height of the frame.
    pub height: f64,
    /// Horizontal axis.
    pub x: Axis,
    /// Vertical axis.
    pub y: Axis,
}

/// plotters' chart of a panel.
type Chart<'a, 'b> = ChartContext<'a, SVGBackend<'b>, Cartesian2d<RangedCoordf64, RangedCoordf64>>;

impl Panel {
    /// Draws grid, frame, ticks, tick labels and axis labels.
    pub fn frame(&self, sheet: &mut Sheet) -> Result<(), Error> {
        self.grid(sheet)?;
        self.border(sheet)?;
        self.words(sheet);
        Ok(())
    }

    /// Light lines at the major ticks.
    fn grid(&self, sheet: &mut Sheet) -> Result<(), Error> {
        let named = |axis: &Axis| -> Vec<f64> {
            let inside = |at: f64| axis.fraction(at) > 0.001 && axis.fraction(at) < 0.999;
            axis.ticks
                .iter()
                .filter(|t| !t.label.is_empty() && inside(t.at))
                .map(|t| t.at)
                .collect()
        };
        let mut lines = Vec::new();
        for x in named(&self.x) {
            lines.push(vec![(self.x_px(x), self.top), (self.x_px(x), self.top + self.height)]);
        }
        for y in named(&self.y) {
            lines.push(vec![(self.left, self.y_px(y)), (self.left + self.width, self.y_px(y))]);
        }
        paths(
            sheet,
            "",
            &lines,
            Stroke {
                colour: style::GRID,
                width: style::GRID_LINE,
                dash: &[],
            },
        )
    }

    /// The frame and its ticks, which point inwards.
    fn border(&self, sheet: &mut Sheet) -> Result<(), Error> {
        let (right, bottom) = (self.left + self.width, self.top + self.height);
        let mut lines = vec![vec![
            (self.left, self.top),
            (right, self.top),
            (right, bottom),
            (self.left, bottom),
            (self.left, self.top),
        ]];
        for tick in self.x.ticks.iter().filter(|tick| self.x.holds(tick.at)) {
            let (x, length) = (self.x_px(tick.at), tick_length(&tick.label));
            lines.push(vec![(x, bottom), (x, bottom - length)]);
        }
        for tick in self.y.ticks.iter().filter(|tick| self.y.holds(tick.at)) {
            let (y, length) = (self.y_px(tick.at), tick_length(&tick.label));
            lines.push(vec![(self.left, y), (self.left + length, y)]);
        }
        let look = Stroke {
            colour: style::FRAME,
            width: style::FRAME_LINE,
            dash: &[],
        };
        paths(
            sheet,
            "stroke-linejoin=\"miter\" stroke-linecap=\"square\"",
            &lines,
            look,
        )
    }

    /// Tick labels and axis labels.
    fn words(&self, sheet: &mut Sheet) {
        let bottom = self.top + self.height;
        let look = Type {
            size: style::TICK_SIZE,
            ..PLAIN
        };
        let mut free_from = f64::NEG_INFINITY;
        for tick in named(&self.x) {
            let look = Type {
                anchor: Anchor::Middle,
                ..look
            };
            let (x, half) = (self.x_px(tick.at), 0.5 * svg::text_width(&tick.label, look.size));
            // A label that would touch its neighbour is left out; its tick stays.
            if x - half < free_from {
                continue;
            }
            free_from = x + half + BETWEEN_LABELS;
            sheet.text(x, bottom + 4.0 + 0.95 * look.size, look, &tick.label);
        }
        // Two panels above each other align their labels unless one has very long ticks.
        let mut widest = LABEL_ROOM;
        let mut free_below = f64::INFINITY;
        for tick in named(&self.y) {
            let y = self.y_px(tick.at);
            if y > free_below {
                continue;
            }
            free_below = y - look.size;
            let look = Type {
                anchor: Anchor::End,
                ..look
            };
            sheet.text(self.left - 5.0, y + 0.36 * look.size, look, &tick.label);
            let width = svg::text_width(&tick.label, look.size);
            widest = if width > widest { width } else { widest };
        }
        let look = Type {
            size: style::LABEL_SIZE,
            anchor: Anchor::Middle,
            ..PLAIN
        };
        sheet.text(self.left + self.width / 2.0, bottom + 31.0, look, &self.x.label);
        let look = Type { upwards: true, ..look };
        sheet.text(
            self.left - widest - 12.0,
            self.top + self.height / 2.0,
            look,
            &self.y.label,
        );
    }

    /// A curve through the given values (x, y); a value without neighbours is a mark.
    pub fn line(&self, sheet: &mut Sheet, values: &[Point], look: Stroke) -> Result<(), Error> {
        let (mut parts, mut lonely) = (Vec::new(), Vec::new());
        for stretch in self.stretches(values) {
            match stretch.as_slice() {
                [place] if self.window().holds(*place) => lonely.push((self.x_px(place.0), self.y_px(place.1))),
                stretch => parts.extend(self.window().clip_line(stretch)),
            }
        }
        if !lonely.is_empty() {
            discs(sheet, &lonely, 0.5 * look.width + 1.0, look.colour)?;
        }
        let parts: Vec<Vec<Point>> = parts.iter().map(|part| self.thinned(part)).collect();
        self.chart(sheet, &svg::dashes(look.dash), |chart| {
            let style = outline(look);
            drawn(chart.draw_series(parts.into_iter().map(|part| PathElement::new(part, style))))
        })
    }

    /// The area between two curves over the same abscissae, `values` (x, lower, upper).
    pub fn band(
        &self,
        sheet: &mut Sheet,
        values: &[(f64, f64, f64)],
        colour: RGBColor,
        opacity: f64,
    ) -> Result<(), Error> {
        if let [lonely] = values {
            // A band over one abscissa has no area.
            let look = Stroke {
                colour,
                width: LONELY_BAND,
                dash: &[],
            };
            return self.bars(sheet, &[*lonely], look);
        }
        let lower: Vec<Point> = values.iter().map(|v| (v.0, v.1)).collect();
        let upper: Vec<Point> = values.iter().rev().map(|v| (v.0, v.2)).collect();
        let around: Vec<Point> = lower.into_iter().chain(upper).collect();
        self.fill(sheet, &format!("opacity=\"{opacity}\""), &[(around, colour)])
    }

    /// Filled polygons of values (x, y), later ones over earlier ones.
    pub fn fill(&self, sheet: &mut Sheet, attributes: &str, shapes: &[(Vec<Point>, RGBColor)]) -> Result<(), Error> {
        let mut cut = Vec::new();
        for (around, colour) in shapes {
            let placed: Vec<Point> = around.iter().filter_map(|&point| self.place(point)).collect();
            let inside = self.thinned(&self.window().clip_polygon(&placed));
            if inside.len() >= 3 {
                cut.push((inside, *colour));
            }
        }
        self.chart(sheet, attributes, |chart| {
            drawn(
                chart.draw_series(
                    cut.into_iter()
                        .map(|(inside, colour)| Polygon::new(inside, colour.filled())),
                ),
            )
        })
    }

    /// A dot at each of the given values; those outside the frame are dropped.
    pub fn dots(&self, sheet: &mut Sheet, values: &[Point], radius: f64, colour: RGBColor) -> Result<(), Error> {
        let inside = self.inside(values);
        self.chart(sheet, "", |chart| {
            let radius = svg::units(radius);
            drawn(
                chart.draw_series(
                    inside
                        .into_iter()
                        .map(|point| Circle::new(point, radius, colour.filled())),
                ),
            )
        })
    }

    /// A ring at each of the given values, white inside.
    pub fn rings(&self, sheet: &mut Sheet, values: &[Point], radius: f64, look: Stroke) -> Result<(), Error> {
        self.dots(sheet, values, radius, style::WHITE)?;
        let inside = self.inside(values);
        self.chart(sheet, "", |chart| {
            let radius = svg::units(radius);
            drawn(
                chart.draw_series(
                    inside
                        .into_iter()
                        .map(|point| Circle::new(point, radius, outline(look))),
                ),
            )
        })
    }

    /// Upright bars between two values each, `values` (x, lower, upper); a lower end without a place reaches the frame.
    pub fn bars(&self, sheet: &mut Sheet, values: &[(f64, f64, f64)], look: Stroke) -> Result<(), Error> {
        let mut parts = Vec::new();
        for &(x, lower, upper) in values {
            let (Some(x), Some(upper)) = (self.x.place(x), self.y.place(upper)) else {
                continue;
            };
            let lower = self.y.place(lower).unwrap_or(self.y.low);
            parts.extend(self.window().clip_line(&[(x, lower), (x, upper)]));
        }
        self.chart(sheet, "", |chart| {
            let style = outline(look);
            drawn(chart.draw_series(parts.into_iter().map(|part| PathElement::new(part, style))))
        })
    }

    /// A bold letter above the frame's left corner, and a title behind it.
    pub fn title(&self, sheet: &mut Sheet, letter: &str, title: &str) {
        let y = self.top - 7.0;
        let look = Type {
            size: style::TITLE_SIZE,
            bold: true,
            ..PLAIN
        };
        sheet.text(self.left, y, look, letter);
        let gap = if letter.is_empty() {
            0.0
        } else {
            svg::text_width(letter, 1.08 * look.size) + 5.0
        };
        let look = Type {
            size: style::LABEL_SIZE,
            ..PLAIN
        };
        sheet.text(
            self.left + gap,
            y,
            look,
            &svg::shorten(title, look.size, self.width - gap),
        );
    }

    /// The horizontal position on the sheet of a place on the x axis, px.
    pub fn x_px(&self, at: f64) -> f64 {
        self.left + self.width * self.x.fraction(at)
    }

    /// The vertical position on the sheet of a place on the y axis, px.
    pub fn y_px(&self, at: f64) -> f64 {
        self.top + self.height * (1.0 - self.y.fraction(at))
    }

    /// Lets plotters draw one layer on the panel's linear coordinates.
    fn chart(
        &self,
        sheet: &mut Sheet,
        attributes: &str,
        draw: impl FnOnce(&mut Chart<'_, '_>) -> Result<(), Error>,
    ) -> Result<(), Error> {
        sheet.shapes(attributes, |area| {
            let corner = (svg::units(self.left), svg::units(self.top));
            // One unit more than the frame: plotters ends its axes on the last unit, not after it.
            let size = (svg::units(self.width) + 1, svg::units(self.height) + 1);
            let inside = area.clone().shrink(corner, size);
            let mut chart = ChartBuilder::on(&inside)
                .build_cartesian_2d(self.x.low..self.x.high, self.y.low..self.y.high)
                .map_err(|error| Error::Plotters(error.to_string()))?;
            draw(&mut chart)
        })
    }

    /// A value's place on both axes.
    fn place(&self, (x, y): Point) -> Option<Point> {
        Some((self.x.place(x)?, self.y.place(y)?))
    }

    /// The places of the values that stand inside the frame.
    fn inside(&self, values: &[Point]) -> Vec<Point> {
        let places = values.iter().filter_map(|&value| self.place(value));
        places.filter(|&place| self.window().holds(place)).collect()
    }

    /// The curve's stretches between values without a place.
    fn stretches(&self, values: &[Point]) -> Vec<Vec<Point>> {
        let mut stretches = vec![Vec::new()];
        for &value in values {
            match (self.place(value), stretches.last_mut()) {
                (Some(place), Some(stretch)) => stretch.push(place),
                _ => stretches.push(Vec::new()),
            }
        }
        stretches.retain(|stretch| !stretch.is_empty());
        stretches
    }

    /// The frame on the axes' own scales.
    fn window(&self) -> Window {
        Window {
            left: self.x.low,
            right: self.x.high,
            low: self.y.low,
            high: self.y.high,
        }
    }

    /// A clipped curve without the points that nobody sees.
    fn thinned(&self, part: &[Point]) -> Vec<Point> {
        let (across, up) = (
            (self.x.high - self.x.low) / self.width,
            (self.y.high - self.y.low) / self.height,
        );
        let pixels: Vec<Point> = part.iter().map(|point| (point.0 / across, point.1 / up)).collect();
        thin(&pixels, TOLERANCE)
            .iter()
            .map(|point| (point.0 * across, point.1 * up))
            .collect()
    }
}

/// The ticks of an axis that carry a label to be written.
fn named(axis: &Axis) -> impl Iterator<Item = &Tick> {
    let inside = axis.ticks.iter().filter(|tick| axis.holds(tick.at));
    inside.filter(|tick| axis.labelled && !tick.label.is_empty())
}

/// Length of a tick, px.
fn tick_length(label: &str) -> f64 {
    if label.is_empty() { 2.0 } else { 4.0 }
}
