//! The calibration study as text: the sets checked, what they show of the paper's findings, and what the data identify.
//!
//! Tested in `tests/plots/calibration.rs`.

use std::fmt::Write;

use super::calibration::{InSea, RANKED, Search, Set, Study, symbol};
use super::csv::{self, Cell};
use super::table::NOTHING;
use crate::numerics::elementary::exp;
use crate::text::count::{counted, counted_as};
use crate::text::escape;

/// Place of Table 1's epsilon_1.
const TABLE: usize = 1;
/// NIC is close if it is within this share of the truth.
const CLOSE: f64 = 0.15;

/// A probability at Table 1's epsilon_1.
fn at(p: &[f64]) -> f64 {
    p.get(TABLE).copied().unwrap_or(f64::NAN)
}

/// In how many seas a finding holds, of those that tell; none told is no data.
fn share(set: &Set, holds: impl Fn(&InSea) -> Option<bool>) -> String {
    let told: Vec<bool> = set.seas.iter().filter_map(holds).collect();
    if told.is_empty() {
        return NO_DATA.to_owned();
    }
    format!("{}/{}", told.iter().filter(|holds| **holds).count(), told.len())
}

/// The misfit of a set; none if a sea tells nothing: no group was met, none exceeds, or all groups lie in one field.
fn misfit(set: &Set) -> Option<f64> {
    let is_told = |sea: &InSea| !sea.p_true.is_empty() && known_error(sea).is_some();
    let is_known = !set.seas.is_empty() && set.seas.iter().all(is_told);
    is_known.then_some(set.misfit)
}

/// What stands where nothing was measured.
const NO_DATA: &str = "no data";

/// Whether the methods have met any group, and the truth has seen any exceedance, so that they can be compared.
fn is_comparable(sea: &InSea) -> bool {
    sea.method_groups > 0 && at(&sea.p_true) > 0.0
}

/// P_true grows with epsilon_1.
fn grows(sea: &InSea) -> Option<bool> {
    (sea.p_true.len() > 1).then(|| sea.p_true.windows(2).all(|pair| pair[1] > pair[0]))
}

/// CIC is at most half the truth.
fn cic_below(sea: &InSea) -> Option<bool> {
    is_comparable(sea).then(|| 2.0 * at(&sea.cic) <= at(&sea.p_true))
}

/// PIC is above the truth at epsilon_1 = 0.
fn pic_above(sea: &InSea) -> Option<bool> {
    let (pic, p_true) = sea.pic.first().zip(sea.p_true.first())?;
    (sea.method_groups > 0).then_some(pic > p_true)
}

/// NIC is close to the truth.
fn nic_close(sea: &InSea) -> Option<bool> {
    is_comparable(sea).then(|| (at(&sea.nic) / at(&sea.p_true) - 1.0).abs() <= CLOSE)
}

/// calibration.csv: one line per set and sea; `spread_ratio` is to the first set.
pub fn csv(study: &Study) -> String {
    let mut rows = Vec::new();
    for set in &study.sets {
        for (i, sea) in set.seas.iter().enumerate() {
            let value = |i: usize| Cell::from(set.values.get(i).copied());
            let p = |p: &[f64], e: usize| Cell::from(p.get(e).copied());
            // Shares of no groups are none.
            let of_method = |shares: &[f64], e: usize| {
                let known = shares.get(e).copied().filter(|_| sea.method_groups > 0);
                Cell::from(known)
            };
            rows.push([
                Cell::from(set.name.as_str()),
                set.reading.as_str().into(),
                set.changes().into(),
                set.size.into(),
                misfit(set).into(),
                value(0),
                value(1),
                value(2),
                value(3),
                value(4),
                value(5),
                sea.sea.as_str().into(),
                sea.theta_t.into(),
                sea.paper.into(),
                p(&sea.p_true, TABLE),
                known_error(sea).into(),
                p(&sea.p_true, 0),
                p(&sea.p_true, 2),
                of_method(&sea.cic, TABLE),
                of_method(&sea.pic, TABLE),
                of_method(&sea.nic, TABLE),
                of_method(&sea.pic, 0),
                sea.method_groups.into(),
                sea.capsizes_per_field.into(),
                sea.spread.into(),
                ratio(study, set, i).into(),
            ]);
        }
    }
    csv::write(
        [
            "set",
            "reading",
            "changes",
            "size",
            "misfit",
            "alpha_1",
            "alpha_2",
            "beta_1",
            "beta_2",
            "epsilon_1",
            "epsilon_2",
            "spectrum",
            "theta_t",
            "paper_p_true",
            "p_true",
            "p_true_se",
            "p_true_without_epsilon_1",
            "p_true_twice_epsilon_1",
            "cic",
            "pic",
            "nic",
            "pic_without_epsilon_1",
            "method_groups",
            "capsizes_per_field",
            "spread",
            "spread_ratio",
        ],
        rows,
    )
}

