//! Table 1: VHGP-Seq against random sampling, ours beside the paper's and beside three more methods; as SVG, Markdown,
//! LaTeX and CSV.
//!
//! | paper | code | unit | meaning |
//! |---|---|---|---|
//! | P_true | `p_true` | 1 | group exceeding probability of the long record |
//! | mean (std) | `mean`, `std` | 1 | over the realisations; shown with std in % of the mean |
//!
//! The digits of every form are chosen in `probability` and `estimate`; the CSV has them all. Tested in
//! `tests/plots/table.rs`.

use std::fmt::Write;

use super::clip::Point;
use super::csv;
use super::shapes::{Stroke, paths};
use super::svg::{Anchor, PLAIN, Sheet, Type, shorten};
use super::table_errors::errors;
use super::{Error, style};
use crate::text::count::counted;
use crate::text::escape::{markdown_cell, tex};
use crate::text::number::{short, short_decimal};

/// Mean and standard deviation over the realisations.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    /// Mean.
    pub mean: f64,
    /// Population standard deviation, in units of the mean; none if the realisations have no spread: if there is but one, or if
    /// all of them are equal.
    pub std: Option<f64>,
}

/// What no unbiased estimate goes below: standard deviations from one sample relative to P_true; divide by √n.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Floor {
    /// Optimal importance sampling.
    pub importance: f64,
    /// A smooth model of mean and variance (Cramer-Rao).
    pub model: f64,
}

/// A row of the paper's own Table 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Printed {
    /// P_true.
    pub p_true: f64,
    /// Mean of VHGP-Seq.
    pub sequential_mean: f64,
    /// Its standard deviation, % of the mean.
    pub sequential_std_percent: f64,
    /// Mean of random sampling.
    pub random_mean: f64,
    /// Its standard deviation, % of the mean.
    pub random_std_percent: f64,
}

/// One row: a sea. What is not known is none.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// Name of the sea.
    pub spectrum: String,
    /// Threshold, rad.
    pub theta_t: f64,
    /// P_true.
    pub p_true: Option<f64>,
    /// Its standard error; none if nothing tells it, as where no group exceeds.
    pub p_true_se: Option<f64>,
    /// Groups behind it.
    pub p_true_groups: u64,
    /// The most samples, up to those of the table, that every realisation of every method reached.
    pub reached: u64,
    /// VHGP-Seq.
    pub sequential: Option<Estimate>,
    /// Random sampling.
    pub random: Option<Estimate>,
    /// The design that looks ahead.
    pub best: Option<Estimate>,
    /// The design that looks ahead, the linear response its control.
    pub control: Option<Estimate>,
    /// The surrogate on a Latin hypercube.
    pub lhs: Option<Estimate>,
    /// What no unbiased estimate over (L, A) goes below.
    pub floor: Option<Floor>,
    /// The same of methods that see the control in place of L.
    pub control_floor: Option<Floor>,
    /// The paper's row for the sea, if it has one at this threshold.
    pub paper: Option<Printed>,
}

/// Table 1 of one ship.
#[derive(Clone, Debug, PartialEq)]
pub struct Table {
    /// Name of the ship.
    pub ship: String,
    /// Parametric excitation, 1/(m s²); none if no sea tells it.
    pub epsilon_1: Option<f64>,
    /// Samples behind each estimate.
    pub samples: u64,
    /// Realisations behind mean and standard deviation.
    pub realisations: u64,
    /// The seas.
    pub rows: Vec<Row>,
}

/// What stands where nothing is known.
pub(super) const NOTHING: &str = "–";

/// A probability with the table's digits.
fn probability(p: Option<f64>) -> String {
    match p.filter(|p| p.is_finite()) {
        None => NOTHING.to_owned(),
        // Four decimals of it would say that there is none.
        Some(p) if p > 0.0 && p < 5e-5 => short(round(p)),
        Some(p) => format!("{p:.4}"),
    }
}

