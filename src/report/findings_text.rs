//! The findings as text: `findings.md` with one line per claim and a table per claim below, `findings.csv` with a row per number.
//!
//! A number carries as many digits as its standard error allows: two of the error's if they are below 35, else one. Where no
//! group exceeded, it is written as `0, at most` its upper bound with 95 %. Tested in `tests/report/finding.rs`.

use std::fmt::Write;

use super::evidence::Measured;
use super::finding::{Expectation, Finding, Verdict};
use crate::plot::axes::fixed;
use crate::plot::csv::{self, Cell};
use crate::text::escape::markdown_cell;

/// A number and its standard error with the digits that the error allows; three digits where there is none. Where nothing was
/// counted, the upper bound.
pub fn written(measured: Option<Measured>) -> String {
    let Some(Measured {
        value,
        standard_error,
        is_bound,
    }) = measured
    else {
        return "–".to_owned();
    };
    if is_bound {
        let bound = value + 2.0 * standard_error.unwrap_or(0.0);
        return format!("0, at most {}", rounded(bound, exponent(bound) - 1));
    }
    if let Some(error) = standard_error.filter(|error| *error > 0.0) {
        let digits = i32::from(leading(error) < 3.5);
        let place = exponent(error) - digits;
        return format!("{} ± {}", rounded(value, place), rounded(error, place));
    }
    let text = rounded(value, exponent(value) - 2);
    let trimmed = text.trim_end_matches('0').trim_end_matches('.');
    if text.contains('.') { trimmed } else { &text }.to_owned()
}

/// The power of ten of a number's first digit; 0 for 0.
fn exponent(value: f64) -> i32 {
    let (mut size, mut power) = (value.abs(), 0);
    while size >= 10.0 && power < 15 {
        size /= 10.0;
        power += 1;
    }
    while size < 1.0 && size > 0.0 && power > -15 {
        size *= 10.0;
        power -= 1;
    }
    power
}

/// A number by its first digit: 2.5 of 0.025.
fn leading(value: f64) -> f64 {
    value.abs() / ten_to(exponent(value))
}

/// 10^n by multiplication.
fn ten_to(n: i32) -> f64 {
    let size = (0..n.abs()).fold(1.0, |product, _| product * 10.0);
    if n < 0 { 1.0 / size } else { size }
}

/// A number rounded to a power of ten.
fn rounded(value: f64, place: i32) -> String {
    if place > 0 {
        let unit = ten_to(place);
        return fixed((value / unit).round() * unit, 0);
    }
    fixed(value, place.unsigned_abs() as usize)
}

/// The two ships that the claims are put to.
#[derive(Clone, Copy, Debug)]
pub struct Ships<'a> {
    /// The ship with the coefficients as printed.
    pub printed: &'a str,
    /// Whether it was run.
    pub printed_was_run: bool,
    /// The first other ship of the run; none if there is no other.
    pub reading: Option<&'a str>,
    /// Further ships of the run, which the findings leave out.
    pub left_out: &'a [String],
}

impl Ships<'_> {
    /// What stands at the head of the reading's columns.
    fn reading(&self) -> &str {
        self.reading.unwrap_or("other")
    }

    /// What the tables cannot say because a ship has no data, or no column; empty if both have.
    fn missing(&self) -> String {
        let mut text = String::new();
        if !self.printed_was_run {
            let _ = writeln!(
                text,
                "No data: *{}* is not among the ships of this run. Every verdict rests on the other ship alone.\n",
                self.printed
            );
        }
        if self.reading.is_none() {
            text.push_str("No data: this run has no ship but the printed one. Every verdict rests on it alone.\n\n");
        }
        if !self.left_out.is_empty() {
            let names: Vec<String> = self.left_out.iter().map(|name| format!("*{name}*")).collect();
            let _ = writeln!(text, "Not compared: {}, further ships of this run.\n", names.join(", "));
        }
        text
    }
}