/// The standard error of a sea's P_true, if there is one that tells anything: it is 0 where no group exceeds.
fn known_error(sea: &InSea) -> Option<f64> {
    (sea.standard_error > 0.0).then_some(sea.standard_error)
}

/// calibration_searches.csv: one line per search.
pub fn searches_csv(study: &Study) -> String {
    let row = |it: &Search| {
        [
            Cell::from(it.reading.as_str()),
            it.free.as_str().into(),
            u64::from(it.changes).into(),
            it.size.into(),
            it.misfit.into(),
            it.ranking.into(),
            it.evaluations.into(),
            it.accepted.into(),
        ]
    };
    let head = [
        "reading",
        "free",
        "changes",
        "size",
        "misfit",
        "ranking",
        "evaluations",
        "accepted",
    ];
    csv::write(head, study.searches.iter().map(row))
}

/// Spread of a set in one sea, as a multiple of that of the first set.
fn ratio(study: &Study, set: &Set, sea: usize) -> Option<f64> {
    let first = study.sets.first()?.seas.get(sea)?.spread?;
    (first > 0.0).then_some(set.seas[sea].spread? / first)
}

/// calibration.md.
pub fn markdown(study: &Study) -> String {
    let mut text = String::from(
        "# Calibration study\n\nWhich coefficients of Eq. (6) give the P_true of Table 1, and the ranking of the methods in Figure 3? Sets are compared \
        with the printed ship; changed numbers are bold. None of them is the authors'.\n\n",
    );
    sets(&mut text, study);
    probabilities(&mut text, study);
    identified(&mut text, study);
    text
}

/// Coefficients, misfit and findings of every set.
fn sets(text: &mut String, study: &Study) {
    let names: Vec<String> = study.names.iter().map(|name| symbol(name)).collect();
    let _ = writeln!(
        text,
        "| set | {} | changed | size | misfit | P grows with ε₁ | CIC ≤ ½ P | PIC > P at ε₁ = 0 | NIC within {:.0} % |",
        names.join(" | "),
        100.0 * CLOSE
    );
    let _ = writeln!(text, "|{}", "---|".repeat(names.len() + 8));
    for set in &study.sets {
        let value = |(value, changed): (&f64, &bool)| {
            let value = csv_number(*value);
            if *changed { format!("**{value}**") } else { value }
        };
        let values: Vec<String> = set.values.iter().zip(&set.changed).map(value).collect();
        let _ = writeln!(
            text,
            "| {} | {} | {} | {:.2} | {} | {} | {} | {} | {} |",
            escape::markdown(&set.name),
            values.join(" | "),
            set.changes(),
            set.size,
            misfit(set).map_or(NO_DATA.to_owned(), |misfit| format!("{misfit:.2}")),
            share(set, grows),
            share(set, cic_below),
            share(set, pic_above),
            share(set, nic_close),
        );
    }
    let Some(fields) = study.sets.first().map(|set| set.fields) else {
        text.push_str("\nNo data: no set was checked.\n\n");
        return;
    };
    let fields = counted(fields, "field");
    let _ = writeln!(
        text,
        "\nAll on {fields} per sea that no search has seen. Size: sum of |ln(value/printed)|, a power of ten is 2.30. \
         Misfit below {} agrees with Table 1 within the errors. Findings: number of seas in which they hold.\n",
        study.accepted_below
    );
}

fn csv_number(value: f64) -> String {
    format!("{value:.4e}")
        .parse::<f64>()
        .map_or(NOTHING.to_owned(), |value| value.to_string().replace('-', "−"))
}

