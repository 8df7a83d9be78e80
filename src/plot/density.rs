//! The joint density of group length and amplitude as filled contours: Figures 1(c) and 3, first column.
//!
//! | paper | code | shape | meaning |
//! |---|---|---|---|
//! | p_{A,L}(a,l) | `p` | (ny, nx), row-major | density over (L/T_p, A/H_s) |
//!
//! Diverging red-blue map as in the authors' public code, with pale yellow for its middle: white is left to where the
//! density vanishes. Tested in `tests/plots/density.rs`.

use plotters::style::RGBColor;

use super::axes::fixed;
use super::clip::Point;
use super::contour::{Loop, loops};
use super::panel::Panel;
use super::shapes::{Stroke, paths, polygons};
use super::svg::{Anchor, PLAIN, Sheet, Type};
use super::{Error, axes, same_length, style};

/// A density on a regular grid.
#[derive(Clone, Debug, PartialEq)]
pub struct Density {
    /// L/T_p of the first column.
    pub x0: f64,
    /// Spacing in L/T_p.
    pub dx: f64,
    /// Number of columns.
    pub nx: u32,
    /// A/H_s of the first row.
    pub y0: f64,
    /// Spacing in A/H_s.
    pub dy: f64,
    /// Number of rows.
    pub ny: u32,
    /// Values, row-major: `p[iy * nx + ix]` stands at (x0 + ix dx, y0 + iy dy); shape (ny, nx).
    pub p: Vec<f64>,
}

/// Ascending levels of a density; the bands between them carry the colours.
#[derive(Clone, Debug, PartialEq)]
pub struct Levels {
    /// Lower borders of the bands, in units of the density.
    pub from: Vec<f64>,
    /// Upper border of the last band.
    pub to: f64,
    /// Decimals of their labels.
    pub decimals: usize,
}

impl Density {
    /// The largest finite value; zero for an empty grid.
    pub fn largest(&self) -> f64 {
        let mut largest = 0.0;
        for &value in &self.p {
            largest = if value.is_finite() && value > largest {
                value
            } else {
                largest
            };
        }
        largest
    }

    /// Round levels up to the largest value, the lowest a tenth of the step, for a colour bar of its own.
    pub fn round_levels(&self, count: u32) -> Levels {
        let largest = self.largest();
        let (step, decimals) = axes::round_step(if largest > 0.0 { largest } else { 1.0 }, count);
        let mut from = vec![0.1 * step];
        let mut i = 1.0;
        while i * step < largest {
            from.push(i * step);
            i += 1.0;
        }
        Levels {
            from,
            to: i * step,
            decimals,
        }
    }

    /// Levels at tenths of the largest value, the lowest at a fiftieth.
    pub fn relative_levels(&self) -> Levels {
        let largest = self.largest();
        let tenths = (1..10).map(|i| largest * f64::from(i) / 10.0);
        Levels {
            from: std::iter::once(largest / 50.0).chain(tenths).collect(),
            to: largest,
            decimals: 1,
        }
    }

    /// Draws the bands into a panel whose axes are L/T_p and A/H_s.
    pub fn draw(&self, sheet: &mut Sheet, panel: &Panel, levels: &Levels) -> Result<(), Error> {
        let (nx, ny) = (self.nx as usize, self.ny as usize);
        same_length("joint density", nx * ny, self.p.len())?;
        let p: Vec<f64> = self
            .p
            .iter()
            .map(|&value| if value.is_finite() { value } else { 0.0 })
            .collect();
        let mut shapes = Vec::new();
        let mut below = style::WHITE;
        for (i, &level) in levels.from.iter().enumerate() {
            let colour = colour(i, levels.from.len());
            for found in if level > 0.0 {
                loops(&p, nx, ny, level)
            } else {
                Vec::new()
            } {
                shapes.push((self.values(&found), if found.area > 0.0 { colour } else { below }));
            }
            below = colour;
        }
        panel.fill(sheet, "", &shapes)
    }

