//! Figure 2: the three ways to supply the initial condition, side by side.
//!
//! | paper | what differs |
//! |---|---|
//! | CIC | one group, upright and at rest: r(a,l), eq. (3) |
//! | PIC | one group, a state drawn from an ensemble simulated beforehand: R(a,l), eq. (4) |
//! | NIC | started a few groups ahead: R(a,l), eq. (4) |
//!
//! Tested in `tests/plots/figures.rs`.

use plotters::style::RGBColor;

use crate::numerics::elementary::{cos, exp};

use super::Error;
use super::clip::Point;
use super::csv;
use super::shapes::{Stroke, arrow, discs, paths, polygons, rounded};
use super::style::{self, Method};
use super::svg::{Anchor, PLAIN, Sheet, Type};

/// A lane of the chart: one method.
struct Lane {
    method: Method,
    name: &'static str,
    /// The texts of its four boxes, up to two lines each.
    boxes: [[String; 2]; 4],
}

/// Left borders of the lanes, px.
const LEFTS: [f64; 3] = [112.0, 394.0, 676.0];
/// Width of a lane, px.
const WIDTH: f64 = 266.0;
/// Upper border of the lanes, px.
const TOP: f64 = 104.0;
/// Upper borders and heights of a lane's boxes, px.
const BOXES: [(f64, f64); 4] = [(228.0, 44.0), (296.0, 44.0), (364.0, 34.0), (422.0, 36.0)];
/// Lower border of the lanes, px.
const BOTTOM: f64 = 470.0;

/// Draws Figure 2; NIC starts `groups_ahead` groups ahead.
pub fn draw(groups_ahead: u32) -> Result<String, Error> {
    let mut sheet = Sheet::new(960.0, 566.0);
    sources(&mut sheet)?;
    for (lane, left) in lanes(groups_ahead).iter().zip(LEFTS) {
        draw_lane(&mut sheet, lane, left)?;
    }
    rows(&mut sheet);
    comparison(&mut sheet)?;
    let what = format!(
        "Flowchart. The elevation gives the envelope, the envelope the Gaussian groups, the groups the joint density of \
         length and amplitude. CIC (green): one group, met upright and at rest, gives a deterministic response and \
         equation (3). PIC (orange): a part of the record is simulated beforehand, its states are the initial conditions \
         of one group, which give a random response and equation (4). NIC (blue): the ship starts {} ahead and meets the \
         group in the state the waves left it in, which gives a random response and equation (4). All are compared with \
         the truth, equation (1).",
        ahead(groups_ahead)
    );
    Ok(sheet.finish("Figure 2: the three methods CIC, PIC and NIC", &what))
}

/// "two groups" in words, digits above twelve.
fn ahead(groups: u32) -> String {
    const WORDS: [&str; 13] = [
        "no", "one", "two", "three", "four", "five", "six", "seven", "eight", "nine", "ten", "eleven", "twelve",
    ];
    let count = WORDS
        .get(groups as usize)
        .map_or_else(|| groups.to_string(), |word| (*word).to_owned());
    format!("{count} {}", if groups == 1 { "group" } else { "groups" })
}

/// The three methods and what stands in their boxes.
fn lanes(groups_ahead: u32) -> [Lane; 3] {
    let two = |first: &str, second: &str| [first.to_owned(), second.to_owned()];
    let alone = || {
        two(
            "roll equation (6) through the group",
            "*η*_{i} = *ρ*_{i} cos *ω*_{p} *t*\u{2002}(5)",
        )
    };
    let random = || two("random response *R*(*a*, *l*)", "");
    let integral = || two("*P*_{est} = ∬ ℙ(*R* > *θ*_{t}) *p*_{A,L} d*a* d*l*\u{2002}(4)", "");
    let start = format!("start at rest {} ahead:", ahead(groups_ahead));
    [
        Lane {
            method: Method::Cic,
            name: "CIC · constant initial condition",
            boxes: [
                two("upright and at rest", "*θ* = 0, d*θ*/d*t* = 0"),
                alone(),
                two("deterministic response *r*(*a*, *l*)", ""),
                two("*P*_{est} = ∬ *I*(*r* > *θ*_{t}) *p*_{A,L} d*a* d*l*\u{2002}(3)", ""),
            ],
        },
        Lane {
            method: Method::Pic,
            name: "PIC · pre-computed initial condition",
            boxes: [
                two(
                    "simulate a part of *η*(*t*), draw",
                    "(*θ*, d*θ*/d*t*) from its ensemble",
                ),
                alone(),
                random(),
                integral(),
            ],
        },
        Lane {
            method: Method::Nic,
            name: "NIC · natural initial condition",
            boxes: [
                two(&start, "the waves set the state"),
                two("roll equation (6) through the groups", "ahead and the group itself"),
                random(),
                integral(),
            ],
        },
    ]
}

