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
