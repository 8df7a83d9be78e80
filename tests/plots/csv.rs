//! CSV: the columns of the contract, floats that read back to the same bits, nothing that is not a number.

use encounter::plot::csv::{self, Cell, GroupsRow, TruthRow};
use encounter::plot::{convergence, exceedance, flowchart, jonswap_groups, response_moments, table, wave_groups};

use super::samples;

fn header(text: &str) -> &str {
    text.lines().next().unwrap_or_default()
}

#[test]
fn the_columns_are_those_of_the_contract() {
    assert_eq!(
        header(&exceedance::csv(&[&samples::exceedance(1, 1)])),
        "ship,spectrum,epsilon_1,theta_t,method,probability,standard_error,n"
    );
    assert_eq!(
        header(&convergence::csv(&samples::convergence())),
        "method,n_samples,mean,std"
    );
    assert_eq!(
        header(&table::csv(&samples::table())),
        "spectrum,theta_t,p_true,p_true_se,sequential_mean,sequential_std,random_mean,random_std,paper_p_true,\
         paper_sequential_mean,paper_sequential_std_percent,paper_random_mean,paper_random_std_percent,\
         best_mean,best_std,lhs_mean,lhs_std,control_mean,control_std"
    );
    assert_eq!(
        header(&csv::groups(&[])),
        "spectrum,fields,groups_per_tp,l_over_tp_mean,l_over_tp_sd,a_over_hs_mean,a_over_hs_sd,correlation,share_a_over_hs_gt_1"
    );
    assert_eq!(
        header(&csv::truth(&[], 0.25)),
        "ship,spectrum,epsilon_1,fields,groups,capsizes,temporal_exceedance_025"
    );
}

#[test]
fn every_row_has_as_many_cells_as_the_header() {
    let texts = [
        wave_groups::csv(&samples::wave_groups()),
        flowchart::csv(2),
        exceedance::csv(&[&samples::exceedance(2, 2)]),
        response_moments::csv(&samples::response_moments()),
        convergence::csv(&samples::convergence()),
        jonswap_groups::csv(&samples::jonswap_groups()),
        table::csv(&samples::table()),
    ];
    for text in texts {
        let columns = header(&text).matches(',').count();
        assert!(text.lines().count() > 3 && text.ends_with('\n') && !text.contains('\r') && !text.contains("NaN"));
        assert!(
            text.lines().all(|line| line.matches(',').count() == columns),
            "{}",
            header(&text)
        );
    }
}

#[test]
fn floats_read_back_to_the_same_bits() {
    let values = [0.1 + 0.2, 1e-7, 1.0 / 3.0, 6.02e23, 5e-324, -0.25];
    let text = csv::write(["x"], values.map(|value| [Cell::Number(value)]));
    for (line, value) in text.lines().skip(1).zip(values) {
        assert_eq!(line.parse::<f64>().expect("a number").to_bits(), value.to_bits());
    }
}

#[test]
fn unknown_is_empty_and_words_are_quoted_only_if_they_must_be() {
    let row = [
        Cell::Number(f64::NAN),
        Cell::Unknown,
        Cell::from("a,\"b\""),
        Cell::from("plain"),
        Cell::Number(-0.0),
    ];
    assert_eq!(
        csv::write(["a", "b", "c", "d", "e"], [row]),
        "a,b,c,d,e\n,,\"a,\"\"b\"\"\",plain,0\n"
    );
}

#[test]
fn groups_and_truth_are_written_in_the_order_of_their_columns() {
    let groups = GroupsRow {
        spectrum: "S1".to_owned(),
        fields: 500,
        groups_per_tp: 0.0932,
        l_over_tp_mean: Some(2.224),
        l_over_tp_sd: Some(1.158),
        a_over_hs_mean: Some(0.466),
        a_over_hs_sd: Some(0.169),
        correlation: Some(0.52),
        share_a_over_hs_gt_1: Some(0.0016),
    };
    assert!(csv::groups(&[groups]).ends_with("\nS1,500,0.0932,2.224,1.158,0.466,0.169,0.52,0.0016\n"));
    let truth = TruthRow {
        ship: "printed".to_owned(),
        spectrum: "S4".to_owned(),
        epsilon_1: 0.02,
        fields: 500,
        groups: 11930,
        capsizes: 7,
        temporal_exceedance: Some(0.125),
    };
    assert!(csv::truth(&[truth], 0.25).ends_with("\nprinted,S4,0.02,500,11930,7,0.125\n"));
}

#[test]
fn a_word_of_a_stranger_is_no_formula_and_no_second_row() {
    for (word, wanted) in [
        ("=HYPERLINK(\"http://x\")", "\"'=HYPERLINK(\"\"http://x\"\")\""),
        ("+1", "\"'+1\""),
        ("-1", "\"'-1\""),
        ("@SUM(A1)", "\"'@SUM(A1)\""),
        ("\t=1", "\"' =1\""),
        ("two\nrows", "\"two rows\""),
        ("an \u{1b}[31m escape", "\"an  [31m escape\""),
    ] {
        assert_eq!(csv::write(["a"], [[Cell::from(word)]]), format!("a\n{wanted}\n"));
    }
    // Numbers keep their sign.
    assert_eq!(csv::write(["a"], [[Cell::Number(-0.25)]]), "a\n-0.25\n");
}