/// The chain from elevation to density, and its branches to the lanes.
fn sources(sheet: &mut Sheet) -> Result<(), Error> {
    let (top, height) = (14.0, 46.0);
    let texts = [
        ["irregular sea", "elevation *η*(*t*)"],
        [
            "envelope *ρ*(*t*), fitted by",
            "Gaussian groups *ρ*_{i}(*t*)\u{2002}(2)",
        ],
        ["joint density *p*_{A,L}(*a*, *l*)", "of the groups, for (3) and (4)"],
    ];
    for (left, lines) in LEFTS.iter().zip(texts) {
        card(sheet, (left + 18.0, top), (WIDTH - 36.0, height), style::FRAME, &lines)?;
    }
    let y = top + height / 2.0;
    for left in [LEFTS[0], LEFTS[1]] {
        arrow(sheet, (left + WIDTH - 18.0, y), (left + WIDTH + 34.0, y), style::FRAME)?;
    }
    let bus = 82.0;
    let centres = LEFTS.map(|left| left + WIDTH / 2.0);
    let look = Stroke {
        colour: style::FRAME,
        width: 1.2,
        dash: &[],
    };
    let lines = [
        vec![(centres[1], top + height), (centres[1], bus)],
        vec![(centres[0], bus), (centres[2], bus)],
    ];
    paths(sheet, "stroke-linecap=\"square\"", &lines, look)?;
    for centre in centres {
        arrow(sheet, (centre, bus), (centre, TOP), style::FRAME)?;
    }
    Ok(())
}

/// One method from its waves to its probability.
fn draw_lane(sheet: &mut Sheet, lane: &Lane, left: f64) -> Result<(), Error> {
    let colour = lane.method.colour();
    let size = (WIDTH, BOTTOM - TOP);
    polygons(sheet, "", &[(rounded((left, TOP), size, 7.0), tint(colour, 0.09))])?;
    let head = rounded((left, TOP), (WIDTH, 26.0), 7.0);
    let square = vec![
        (left, TOP + 13.0),
        (left + WIDTH, TOP + 13.0),
        (left + WIDTH, TOP + 26.0),
        (left, TOP + 26.0),
    ];
    polygons(sheet, "", &[(head, colour), (square, colour)])?;
    let look = Type {
        size: style::LABEL_SIZE,
        bold: true,
        anchor: Anchor::Middle,
        colour: style::WHITE,
        ..PLAIN
    };
    sheet.text(left + WIDTH / 2.0, TOP + 17.5, look, lane.name);
    picture(sheet, lane.method, left + 16.0)?;
    for (i, ((top, height), lines)) in BOXES.iter().zip(&lane.boxes).enumerate() {
        let lines: Vec<&str> = lines
            .iter()
            .map(String::as_str)
            .filter(|line| !line.is_empty())
            .collect();
        card(sheet, (left + 14.0, *top), (WIDTH - 28.0, *height), colour, &lines)?;
        let from = if i == 0 { 212.0 } else { BOXES[i - 1].0 + BOXES[i - 1].1 };
        arrow(sheet, (left + WIDTH / 2.0, from), (left + WIDTH / 2.0, *top), colour)?;
    }
    Ok(())
}

/// What the rows of boxes are, in the left margin.
fn rows(sheet: &mut Sheet) {
    let look = Type {
        size: style::TICK_SIZE,
        anchor: Anchor::End,
        colour: style::GREY,
        ..PLAIN
    };
    let mut name = |y: f64, lines: [&str; 2]| {
        let first = if lines[1].is_empty() { y + 3.6 } else { y - 2.6 };
        sheet.text(100.0, first, look, lines[0]);
        sheet.text(100.0, y + 9.8, look, lines[1]);
    };
    name(37.0, ["shared", "input"]);
    name(171.0, ["waves met", "by the ship"]);
    let names = [
        ["initial", "condition"],
        ["simulation", ""],
        ["response", ""],
        ["probability", ""],
    ];
    for ((top, height), lines) in BOXES.iter().zip(names) {
        name(top + height / 2.0, lines);
    }
    name(529.0, ["test", ""]);
}

/// The truth below the lanes.
fn comparison(sheet: &mut Sheet) -> Result<(), Error> {
    let (top, height) = (510.0, 38.0);
    for (left, method) in LEFTS.iter().zip([Method::Cic, Method::Pic, Method::Nic]) {
        let centre = left + WIDTH / 2.0;
        arrow(sheet, (centre, BOTTOM), (centre, top), method.colour())?;
    }
    let whole = LEFTS[2] + WIDTH - LEFTS[0];
    let text =
        "compared with the truth *P*_{true} = (1/*n*) Σ *I*(*r*_{i} > *θ*_{t})\u{2002}(1), from one very long record";
    card(sheet, (LEFTS[0], top), (whole, height), style::BLACK, &[text])
}

