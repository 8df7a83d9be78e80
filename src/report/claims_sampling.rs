//! The paper's claims about moments, sampling and detection, and the numbers of Table 1; see `claims`.
//!
//! | claim | paper | here |
//! |---|---|---|
//! | F6 | mean and spread of R(a, l), Figure 4 | `moments` |
//! | F7, F8 | VHGP-Seq against random sampling | `sampling` |
//! | F9 | the detection decides the probability by groups | `detection` |
//! | T1 | the numbers of Table 1 | `table` |
//!
//! Tested in `tests/report/claims.rs`.

use super::claims::{Settings, claim, difference, largest, smallest};
use super::evidence::{Evidence, Measured, Row, ratio};
use super::finding::{Claim, Expectation};

/// Which of a moment's ratios to the truth's, over the groups of Figure 4, is the number of a claim.
#[derive(Clone, Copy, PartialEq)]
enum Which {
    /// The one furthest from 1, over every epsilon_1.
    Furthest,
    /// The one furthest from 1 at the largest epsilon_1.
    FurthestAtLast,
    /// The smallest one at the smallest epsilon_1.
    SmallestAtFirst,
}

/// F6: mean and spread of R(a, l) by each method over those of the truth.
pub(super) fn moments(evidence: &Evidence, settings: &Settings) -> Vec<Claim> {
    let near = near(1.0, settings.agreement, 0.0);
    let (above, none) = (Expectation::Above(1.0), Expectation::AtMost(0.0));
    let rows = [
        (
            "F6a",
            "CIC catches the mean of R(a, l) and has no spread",
            "cic",
            Which::Furthest,
            near,
            none,
        ),
        (
            "F6b",
            "PIC overestimates mean and spread of R(a, l) at small epsilon_1",
            "pic",
            Which::SmallestAtFirst,
            above,
            above,
        ),
        (
            "F6c",
            "PIC has mean and spread of R(a, l) at large epsilon_1",
            "pic",
            Which::FurthestAtLast,
            near,
            near,
        ),
        (
            "F6d",
            "NIC has mean and spread of R(a, l)",
            "nic",
            Which::Furthest,
            near,
            near,
        ),
    ];
    let mut claims = Vec::new();
    for (id, says, method, which, of_mean, of_spread) in rows {
        let chosen = match which {
            Which::Furthest => "the one furthest from 1 over Figure 4's groups and epsilon_1",
            Which::FurthestAtLast => "the one furthest from 1 over Figure 4's groups, at the largest epsilon_1",
            Which::SmallestAtFirst => "the smallest over Figure 4's groups, at the smallest epsilon_1",
        };
        let quantity = format!(
            "mean and standard deviation of R by {} over those of the truth, {chosen}",
            method.to_uppercase()
        );
        for (case, column, expectation) in [("mean", "mean", of_mean), ("spread", "std", of_spread)] {
            let measured = moment(evidence, method, column, which);
            claims.push(claim(format!("{id}-{case}"), says, &quantity, expectation, measured));
        }
    }
    claims
}

/// Near the paper's value.
fn near(wanted: f64, share: f64, error: f64) -> Expectation {
    Expectation::Near { wanted, share, error }
}

/// The ratio of a method's moment to the truth's that a claim is about.
fn moment(evidence: &Evidence, method: &str, column: &str, which: Which) -> Option<Measured> {
    let epsilons = evidence.moments.words("epsilon_1");
    let wanted = match which {
        Which::Furthest => None,
        Which::FurthestAtLast => Some(*epsilons.last()?),
        Which::SmallestAtFirst => Some(*epsilons.first()?),
    };
    let same = |a: Row<'_>, b: Row<'_>| {
        ["epsilon_1", "l_over_tp", "a_over_hs"]
            .iter()
            .all(|key| a.word(key) == b.word(key))
    };
    let truths = evidence.moments.with(&[("method", "truth")]);
    let own = evidence.moments.with(&[("method", method)]);
    let over_truth = |truth: Row<'_>| {
        let own = own.iter().find(|row| same(**row, truth))?;
        ratio(of_groups(*own, column)?, of_groups(truth, column)?)
    };
    let ratios = truths
        .into_iter()
        .filter(|row| wanted.is_none_or(|epsilon_1| row.word("epsilon_1") == epsilon_1))
        .filter_map(over_truth);
    if which == Which::SmallestAtFirst {
        return smallest(ratios);
    }
    let away = |number: &Measured| (number.value - 1.0).abs();
    ratios.reduce(|most, next| if away(&next) > away(&most) { next } else { most })
}