/// A probability and its standard error; where none of its groups exceeds, the bound that n of them give.
fn with_error(row: &Row) -> String {
    match (row.p_true, row.p_true_se.filter(|error| error.is_finite())) {
        (Some(_), Some(error)) => format!("{} ± {error:.4}", probability(row.p_true)),
        (Some(p), None) if p <= 0.0 && row.p_true_groups > 0 => below(row.p_true_groups as f64),
        (p, _) => probability(p),
    }
}

/// The bound with 95 % of a probability of which n groups showed no exceedance.
fn below(n: f64) -> String {
    format!("< {}", short(round(3.0 / n)))
}

/// A number with two significant digits.
fn round(value: f64) -> f64 {
    format!("{value:.1e}").parse().unwrap_or(value)
}

/// A mean with its standard deviation in per cent of it.
fn estimate(mean: f64, std_percent: f64) -> String {
    if std_percent.is_finite() {
        format!("{} ({std_percent:.0} %)", probability(Some(mean)))
    } else {
        probability(Some(mean))
    }
}

/// Our estimate, if there is one; without a standard deviation if the realisations have none.
fn ours(known: Option<Estimate>) -> String {
    known.map_or(NOTHING.to_owned(), |known| {
        let std = known.std.unwrap_or(f64::NAN);
        estimate(known.mean, 100.0 * std / known.mean)
    })
}

/// Our estimate by random sampling, whose samples may have seen nothing.
fn ours_at_random(row: &Row, table: &Table) -> String {
    match row.random {
        Some(random) if random.mean <= 0.0 => below((table.samples * table.realisations) as f64),
        known => ours(known),
    }
}

/// The eleven cells of a row as they stand in every form.
fn cells(row: &Row, table: &Table) -> [String; 11] {
    let paper = |cell: fn(&Printed) -> String| row.paper.as_ref().map_or(NOTHING.to_owned(), cell);
    [
        row.spectrum.clone(),
        short_decimal(row.theta_t),
        with_error(row),
        paper(|printed| probability(Some(printed.p_true))),
        ours(row.sequential),
        paper(|printed| estimate(printed.sequential_mean, printed.sequential_std_percent)),
        ours(row.best),
        ours(row.control),
        ours(row.lhs),
        ours_at_random(row, table),
        paper(|printed| estimate(printed.random_mean, printed.random_std_percent)),
    ]
}

/// What the table is of: its parametric excitation, and how the estimates came about.
fn what(table: &Table, unit: &str, epsilon_1: &str) -> String {
    let value = table.epsilon_1.map_or(NOTHING.to_owned(), short);
    let realisations = counted(table.realisations, "realisation");
    let samples = counted(table.samples, "sample");
    format!(
        "{epsilon_1} = {value} {unit}; mean (standard deviation in % of the mean) of {realisations} with {samples} each"
    )
}

/// What the table leaves open, and why; empty if it leaves nothing open.
fn left_open(table: &Table) -> String {
    let mut words = String::new();
    if table.rows.is_empty() {
        words.push_str(" No data: no row of vhgp_seq.case names a sea of this run.");
    }
    if table.realisations == 1 {
        words.push_str(" One realisation has no standard deviation.");
    }
    let short_of = table.rows.iter().filter(|row| row.reached < table.samples);
    for row in short_of {
        let reached = counted(row.reached, "sample");
        let _ = write!(
            words,
            " {}: the estimates end at {reached}, since the sea has no more groups.",
            row.spectrum
        );
    }
    words
}

/// The sentence below the table.
fn caption(table: &Table) -> String {
    format!(
        "Ship {}, {}; P_true ± standard error. The rows share their random phases: they are correlated.{}",
        table.ship,
        what(table, "m⁻¹ s⁻²", "epsilon_1"),
        left_open(table)
    )
}