/// A small picture of the waves a method uses; a dot marks where the ship starts.
fn picture(sheet: &mut Sheet, method: Method, left: f64) -> Result<(), Error> {
    let (width, middle) = (WIDTH - 32.0, 171.0);
    let zero = Stroke {
        colour: RGBColor(190, 190, 190),
        width: 0.7,
        dash: &[],
    };
    paths(sheet, "", &[vec![(left, middle), (left + width, middle)]], zero)?;
    let wave = |from: f64, to: f64, groups: &[(f64, f64, f64)]| -> Vec<Point> {
        let steps = (0..=240).map(|i| from + (to - from) * f64::from(i) / 240.0);
        steps
            .map(|x| (left + width * x, middle - 34.0 * elevation(x, groups)))
            .collect()
    };
    let strong = Stroke {
        colour: method.colour(),
        width: 1.5,
        dash: &[],
    };
    let faint = Stroke {
        colour: RGBColor(150, 150, 150),
        width: 1.1,
        dash: &[],
    };
    let (lines, starts): (Vec<(Vec<Point>, Stroke)>, Vec<Point>) = match method {
        Method::Pic => {
            let record = [
                (0.03, 0.05, 0.5),
                (0.16, 0.05, 0.75),
                (0.29, 0.04, 0.45),
                (0.37, 0.03, 0.35),
            ];
            let ensemble = [0.02, 0.07, 0.12, 0.18, 0.23, 0.28, 0.33, 0.38];
            let states = ensemble.map(|x| (left + width * x, middle - 34.0 * elevation(x, &record)));
            let starts = states.into_iter().chain([(left + width * 0.54, middle)]).collect();
            (
                vec![
                    (wave(0.0, 0.4, &record), faint),
                    (wave(0.54, 1.0, &[(0.77, 0.075, 1.0)]), strong),
                ],
                starts,
            )
        }
        Method::Nic => {
            let groups = [(0.17, 0.055, 0.62), (0.46, 0.07, 0.8), (0.8, 0.065, 1.0)];
            let lines = vec![(wave(0.0, 0.64, &groups), faint), (wave(0.64, 1.0, &groups), strong)];
            (lines, vec![(left + 1.5, middle)])
        }
        _ => (
            vec![(wave(0.25, 0.75, &[(0.5, 0.08, 1.0)]), strong)],
            vec![(left + width * 0.25, middle)],
        ),
    };
    for (line, look) in lines {
        paths(sheet, "stroke-linejoin=\"round\"", &[line], look)?;
    }
    if method == Method::Pic {
        arrow(
            sheet,
            (left + width * 0.43, middle - 16.0),
            (left + width * 0.54, middle - 16.0),
            method.colour(),
        )?;
    }
    discs(sheet, &starts, 2.6, method.colour())
}

/// A sum of wave groups (centre, length, amplitude), for the pictures.
fn elevation(x: f64, groups: &[(f64, f64, f64)]) -> f64 {
    let mut sum = 0.0;
    for &(centre, length, amplitude) in groups {
        let u = (x - centre) / length;
        sum += amplitude * exp(-0.5 * u * u) * cos(150.0 * (x - centre));
    }
    sum
}

/// A white box with a coloured border and centred lines of text.
fn card(sheet: &mut Sheet, corner: Point, size: Point, colour: RGBColor, lines: &[&str]) -> Result<(), Error> {
    let mut around = rounded(corner, size, 5.0);
    polygons(sheet, "", &[(around.clone(), style::WHITE)])?;
    around.extend(around.first().copied());
    paths(
        sheet,
        "stroke-linejoin=\"round\"",
        &[around],
        Stroke {
            colour,
            width: 1.3,
            dash: &[],
        },
    )?;
    let look = Type {
        size: style::LABEL_SIZE,
        anchor: Anchor::Middle,
        ..PLAIN
    };
    let leading = 15.0;
    let first = corner.1 + size.1 / 2.0 + 0.36 * look.size - leading * (lines.len() as f64 - 1.0) / 2.0;
    for (i, line) in lines.iter().enumerate() {
        sheet.text(corner.0 + size.0 / 2.0, first + leading * i as f64, look, line);
    }
    Ok(())
}

/// A colour thinned with white.
fn tint(RGBColor(r, g, b): RGBColor, share: f64) -> RGBColor {
    let mix = |c: u8| (255.0 - share * (255.0 - f64::from(c))).round() as u8;
    RGBColor(mix(r), mix(g), mix(b))
}

/// The chart as a table.
pub fn csv(groups_ahead: u32) -> String {
    let nic = format!("at rest {} ahead", ahead(groups_ahead));
    let rows: [[&str; 5]; 3] = [
        [
            "cic",
            "upright and at rest",
            "one group by (5)",
            "deterministic r(a;l)",
            "3",
        ],
        [
            "pic",
            "drawn from an ensemble simulated beforehand",
            "one group by (5)",
            "random R(a;l)",
            "4",
        ],
        ["nic", &nic, "the groups ahead and the group", "random R(a;l)", "4"],
    ];
    let rows = rows.map(|row| row.map(csv::Cell::from));
    csv::write(["method", "initial_condition", "waves", "response", "equation"], rows)
}
