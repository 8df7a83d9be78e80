//! Every claim of the paper as numbers of one ship, and what is expected of each.
//!
//! | claim | paper | here |
//! |---|---|---|
//! | F1 | P_true grows with epsilon_1 | `growth` |
//! | F2 | CIC far below P_true at large thresholds | `constant` |
//! | F3 | PIC overestimates at small epsilon_1, improves with it, mostly beats CIC | `precomputed` |
//! | F4, F5 | NIC is hardly told from P_true; reconstructed groups would do | `natural` |
//! | F6-F9, T1 | Figure 4, sampling, detection, Table 1 | `claims_sampling` |
//!
//! Tested in `tests/report/claims.rs`.

use crate::numerics::domain;
use serde::{Deserialize, Serialize};

use super::claims_sampling;
use super::evidence::{Evidence, Measured, Row, ratio};
use super::finding::{Claim, Expectation};
use crate::numerics::elementary::{ln, log10};

/// The `[findings]` table: what the paper's words are taken to mean.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Settings {
    /// Name of the ship with the coefficients as printed.
    pub printed: String,
    /// Share of its value within which a number of the paper counts as met.
    #[serde(deserialize_with = "domain::positive")]
    pub agreement: f64,
    /// "Far below": at most this share of P_true.
    #[serde(deserialize_with = "domain::positive")]
    pub far: f64,
    /// "Hardly distinguishable" on a logarithmic axis: at most so many decades apart.
    #[serde(deserialize_with = "domain::positive")]
    pub decades: f64,
    /// Thresholds count where P_true, and the ratio of an estimate to it, is known to this share of its value.
    #[serde(deserialize_with = "domain::positive")]
    pub known: f64,
    /// Realisations behind the paper's means and standard deviations in Table 1, at least 2.
    #[serde(deserialize_with = "domain::count")]
    pub realisations: u32,
}

impl Settings {
    /// A standard deviation is of two numbers at least.
    ///
    /// # Errors
    /// `key: expected .., found ..`.
    pub fn check(&self) -> Result<(), String> {
        if self.realisations >= 2 {
            return Ok(());
        }
        let found = self.realisations;
        Err(format!("realisations: expected at least 2, found {found}"))
    }
}

/// Every claim, with the numbers of one ship.
pub fn claims(evidence: &Evidence, settings: &Settings) -> Vec<Claim> {
    let mut all = growth(evidence);
    all.extend(constant(evidence, settings));
    all.extend(precomputed(evidence));
    all.extend(natural(evidence, settings));
    all.extend(claims_sampling::moments(evidence, settings));
    all.extend(claims_sampling::sampling(evidence, settings));
    all.extend(claims_sampling::detection(evidence, settings));
    all.extend(claims_sampling::table(evidence, settings));
    all
}

/// A claim with its number.
pub(super) fn claim(
    id: String,
    says: &str,
    quantity: &str,
    expectation: Expectation,
    measured: Option<Measured>,
) -> Claim {
    Claim {
        id,
        says: says.to_owned(),
        quantity: quantity.to_owned(),
        // A number that is not finite is none: it would pass for one in a table.
        measured: measured.filter(|measured| measured.value.is_finite()),
        expectation,
    }
}

/// P_est / P_true of a method at Table 1's threshold.
fn at_table(evidence: &Evidence, method: &str, sea: &str, epsilon_1: &str) -> Option<Measured> {
    let theta_t = evidence.theta_t(sea)?;
    let p = evidence.probability(method, sea, epsilon_1, theta_t)?;
    ratio(p, evidence.probability("truth", sea, epsilon_1, theta_t)?)
}

/// The distance of a ratio from 1 in decades, and its standard error.
fn decades(ratio: Measured) -> Measured {
    Measured {
        value: log10(ratio.value).abs(),
        standard_error: ratio.standard_error.map(|error| error / (ratio.value * ln(10.0))),
    }
}

/// The largest of some numbers.
pub(super) fn largest(numbers: impl Iterator<Item = Measured>) -> Option<Measured> {
    numbers.fold(None, |most, next| match most {
        Some(most) if most.value >= next.value => Some(most),
        _ => Some(next),
    })
}

/// The smallest of some numbers.
pub(super) fn smallest(numbers: impl Iterator<Item = Measured>) -> Option<Measured> {
    numbers.reduce(|least, next| if next.value < least.value { next } else { least })
}

/// F1.
fn growth(evidence: &Evidence) -> Vec<Claim> {
    let epsilons = evidence.epsilons();
    let per_sea = |sea: &&str| {
        let step = |pair: &[&str]| {
            let theta_t = evidence.theta_t(sea)?;
            let at = |epsilon_1: &str| evidence.probability("truth", sea, epsilon_1, theta_t);
            ratio(at(pair[1])?, at(pair[0])?)
        };
        claim(
            format!("F1-{sea}"),
            "P_true grows with epsilon_1",
            "smallest ratio of P_true from one epsilon_1 to the next, at Table 1's threshold",
            Expectation::Above(1.0),
            smallest(epsilons.windows(2).filter_map(step)),
        )
    };
    evidence.seas().iter().map(per_sea).collect()
}

