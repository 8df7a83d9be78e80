//! Figure 7 (ours): the exceeding probability by groups and by time, and what the similarity threshold of the detection
//! does to each.
//!
//! | paper | code | unit | meaning |
//! |---|---|---|---|
//! | P(r > theta_t) | `by_groups` | 1 | share of groups, Eq. (1) |
//! | P_temp | `by_time` | 1 | share of time with absolute roll above theta_t |
//! | C_thr | `similarity_threshold` | 1 | least similarity of a group to its Gaussian |
//!
//! Tested in `tests/plots/temporal.rs`.

use plotters::style::RGBColor;

use super::axes::Axis;
use super::csv::{self, Cell};
use super::legend::{Entry, Sample, strip, strip_height};
use super::panel::Panel;
use super::shapes::Stroke;
use super::svg::{PLAIN, Sheet, Type, shorten};
use super::{Error, same_length, style};
use crate::text::count::counted;
use crate::text::number::short;

/// Probabilities against thresholds.
#[derive(Clone, Debug, PartialEq)]
pub struct Line {
    /// Thresholds, rad.
    pub theta_t: Vec<f64>,
    /// Probabilities, as many.
    pub probability: Vec<f64>,
    /// Their standard errors, as many; 0 where nothing tells it.
    pub standard_error: Vec<f64>,
}

/// The whole record of one sea at one epsilon_1.
#[derive(Clone, Debug, PartialEq)]
pub struct Whole {
    /// Name of the sea.
    pub spectrum: String,
    /// Parametric excitation, 1/(m s^2).
    pub epsilon_1: f64,
    /// Number of fields.
    pub fields: u64,
    /// Share of time.
    pub by_time: Line,
}

/// What one similarity threshold makes of the studied fields.
#[derive(Clone, Debug, PartialEq)]
pub struct Detection {
    /// C_thr.
    pub similarity_threshold: f64,
    /// Share of groups.
    pub by_groups: Line,
    /// Share of time within the groups' segments.
    pub within_groups: Line,
}

/// The studied fields at one epsilon_1.
#[derive(Clone, Debug, PartialEq)]
pub struct Study {
    /// Parametric excitation, 1/(m s^2).
    pub epsilon_1: f64,
    /// Share of time.
    pub by_time: Line,
    /// One entry per similarity threshold.
    pub detections: Vec<Detection>,
}

/// What Figure 7 shows.
#[derive(Clone, Debug, PartialEq)]
pub struct Temporal {
    /// Name of the ship.
    pub ship: String,
    /// Every sea and epsilon_1 of the whole record, for the data beside the picture.
    pub wholes: Vec<Whole>,
    /// Name of the studied sea.
    pub spectrum: String,
    /// Number of fields studied.
    pub fields: u64,
    /// One study per epsilon_1.
    pub studies: Vec<Study>,
    /// Which of them is drawn.
    pub drawn: usize,
    /// The similarity threshold that the others are compared with, by its place; none if the study leaves it out.
    pub reference: Option<usize>,
}

/// Colour and dash of each similarity threshold in turn.
const LOOKS: [(RGBColor, &[f64]); 4] = [
    (style::PURPLE, &[7.0, 2.0, 1.5, 2.0]),
    (style::BLUE, &[]),
    (style::TEAL, &[3.6, 2.0]),
    (style::GREY, &[1.5, 1.5]),
];
/// Width of a panel, px.
const WIDTH: f64 = 236.0;
/// Height of a panel, px.
const HEIGHT: f64 = 190.0;
/// Left borders of the panels, px.
const LEFTS: [f64; 3] = [62.0, 366.0, 670.0];
/// Upper border of the panels, px.
const TOP: f64 = 56.0;

