//! Table 1 in its four forms.

use encounter::plot::table;

use super::{samples, svg};

#[test]
fn the_digits_are_those_of_the_paper_in_every_form() {
    let table = samples::table();
    let words = svg::words(&table::svg(&table).expect("the sample is sound"));
    for wanted in [
        "0.0459 ± 0.0002",
        "0.0421",
        "0.0451 (6 %)",
        "0.0416 (5 %)",
        "0.0462 (44 %)",
        "0.0420 (44 %)",
    ] {
        assert!(
            words.iter().any(|word| word == wanted),
            "{wanted} is missing in the SVG"
        );
        assert!(
            table::markdown(&table).contains(wanted),
            "{wanted} is missing in the Markdown"
        );
    }
    assert!(table::latex(&table).contains("0.0459 $\\pm$ 0.0002 & 0.0421 & 0.0451 (6\\,\\%) & 0.0416 (5\\,\\%)"));
}

#[test]
fn what_is_not_known_is_a_dash_in_print_and_empty_in_the_csv() {
    let table = samples::table();
    assert!(
        table::markdown(&table)
            .contains("| S4 | 1.05 | – | 0.0076 | – | 0.0082 (12 %) | – | – | – | – | 0.0105 (101 %) |")
    );
    assert!(table::latex(&table).contains("S4 & 1.05 & -- & 0.0076 & -- "));
    assert!(table::csv(&table).contains("\nS4,1.05,,,,,,,0.0076,0.0082,12,0.0105,101,,,,,,\n"));
    assert!(
        table::csv(&table).contains(
            "\nS3,1,0.0254,0.00024,0.0251,0.0021,0.026,0.0149,,,,,,0.0251,0.0021,0.026,0.0149,0.0251,0.0021\n"
        )
    );
}

#[test]
fn the_markdown_has_every_error_beside_its_floor() {
    let text = table::markdown(&samples::table());
    // Bias -1.7, std 5.9; floors 300, 150, 200, 100 over √120; (150/5)² samples.
    assert!(
        text.contains(
            "| S1 | −1.7, 5.9, 6.1 | −1.7, 5.9, 6.1 | −1.7, 5.9, 6.1 | +0.7, 43.8, 43.8 | 27.4, 13.7 | 18.3, 9.1 | 900 |"
        ),
        "{text}"
    );
    assert!(text.contains("| S4 | – | – | – | – | – | – | – |"));
}

#[test]
fn a_table_without_rows_is_still_a_table() {
    let mut table = samples::table();
    table.rows.clear();
    svg::check(&table::svg(&table).expect("no row is sound"));
    assert!(table::markdown(&table).lines().count() >= 2);
}

#[test]
fn latex_escapes_a_name() {
    let mut table = samples::table();
    table.rows[0].spectrum = "S_1".to_owned();
    assert!(table::latex(&table).contains("S\\_1 & 0.7"));
}

#[test]
fn a_table_without_rows_says_why() {
    let mut table = samples::table();
    table.rows.clear();
    assert!(table::markdown(&table).contains("No data: no row of vhgp_seq.case names a sea of this run."));
}

#[test]
fn a_threshold_that_does_not_round_well_stays_within_its_column() {
    let mut table = samples::table();
    table.rows[0].theta_t = 0.779_999_999_999_999_9;
    let words = svg::words(&table::svg(&table).expect("the sample is sound"));
    assert!(words.iter().any(|word| word == "0.78"));
    assert!(table::markdown(&table).contains("| S1 | 0.78 |"));
    assert!(
        table::csv(&table).contains("\nS1,0.7799999999999999,"),
        "the data keep every digit"
    );
}

#[test]
fn what_was_never_seen_has_a_bound_and_no_error() {
    let mut table = samples::table();
    (table.rows[0].p_true, table.rows[0].p_true_se) = (Some(0.0), None);
    table.rows[0].p_true_groups = 3000;
    table.rows[0].random = Some(table::Estimate { mean: 0.0, std: None });
    let text = table::markdown(&table);
    // 3/3000; 3 over 120 samples in each of 100 realisations.
    assert!(
        text.contains("| S1 | 0.7 | < 0.001 |") && text.contains("| < 0.00025 |"),
        "{text}"
    );
    assert!(table::latex(&table).contains("$<$ 0.001"));
    assert!(table::csv(&table).contains("\nS1,0.7,0,,"));
}

#[test]
fn one_realisation_is_one_and_has_no_standard_deviation() {
    let mut table = samples::table();
    (table.realisations, table.samples) = (1, 1);
    for row in &mut table.rows {
        row.sequential = row.sequential.map(|known| table::Estimate { std: None, ..known });
        row.reached = 1;
    }
    let text = table::markdown(&table);
    assert!(text.contains("of 1 realisation with 1 sample each"), "{text}");
    assert!(
        text.contains("| 0.0451 | 0.0416 (5 %) |") && text.contains("−1.7, –, –"),
        "{text}"
    );
}

#[test]
fn blank_cells_of_a_sea_with_too_few_groups_are_explained() {
    let mut table = samples::table();
    (table.rows[1].sequential, table.rows[1].reached) = (None, 15);
    let said = "S2: the estimates end at 15 samples, since the sea has no more groups.";
    assert!(table::markdown(&table).contains(said));
}