/// F2.
fn constant(evidence: &Evidence, settings: &Settings) -> Vec<Claim> {
    let known = 100.0 * settings.known;
    let per_sea = |sea: &&str| {
        let at_last = |epsilon_1: &&str| {
            let theta_t = evidence.last_known(sea, epsilon_1, settings.known)?;
            let p = evidence.probability("cic", sea, epsilon_1, theta_t)?;
            ratio(p, evidence.probability("truth", sea, epsilon_1, theta_t)?)
        };
        claim(
            format!("F2-{sea}"),
            "CIC lies far below P_true at large thresholds",
            &format!(
                "largest P_CIC / P_true over epsilon_1, each at the last threshold where P_true is known to {known} %"
            ),
            Expectation::AtMost(settings.far),
            largest(evidence.epsilons().iter().filter_map(at_last)),
        )
    };
    evidence.seas().iter().map(per_sea).collect()
}

/// F3.
fn precomputed(evidence: &Evidence) -> Vec<Claim> {
    let (seas, epsilons) = (evidence.seas(), evidence.epsilons());
    let pic = |sea: &str, epsilon_1: Option<&&str>| at_table(evidence, "pic", sea, epsilon_1?);
    let over = |sea: &&str| {
        claim(
            format!("F3a-{sea}"),
            "PIC overestimates at small epsilon_1",
            "P_PIC / P_true at the smallest epsilon_1, at Table 1's threshold",
            Expectation::Above(1.0),
            pic(sea, epsilons.first()),
        )
    };
    let nearer = |sea: &&str| {
        claim(
            format!("F3b-{sea}"),
            "PIC improves with epsilon_1",
            "distance of PIC from P_true in decades at the largest epsilon_1 less that at the smallest, at Table 1's threshold",
            Expectation::Below(0.0),
            pic(sea, epsilons.last())
                .zip(pic(sea, epsilons.first()))
                .map(|(last, first)| difference(decades(last), decades(first))),
        )
    };
    let mut claims: Vec<Claim> = seas.iter().map(over).collect();
    claims.extend(seas.iter().map(nearer));
    claims.push(claim(
        "F3c".to_owned(),
        "PIC is better than CIC in most cases",
        "share of seas and epsilon_1 in which PIC is nearer to P_true, at Table 1's thresholds",
        Expectation::Above(0.5),
        share_of_better(evidence),
    ));
    claims
}

/// A difference of two numbers taken for independent.
pub(super) fn difference(a: Measured, b: Measured) -> Measured {
    let error = |known: Measured| known.standard_error.unwrap_or(0.0);
    let spread = error(a) * error(a) + error(b) * error(b);
    Measured {
        value: a.value - b.value,
        standard_error: Some(spread.sqrt()),
    }
}

/// The share of seas and epsilon_1 in which PIC is nearer to P_true than CIC.
fn share_of_better(evidence: &Evidence) -> Option<Measured> {
    let (mut better, mut all) = (0.0, 0.0);
    for sea in evidence.seas() {
        for epsilon_1 in evidence.epsilons() {
            let distance = |method: &str| at_table(evidence, method, sea, epsilon_1).map(decades);
            if let Some((pic, cic)) = distance("pic").zip(distance("cic")) {
                all += 1.0;
                better += if pic.value < cic.value { 1.0 } else { 0.0 };
            }
        }
    }
    (all > 0.0).then_some(Measured {
        value: better / all,
        standard_error: None,
    })
}

/// F4 and F5.
fn natural(evidence: &Evidence, settings: &Settings) -> Vec<Claim> {
    let furthest = |method: &str, sea: &str| {
        let rows = evidence
            .exceedance
            .rows()
            .filter(|row| row.word("method") == method && row.word("spectrum") == sea);
        let distance = |row: Row<'_>| {
            let p = row.measured("probability", "standard_error")?;
            let truth = evidence.probability("truth", sea, row.word("epsilon_1"), row.word("theta_t"))?;
            let known = |number: Measured| {
                number
                    .standard_error
                    .is_some_and(|error| error < settings.known * number.value)
            };
            if !known(truth) {
                return None;
            }
            // Nothing where the truth has something is as far as can be told: a decade below its standard error.
            if p.value > 0.0 {
                return ratio(p, truth).filter(|ratio| known(*ratio)).map(decades);
            }
            let value = 0.1 * truth.standard_error?;
            ratio(Measured { value, ..p }, truth).map(decades)
        };
        largest(rows.filter_map(distance))
    };
    let known = 100.0 * settings.known;
    let mut claims = Vec::new();
    for (id, method, says) in [
        (
            "F4",
            "nic",
            "NIC is hardly distinguishable from P_true; two groups ahead suffice for the initial condition",
        ),
        (
            "F5",
            "nic_groups",
            "lost phases and frequency modulation matter little: NIC from reconstructed groups would do",
        ),
    ] {
        for sea in evidence.seas() {
            claims.push(claim(
                format!("{id}-{sea}"),
                says,
                &format!(
                    "largest distance of NIC from P_true in decades, over epsilon_1 and the thresholds where their ratio is \
                     known to {known} %"
                ),
                Expectation::AtMost(settings.decades),
                furthest(method, sea),
            ));
        }
    }
    claims
}