/// Draws Figure 7.
///
/// # Errors
/// Arrays that do not belong together.
pub fn draw(figure: &Temporal) -> Result<String, Error> {
    let legend = legend(figure);
    let width = LEFTS[2] + WIDTH + 18.0;
    let mut sheet = Sheet::new(width, TOP + HEIGHT + 52.0 + strip_height(&legend, width - 20.0));
    let drawn = figure.studies.get(figure.drawn);
    let look = Type {
        size: style::LABEL_SIZE,
        colour: style::GREY,
        ..PLAIN
    };
    let whose = format!(
        "ship: {}, sea: {}, *ε*_{{1}} = {} {}, {}",
        figure.ship,
        figure.spectrum,
        drawn.map_or("–".to_owned(), |study| short(study.epsilon_1)),
        style::EPSILON_UNIT,
        counted(figure.fields, "field")
    );
    sheet.text(
        LEFTS[0],
        18.0,
        look,
        &shorten(&whose, look.size, width - LEFTS[0] - 16.0),
    );
    let x = threshold_axis(drawn);
    let decades = |label: &str| Axis::decades(-5, 0, label);
    let panels = [
        ("(a)", "by groups", decades("*P*(*r* > *θ*_{t})")),
        ("(b)", "by time", decades("share of time |*θ*| > *θ*_{t}")),
        ("(c)", "thick: groups, thin: time", ratio_axis(drawn, figure.reference)?),
    ];
    for ((letter, title, y), left) in panels.into_iter().zip(LEFTS) {
        let panel = Panel {
            left,
            top: TOP,
            width: WIDTH,
            height: HEIGHT,
            x: x.clone(),
            y,
        };
        panel.frame(&mut sheet)?;
        panel.title(&mut sheet, letter, title);
        let Some(study) = drawn else { continue };
        match letter {
            "(a)" => lines(&mut sheet, &panel, study, |detection| &detection.by_groups)?,
            "(b)" => {
                lines(&mut sheet, &panel, study, |detection| &detection.within_groups)?;
                panel.dots(&mut sheet, &points(&study.by_time)?, style::DOT, style::BLACK)?;
            }
            _ => {
                for (look, points) in compared(study, figure.reference)? {
                    panel.line(&mut sheet, &points, look)?;
                }
            }
        }
    }
    strip(&mut sheet, width / 2.0, TOP + HEIGHT + 44.0, width - 20.0, &legend)?;
    let what = format!(
        "Ship: {}. Sea: {}. (a) Share of groups whose largest roll exceeds the threshold, for several similarity thresholds of \
         the detection. (b) Black dots: share of time with absolute roll above the threshold, which knows no groups; lines: \
         the part of it that lies within the detected groups. (c) Thick: the shares of (a) over that of the reference \
         detection; thin: the lines of (b) over the dots.",
        figure.ship, figure.spectrum
    );
    Ok(sheet.finish("Figure 7: probability by groups and by time", &what))
}

/// The similarity thresholds, and the dots.
fn legend(figure: &Temporal) -> Vec<Entry> {
    let mut entries = vec![Entry {
        sample: Sample::Dot(style::BLACK),
        name: "by time, whole roll".to_owned(),
    }];
    let studied = figure
        .studies
        .first()
        .map_or(&[] as &[Detection], |study| &study.detections);
    for (i, detection) in studied.iter().enumerate() {
        let reference = if figure.reference == Some(i) {
            " (reference)"
        } else {
            ""
        };
        entries.push(Entry {
            sample: Sample::Line(look(i)),
            name: format!("*C*_{{thr}} = {}{reference}", short(detection.similarity_threshold)),
        });
    }
    entries
}

fn look(place: usize) -> Stroke {
    let (colour, dash) = LOOKS[place % LOOKS.len()];
    Stroke {
        colour,
        width: style::LINE,
        dash,
    }
}

/// Thresholds from zero to the largest of all.
fn threshold_axis(study: Option<&Study>) -> Axis {
    let all = study.iter().flat_map(|study| &study.by_time.theta_t);
    Axis::thresholds(all.copied())
}

/// Ratios from the fifth below the smallest to the fifth above the largest, four at most.
fn ratio_axis(study: Option<&Study>, reference: Option<usize>) -> Result<Axis, Error> {
    let (mut low, mut high) = (0.8, 1.2);
    if let Some(study) = study {
        for (_, points) in compared(study, reference)? {
            for (_, ratio) in points {
                low = if ratio < low { ratio } else { low };
                high = if ratio > high { ratio } else { high };
            }
        }
    }
    let high = if high < 4.0 { high } else { 4.0 };
    Ok(Axis::linear(
        (5.0 * low).floor() / 5.0,
        (5.0 * high).ceil() / 5.0,
        7,
        "relative to the reference",
    ))
}