/// `findings.md`: how many numbers have which verdict, a line per claim, and a table of numbers per claim.
pub fn markdown(findings: &[Finding], ships: &Ships<'_>) -> String {
    let (printed, reading) = (ships.printed, ships.reading());
    let mut text = String::from("# Findings against the paper\n\n");
    text.push_str(&ships.missing());
    let _ = writeln!(
        text,
        "Each claim of the paper as a number, for *{printed}*, the ship with the coefficients as printed, and for *{reading}*, a \
         labelled reading that is not the authors'. ± is one standard error. A number *holds* an expectation of more or less \
         (>, <) if it is on that side by more than two standard errors, a bound (at most) if it keeps it, and one of agreement \
         (within) if it is in the range, widened by two of the paper's own standard errors; it *fails* if it misses by more than \
         two standard errors, and leaves the claim *open* in between. The seas share their random phases. Of a \
         reading chosen for Table 1's P_true and Figure 3's order, as *calibrated* is, F1, F2 and T1a say that such a ship exists: \
         they are no test of the paper. Computed from \
         fig3_exceedance.csv, fig4_response_moments.csv, fig7_temporal.csv and table1.csv of each ship; numbers by verdict:\n"
    );
    for verdict in Verdict::ALL {
        let count = findings.iter().filter(|finding| finding.verdict == verdict).count();
        if count > 0 {
            let _ = writeln!(text, "- {}: {count}", verdict.words(reading));
        }
    }
    let groups: Vec<&[Finding]> = findings.chunk_by(|a, b| a.claim.stem() == b.claim.stem()).collect();
    text.push_str("\n| | the paper says | verdict |\n|---|---|---|\n");
    for group in &groups {
        let claim = &group[0].claim;
        line(&mut text, &[claim.stem(), &claim.says, &verdicts(group, reading)]);
    }
    text.push_str("\n## The numbers\n");
    for group in groups {
        numbers(&mut text, group, printed, reading);
    }
    text
}

/// One line of a table.
fn line(text: &mut String, cells: &[&str]) {
    let cells: Vec<String> = cells.iter().map(|cell| markdown_cell(cell)).collect();
    let _ = writeln!(text, "| {} |", cells.join(" | "));
}

/// The verdict of a claim: one if its cases agree, else each with its cases.
fn verdicts(group: &[Finding], reading: &str) -> String {
    let with = |verdict: Verdict| {
        let cases: Vec<&str> = group
            .iter()
            .filter(|finding| finding.verdict == verdict)
            .map(|finding| finding.claim.case())
            .collect();
        (!cases.is_empty()).then(|| (verdict.words(reading), cases.join(", ")))
    };
    let found: Vec<(String, String)> = Verdict::ALL.into_iter().filter_map(with).collect();
    match found.as_slice() {
        [(words, _)] => words.clone(),
        several => {
            let each: Vec<String> = several
                .iter()
                .map(|(words, cases)| format!("{cases}: {words}"))
                .collect();
            each.join("; ")
        }
    }
}

/// The numbers of one claim.
fn numbers(text: &mut String, group: &[Finding], printed: &str, reading: &str) {
    let claim = &group[0].claim;
    let _ = writeln!(
        text,
        "\n### {}: {}\n\n{}.\n",
        claim.stem(),
        claim.says,
        capital(&claim.quantity)
    );
    line(text, &["case", "expected", printed, reading, "verdict"]);
    text.push_str("|---|---|---|---|---|\n");
    for finding in group {
        let claim = &finding.claim;
        let case = if claim.case().is_empty() { "all" } else { claim.case() };
        let cells = [
            claim.expectation.words(),
            judged(claim.expectation, claim.measured),
            judged(claim.expectation, finding.reading),
            finding.verdict.words(reading),
        ];
        line(text, &[case, &cells[0], &cells[1], &cells[2], &cells[3]]);
    }
}

/// A number and what it says.
fn judged(expectation: Expectation, measured: Option<Measured>) -> String {
    let says = |measured: Measured| format!("{}, {}", written(Some(measured)), expectation.outcome(measured).word());
    measured.map_or_else(|| written(None), says)
}

/// A sentence's first letter made large.
fn capital(words: &str) -> String {
    let mut letters = words.chars();
    letters
        .next()
        .map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect())
}

/// `findings.csv`.
pub fn table(findings: &[Finding], ships: &Ships<'_>) -> String {
    let reading = ships.reading();
    let header = [
        "id",
        "paper_says",
        "quantity",
        "expected",
        "printed",
        "printed_standard_error",
        "printed_outcome",
        "reading",
        "reading_standard_error",
        "reading_outcome",
        "verdict",
    ];
    let value = |measured: Option<Measured>| Cell::from(measured.map(|measured| measured.value));
    // A bound is no standard error.
    let error = |measured: Option<Measured>| {
        let counted = measured.filter(|measured| !measured.is_bound);
        Cell::from(counted.and_then(|measured| measured.standard_error))
    };
    csv::write(
        header,
        findings.iter().map(|finding| {
            let claim = &finding.claim;
            let outcome = |measured: Option<Measured>| {
                Cell::from(measured.map_or("", |measured| claim.expectation.outcome(measured).word()))
            };
            [
                claim.id.as_str().into(),
                claim.says.as_str().into(),
                claim.quantity.as_str().into(),
                claim.expectation.words().as_str().into(),
                value(claim.measured),
                error(claim.measured),
                outcome(claim.measured),
                value(finding.reading),
                error(finding.reading),
                outcome(finding.reading),
                finding.verdict.words(reading).as_str().into(),
            ]
        }),
    )
}
