//! Claims about claims: each number is the one its words name, worked out by hand from small results.

use std::collections::BTreeMap;

use encounter::numerics::elementary::log10;
use encounter::plot::style::Method;
use encounter::plot::table::{Estimate, Printed, Row};
use encounter::report::claims::{Settings, claims};
use encounter::report::evidence::{Curve, Detection, Evidence, Measured, Moment, Study};
use encounter::report::finding::{Claim, Expectation, Outcome};

/// Method, place of epsilon_1, and (theta_t, probability, standard error) of each of its points; Table 1 stands at 0.7.
type Line = (Method, usize, &'static [(f64, f64, f64)]);

const EXCEEDANCE: [Line; 8] = [
    (Method::Truth, 0, &[(0.7, 0.01, 0.0001), (0.8, 0.001, 0.0005)]),
    (Method::Truth, 1, &[(0.7, 0.04, 0.0001), (0.8, 0.02, 0.0001)]),
    (Method::Cic, 0, &[(0.7, 0.001, 0.0001), (0.8, 0.001, 0.0001)]),
    (Method::Cic, 1, &[(0.7, 0.03, 0.0001), (0.8, 0.004, 0.0001)]),
    (Method::Pic, 0, &[(0.7, 0.05, 0.0001)]),
    (Method::Pic, 1, &[(0.7, 0.08, 0.0001)]),
    (Method::Nic, 1, &[(0.7, 0.04, 0.0001), (0.8, 0.03, 0.0001)]),
    (Method::NicGroups, 1, &[(0.7, 0.0, 0.0)]),
];

/// Groups behind every probability.
const GROUPS: u64 = 1000;

/// Method, place of the group, place of epsilon_1, mean, standard deviation and number of responses.
const MOMENTS: [(Method, usize, usize, f64, f64, u64); 9] = [
    (Method::Truth, 0, 0, 0.4, 0.1, 10_000),
    (Method::Truth, 1, 0, 0.5, 0.1, 10_000),
    (Method::Pic, 0, 0, 0.6, 0.3, 10_000),
    (Method::Pic, 1, 0, 0.55, 0.08, 10_000),
    (Method::Truth, 0, 1, 0.4, 0.1, 10_000),
    (Method::Truth, 1, 1, 0.5, 0.1, 10_000),
    (Method::Cic, 0, 1, 0.42, 0.0, 1),
    (Method::Cic, 1, 1, 0.45, 0.0, 1),
    (Method::Pic, 0, 1, 0.4, 0.09, 10_000),
];

fn curve(points: &[(f64, f64, f64)]) -> Curve {
    let share = |(_, p, error): &(f64, f64, f64)| Measured::share(*p, *error, GROUPS);
    let at_table = points.iter().find(|(theta_t, ..)| *theta_t == 0.7);
    Curve {
        theta_t: points.iter().map(|(theta_t, ..)| *theta_t).collect(),
        probability: points.iter().map(share).collect(),
        at_table: at_table.and_then(share),
    }
}

/// A share of groups with its error, and a share of time, at 0.7 and the second epsilon_1.
fn detection(p: f64, within: f64) -> Detection {
    let exact = Curve {
        theta_t: vec![0.7],
        probability: vec![Some(Measured::exact(within))],
        at_table: None,
    };
    Detection {
        by_groups: vec![Curve::default(), curve(&[(0.7, p, 0.0001)])],
        within_groups: vec![Curve::default(), exact],
    }
}

fn row() -> Row {
    let estimate = |mean, std| {
        let std = Some(std);
        Some(Estimate { mean, std })
    };
    Row {
        spectrum: "S1".to_owned(),
        theta_t: 0.7,
        p_true: Some(0.04),
        p_true_se: Some(0.0001),
        p_true_groups: GROUPS,
        reached: 120,
        sequential: estimate(0.05, 0.005),
        random: estimate(0.04, 0.02),
        best: None,
        control: None,
        lhs: None,
        floor: None,
        control_floor: None,
        paper: Some(Printed {
            p_true: 0.0421,
            sequential_mean: 0.0416,
            sequential_std_percent: 5.0,
            random_mean: 0.042,
            random_std_percent: 44.0,
        }),
    }
}

fn evidence() -> Evidence {
    let curves = EXCEEDANCE
        .iter()
        .map(|(method, e, points)| ((*method, 0, *e), curve(points)));
    let moments = MOMENTS.map(|(method, group, e, mean, std, n)| ((method, group, e), Moment { mean, std, n }));
    Evidence {
        ship: "toy".to_owned(),
        realisations: 100,
        samples: 120,
        seas: vec!["S1".to_owned()],
        epsilons: vec![0.0, 0.002],
        curves: curves.collect(),
        moments: BTreeMap::from(moments),
        study: Some(Study {
            sea: "S1".to_owned(),
            detections: vec![detection(0.03, 0.09), detection(0.06, 0.1)],
        }),
        table: vec![row()],
    }
}

fn settings() -> Settings {
    Settings {
        printed: "printed".to_owned(),
        agreement: 0.05,
        far: 0.5,
        decades: 0.1,
        known: 0.1,
        realisations: 100,
    }
}

fn toy() -> Vec<Claim> {
    claims(&evidence(), &settings())
}

/// Value of a claim, and whether it holds.
fn found(id: &str) -> Option<(f64, bool)> {
    let all = toy();
    let claim = all.iter().find(|claim| claim.id == id).expect("the claim is made");
    claim
        .measured
        .map(|measured| (measured.value, claim.expectation.outcome(measured) == Outcome::Holds))
}

fn is(id: &str, value: f64, holds: bool) {
    let (ours, ok) = found(id).expect("there is a number");
    assert!((ours - value).abs() < 1e-12 && ok == holds, "{id}: {ours}, {ok}");
}

#[test]
fn growth_is_from_one_epsilon_1_to_the_next() {
    is("F1-S1", 4.0, true);
}

#[test]
fn the_constant_condition_is_judged_where_the_truth_is_still_known() {
    // At epsilon_1 = 0 the truth at 0.8 is known to a half only: 0.7 counts, .1; at .002 it is 0.8, .2.
    is("F2-S1", 0.2, true);
}

#[test]
fn the_precomputed_condition_overestimates_and_improves_by_decades() {
    is("F3a-S1", 5.0, true);
    is("F3b-S1", -log10(2.5), true);
    // |log 5| < |log .1| at 0; |log 2| > |log .75| at .002.
    is("F3c", 0.5, false);
}

#[test]
fn the_natural_condition_is_as_far_as_its_furthest_known_threshold() {
    is("F4-S1", log10(1.5), false);
    // No group of a thousand exceeds: the probability is at most 3/1000, so that it is as far off as that at least.
    is("F5-S1", log10(0.04 / 0.003), false);
}

#[test]
fn what_is_far_by_chance_is_not_counted_against_the_natural_condition() {
    // Thrice the truth, but from next to nothing: only what is known to a tenth counts.
    let mut evidence = evidence();
    let chance = curve(&[(0.7, 0.04, 0.0001), (0.8, 0.06, 0.02)]);
    evidence.curves.insert((Method::Nic, 0, 1), chance);
    assert_eq!(number(&evidence, "F4-S1").map(|measured| measured.value), Some(0.0));
}

/// The number of a claim.
fn number(evidence: &Evidence, id: &str) -> Option<Measured> {
    let all = claims(evidence, &settings());
    let claim = all.iter().find(|claim| claim.id == id).expect("the claim is made");
    claim.measured
}

#[test]
fn no_exceedance_among_few_groups_tells_nothing_against_a_method() {
    let mut evidence = evidence();
    let few = Curve {
        theta_t: vec![0.7],
        probability: vec![Measured::share(0.0, 0.0, 20)],
        at_table: Measured::share(0.0, 0.0, 20),
    };
    for method in [Method::NicGroups, Method::Cic] {
        evidence.curves.insert((method, 0, 1), few.clone());
    }
    // At most 3/20, while the truth is 0.04.
    assert_eq!(number(&evidence, "F5-S1"), None);
    let bound = Measured::none_among(20.0);
    assert_eq!(Expectation::AtMost(0.5).outcome(bound), Outcome::Holds);
    assert_eq!(Expectation::AtMost(0.1).outcome(bound), Outcome::Open);
}

#[test]
fn what_a_single_field_or_no_group_tells_is_unknown() {
    // All groups in one field: the standard error by fields is zero, and nothing bounds the share.
    assert_eq!(Measured::share(0.3, 0.0, 500), None);
    assert_eq!(Measured::share(0.0, 0.0, 0), None);
    assert_eq!(Measured::share(0.0, 0.0, 3000).map(Measured::at_most), Some(0.001));
    assert_eq!(
        Measured::share(1.0, 0.0, 3000).and_then(|all| all.standard_error),
        Some(0.0005)
    );
    let mut evidence = evidence();
    evidence.curves.clear();
    for id in ["F1-S1", "F2-S1", "F3a-S1", "F3b-S1", "F3c", "F4-S1", "F5-S1"] {
        assert_eq!(number(&evidence, id), None, "{id}");
    }
}

#[test]
fn a_single_realisation_is_no_test_of_table_1() {
    let mut evidence = evidence();
    evidence.realisations = 1;
    let lone = |mean| Some(Estimate { mean, std: None });
    (evidence.table[0].sequential, evidence.table[0].random) = (lone(0.05), lone(0.0));
    for id in ["F7-S1", "F8a-S1", "F8b-S1", "T1b-S1", "T1c-S1", "T1e-S1", "T1f-S1"] {
        assert_eq!(number(&evidence, id), None, "{id}");
    }
    // None of 120 random samples exceeds.
    assert_eq!(number(&evidence, "T1d-S1").map(Measured::at_most), Some(0.025));
}

#[test]
fn one_epsilon_1_shows_no_growth_and_no_improvement() {
    let mut evidence = evidence();
    evidence.epsilons.truncate(1);
    assert_eq!((number(&evidence, "F1-S1"), number(&evidence, "F3b-S1")), (None, None));
}

#[test]
fn one_detection_is_compared_with_none() {
    let mut evidence = evidence();
    evidence
        .study
        .as_mut()
        .expect("there is a study")
        .detections
        .truncate(1);
    assert_eq!((number(&evidence, "F9a"), number(&evidence, "F9b")), (None, None));
}

#[test]
fn ten_thousand_thresholds_are_looked_up_in_a_moment() {
    let mut evidence = evidence();
    let points: Vec<(f64, f64, f64)> = (1..=10_000_u32).map(|i| (f64::from(i) * 1e-4, 0.5, 0.001)).collect();
    for sea in 0..4 {
        for method in Method::ALL {
            for e in 0..3 {
                evidence.curves.insert((method, sea, e), curve(&points));
            }
        }
    }
    evidence.epsilons.push(0.004);
    evidence.seas = ["S1", "S2", "S3", "S4"].map(str::to_owned).to_vec();
    let start = std::time::Instant::now();
    assert_eq!(number(&evidence, "F4-S4").map(|measured| measured.value), Some(0.0));
    // A look-up by scanning all rows would take minutes.
    assert!(start.elapsed().as_secs() < 5, "{:?}", start.elapsed());
}

#[test]
fn moments_are_judged_where_they_are_furthest_off() {
    // 1.5 and 1.1; 3 and 0.8.
    is("F6b-mean", 1.1, true);
    is("F6b-spread", 0.8, false);
    // 1.05 and 0.9: their mean would look fine.
    is("F6a-mean", 0.9, false);
    is("F6a-spread", 0.0, true);
    is("F6c-mean", 1.0, true);
    is("F6c-spread", 0.9, false);
    assert_eq!(found("F6d-mean"), None, "no NIC among the moments");
}

#[test]
fn precision_counts_the_bias_too() {
    // Bias 25 %, std 12.5 %: (1 - .04)/.04 over .078125.
    is("F7-S1", 24.0 / 0.078_125, false);
    // 25 % off where random sampling is right.
    is("F8a-S1", 25.0, false);
    is("F8b-S1", 0.2, true);
}

#[test]
fn the_numbers_of_table_1_stand_beside_the_papers() {
    is("F9a", 2.0, true);
    // 0.1 over 0.09, less 2.
    is("F9b", 0.1 / 0.09 - 2.0, true);
    is("T1a-S1", 0.04, true);
    is("T1b-S1", 0.05, false);
    is("T1c-S1", 10.0, false);
    is("T1d-S1", 0.04, true);
    is("T1e-S1", 50.0, true);
    is("T1f-S1", 25.0, false);
}