/// One line per similarity threshold.
fn lines(sheet: &mut Sheet, panel: &Panel, study: &Study, of: impl Fn(&Detection) -> &Line) -> Result<(), Error> {
    for (i, detection) in study.detections.iter().enumerate() {
        panel.line(sheet, &points(of(detection))?, look(i))?;
    }
    Ok(())
}

/// A line with its look.
type Drawn = (Stroke, Vec<(f64, f64)>);

/// Each similarity threshold's share of groups over that of the reference, and its share of time over that of the roll; with
/// the look of each.
fn compared(study: &Study, reference: Option<usize>) -> Result<Vec<Drawn>, Error> {
    let mut found = Vec::new();
    let reference = reference.and_then(|place| study.detections.get(place));
    for (i, detection) in study.detections.iter().enumerate() {
        if let Some(reference) = reference {
            found.push((look(i), ratio(&detection.by_groups, &reference.by_groups)?));
        }
        let thin = Stroke {
            width: style::FINE_LINE,
            ..look(i)
        };
        found.push((thin, ratio(&detection.within_groups, &study.by_time)?));
    }
    Ok(found)
}

/// A line over another, where the other is known to a quarter of its value.
fn ratio(line: &Line, reference: &Line) -> Result<Vec<(f64, f64)>, Error> {
    same_length("probability", reference.theta_t.len(), line.probability.len())?;
    let known = reference.probability.iter().zip(&reference.standard_error);
    let points = points(line)?.into_iter().zip(known);
    Ok(points
        .filter(|(_, (p, error))| **p >= 1.0 || (**error > 0.0 && **error < 0.25 * **p))
        .map(|((theta_t, p), (reference, _))| (theta_t, p / reference))
        .collect())
}

/// The points (theta_t, P).
fn points(line: &Line) -> Result<Vec<(f64, f64)>, Error> {
    same_length("probability", line.theta_t.len(), line.probability.len())?;
    same_length("standard_error", line.theta_t.len(), line.standard_error.len())?;
    Ok(line
        .theta_t
        .iter()
        .copied()
        .zip(line.probability.iter().copied())
        .collect())
}

/// A standard error, if there is one that tells anything.
fn known(errors: &[f64], place: usize) -> Option<f64> {
    errors.get(place).copied().filter(|error| *error > 0.0)
}

/// The data of Figure 7. Rows without a similarity threshold: the whole record. The others: the studied fields, with the
/// share of groups, the share of time, and the part of it within groups.
///
/// # Errors
/// Arrays that do not belong together.
pub fn csv(figure: &Temporal) -> Result<String, Error> {
    let header = [
        "ship",
        "spectrum",
        "epsilon_1",
        "theta_t",
        "fields",
        "temporal_probability",
        "temporal_standard_error",
        "similarity_threshold",
        "group_probability",
        "group_standard_error",
        "temporal_within_groups",
    ];
    let mut rows: Vec<[Cell; 11]> = Vec::new();
    for whole in &figure.wholes {
        for (k, (theta_t, p)) in points(&whole.by_time)?.into_iter().enumerate() {
            rows.push([
                figure.ship.as_str().into(),
                whole.spectrum.as_str().into(),
                whole.epsilon_1.into(),
                theta_t.into(),
                whole.fields.into(),
                p.into(),
                known(&whole.by_time.standard_error, k).into(),
                Cell::Unknown,
                Cell::Unknown,
                Cell::Unknown,
                Cell::Unknown,
            ]);
        }
    }
    for study in &figure.studies {
        let time = points(&study.by_time)?;
        for detection in &study.detections {
            for (k, (theta_t, p)) in time.iter().enumerate() {
                // Without groups there is no share of them.
                let of = |values: &[f64]| values.get(k).copied();
                rows.push([
                    figure.ship.as_str().into(),
                    figure.spectrum.as_str().into(),
                    study.epsilon_1.into(),
                    (*theta_t).into(),
                    figure.fields.into(),
                    (*p).into(),
                    known(&study.by_time.standard_error, k).into(),
                    detection.similarity_threshold.into(),
                    of(&detection.by_groups.probability).into(),
                    known(&detection.by_groups.standard_error, k).into(),
                    of(&detection.within_groups.probability).into(),
                ]);
            }
        }
    }
    Ok(csv::write(header, rows))
}
