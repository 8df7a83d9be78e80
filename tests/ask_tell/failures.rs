//! Runs that failed, and samples that all say the same.

use super::{Stranger, roll};
use std::collections::BTreeSet;
use std::fmt::Write;

/// A maximum by length and amplitude of a group.
type Ship = fn(f64, f64) -> String;

/// Writes maxima.csv: these samples failed, by their place in the batch, the others did not.
fn fail(stranger: &Stranger, failed: &[usize]) {
    let samples: Vec<usize> = stranger.batch().into_keys().collect();
    let mut text = "sample,r\n".to_owned();
    for i in failed {
        writeln!(text, "{},Failed", samples[*i]).expect("a text grows");
    }
    stranger.file("maxima.csv", &text);
    stranger.said(&["tell", "DIR", "DIR/maxima.csv"]);
}

/// The column `group` of batch.csv.
fn groups(stranger: &Stranger) -> Vec<usize> {
    let row = |line: &str| line.split(',').nth(1).map(|cell| cell.parse().expect("a whole number"));
    let text = stranger.text("batch.csv");
    text.lines().skip(1).map(|line| row(line).expect("a group")).collect()
}

#[test]
fn a_failed_run_is_drawn_anew_near_its_place_and_its_group_is_not_asked_for_again() {
    let stranger = Stranger::new();
    stranger.said(&["ask", "DIR"]);
    let (first, before) = (groups(&stranger), stranger.batch());
    fail(&stranger, &[3]);
    let said = stranger.said(&["ask", "DIR"]);
    assert!(
        said.starts_with("30 samples to simulate, 0 of 36 told, 1 failed and drawn anew"),
        "{said}"
    );
    let (second, after) = (groups(&stranger), stranger.batch());
    let changed: Vec<usize> = (0..30).filter(|i| first[*i] != second[*i]).collect();
    assert_eq!(changed, [3], "only the failed place is drawn anew");
    assert!(!first.contains(&second[3]));
    let fresh = after.iter().find(|(sample, _)| !before.contains_key(sample));
    let (old, new) = (
        *before.values().nth(3).expect("30 samples"),
        *fresh.expect("a new number").1,
    );
    let distance = |p: (f64, f64), q: (f64, f64)| ((p.0 - q.0) / 8.0).abs().max((p.1 - q.1).abs() / 2.5);
    assert!(
        distance(old, new) < 1.5,
        "{old:?} {new:?}: within about a standard deviation of the sea"
    );
    // The whole sequence ends, and takes no group twice.
    let mut seen: BTreeSet<usize> = first.iter().copied().collect();
    let mut batches = vec![second[3]];
    let said = stranger.to_the_end_with(|| {
        stranger.simulate(stranger.batch());
        if stranger.batch().len() < 30 {
            batches.extend(groups(&stranger));
        }
    });
    assert!(
        said.starts_with("36 of 36 told, 1 failed and drawn anew; P(r > 0.75) = "),
        "{said}"
    );
    assert!(batches.iter().all(|group| seen.insert(*group)), "{batches:?}");
    let last = stranger.text("estimate.csv");
    assert!(last.lines().last().expect("an estimate").starts_with("36,"), "{last}");
}

#[test]
fn neither_the_order_of_failures_nor_those_of_other_places_change_what_is_drawn() {
    let whole = Stranger::new();
    whole.said(&["ask", "DIR"]);
    fail(&whole, &[3, 7, 20]);
    whole.said(&["ask", "DIR"]);
    let expected = groups(&whole);
    for order in [[20, 7, 3], [7, 3, 20]] {
        let parts = Stranger::new();
        for i in order {
            parts.said(&["ask", "DIR"]);
            let before = groups(&parts);
            fail(&parts, &[i]);
            parts.said(&["ask", "DIR"]);
            let others = |groups: &[usize]| [&groups[..i], &groups[i + 1..]].concat();
            assert_eq!(others(&groups(&parts)), others(&before), "an open sample stays");
        }
        assert_eq!(groups(&parts), expected, "{order:?}");
    }
}

