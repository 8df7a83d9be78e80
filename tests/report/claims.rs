//! Claims about claims: each number is the one its words name, worked out by hand from small files.

use encounter::numerics::elementary::log10;
use encounter::report::claims::{Settings, claims};
use encounter::report::evidence::{Evidence, Sheet};
use encounter::report::finding::Claim;

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
toy,0,1.5,0.35,truth,0.4,0.1,10
toy,0,2.5,0.35,truth,0.5,0.1,10
toy,0,1.5,0.35,pic,0.6,0.3,10
toy,0,2.5,0.35,pic,0.5,0.1,10
toy,0.002,1.5,0.35,truth,0.4,0.1,10
toy,0.002,1.5,0.35,cic,0.4,0,1
";

const TEMPORAL: &str = "ship,spectrum,epsilon_1,theta_t,fields,temporal_probability,temporal_standard_error,similarity_threshold,group_probability,group_standard_error,temporal_within_groups
toy,S1,0.002,0.7,100,0.1,0.001,,,,
toy,S1,0.002,0.7,10,0.1,0.001,0.65,0.03,0.0001,0.1
toy,S1,0.002,0.7,10,0.1,0.001,0.85,0.06,0.0001,0.1
";

const TABLE: &str = "spectrum,theta_t,p_true,p_true_se,sequential_mean,sequential_std,random_mean,random_std,paper_p_true,paper_sequential_mean,paper_sequential_std_percent,paper_random_mean,paper_random_std_percent
S1,0.7,0.04,0.0001,0.05,0.005,0.04,0.02,0.0421,0.0416,5,0.042,44
";

fn toy() -> Vec<Claim> {
    let evidence = Evidence {
        ship: "toy".to_owned(),
        realisations: 100,
        exceedance: Sheet::read(EXCEEDANCE),
        moments: Sheet::read(MOMENTS),
        temporal: Sheet::read(TEMPORAL),
        table: Sheet::read(TABLE),
    };
    let settings = Settings {
        printed: "printed".to_owned(),
        agreement: 0.05,
        far: 0.5,
        decades: 0.1,
        known: 0.1,
    };
    claims(&evidence, &settings)
}

/// Value of a claim, and whether it holds.
fn found(id: &str) -> Option<(f64, bool)> {
    let all = toy();
    let claim = all.iter().find(|claim| claim.id == id).expect("the claim is made");
    claim
        .measured
        .map(|measured| (measured.value, claim.expectation.holds(measured)))
}

fn is(id: &str, value: f64, holds: bool) {
    let (ours, ok) = found(id).expect("there is a number");
    assert!((ours - value).abs() < 1e-12 && ok == holds, "{id}: {ours}, {ok}");
}

#[test]
fn growth_compares_the_largest_epsilon_1_with_the_smallest() {
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
    is("F3b-S1", log10(2.5), true);
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
fn moments_are_means_over_the_groups_of_figure_4() {
    is("F6c", 1.25, true);
    is("F6d", 2.0, true);
    is("F6a", 1.0, true);
    is("F6b", 0.0, true);
    assert_eq!(found("F6g"), None, "no NIC among the moments");
}

#[test]
fn the_numbers_of_table_1_stand_beside_the_papers() {
    // sd 10 %: (1 - .04)/(.04 * .01).
    is("F7-S1", 2400.0, true);
    is("F8-S1", 0.2, true);
    is("F9", 2.0, true);
    is("T1a-S1", 0.04, true);
    is("T1b-S1", 0.05, false);
    is("T1d-S1", 10.0, false);
    is("T1e-S1", 50.0, true);
    is("T1f-S1", 25.0, false);
}
