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
use super::evidence::{Curve, Detection, Evidence, Measured, Moment, ratio};
use super::finding::{Claim, Expectation};
use crate::plot::style::Method;
use crate::plot::table::{Estimate, Printed, Row};

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
            Method::Cic,
            Which::Furthest,
            near,
            none,
        ),
        (
            "F6b",
            "PIC overestimates mean and spread of R(a, l) at small epsilon_1",
            Method::Pic,
            Which::SmallestAtFirst,
            above,
            above,
        ),
        (
            "F6c",
            "PIC has mean and spread of R(a, l) at large epsilon_1",
            Method::Pic,
            Which::FurthestAtLast,
            near,
            near,
        ),
        (
            "F6d",
            "NIC has mean and spread of R(a, l)",
            Method::Nic,
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
            method.label()
        );
        for (case, of, expectation) in [("mean", Of::Mean, of_mean), ("spread", Of::Spread, of_spread)] {
            let measured = moment(evidence, method, of, which);
            claims.push(claim(format!("{id}-{case}"), says, &quantity, expectation, measured));
        }
    }
    claims
}

/// Near the paper's value.
fn near(wanted: f64, share: f64, error: f64) -> Expectation {
    Expectation::Near { wanted, share, error }
}

/// Which moment a claim is about.
#[derive(Clone, Copy, PartialEq)]
enum Of {
    /// The mean.
    Mean,
    /// The standard deviation.
    Spread,
}

/// The ratio of a method's moment to the truth's that a claim is about.
fn moment(evidence: &Evidence, method: Method, of: Of, which: Which) -> Option<Measured> {
    let last = evidence.epsilons.len().checked_sub(1)?;
    let is_wanted = |epsilon_1: usize| match which {
        Which::Furthest => true,
        Which::FurthestAtLast => epsilon_1 == last,
        Which::SmallestAtFirst => epsilon_1 == 0,
    };
    let over_truth = |((_, group, epsilon_1), truth): (&(Method, usize, usize), &Moment)| {
        let own = evidence.moments.get(&(method, *group, *epsilon_1))?;
        ratio(of_groups(method, own, of)?, of_groups(Method::Truth, truth, of)?)
    };
    let truths = evidence
        .moments
        .iter()
        .filter(|((method, _, epsilon_1), _)| *method == Method::Truth && is_wanted(*epsilon_1));
    let ratios = truths.filter_map(over_truth);
    if which == Which::SmallestAtFirst {
        return smallest(ratios);
    }
    let away = |number: &Measured| (number.value - 1.0).abs();
    ratios.reduce(|most, next| if away(&next) > away(&most) { next } else { most })
}

/// A moment with its standard error, that of normal numbers for a standard deviation; none of fewer responses than it takes.
fn of_groups(method: Method, moment: &Moment, of: Of) -> Option<Measured> {
    // CIC starts every run from the same state: one response is all that it has, without an error.
    let least = if method == Method::Cic { 1 } else { 2 };
    let (value, halved) = match of {
        Of::Mean => (moment.mean, 1.0),
        Of::Spread => (moment.std, 2.0),
    };
    (moment.n >= least).then(|| Measured::with_error(value, moment.std / (halved * moment.n as f64).sqrt()))
}

/// The relative error of a method in a row of Table 1: its mean's distance from P_true and its root mean square, in P_true;
/// none if the realisations have no spread.
fn errors(row: &Row, method: Option<Estimate>, n: f64) -> Option<(Measured, Measured)> {
    let p = row.p_true.filter(|p| *p > 0.0)?;
    let Estimate { mean, std } = method?;
    let (bias, std) = (mean / p - 1.0, std? / p);
    let square = bias * bias + std * std;
    // Variances of a mean and of a variance of n normal numbers.
    let spread = (4.0 * bias * bias * std * std + 2.0 * std * std * std * std) / n;
    let distance = Measured::with_error(bias.abs(), std / n.sqrt());
    Some((distance, Measured::with_error(square, spread.sqrt())))
}

/// A number in other units.
fn times(factor: f64, number: Measured) -> Measured {
    Measured {
        value: factor * number.value,
        standard_error: number.standard_error.map(|error| factor * error),
        ..number
    }
}