#[test]
fn a_failure_contradicts_a_maximum_and_is_told_twice_as_once() {
    let stranger = Stranger::new();
    stranger.said(&["ask", "DIR"]);
    let sample = *stranger.batch().keys().next().expect("30 samples are asked for");
    fail(&stranger, &[0]);
    let known = stranger.text("state.toml");
    stranger.said(&["tell", "DIR", "DIR/maxima.csv"]);
    assert_eq!(stranger.text("state.toml"), known);
    stranger.file("maxima.csv", &format!("sample,r\n{sample},0.5\n"));
    let why = stranger.refused(&["tell", "DIR", "DIR/maxima.csv"]);
    assert!(
        why.contains(&format!("expected sample {sample} = failed as told, found 0.5")),
        "{why}"
    );
}

#[test]
fn a_simulator_that_always_fails_is_stopped_with_a_word() {
    let stranger = Stranger::new();
    for _ in 0..19 {
        stranger.said(&["ask", "DIR"]);
        fail(&stranger, &[0]);
    }
    stranger.said(&["ask", "DIR"]);
    let sample = *stranger.batch().keys().next().expect("30 samples are asked for");
    stranger.file("maxima.csv", &format!("sample,r\n{sample},failed\n"));
    let why = stranger.refused(&["tell", "DIR", "DIR/maxima.csv"]);
    assert!(why.contains("expected fewer than 20 failed runs at one place"), "{why}");
}

#[test]
fn a_sea_without_groups_to_spare_refuses_the_failure_and_not_the_maxima_after_it() {
    let stranger = Stranger::without_sequence();
    let text = stranger.text("groups.csv");
    let first: Vec<&str> = text.lines().take(1 + 40).collect();
    stranger.file("groups.csv", &(first.join("\n") + "\n"));
    stranger.said(&super::begin("36"));
    for i in [0, 1, 2] {
        stranger.said(&["ask", "DIR"]);
        fail(&stranger, &[i]);
    }
    stranger.said(&["ask", "DIR"]);
    let sample = *stranger.batch().keys().nth(5).expect("30 samples are asked for");
    stranger.file("maxima.csv", &format!("sample,r\n{sample},failed\n"));
    let why = stranger.refused(&["tell", "DIR", "DIR/maxima.csv"]);
    assert!(
        why.contains("expected more than 40 groups, since no sample and no failed run"),
        "{why}"
    );
    assert!(stranger.to_the_end().starts_with("36 of 36 told, 3 failed"));
}

#[test]
fn no_exceedance_gives_an_upper_bound_and_only_exceedances_a_lower_one() {
    // 1 - 0.05^(1/30).
    let bound = 0.095_034;
    let ships: [(Ship, bool); 5] = [
        (|l, a| (0.3 * roll(l, a)).min(0.7).to_string(), false),
        (|_, _| "0".to_owned(), false),
        (|_, _| "-749999".to_owned(), false),
        (|l, a| (1.0 + roll(l, a)).to_string(), true),
        (|_, _| "749999".to_owned(), true),
    ];
    for (ship, exceeds) in ships {
        let stranger = Stranger::new();
        let said = stranger.to_the_end_with(|| stranger.answer(stranger.batch(), ship));
        let (says, column, value) = if exceeds {
            (
                "P(r > 0.75) >= 0.905 with 95 % confidence, since each of 36 samples",
                3,
                1.0 - bound,
            )
        } else {
            (
                "P(r > 0.75) <= 0.095 with 95 % confidence, since none of 36 samples",
                4,
                bound,
            )
        };
        assert!(said.contains(says) && !said.contains("+-"), "{said}");
        let text = stranger.text("estimate.csv");
        assert_eq!(text.lines().count(), 4, "{text}");
        for line in text.lines().skip(1) {
            let cells: Vec<&str> = line.split(',').collect();
            assert_eq!(
                (cells.len(), cells[1], cells[2], cells[7 - column]),
                (5, "", "", ""),
                "{line}"
            );
            let found: f64 = cells[column].parse().expect("a bound");
            assert!((found - value).abs() < 1e-6, "{line}");
        }
    }
}

#[test]
fn extreme_maxima_of_both_kinds_end_with_an_estimate_or_an_unknown_deviation() {
    for large in ["0.7500000001", "749999"] {
        let stranger = Stranger::new();
        let ship = |_: f64, a: f64| {
            if a > 6.0 {
                large.to_owned()
            } else {
                "-749999".to_owned()
            }
        };
        let said = stranger.to_the_end_with(|| stranger.answer(stranger.batch(), ship));
        assert!(said.contains("P(r > 0.75) = ") && !said.contains("NaN"), "{said}");
        assert!(!said.contains("+- 0 ") && !said.contains("+- 0.00000"), "{said}");
    }
}