/// Right ends of the columns but the first, px; the first two are set from their left and middle.
const ENDS: [f64; 11] = [
    30.0, 112.0, 270.0, 340.0, 486.0, 604.0, 736.0, 866.0, 996.0, 1144.0, 1268.0,
];
/// Right end of the rules, px.
const EDGE: f64 = 1278.0;
/// Distance of rows, px.
const LEADING: f64 = 25.0;

/// Draws Table 1.
pub fn svg(table: &Table) -> Result<String, Error> {
    let head = 84.0;
    let foot = head + LEADING * table.rows.len() as f64;
    let mut sheet = Sheet::new(EDGE + 20.0, foot + 54.0);
    heads(&mut sheet)?;
    for (i, row) in table.rows.iter().enumerate() {
        let y = head + LEADING * (i as f64 + 0.66);
        for (j, text) in cells(row, table).iter().enumerate() {
            let colour = if matches!(j, 3 | 5 | 10) {
                style::GREY
            } else {
                style::BLACK
            };
            let look = Type {
                size: 12.0,
                bold: j == 0,
                colour,
                anchor: anchor(j),
                ..PLAIN
            };
            let text = if j == 0 {
                shorten(text, 1.1 * look.size, 48.0)
            } else {
                text.clone()
            };
            sheet.text(ENDS[j], y, look, &text);
        }
    }
    rule(&mut sheet, &[((20.0, foot + 4.0), EDGE)], 1.4)?;
    let look = Type {
        size: style::TICK_SIZE,
        colour: style::GREY,
        ..PLAIN
    };
    let first = format!(
        "Ship {}, {}; *P*_{{true}} ± standard error.{}",
        shorten(&table.ship, look.size, 150.0),
        what(table, style::EPSILON_UNIT, "*ε*_{1}"),
        left_open(table)
    );
    let first = shorten(&first, look.size, EDGE - 22.0);
    sheet.text(22.0, foot + 24.0, look, &first);
    sheet.text(
        22.0,
        foot + 39.0,
        look,
        "Grey: the paper's values. The rows share their random phases: they are correlated. Not in the paper: a design that looks \
         ahead, the same with a control, and VHGP-Seq's surrogate on a Latin hypercube.",
    );
    let what = format!(
        "{} Columns: sea, threshold in rad, and ours beside the paper's for the truth, VHGP-Seq and \
         random sampling; ours for the look-ahead design, the same with a control, and the Latin hypercube.",
        caption(table)
    );
    Ok(sheet.finish("Table 1: VHGP-Seq against random sampling", &what))
}

/// How a column is set.
fn anchor(column: usize) -> Anchor {
    if column == 0 { Anchor::Start } else { Anchor::End }
}

/// The two lines of heads and the rules around them.
fn heads(sheet: &mut Sheet) -> Result<(), Error> {
    let groups = [
        (2, 3, "*P*_{true}"),
        (4, 5, "VHGP-Seq"),
        (6, 6, "look-ahead"),
        (7, 7, "control"),
        (8, 8, "hypercube"),
        (9, 10, "random sampling"),
    ];
    let bold = Type {
        size: style::TITLE_SIZE,
        bold: true,
        anchor: Anchor::Middle,
        ..PLAIN
    };
    let mut rules = Vec::new();
    for (first, last, name) in groups {
        let (left, right) = (ENDS[first - 1] + 34.0, ENDS[last]);
        sheet.text(left + (right - left) / 2.0, 36.0, bold, name);
        rules.push(((left, 47.0), right));
    }
    let names = [
        "sea",
        "*θ*_{t} (rad)",
        "ours",
        "paper",
        "ours",
        "paper",
        "ours",
        "ours",
        "ours",
        "ours",
        "paper",
    ];
    for (j, name) in names.into_iter().enumerate() {
        let look = Type {
            size: style::LABEL_SIZE,
            anchor: anchor(j),
            ..PLAIN
        };
        sheet.text(ENDS[j], 66.0, look, name);
    }
    rule(sheet, &rules, 0.7)?;
    rule(sheet, &[((20.0, 14.0), EDGE)], 1.4)?;
    rule(sheet, &[((20.0, 78.0), EDGE)], 0.9)
}

