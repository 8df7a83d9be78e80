//! The verdict on a claim: what is expected of a number, whether two ships' numbers hold it, and the tables that say so.
//!
//! A number holds an expectation unless it misses it by more than two of its standard errors; a range expected about the
//! paper's own value is as wide as `Settings::agreement` says. Tested in `tests/report/finding.rs`.

use std::fmt::Write;

use super::evidence::Measured;
use crate::plot::csv::{self, Cell};

/// What is expected of a number.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Expectation {
    /// Above a bound, by more than two standard errors.
    Above(f64),
    /// Below a bound, by more than two standard errors.
    Below(f64),
    /// At most a bound, within two standard errors.
    AtMost(f64),
    /// The paper's value, give or take a share of it and two standard errors.
    Near(f64, f64),
}

impl Expectation {
    /// Whether a number meets the expectation.
    pub fn holds(self, measured: Measured) -> bool {
        let Measured { value, standard_error } = measured;
        let slack = 2.0 * standard_error.unwrap_or(0.0);
        match self {
            Self::Above(bound) => value - slack > bound,
            Self::Below(bound) => value + slack < bound,
            Self::AtMost(bound) => value - slack <= bound,
            Self::Near(wanted, share) => (value - wanted).abs() <= share * wanted.abs() + slack,
        }
    }

    /// The expectation in words.
    pub fn words(self) -> String {
        match self {
            Self::Above(bound) => format!("> {bound}"),
            Self::Below(bound) => format!("< {bound}"),
            Self::AtMost(bound) => format!("at most {bound}"),
            Self::Near(wanted, share) => format!("{wanted} ± {} %", (1000.0 * share).round() / 10.0),
        }
    }
}

/// A claim, and what one ship says to it.
#[derive(Clone, Debug, PartialEq)]
pub struct Claim {
    /// Short name, such as `F2-S1`.
    pub id: String,
    /// What the paper says.
    pub says: String,
    /// What is measured.
    pub quantity: String,
    /// What is expected of it.
    pub expectation: Expectation,
    /// The number; none where it cannot be known.
    pub measured: Option<Measured>,
}

/// What is to be said of a claim.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// The coefficients as printed hold it.
    Reproduced,
    /// The other reading of the coefficients holds it, the printed ones do not.
    UnderReading,
    /// Neither holds it.
    NotReproduced,
    /// Neither has a number.
    Unknown,
}

impl Verdict {
    /// The verdict of what the printed coefficients and the other reading say.
    pub fn of(expectation: Expectation, printed: Option<Measured>, reading: Option<Measured>) -> Self {
        let holds = |measured: Option<Measured>| measured.map(|measured| expectation.holds(measured));
        match (holds(printed), holds(reading)) {
            (Some(true), _) => Self::Reproduced,
            (_, Some(true)) => Self::UnderReading,
            (None, None) => Self::Unknown,
            _ => Self::NotReproduced,
        }
    }

    /// The verdict in words; `reading` names the other ship.
    pub fn words(self, reading: &str) -> String {
        match self {
            Self::Reproduced => "reproduced".to_owned(),
            Self::UnderReading => format!("reproduced under the {reading} reading"),
            Self::NotReproduced => "not reproduced".to_owned(),
            Self::Unknown => "unknown".to_owned(),
        }
    }
}

/// A claim with both ships' numbers and the verdict.
#[derive(Clone, Debug, PartialEq)]
pub struct Finding {
    /// The claim; its number is that of the printed coefficients.
    pub claim: Claim,
    /// The number of the other reading.
    pub reading: Option<Measured>,
    /// The verdict.
    pub verdict: Verdict,
}

/// Every claim with its verdict, in the order in which the claims are first met.
pub fn findings(printed: &[Claim], reading: &[Claim]) -> Vec<Finding> {
    let own = |claims: &[Claim], id: &str| {
        claims
            .iter()
            .find(|claim| claim.id == id)
            .and_then(|claim| claim.measured)
    };
    let only_there = reading
        .iter()
        .filter(|claim| printed.iter().all(|known| known.id != claim.id));
    let all = printed.iter().chain(only_there);
    all.map(|claim| {
        let (of_printed, of_reading) = (own(printed, &claim.id), own(reading, &claim.id));
        Finding {
            claim: Claim {
                measured: of_printed,
                ..claim.clone()
            },
            reading: of_reading,
            verdict: Verdict::of(claim.expectation, of_printed, of_reading),
        }
    })
    .collect()
}

/// A number with three significant digits, and its standard error with as many decimals.
pub fn written(measured: Option<Measured>) -> String {
    let Some(Measured { value, standard_error }) = measured else {
        return "–".to_owned();
    };
    let decimals = decimals(value);
    match standard_error {
        Some(error) => format!("{value:.decimals$} ± {error:.decimals$}"),
        None => format!("{value:.decimals$}"),
    }
}

/// The decimals that leave three significant digits, at most five.
fn decimals(value: f64) -> usize {
    let mut size = value.abs();
    let mut decimals = 2;
    while size < 1.0 && decimals < 5 {
        size *= 10.0;
        decimals += 1;
    }
    if size >= 100.0 { 0 } else { decimals }
}

/// `findings.md`: a table, and how many claims have which verdict.
pub fn markdown(findings: &[Finding], printed: &str, reading: &str) -> String {
    let mut text = String::from("# Findings against the paper\n\n");
    let _ = writeln!(
        text,
        "Each claim of the paper as a number. *{printed}* is the ship with the coefficients as printed, *{reading}* a labelled \
         reading that is not the authors'. ± is one standard error. A claim holds unless the number misses what is expected \
         by more than two standard errors. Computed from fig3_exceedance.csv, fig4_response_moments.csv, fig7_temporal.csv \
         and table1.csv of each ship.\n"
    );
    for verdict in [
        Verdict::Reproduced,
        Verdict::UnderReading,
        Verdict::NotReproduced,
        Verdict::Unknown,
    ] {
        let count = findings.iter().filter(|finding| finding.verdict == verdict).count();
        let _ = writeln!(text, "- {}: {count}", verdict.words(reading));
    }
    let _ = writeln!(
        text,
        "\n| | the paper says | measured here | expected | {printed} | {reading} | verdict |"
    );
    text.push_str("|---|---|---|---|---|---|---|\n");
    for finding in findings {
        let claim = &finding.claim;
        let cells = [
            claim.id.clone(),
            claim.says.clone(),
            claim.quantity.clone(),
            claim.expectation.words(),
            written(claim.measured),
            written(finding.reading),
            finding.verdict.words(reading),
        ];
        let _ = writeln!(text, "| {} |", cells.map(|cell| cell.replace('|', "\\|")).join(" | "));
    }
    text
}

/// `findings.csv`.
pub fn table(findings: &[Finding], reading: &str) -> String {
    let header = [
        "id",
        "paper_says",
        "quantity",
        "expected",
        "printed",
        "printed_standard_error",
        "reading",
        "reading_standard_error",
        "verdict",
    ];
    let value = |measured: Option<Measured>| Cell::from(measured.map(|measured| measured.value));
    let error = |measured: Option<Measured>| Cell::from(measured.and_then(|measured| measured.standard_error));
    csv::write(
        header,
        findings.iter().map(|finding| {
            let claim = &finding.claim;
            [
                claim.id.as_str().into(),
                claim.says.as_str().into(),
                claim.quantity.as_str().into(),
                claim.expectation.words().as_str().into(),
                value(claim.measured),
                error(claim.measured),
                value(finding.reading),
                error(finding.reading),
                finding.verdict.words(reading).as_str().into(),
            ]
        }),
    )
}
