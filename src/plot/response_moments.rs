//! Figure 4: mean and standard deviation of the random response R(a,l) by the methods, at a few group shapes.
//!
//! | paper | code | unit | meaning |
//! |---|---|---|---|
//! | R(a,l) | `mean`, `std` | rad | largest roll in a group of given shape |
//! | ε₁ | `epsilon_1` | 1/(m s²) | parametric excitation |
//!
//! Tested in `tests/plots/figures.rs`.

use super::axes::Axis;
use super::csv;
use super::legend::{Entry, Sample, method, strip, strip_height};
use super::panel::Panel;
use super::shapes::Stroke;
use super::style::{self, Method};
use super::svg::{PLAIN, Sheet, Type, shorten};
use super::{Error, same_length};
use crate::text::count::{counted, thousands};
use crate::text::number::short;

/// One method's moments over ε₁.
#[derive(Clone, Debug, PartialEq)]
pub struct Moments {
    /// Whose they are.
    pub method: Method,
    /// Parametric excitations, 1/(m s²).
    pub epsilon_1: Vec<f64>,
    /// Means of R, rad, as many.
    pub mean: Vec<f64>,
    /// Population standard deviations of R, rad, as many.
    pub std: Vec<f64>,
    /// Numbers of responses, as many.
    pub n: Vec<u64>,
}

impl Moments {
    /// The standard deviation in place `i`: none of a single response, but for CIC, which starts every run from the same state
    /// and has no other response.
    fn spread(&self, i: usize) -> Option<f64> {
        let n = self.n.get(i).copied().unwrap_or(0);
        let known = n > 1 || self.method == Method::Cic;
        self.std.get(i).copied().filter(|_| known)
    }

    /// The points (ε₁, moment), where the moment is known.
    fn points(&self, of: Of) -> Vec<(f64, f64)> {
        let known = self.epsilon_1.iter().enumerate();
        known.filter_map(|(i, x)| Some((*x, of.value(self, i)?))).collect()
    }

    /// Bars of one standard error about the points, that of normal numbers for a standard deviation.
    fn bars(&self, of: Of) -> Vec<(f64, f64, f64)> {
        let bar = |(i, x): (usize, &f64)| {
            let n = self.n.get(i).copied().filter(|n| *n > 1)?;
            let error = self.spread(i)? / (of.halved() * n as f64).sqrt();
            let y = of.value(self, i)?;
            Some((*x, y - error, y + error))
        };
        self.epsilon_1.iter().enumerate().filter_map(bar).collect()
    }
}

/// Which moment a row of panels shows.
#[derive(Clone, Copy, PartialEq)]
enum Of {
    /// The mean.
    Mean,
    /// The standard deviation.
    Spread,
}

impl Of {
    fn value(self, moments: &Moments, i: usize) -> Option<f64> {
        match self {
            Of::Mean => moments.mean.get(i).copied(),
            Of::Spread => moments.spread(i),
        }
    }

    /// The variance of the moment is that of a response over this many n.
    fn halved(self) -> f64 {
        match self {
            Of::Mean => 1.0,
            Of::Spread => 2.0,
        }
    }
}

/// One column: a group shape.
#[derive(Clone, Debug, PartialEq)]
pub struct Shape {
    /// Length over peak period.
    pub l_over_tp: f64,
    /// Amplitude over significant wave height.
    pub a_over_hs: f64,
    /// Number of groups of about this shape.
    pub groups: u64,
    /// The methods' moments.
    pub moments: Vec<Moments>,
}

/// What Figure 4 shows.
#[derive(Clone, Debug, PartialEq)]
pub struct ResponseMoments {
    /// Name of the ship.
    pub ship: String,
    /// Name of the sea.
    pub spectrum: String,
    /// The group shapes.
    pub shapes: Vec<Shape>,
}

/// Width of a panel, px.
const WIDTH: f64 = 256.0;
/// Height of a panel, px.
const HEIGHT: f64 = 150.0;
/// Left border of the first panel, px.
const LEFT: f64 = 62.0;
/// Distance of columns, px.
const COLUMN: f64 = 278.0;
/// Upper borders of the two rows, px.
const TOPS: [f64; 2] = [56.0, 236.0];