    /// A loop's points as (L/T_p, A/H_s).
    fn values(&self, found: &Loop) -> Vec<Point> {
        found
            .points
            .iter()
            .map(|&(i, j)| (self.x0 + i * self.dx, self.y0 + j * self.dy))
            .collect()
    }
}

/// The colour of band `i` of `n`: blue for the lowest, red for the highest.
pub fn colour(i: usize, n: usize) -> RGBColor {
    let t = if n > 1 { i as f64 / (n - 1) as f64 } else { 1.0 };
    // The ends of the map are nearly black: leave a sixth of blue, which covers most of the area, and a bit of red.
    let (r, g, b) = colorous::RED_YELLOW_BLUE.eval_continuous(0.84 - 0.78 * t).as_tuple();
    RGBColor(r, g, b)
}

/// A colour bar standing at (left, top), `height` px high, labelled at the levels; all but `every`-th stay unlabelled.
pub fn upright_bar(sheet: &mut Sheet, corner: Point, height: f64, levels: &Levels, title: &str) -> Result<(), Error> {
    let (left, top) = corner;
    let width = 11.0;
    let n = levels.from.len();
    let block = height / n as f64;
    let mut shapes = Vec::new();
    for i in 0..n {
        let (low, high) = (top + height - block * i as f64, top + height - block * (i + 1) as f64);
        shapes.push((
            vec![(left, low), (left + width, low), (left + width, high), (left, high)],
            colour(i, n),
        ));
    }
    polygons(sheet, "shape-rendering=\"crispEdges\"", &shapes)?;
    outline(sheet, corner, width, height)?;
    let look = Type {
        size: style::TICK_SIZE,
        ..PLAIN
    };
    let borders = levels.from.iter().copied().chain([levels.to]);
    let every = n / 12 + 1;
    for (i, value) in borders.enumerate().filter(|(i, _)| i % every == 0) {
        let decimals = if i == 0 { levels.decimals + 1 } else { levels.decimals };
        let y = top + height - block * i as f64 + 0.36 * look.size;
        sheet.text(left + width + 4.0, y, look, &fixed(value, decimals));
    }
    let look = Type {
        size: style::LABEL_SIZE,
        anchor: Anchor::Middle,
        upwards: true,
        ..PLAIN
    };
    sheet.text(left + width + 42.0, top + height / 2.0, look, title);
    Ok(())
}

/// A lying colour bar for relative levels, its ends labelled 0 and 1.
pub fn lying_bar(sheet: &mut Sheet, corner: Point, width: f64, title: &str) -> Result<(), Error> {
    let (left, top) = corner;
    let (n, height) = (10, 9.0);
    let block = width / n as f64;
    let mut shapes = Vec::new();
    for i in 0..n {
        let (from, to) = (left + block * i as f64, left + block * (i + 1) as f64);
        shapes.push((
            vec![(from, top), (to, top), (to, top + height), (from, top + height)],
            colour(i, n),
        ));
    }
    polygons(sheet, "shape-rendering=\"crispEdges\"", &shapes)?;
    outline(sheet, corner, width, height)?;
    let look = Type {
        size: style::TICK_SIZE,
        anchor: Anchor::Middle,
        ..PLAIN
    };
    for (fraction, label) in [(0.0, "0"), (0.5, "0.5"), (1.0, "1")] {
        sheet.text(left + fraction * width, top + height + 12.0, look, label);
    }
    sheet.text(left + width / 2.0, top - 5.0, look, title);
    Ok(())
}

/// The thin frame around a colour bar.
fn outline(sheet: &mut Sheet, (left, top): Point, width: f64, height: f64) -> Result<(), Error> {
    let (right, bottom) = (left + width, top + height);
    let around = vec![(left, top), (right, top), (right, bottom), (left, bottom), (left, top)];
    paths(
        sheet,
        "",
        &[around],
        Stroke {
            colour: style::FRAME,
            width: style::GRID_LINE,
            dash: &[],
        },
    )
}