/// A moment with its standard error, that of normal numbers for a standard deviation.
fn of_groups(row: Row<'_>, column: &str) -> Option<Measured> {
    let (n, std) = (row.number("n")?, row.number("std")?);
    let halved = if column == "mean" { 1.0 } else { 2.0 };
    Some(Measured {
        value: row.number(column)?,
        standard_error: (n > 0.0).then(|| std / (halved * n).sqrt()),
    })
}

/// The relative error of a method in a row of Table 1: its mean's distance from P_true and its root mean square, in P_true.
fn errors(row: Row<'_>, method: &str, n: f64) -> Option<(Measured, Measured)> {
    let p = row.number("p_true").filter(|p| *p > 0.0)?;
    let (mean, std) = (
        row.number(&format!("{method}_mean"))?,
        row.number(&format!("{method}_std"))?,
    );
    let (bias, std) = (mean / p - 1.0, std / p);
    let square = bias * bias + std * std;
    // Variances of a mean and of a variance of n normal numbers.
    let spread = (4.0 * bias * bias * std * std + 2.0 * std * std * std * std) / n;
    let distance = Measured {
        value: bias.abs(),
        standard_error: Some(std / n.sqrt()),
    };
    let square = Measured {
        value: square,
        standard_error: Some(spread.sqrt()),
    };
    Some((distance, square))
}

/// A number in other units.
fn times(factor: f64, number: Measured) -> Measured {
    Measured {
        value: factor * number.value,
        standard_error: number.standard_error.map(|error| factor * error),
    }
}

/// F7 and F8: VHGP-Seq against random sampling.
pub(super) fn sampling(evidence: &Evidence, settings: &Settings) -> Vec<Claim> {
    let n = evidence.realisations as f64;
    let (mut needed, mut closer, mut narrower) = (Vec::new(), Vec::new(), Vec::new());
    for row in evidence.table.rows() {
        let sea = row.word("spectrum");
        let (sequential, random) = (errors(row, "sequential", n), errors(row, "random", n));
        let as_good = sequential.zip(row.number("p_true")).and_then(|((_, square), p)| {
            let one = Measured {
                value: (1.0 - p) / p,
                standard_error: None,
            };
            ratio(one, square)
        });
        needed.push(claim(
            format!("F7-{sea}"),
            "VHGP-Seq needs O(100) samples where random sampling needs more than O(1000)",
            "random samples whose root-mean-square error is that of VHGP-Seq with Table 1's number of samples",
            Expectation::Above(1000.0),
            as_good,
        ));
        closer.push(claim(
            format!("F8a-{sea}"),
            "the means of VHGP-Seq lie closer to P_true than those of random sampling",
            "distance of VHGP-Seq's mean from P_true less that of random sampling's, % of P_true",
            Expectation::Below(0.0),
            sequential
                .zip(random)
                .map(|((ours, _), (theirs, _))| times(100.0, difference(ours, theirs))),
        ));
        let spreads = of_mean(row, "sequential", n).zip(of_mean(row, "random", n));
        narrower.push(claim(
            format!("F8b-{sea}"),
            "the standard deviation of VHGP-Seq is much smaller than that of random sampling",
            "standard deviation of VHGP-Seq over that of random sampling, both relative to their means",
            Expectation::AtMost(settings.far),
            spreads.and_then(|(ours, theirs)| ratio(ours, theirs)),
        ));
    }
    needed.extend(closer);
    needed.extend(narrower);
    needed
}

/// The standard deviation of a method in % of its mean, its standard error that of n normal numbers.
fn of_mean(row: Row<'_>, method: &str, n: f64) -> Option<Measured> {
    let value = 100.0 * row.number(&format!("{method}_std"))? / row.number(&format!("{method}_mean"))?;
    Some(Measured {
        value,
        standard_error: (n > 1.0).then(|| value / (2.0 * (n - 1.0)).sqrt()),
    })
}