/// Draws Figure 4.
pub fn draw(figure: &ResponseMoments) -> Result<String, Error> {
    for moments in figure.shapes.iter().flat_map(|shape| &shape.moments) {
        same_length("mean of R", moments.epsilon_1.len(), moments.mean.len())?;
        same_length("standard deviation of R", moments.epsilon_1.len(), moments.std.len())?;
    }
    let width = LEFT + COLUMN * figure.shapes.len().max(1) as f64;
    let legend = legend(figure);
    let mut sheet = Sheet::new(width, 446.0 + strip_height(&legend, width - 20.0));
    let look = Type {
        size: style::LABEL_SIZE,
        colour: style::GREY,
        ..PLAIN
    };
    let whose = format!("ship: {}, sea: {}", figure.ship, figure.spectrum);
    sheet.text(LEFT, 18.0, look, &shorten(&whose, look.size, width - LEFT - 16.0));
    let x = epsilon_axis(figure);
    let all = || figure.shapes.iter().flat_map(|shape| &shape.moments);
    let means = Axis::around(all().flat_map(|m| m.mean.iter().copied()), 5, "mean of *R* (rad)");
    let spreads = all().flat_map(|m| m.points(Of::Spread)).map(|(_, std)| std);
    let stds = Axis::from_zero(spreads, 5, "std. dev. of *R* (rad)");
    for (j, shape) in figure.shapes.iter().enumerate() {
        let left = LEFT + COLUMN * j as f64;
        let own = |axis: &Axis| if j == 0 { axis.clone() } else { axis.clone().bare() };
        let upper = Panel {
            left,
            top: TOPS[0],
            width: WIDTH,
            height: HEIGHT,
            x: x.clone().bare(),
            y: own(&means),
        };
        let lower = Panel {
            left,
            top: TOPS[1],
            width: WIDTH,
            height: HEIGHT,
            x: x.clone(),
            y: own(&stds),
        };
        upper.frame(&mut sheet)?;
        lower.frame(&mut sheet)?;
        let letters = [
            char::from(b'a' + (j % 13) as u8),
            char::from(b'a' + ((j + figure.shapes.len()) % 26) as u8),
        ];
        upper.title(&mut sheet, &format!("({})", letters[0]), &shape_title(shape));
        lower.title(&mut sheet, &format!("({})", letters[1]), "");
        draw_moments(&mut sheet, &upper, shape, Of::Mean)?;
        draw_moments(&mut sheet, &lower, shape, Of::Spread)?;
    }
    strip(&mut sheet, width / 2.0, 434.0, width - 20.0, &legend)?;
    let what = format!(
        "Ship: {}. Sea: {}. Mean (upper row) and standard deviation (lower row) of the largest roll in groups of a given \
         length and amplitude against epsilon_1, one column per shape. Black dots: truth. Green dash-dotted: CIC. Orange: \
         PIC. Blue: NIC. Bars of one standard error, most of them hidden by their marks.",
        figure.ship, figure.spectrum
    );
    Ok(sheet.finish("Figure 4: mean and standard deviation of the response", &what))
}

/// The head of a column.
fn shape_title(shape: &Shape) -> String {
    let count = counted(thousands(shape.groups), "group");
    format!(
        "*L*/*T*_{{p}} = {}, *A*/*H*_{{s}} = {} ({count})",
        short(shape.l_over_tp),
        short(shape.a_over_hs)
    )
}

/// A tick at every ε₁.
fn epsilon_axis(figure: &ResponseMoments) -> Axis {
    let all = figure.shapes.iter().flat_map(|shape| &shape.moments);
    let values = all.flat_map(|moments| moments.epsilon_1.iter().copied());
    Axis::at_values(values, &format!("*ε*_{{1}} ({})", style::EPSILON_UNIT))
}

/// Draws one moment by every method, the truth's dots last.
fn draw_moments(sheet: &mut Sheet, panel: &Panel, shape: &Shape, of: Of) -> Result<(), Error> {
    for wanted in [Method::Cic, Method::Pic, Method::NicGroups, Method::Nic] {
        for moments in shape.moments.iter().filter(|moments| moments.method == wanted) {
            let look = Stroke {
                colour: wanted.colour(),
                width: style::LINE,
                dash: wanted.dash(),
            };
            panel.line(sheet, &moments.points(of), look)?;
            let bar = Stroke {
                width: 1.0,
                dash: &[],
                ..look
            };
            panel.bars(sheet, &moments.bars(of), bar)?;
            panel.rings(sheet, &moments.points(of), 3.4, Stroke { width: 1.4, ..look })?;
        }
    }
    for moments in shape.moments.iter().filter(|moments| moments.method == Method::Truth) {
        let bar = Stroke {
            colour: style::BLACK,
            width: 0.8,
            dash: &[],
        };
        panel.bars(sheet, &moments.bars(of), bar)?;
        panel.dots(sheet, &moments.points(of), 2.3, style::BLACK)?;
    }
    Ok(())
}

/// The methods that occur, lines with their marks.
fn legend(figure: &ResponseMoments) -> Vec<Entry> {
    let occurs = |wanted: Method| {
        figure
            .shapes
            .iter()
            .flat_map(|shape| &shape.moments)
            .any(|moments| moments.method == wanted)
    };
    let mut entries = Vec::new();
    for wanted in Method::ALL.into_iter().filter(|wanted| occurs(*wanted)) {
        let Entry { sample, name } = method(wanted);
        let sample = if let Sample::Line(look) = sample {
            Sample::Marked(look)
        } else {
            sample
        };
        entries.push(Entry {
            sample,
            name: if wanted == Method::Truth {
                "truth".to_owned()
            } else {
                name
            },
        });
    }
    entries
}

/// The data of Figure 4.
pub fn csv(figure: &ResponseMoments) -> String {
    let header = [
        "ship",
        "epsilon_1",
        "l_over_tp",
        "a_over_hs",
        "method",
        "mean",
        "std",
        "n",
    ];
    let mut rows = Vec::new();
    for shape in &figure.shapes {
        for moments in &shape.moments {
            for (i, epsilon_1) in moments.epsilon_1.iter().enumerate() {
                rows.push([
                    figure.ship.as_str().into(),
                    (*epsilon_1).into(),
                    shape.l_over_tp.into(),
                    shape.a_over_hs.into(),
                    moments.method.name().into(),
                    moments.mean.get(i).copied().into(),
                    moments.spread(i).into(),
                    moments.n.get(i).copied().into(),
                ]);
            }
        }
    }
    csv::write(header, rows)
}