/// F7 and F8: VHGP-Seq against random sampling.
pub(super) fn sampling(evidence: &Evidence, settings: &Settings) -> Vec<Claim> {
    let n = evidence.realisations as f64;
    let (mut needed, mut closer, mut narrower) = (Vec::new(), Vec::new(), Vec::new());
    for row in &evidence.table {
        let sea = &row.spectrum;
        let (sequential, random) = (errors(row, row.sequential, n), errors(row, row.random, n));
        let as_good = sequential
            .zip(row.p_true)
            .and_then(|((_, square), p)| ratio(Measured::exact((1.0 - p) / p), square));
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
        let spreads = of_mean(row.sequential, n).zip(of_mean(row.random, n));
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
fn of_mean(method: Option<Estimate>, n: f64) -> Option<Measured> {
    let Estimate { mean, std } = method?;
    let value = 100.0 * std? / mean;
    Some(Measured::with_error(value, value / (2.0 * (n - 1.0)).sqrt()))
}

/// F9: the probability by groups under several detections.
pub(super) fn detection(evidence: &Evidence, settings: &Settings) -> Vec<Claim> {
    let middle = evidence.epsilons.len() / 2;
    let study = evidence.study.as_ref();
    let at = |of: fn(&Detection) -> &Vec<Curve>| -> Option<Vec<Measured>> {
        let study = study?;
        let theta_t = evidence.theta_t(&study.sea)?;
        let curves = study
            .detections
            .iter()
            .filter_map(|detection| of(detection).get(middle));
        Some(curves.filter_map(|curve| curve.at(theta_t)).collect())
    };
    let range = |numbers: Option<Vec<Measured>>| {
        // One detection has nothing to be compared with.
        let numbers = numbers.filter(|numbers| numbers.len() > 1)?;
        let all = || numbers.iter().copied();
        ratio(largest(all())?, smallest(all())?)
    };
    let by_groups = range(at(|detection| &detection.by_groups));
    let by_time = range(at(|detection| &detection.within_groups));
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

/// The mean of random sampling over the realisations; where no sample of any exceeded, its bound.
fn random_mean(evidence: &Evidence, row: &Row) -> Option<Measured> {
    let none_seen = Measured::none_among((evidence.samples * evidence.realisations) as f64);
    let is_none = row.random.is_some_and(|random| random.mean <= 0.0);
    if is_none {
        return Some(none_seen);
    }
    mean(evidence, row.random)
}

/// The mean of a method over the realisations with its standard error; none if they have no spread.
fn mean(evidence: &Evidence, method: Option<Estimate>) -> Option<Measured> {
    let Estimate { mean, std } = method?;
    let n = evidence.realisations as f64;
    Some(Measured::with_error(mean, std? / n.sqrt()))
}

/// What of a method's columns in Table 1 is compared with the paper's.
struct Columns {
    /// Names of the two claims, about the mean and the standard deviation.
    ids: [&'static str; 2],
    /// What the two numbers are.
    what: [&'static str; 2],
    /// Our estimate.
    ours: fn(&Row) -> Option<Estimate>,
    /// Our mean with its standard error.
    mean: fn(&Evidence, &Row) -> Option<Measured>,
    /// The paper's mean, and its standard deviation in % of it.
    paper: fn(&Printed) -> [f64; 2],
}

/// The columns of both methods.
const COLUMNS: [Columns; 2] = [
    Columns {
        ids: ["T1b", "T1c"],
        what: ["mean of VHGP-Seq", "standard deviation of VHGP-Seq, % of the mean"],
        ours: |row| row.sequential,
        mean: |evidence, row| mean(evidence, row.sequential),
        paper: |printed| [printed.sequential_mean, printed.sequential_std_percent],
    },
    Columns {
        ids: ["T1d", "T1e"],
        what: [
            "mean of random sampling",
            "standard deviation of random sampling, % of the mean",
        ],
        ours: |row| row.random,
        mean: random_mean,
        paper: |printed| [printed.random_mean, printed.random_std_percent],
    },
];

/// The numbers of Table 1.
pub(super) fn table(evidence: &Evidence, settings: &Settings) -> Vec<Claim> {
    let n = evidence.realisations as f64;
    let mut claims = Vec::new();
    for row in &evidence.table {
        if let Some(printed) = row.paper {
            claims.push(claim(
                format!("T1a-{}", row.spectrum),
                "Table 1's P_true",
                "P_true",
                near(printed.p_true, settings.agreement, 0.0),
                Measured::share(
                    row.p_true.unwrap_or(f64::NAN),
                    row.p_true_se.unwrap_or(0.0),
                    row.p_true_groups,
                ),
            ));
        }
    }
    for columns in &COLUMNS {
        claims.extend(means(evidence, settings, columns));
        claims.extend(spreads(evidence, settings, columns));
    }
    claims.extend(evidence.table.iter().map(|row| {
        claim(
            format!("T1f-{}", row.spectrum),
            "the means of VHGP-Seq agree with P_true to 0.4 - 8 %",
            "distance of VHGP-Seq's mean from P_true, %",
            Expectation::AtMost(8.0),
            errors(row, row.sequential, n).map(|(distance, _)| times(100.0, distance)),
        )
    }));
    claims
}

/// The means of a method beside the paper's.
fn means(evidence: &Evidence, settings: &Settings, columns: &Columns) -> Vec<Claim> {
    let theirs = f64::from(settings.realisations);
    let of = |row: &Row| {
        let [wanted, percent] = row.paper.as_ref().map(columns.paper)?;
        let [id, what] = [columns.ids[0], columns.what[0]];
        Some(claim(
            format!("{id}-{}", row.spectrum),
            &format!("Table 1's {what}"),
            what,
            near(wanted, settings.agreement, wanted * percent / 100.0 / theirs.sqrt()),
            (columns.mean)(evidence, row),
        ))
    };
    evidence.table.iter().filter_map(of).collect()
}

/// The standard deviations of a method beside the paper's.
fn spreads(evidence: &Evidence, settings: &Settings, columns: &Columns) -> Vec<Claim> {
    let (n, theirs) = (evidence.realisations as f64, f64::from(settings.realisations));
    let of = |row: &Row| {
        let [_, percent] = row.paper.as_ref().map(columns.paper)?;
        let [id, what] = [columns.ids[1], columns.what[1]];
        Some(claim(
            format!("{id}-{}", row.spectrum),
            &format!("Table 1's {what}"),
            what,
            near(percent, settings.agreement, percent / (2.0 * (theirs - 1.0)).sqrt()),
            of_mean((columns.ours)(row), n),
        ))
    };
    evidence.table.iter().filter_map(of).collect()
}