/// Horizontal rules from a point to a right end.
fn rule(sheet: &mut Sheet, rules: &[(Point, f64)], width: f64) -> Result<(), Error> {
    let lines: Vec<Vec<Point>> = rules
        .iter()
        .map(|&((left, y), right)| vec![(left, y), (right, y)])
        .collect();
    paths(
        sheet,
        "",
        &lines,
        Stroke {
            colour: style::BLACK,
            width,
            dash: &[],
        },
    )
}

/// Writes Table 1 as Markdown.
pub fn markdown(table: &Table) -> String {
    let mut text = String::from(
        "| sea | θ_t (rad) | P_true | paper | VHGP-Seq: mean (std) | paper | look-ahead | control | hypercube | random: mean (std) | paper |\n\
         |---|---|---|---|---|---|---|---|---|---|---|\n",
    );
    for row in &table.rows {
        let line = cells(row, table).map(|cell| markdown_cell(&cell)).join(" | ");
        let _ = writeln!(text, "| {line} |");
    }
    format!("{text}\n{}\n\n{}", caption(table), errors(table))
}

/// Writes Table 1 as LaTeX (`booktabs`).
pub fn latex(table: &Table) -> String {
    let mut text = String::from(
        "\\begin{tabular}{lcccccccccc}\n\\toprule\n & & \\multicolumn{2}{c}{$P_{\\mathrm{true}}$} & \
         \\multicolumn{2}{c}{VHGP-Seq: mean (std)} & look-ahead & control & hypercube & \
         \\multicolumn{2}{c}{random: mean (std)} \\\\\n\
         \\cmidrule(lr){3-4}\\cmidrule(lr){5-6}\\cmidrule(lr){7-7}\\cmidrule(lr){8-8}\\cmidrule(lr){9-9}\\cmidrule(lr){10-11}\n\
         sea & $\\theta_t$ (rad) & ours & paper & ours & paper & ours & ours & ours & ours & paper \\\\\n\\midrule\n",
    );
    for row in &table.rows {
        let line = cells(row, table).map(|cell| tex(&cell)).join(" & ");
        let _ = writeln!(text, "{line} \\\\");
    }
    format!("{text}\\bottomrule\n\\end{{tabular}}\n% {}\n", caption(table))
}

/// Writes `table1.csv`, columns as in the contract of published files.
pub fn csv(table: &Table) -> String {
    let header = [
        "spectrum",
        "theta_t",
        "p_true",
        "p_true_se",
        "sequential_mean",
        "sequential_std",
        "random_mean",
        "random_std",
        "paper_p_true",
        "paper_sequential_mean",
        "paper_sequential_std_percent",
        "paper_random_mean",
        "paper_random_std_percent",
        "best_mean",
        "best_std",
        "lhs_mean",
        "lhs_std",
        "control_mean",
        "control_std",
    ];
    csv::write(
        header,
        table.rows.iter().map(|row| {
            [
                row.spectrum.as_str().into(),
                row.theta_t.into(),
                row.p_true.into(),
                row.p_true_se.into(),
                row.sequential.map(|known| known.mean).into(),
                row.sequential.and_then(|known| known.std).into(),
                row.random.map(|known| known.mean).into(),
                row.random.and_then(|known| known.std).into(),
                row.paper.map(|printed| printed.p_true).into(),
                row.paper.map(|printed| printed.sequential_mean).into(),
                row.paper.map(|printed| printed.sequential_std_percent).into(),
                row.paper.map(|printed| printed.random_mean).into(),
                row.paper.map(|printed| printed.random_std_percent).into(),
                row.best.map(|known| known.mean).into(),
                row.best.and_then(|known| known.std).into(),
                row.lhs.map(|known| known.mean).into(),
                row.lhs.and_then(|known| known.std).into(),
                row.control.map(|known| known.mean).into(),
                row.control.and_then(|known| known.std).into(),
            ]
        }),
    )
}
