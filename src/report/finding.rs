//! The verdict on a claim: what is expected of a number, what two ships' numbers say to it, and which verdict that makes.
//!
//! | expected | holds | fails |
//! |---|---|---|
//! | above, below a bound | on its side by more than two standard errors | on the other side by more than two |
//! | at most a bound | at most the bound | above it by more than two |
//! | near the paper's value | within a share of it and two of the paper's own errors | outside, by more than two of both |
//!
//! Between the two a number is open: it cannot be told. Where no group exceeded, the number is 0 and two standard errors are its
//! upper bound with 95 %; such a number is at most a bound only if its upper bound is. Tested in `tests/report/finding.rs`.

use std::collections::BTreeMap;

use super::evidence::Measured;
use super::findings_text::written;

/// What is expected of a number.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Expectation {
    /// Above a bound.
    Above(f64),
    /// Below a bound.
    Below(f64),
    /// At most a bound.
    AtMost(f64),
    /// The paper's value, give or take a share of it and two of its standard errors.
    Near {
        /// The paper's value.
        wanted: f64,
        /// The share of it that does not count as a difference.
        share: f64,
        /// Its own standard error; 0 if it has none to speak of.
        error: f64,
    },
}

/// What a number says to an expectation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// The expectation is met.
    Holds,
    /// It is missed, by more than two standard errors.
    Fails,
    /// Two standard errors leave it open.
    Open,
}

impl Outcome {
    /// The outcome in a word.
    pub fn word(self) -> &'static str {
        match self {
            Self::Holds => "holds",
            Self::Fails => "fails",
            Self::Open => "open",
        }
    }
}

impl Expectation {
    /// What a number says.
    pub fn outcome(self, measured: Measured) -> Outcome {
        let Measured {
            value,
            standard_error,
            is_bound,
        } = measured;
        let error = standard_error.unwrap_or(0.0);
        let slack = 2.0 * error;
        let of = |holds: bool, open: bool| match (holds, open) {
            (true, _) => Outcome::Holds,
            (false, true) => Outcome::Open,
            (false, false) => Outcome::Fails,
        };
        match self {
            Self::Above(bound) => of(value - slack > bound, value + slack > bound),
            Self::Below(bound) => of(value + slack < bound, value - slack < bound),
            // Where nothing was counted, 0 is no measured value: all that it may be has to keep the bound.
            Self::AtMost(bound) if is_bound => of(value + slack <= bound, true),
            Self::AtMost(bound) => of(value <= bound, value - slack <= bound),
            Self::Near {
                wanted,
                share,
                error: theirs,
            } => {
                let both = (error * error + theirs * theirs).sqrt();
                let (miss, range) = ((value - wanted).abs(), share * wanted.abs());
                of(miss <= range + 2.0 * theirs, miss <= range + 2.0 * both)
            }
        }
    }

    /// The expectation in words.
    pub fn words(self) -> String {
        match self {
            Self::Above(bound) => format!("> {bound}"),
            Self::Below(bound) => format!("< {bound}"),
            Self::AtMost(bound) => format!("at most {bound}"),
            Self::Near { wanted, share, error } => {
                let wanted = Measured {
                    standard_error: (error > 0.0).then_some(error),
                    ..Measured::exact(wanted)
                };
                format!("{} within {} %", written(Some(wanted)), (1000.0 * share).round() / 10.0)
            }
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

impl Claim {
    /// The claim without its case: `F2` of `F2-S1`.
    pub fn stem(&self) -> &str {
        self.id.split_once('-').map_or(&self.id, |(stem, _)| stem)
    }

    /// The case: `S1` of `F2-S1`; empty where there is but one.
    pub fn case(&self) -> &str {
        self.id.split_once('-').map_or("", |(_, case)| case)
    }
}

/// What is to be said of a claim.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// It holds for both readings of the coefficients, or for the one that has a number.
    Reproduced,
    /// The coefficients as printed hold it, the other reading does not.
    AsPrinted,
    /// The other reading of the coefficients holds it, the printed ones do not.
    UnderReading,
    /// Neither holds it, and one leaves it open.
    Undecided,
    /// Neither holds it.
    NotReproduced,
    /// Neither has a number.
    Unknown,
}

impl Verdict {
    /// Every verdict, in the order of tables.
    pub const ALL: [Verdict; 6] = [
        Self::Reproduced,
        Self::UnderReading,
        Self::AsPrinted,
        Self::Undecided,
        Self::NotReproduced,
        Self::Unknown,
    ];

    /// The verdict of what the printed coefficients and the other reading say.
    pub fn of(expectation: Expectation, printed: Option<Measured>, reading: Option<Measured>) -> Self {
        use Outcome::{Holds, Open};
        let outcome = |measured: Option<Measured>| measured.map(|measured| expectation.outcome(measured));
        match (outcome(printed), outcome(reading)) {
            (Some(Holds), Some(Holds) | None) => Self::Reproduced,
            (Some(Holds), _) => Self::AsPrinted,
            (_, Some(Holds)) => Self::UnderReading,
            (None, None) => Self::Unknown,
            (Some(Open), _) | (_, Some(Open)) => Self::Undecided,
            _ => Self::NotReproduced,
        }
    }

    /// The verdict in words; `reading` names the other ship.
    pub fn words(self, reading: &str) -> String {
        match self {
            Self::Reproduced => "reproduced".to_owned(),
            Self::AsPrinted => "reproduced as printed only".to_owned(),
            Self::UnderReading => format!("reproduced under the {reading} reading"),
            Self::Undecided => "undecided".to_owned(),
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
    let by_id = |claims: &[Claim]| -> BTreeMap<String, Option<Measured>> {
        let numbers = claims.iter().map(|claim| (claim.id.clone(), claim.measured));
        numbers.collect()
    };
    let (in_printed, in_reading) = (by_id(printed), by_id(reading));
    let own = |numbers: &BTreeMap<String, Option<Measured>>, id: &str| numbers.get(id).copied().flatten();
    let only_there = reading.iter().filter(|claim| !in_printed.contains_key(&claim.id));
    let all = printed.iter().chain(only_there);
    all.map(|claim| {
        let (of_printed, of_reading) = (own(&in_printed, &claim.id), own(&in_reading, &claim.id));
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
