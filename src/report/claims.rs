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
    pub agreement: f64,
    /// "Far below": at most this share of P_true.
    pub far: f64,
    /// "Hardly distinguishable" on a logarithmic axis: at most so many decades apart.
    pub decades: f64,
    /// Thresholds count where P_true is known to this share of its value.
    pub known: f64,
}

/// Every claim, with the numbers of one ship.
pub fn claims(evidence: &Evidence, settings: &Settings) -> Vec<Claim> {
    let mut all = growth(evidence);
    all.extend(constant(evidence, settings));
    all.extend(precomputed(evidence));
    all.extend(natural(evidence, settings));
    all.extend(claims_sampling::moments(evidence, settings));
    all.extend(claims_sampling::sampling(evidence));
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

/// F1.
fn growth(evidence: &Evidence) -> Vec<Claim> {
    let epsilons = evidence.epsilons();
    let per_sea = |sea: &&str| {
        let grown = || {
            let (first, last) = (epsilons.first()?, epsilons.last()?);
            let theta_t = evidence.theta_t(sea)?;
            let at = |epsilon_1: &str| evidence.probability("truth", sea, epsilon_1, theta_t);
            ratio(at(last)?, at(first)?)
        };
        claim(
            format!("F1-{sea}"),
            "P_true grows with epsilon_1",
            "P_true at the largest epsilon_1 over that at 0, at Table 1's threshold",
            Expectation::Above(1.0),
            grown(),
        )
    };
    evidence.seas().iter().map(per_sea).collect()
}

/// F2.
fn constant(evidence: &Evidence, settings: &Settings) -> Vec<Claim> {
    let per_sea = |sea: &&str| {
        let at_last = |epsilon_1: &&str| {
            let theta_t = evidence.last_known(sea, epsilon_1, settings.known)?;
            let p = evidence.probability("cic", sea, epsilon_1, theta_t)?;
            ratio(p, evidence.probability("truth", sea, epsilon_1, theta_t)?)
        };
        claim(
            format!("F2-{sea}"),
            "CIC lies far below P_true at large thresholds",
            "largest P_CIC / P_true over epsilon_1, each at the last threshold where P_true is known",
            Expectation::AtMost(settings.far),
            largest(evidence.epsilons().iter().filter_map(at_last)),
        )
    };
    evidence.seas().iter().map(per_sea).collect()
}

/// F3.
fn precomputed(evidence: &Evidence) -> Vec<Claim> {
    let epsilons = evidence.epsilons();
    let pic = |sea: &str, epsilon_1: Option<&&str>| at_table(evidence, "pic", sea, epsilon_1?);
    let mut claims = Vec::new();
    for sea in evidence.seas() {
        let (first, last) = (pic(sea, epsilons.first()), pic(sea, epsilons.last()));
        claims.push(claim(
            format!("F3a-{sea}"),
            "PIC overestimates at small epsilon_1",
            "P_PIC / P_true at the smallest epsilon_1, at Table 1's threshold",
            Expectation::Above(1.0),
            first,
        ));
        let nearer = first.zip(last).map(|(first, last)| {
            let (first, last) = (decades(first), decades(last));
            let error = |known: Measured| known.standard_error.unwrap_or(0.0);
            let spread = error(first) * error(first) + error(last) * error(last);
            Measured {
                value: first.value - last.value,
                standard_error: Some(spread.sqrt()),
            }
        });
        claims.push(claim(
            format!("F3b-{sea}"),
            "PIC improves with epsilon_1",
            "decades by which PIC comes nearer to P_true from the smallest epsilon_1 to the largest",
            Expectation::Above(0.0),
            nearer,
        ));
    }
    let (mut better, mut all) = (0.0, 0.0);
    for sea in evidence.seas() {
        for epsilon_1 in &epsilons {
            let methods = [
                at_table(evidence, "pic", sea, epsilon_1),
                at_table(evidence, "cic", sea, epsilon_1),
            ];
            if let [Some(pic), Some(cic)] = methods {
                all += 1.0;
                better += if decades(pic).value < decades(cic).value {
                    1.0
                } else {
                    0.0
                };
            }
        }
    }
    claims.push(claim(
        "F3c".to_owned(),
        "PIC is better than CIC in most cases",
        "share of seas and epsilon_1 in which PIC is nearer to P_true, at Table 1's thresholds",
        Expectation::Above(0.5),
        (all > 0.0).then_some(Measured {
            value: better / all,
            standard_error: None,
        }),
    ));
    claims
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
            let known = truth
                .standard_error
                .is_some_and(|error| error < settings.known * truth.value);
            // Nothing where the truth has something is as far as can be told: a decade below its standard error.
            let p = if p.value > 0.0 {
                p
            } else {
                Measured {
                    value: 0.1 * truth.standard_error?,
                    ..p
                }
            };
            known.then(|| ratio(p, truth)).flatten().map(decades)
        };
        largest(rows.filter_map(distance))
    };
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
                "largest distance of NIC from P_true, decades, over epsilon_1 and the thresholds where P_true is known",
                Expectation::AtMost(settings.decades),
                furthest(method, sea),
            ));
        }
    }
    claims
}
