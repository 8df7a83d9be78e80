//! Claims about claims: each number is the one its words name, worked out by hand from small files.

use encounter::numerics::elementary::log10;
use encounter::report::claims::{Settings, claims};
use encounter::report::evidence::{Evidence, Sheet};
use encounter::report::finding::{Claim, Outcome};

const EXCEEDANCE: &str = "ship,spectrum,epsilon_1,theta_t,method,probability,standard_error,n
toy,S1,0,0.7,truth,0.01,0.0001,1000
toy,S1,0,0.8,truth,0.001,0.0005,1000
toy,S1,0.002,0.7,truth,0.04,0.0001,1000
toy,S1,0.002,0.8,truth,0.02,0.0001,1000
toy,S1,0,0.7,cic,0.001,0.0001,1000
toy,S1,0,0.8,cic,0.001,0.0001,1000
toy,S1,0.002,0.7,cic,0.03,0.0001,1000
toy,S1,0.002,0.8,cic,0.004,0.0001,1000
toy,S1,0,0.7,pic,0.05,0.0001,1000
toy,S1,0.002,0.7,pic,0.08,0.0001,1000
toy,S1,0,0.7,nic,0.01,0.0001,1000
toy,S1,0.002,0.7,nic,0.04,0.0001,1000
toy,S1,0.002,0.8,nic,0.03,0.0001,1000
toy,S1,0.002,0.7,nic_groups,0,0,1000
";

const MOMENTS: &str = "ship,epsilon_1,l_over_tp,a_over_hs,method,mean,std,n
toy,0,1.5,0.35,truth,0.4,0.1,10000
toy,0,2.5,0.35,truth,0.5,0.1,10000
toy,0,1.5,0.35,pic,0.6,0.3,10000
toy,0,2.5,0.35,pic,0.55,0.08,10000
toy,0.002,1.5,0.35,truth,0.4,0.1,10000
toy,0.002,2.5,0.35,truth,0.5,0.1,10000
toy,0.002,1.5,0.35,cic,0.42,0,1
toy,0.002,2.5,0.35,cic,0.45,0,1
toy,0.002,1.5,0.35,pic,0.4,0.09,10000
";

const TEMPORAL: &str = "ship,spectrum,epsilon_1,theta_t,fields,temporal_probability,temporal_standard_error,similarity_threshold,group_probability,group_standard_error,temporal_within_groups
toy,S1,0.002,0.7,100,0.1,0.001,,,,
toy,S1,0.002,0.7,10,0.1,0.001,0.65,0.03,0.0001,0.09
toy,S1,0.002,0.7,10,0.1,0.001,0.85,0.06,0.0001,0.1
";

const TABLE: &str = "spectrum,theta_t,p_true,p_true_se,sequential_mean,sequential_std,random_mean,random_std,paper_p_true,paper_sequential_mean,paper_sequential_std_percent,paper_random_mean,paper_random_std_percent
S1,0.7,0.04,0.0001,0.05,0.005,0.04,0.02,0.0421,0.0416,5,0.042,44
";

fn evidence() -> Evidence {
    Evidence {
        ship: "toy".to_owned(),
        realisations: 100,
        exceedance: Sheet::read(EXCEEDANCE),
        moments: Sheet::read(MOMENTS),
        temporal: Sheet::read(TEMPORAL),
        table: Sheet::read(TABLE),
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
    // No group above: as far as a tenth of the truth's standard error.
    is("F5-S1", log10(0.04 / 0.00001), false);
}

#[test]
fn what_is_far_by_chance_is_not_counted_against_the_natural_condition() {
    // Thrice the truth, but from next to nothing: only what is known to a tenth counts.
    let mut evidence = evidence();
    let chance = "toy,S1,0.002,0.8,nic,0.06,0.02,1000";
    evidence.exceedance = Sheet::read(&EXCEEDANCE.replace("toy,S1,0.002,0.8,nic,0.03,0.0001,1000", chance));
    let all = claims(&evidence, &settings());
    let claim = all.iter().find(|claim| claim.id == "F4-S1").expect("it is made");
    assert_eq!(claim.measured.map(|measured| measured.value), Some(0.0));
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
