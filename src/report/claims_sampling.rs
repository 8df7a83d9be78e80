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

use super::claims::{Settings, claim, largest};
use super::evidence::{Evidence, Measured, Row, ratio};
use super::finding::{Claim, Expectation};

/// F6: mean and spread of R(a, l) by each method over those of the truth.
pub(super) fn moments(evidence: &Evidence, settings: &Settings) -> Vec<Claim> {
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

/// F7 and F8: VHGP-Seq against random sampling.
pub(super) fn sampling(evidence: &Evidence) -> Vec<Claim> {
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

/// F9: the probability by groups under several detections.
pub(super) fn detection(evidence: &Evidence, settings: &Settings) -> Vec<Claim> {
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
pub(super) fn table(evidence: &Evidence, settings: &Settings) -> Vec<Claim> {
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