/// F9: the probability by groups under several detections.
pub(super) fn detection(evidence: &Evidence, settings: &Settings) -> Vec<Claim> {
    let epsilons = evidence.epsilons();
    let studied = evidence
        .temporal
        .rows()
        .find(|row| !row.word("similarity_threshold").is_empty());
    let sea = studied.map_or("", |row| row.word("spectrum"));
    let studied = || -> Option<Vec<Row<'_>>> {
        let wanted = [
            ("spectrum", sea),
            ("epsilon_1", *epsilons.get(epsilons.len() / 2)?),
            ("theta_t", evidence.theta_t(sea)?),
        ];
        let mut rows = evidence.temporal.with(&wanted);
        rows.retain(|row| !row.word("similarity_threshold").is_empty());
        Some(rows)
    };
    let range = |column: &str, error: &str| {
        let rows = studied()?;
        let numbers = || rows.iter().filter_map(|row| row.measured(column, error));
        ratio(largest(numbers())?, smallest(numbers())?)
    };
    let by_groups = range("group_probability", "group_standard_error");
    let by_time = range("temporal_within_groups", "");
    vec![
        claim(
            "F9a".to_owned(),
            "the probability by groups depends on how many groups are detected",
            "largest over smallest P_true by groups over the similarity thresholds of Figure 7, at Table 1's threshold",
            Expectation::Above(1.0 + settings.agreement),
            by_groups,
        ),
        claim(
            "F9b".to_owned(),
            "the probability by time is the more robust one",
            "largest over smallest share of time within groups over the similarity thresholds of Figure 7, less that of F9a",
            Expectation::Below(0.0),
            by_time
                .zip(by_groups)
                .map(|(by_time, by_groups)| difference(by_time, by_groups)),
        ),
    ]
}

/// The numbers of Table 1.
pub(super) fn table(evidence: &Evidence, settings: &Settings) -> Vec<Claim> {
    let (n, theirs) = (evidence.realisations as f64, f64::from(settings.realisations));
    let mut claims = Vec::new();
    let rows: Vec<Row<'_>> = evidence.table.rows().collect();
    for row in &rows {
        if let Some(wanted) = row.number("paper_p_true") {
            claims.push(claim(
                format!("T1a-{}", row.word("spectrum")),
                "Table 1's P_true",
                "P_true",
                near(wanted, settings.agreement, 0.0),
                row.measured("p_true", "p_true_se"),
            ));
        }
    }
    let columns = [
        (
            "T1b",
            "T1c",
            "mean of VHGP-Seq",
            "standard deviation of VHGP-Seq, % of the mean",
            "sequential",
        ),
        (
            "T1d",
            "T1e",
            "mean of random sampling",
            "standard deviation of random sampling, % of the mean",
            "random",
        ),
    ];
    for (of_means, of_stds, mean, std, method) in columns {
        let wanted = |row: &Row<'_>| {
            let percent = row.number(&format!("paper_{method}_std_percent"))?;
            Some((row.number(&format!("paper_{method}_mean"))?, percent))
        };
        for row in &rows {
            let Some((wanted, percent)) = wanted(row) else { continue };
            let own = row.measured(&format!("{method}_mean"), &format!("{method}_std"));
            claims.push(claim(
                format!("{of_means}-{}", row.word("spectrum")),
                &format!("Table 1's {mean}"),
                mean,
                near(wanted, settings.agreement, wanted * percent / 100.0 / theirs.sqrt()),
                own.map(|own| Measured {
                    standard_error: own.standard_error.map(|std| std / n.sqrt()),
                    ..own
                }),
            ));
        }
        for row in &rows {
            let Some((_, percent)) = wanted(row) else { continue };
            claims.push(claim(
                format!("{of_stds}-{}", row.word("spectrum")),
                &format!("Table 1's {std}"),
                std,
                near(percent, settings.agreement, percent / (2.0 * (theirs - 1.0)).sqrt()),
                of_mean(*row, method, n),
            ));
        }
    }
    claims.extend(rows.iter().map(|row| {
        claim(
            format!("T1f-{}", row.word("spectrum")),
            "the means of VHGP-Seq agree with P_true to 0.4 - 8 %",
            "distance of VHGP-Seq's mean from P_true, %",
            Expectation::AtMost(8.0),
            errors(*row, "sequential", n).map(|(distance, _)| times(100.0, distance)),
        )
    }));
    claims
}
