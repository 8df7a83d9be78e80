//! Every claim of the paper as numbers of one ship, and what is expected of each.
//!
//! | claim | paper | here |
//! |---|---|---|
//! | F1 | P_true grows with epsilon_1 | `growth` |
//! | F2 | CIC far below P_true at large thresholds | `constant` |
//! | F3 | PIC overestimates at small epsilon_1, improves with it, mostly beats CIC | `precomputed` |
//! | F4, F5 | NIC is hardly told from P_true; reconstructed groups would do | `natural` |
//! | F6 | mean and spread of R(a, l), Figure 4 | `moments` |
//! | F7, F8 | VHGP-Seq against random sampling | `sampling` |
//! | F9 | the detection decides the probability by groups | `detection` |
//! | T1 | the numbers of Table 1 | `table` |
//!
//! Tested in `tests/report/claims.rs`.

use serde::{Deserialize, Serialize};

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
    all.extend(moments(evidence, settings));
    all.extend(sampling(evidence));
    all.extend(detection(evidence, settings));
    all.extend(table(evidence, settings));
    all
}

fn claim(id: String, says: &str, quantity: &str, expectation: Expectation, measured: Option<Measured>) -> Claim {
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
fn largest(numbers: impl Iterator<Item = Measured>) -> Option<Measured> {
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

/// F6.
fn moments(evidence: &Evidence, settings: &Settings) -> Vec<Claim> {
    let epsilons = evidence.moments.words("epsilon_1");
    // A moment of a method over that of the truth, the mean over the groups of Figure 4.
    let over_truth = |column: &str, method: &str, epsilon_1: Option<&&str>| {
        let epsilon_1 = *epsilon_1?;
        let (mut sum, mut n) = (0.0, 0.0);
        for truth in evidence.moments.with(&[("method", "truth"), ("epsilon_1", epsilon_1)]) {
            let same = |row: &Row<'_>| {
                ["l_over_tp", "a_over_hs"]
                    .iter()
                    .all(|key| row.word(key) == truth.word(key))
            };
            let own = evidence
                .moments
                .rows()
                .find(|row| row.word("method") == method && row.word("epsilon_1") == epsilon_1 && same(row));
            let (own, truth) = (own?.number(column)?, truth.number(column)?);
            sum += own / truth;
            n += 1.0;
        }
        (n > 0.0).then(|| Measured {
            value: sum / n,
            standard_error: None,
        })
    };
    let (first, last) = (epsilons.first(), epsilons.last());
    let near = Expectation::Near(1.0, settings.agreement);
    let rows = [
        ("F6a", "CIC catches the mean of R(a, l)", "mean", "cic", last, near),
        ("F6b", "CIC has no spread", "std", "cic", last, Expectation::AtMost(0.0)),
        (
            "F6c",
            "PIC overestimates the mean at small epsilon_1",
            "mean",
            "pic",
            first,
            Expectation::Above(1.0),
        ),
        (
            "F6d",
            "PIC overestimates the spread at small epsilon_1",
            "std",
            "pic",
            first,
            Expectation::Above(1.0),
        ),
        ("F6e", "PIC has the mean at large epsilon_1", "mean", "pic", last, near),
        ("F6f", "PIC has the spread at large epsilon_1", "std", "pic", last, near),
        ("F6g", "NIC has the mean", "mean", "nic", last, near),
        ("F6h", "NIC has the spread", "std", "nic", last, near),
    ];
    let row =
        |(id, says, column, method, epsilon_1, expectation): (&str, &str, &str, &str, Option<&&str>, Expectation)| {
            let name = if column == "mean" {
                "mean of R"
            } else {
                "standard deviation of R"
            };
            let which = if epsilon_1 == first { "smallest" } else { "largest" };
            let quantity = format!(
                "{name} by {} over that of the truth, mean over Figure 4's groups, {which} epsilon_1",
                method.to_uppercase()
            );
            claim(
                id.to_owned(),
                says,
                &quantity,
                expectation,
                over_truth(column, method, epsilon_1),
            )
        };
    rows.into_iter().map(row).collect()
}

/// F7 and F8.
fn sampling(evidence: &Evidence) -> Vec<Claim> {
    let mut claims = Vec::new();
    for row in evidence.table.rows() {
        let sea = row.word("spectrum");
        let spread = |column: &str, mean: &str| Some(row.number(column)? / row.number(mean)?);
        let sequential = spread("sequential_std", "sequential_mean");
        let random = spread("random_std", "random_mean");
        let needed = sequential
            .zip(row.number("p_true"))
            .map(|(sd, p)| (1.0 - p) / (p * sd * sd));
        let exact = |value: f64| Measured {
            value,
            standard_error: None,
        };
        claims.push(claim(
            format!("F7-{sea}"),
            "VHGP-Seq needs O(100) samples where random sampling needs more than O(1000)",
            "random samples that would be as precise as VHGP-Seq is with 120",
            Expectation::Above(1000.0),
            needed.map(exact),
        ));
        claims.push(claim(
            format!("F8-{sea}"),
            "the standard deviation of VHGP-Seq is much smaller than that of random sampling",
            "standard deviation of VHGP-Seq over that of random sampling, both relative to their means",
            Expectation::AtMost(0.5),
            sequential.zip(random).map(|(a, b)| exact(a / b)),
        ));
    }
    claims
}

/// F9.
fn detection(evidence: &Evidence, settings: &Settings) -> Vec<Claim> {
    let epsilons = evidence.epsilons();
    let studied = evidence
        .temporal
        .rows()
        .find(|row| !row.word("similarity_threshold").is_empty());
    let sea = studied.map_or("", |row| row.word("spectrum"));
    let changed = || {
        let theta_t = evidence.theta_t(sea)?;
        let wanted = [
            ("spectrum", sea),
            ("epsilon_1", *epsilons.get(epsilons.len() / 2)?),
            ("theta_t", theta_t),
        ];
        let rows = evidence
            .temporal
            .with(&wanted)
            .into_iter()
            .filter(|row| !row.word("similarity_threshold").is_empty());
        let p: Vec<Measured> = rows
            .filter_map(|row| row.measured("group_probability", "group_standard_error"))
            .collect();
        let most = largest(p.iter().copied())?;
        let least = p
            .into_iter()
            .reduce(|least, next| if next.value < least.value { next } else { least })?;
        ratio(most, least)
    };
    vec![claim(
        "F9".to_owned(),
        "the probability by groups depends on how many groups are detected",
        "largest over smallest P_true by groups over the similarity thresholds of Figure 7, at Table 1's threshold",
        Expectation::Above(1.0 + settings.agreement),
        changed(),
    )]
}

/// The numbers of Table 1.
fn table(evidence: &Evidence, settings: &Settings) -> Vec<Claim> {
    let mut claims = Vec::new();
    for row in evidence.table.rows() {
        let sea = row.word("spectrum");
        let n = evidence.realisations as f64;
        let mean_of = |mean: &str, std: &str| {
            Some(Measured {
                value: row.number(mean)?,
                standard_error: row.number(std).map(|std| std / n.sqrt()),
            })
        };
        let percent = |mean: &str, std: &str| {
            let value = 100.0 * row.number(std)? / row.number(mean)?;
            // That of a standard deviation of n normal numbers.
            Some(Measured {
                value,
                standard_error: (n > 1.0).then(|| value / (2.0 * (n - 1.0)).sqrt()),
            })
        };
        let numbers = [
            ("P_true", "paper_p_true", row.measured("p_true", "p_true_se")),
            (
                "mean of VHGP-Seq",
                "paper_sequential_mean",
                mean_of("sequential_mean", "sequential_std"),
            ),
            (
                "mean of random sampling",
                "paper_random_mean",
                mean_of("random_mean", "random_std"),
            ),
            (
                "standard deviation of VHGP-Seq, % of the mean",
                "paper_sequential_std_percent",
                percent("sequential_mean", "sequential_std"),
            ),
            (
                "standard deviation of random sampling, % of the mean",
                "paper_random_std_percent",
                percent("random_mean", "random_std"),
            ),
        ];
        for (i, (quantity, printed, measured)) in numbers.into_iter().enumerate() {
            if let Some(wanted) = row.number(printed) {
                claims.push(claim(
                    format!("T1{}-{sea}", char::from(b'a' + i as u8)),
                    &format!("Table 1: {wanted}"),
                    quantity,
                    Expectation::Near(wanted, settings.agreement),
                    measured,
                ));
            }
        }
        let away = row
            .number("sequential_mean")
            .zip(row.number("p_true"))
            .map(|(mean, p)| Measured {
                value: 100.0 * (mean / p - 1.0).abs(),
                standard_error: row.number("sequential_std").map(|std| 100.0 * std / (p * n.sqrt())),
            });
        claims.push(claim(
            format!("T1f-{sea}"),
            "the means of VHGP-Seq agree with P_true to 0.4 - 8 %",
            "distance of VHGP-Seq's mean from P_true, %",
            Expectation::AtMost(8.0),
            away,
        ));
    }
    claims
}