/// P_true, methods, capsizes and spread per sea.
fn probabilities(text: &mut String, study: &Study) {
    text.push_str("| set | sea | paper | P_true | CIC/P | PIC/P | NIC/P | P at ε₁ = 0, 2 ε₁ | capsizes a field | spread, rad (ratio) |\n|---|---|---|---|---|---|---|---|---|---|\n");
    for set in &study.sets {
        for (i, sea) in set.seas.iter().enumerate() {
            let p = at(&sea.p_true);
            let over = |other: &[f64]| {
                if is_comparable(sea) {
                    format!("{:.2}", at(other) / p)
                } else {
                    NOTHING.to_owned()
                }
            };
            let measured = match (sea.p_true.get(TABLE), known_error(sea)) {
                (None, _) => NO_DATA.to_owned(),
                (Some(p), None) if *p <= 0.0 => "none exceeds".to_owned(),
                (Some(p), None) => format!("{p:.4}"),
                (Some(p), Some(error)) => format!("{p:.4} ± {error:.4}"),
            };
            let other = |e: usize| sea.p_true.get(e).map_or(NOTHING.to_owned(), |p| format!("{p:.4}"));
            let spread = sea.spread.map_or(NOTHING.to_owned(), |spread| {
                let ratio = ratio(study, set, i).map_or(NOTHING.to_owned(), |ratio| format!("{ratio:.2}"));
                format!("{spread:.3} ({ratio})")
            });
            let _ = writeln!(
                text,
                "| {} | {} | {:.4} | {measured} | {} | {} | {} | {}, {} | {:.3} | {spread} |",
                escape::markdown(&set.name),
                escape::markdown(&sea.sea),
                sea.paper,
                over(&sea.cic),
                over(&sea.pic),
                over(&sea.nic),
                other(0),
                other(2),
                sea.capsizes_per_field,
            );
        }
    }
    text.push_str("\nSpread: scatter of the response about its mean given (L, A), near the threshold; ratio to the first set.\n\n");
}

/// What the data identify.
fn identified(text: &mut String, study: &Study) {
    let ranked = study.accepted.iter().filter(|(_, ranking)| *ranking < RANKED).count();
    let evaluations = study.searches.iter().fold(0, |sum, it| sum + it.evaluations);
    let _ = writeln!(
        text,
        "## What the data identify\n\n{} tried {}; {} of them agree with Table 1 within the errors of \
         the search, {ranked} of these keep the ranking too. The range of each coefficient among them, as a factor of the printed \
         value:\n\n| coefficient | agreeing with Table 1 | keeping the ranking too |\n|---|---|---|",
        counted_as(study.searches.len(), "search", "searches"),
        counted(evaluations, "candidate"),
        study.accepted.len()
    );
    for (i, name) in study.names.iter().enumerate() {
        let factors = |ranked: bool| {
            study.range(i, ranked).map_or(NOTHING.to_owned(), |(low, high)| {
                format!("{:.3} to {:.3}", exp(low), exp(high))
            })
        };
        let _ = writeln!(text, "| {} | {} | {} |", symbol(name), factors(false), factors(true));
    }
    let mut pairs: Vec<(f64, String)> = Vec::new();
    for i in 0..study.names.len() {
        for j in 0..i {
            if let Some(c) = correlation(study, i, j) {
                pairs.push((
                    c,
                    format!("{}, {}: {c:+.2}", symbol(&study.names[j]), symbol(&study.names[i])),
                ));
            }
        }
    }
    pairs.sort_by(|p, q| q.0.abs().total_cmp(&p.0.abs()));
    let strongest: Vec<&str> = pairs.iter().take(4).map(|(_, words)| words.as_str()).collect();
    if !strongest.is_empty() {
        let _ = writeln!(
            text,
            "\nThe strongest correlations of their logarithms: {}.",
            strongest.join("; ")
        );
    }
}

/// Correlation of ln ratios among the trials that agree with Table 1; none if one of them does not vary.
fn correlation(study: &Study, i: usize, j: usize) -> Option<f64> {
    // Two trials always lie on a line.
    if study.accepted.len() < 3 {
        return None;
    }
    let n = study.accepted.len() as f64;
    let mean = |i: usize| study.accepted.iter().fold(0.0, |sum, (x, _)| sum + x[i]) / n;
    let (a, b) = (mean(i), mean(j));
    let (mut aa, mut bb, mut ab) = (0.0, 0.0, 0.0);
    for (x, _) in &study.accepted {
        aa += (x[i] - a) * (x[i] - a);
        bb += (x[j] - b) * (x[j] - b);
        ab += (x[i] - a) * (x[j] - b);
    }
    (aa > 0.0 && bb > 0.0).then(|| ab / (aa * bb).sqrt())
}
