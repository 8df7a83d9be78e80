//! Claims about verdicts.

use encounter::report::evidence::{Measured, ratio};
use encounter::report::finding::{Claim, Expectation, Verdict, findings, markdown, table, written};

fn number(value: f64, standard_error: f64) -> Measured {
    Measured {
        value,
        standard_error: Some(standard_error),
    }
}

fn claim(id: &str, measured: Option<Measured>) -> Claim {
    Claim {
        id: id.to_owned(),
        says: "it grows | a bar".to_owned(),
        quantity: "growth".to_owned(),
        expectation: Expectation::Above(1.0),
        measured,
    }
}

#[test]
fn an_expectation_leaves_two_standard_errors_of_room() {
    let holds = |expectation: Expectation, value: f64| expectation.holds(number(value, 0.1));
    assert!(holds(Expectation::Above(1.0), 1.21) && !holds(Expectation::Above(1.0), 1.19));
    assert!(holds(Expectation::Below(1.0), 0.79) && !holds(Expectation::Below(1.0), 0.81));
    assert!(holds(Expectation::AtMost(1.0), 1.19) && !holds(Expectation::AtMost(1.0), 1.21));
    assert!(holds(Expectation::Near(1.0, 0.05), 1.24) && !holds(Expectation::Near(1.0, 0.05), 1.26));
    assert!(holds(Expectation::Near(1.0, 0.05), 0.76) && !holds(Expectation::Near(1.0, 0.05), 0.74));
}

#[test]
fn the_printed_coefficients_come_before_the_other_reading() {
    let (yes, no) = (Some(number(2.0, 0.1)), Some(number(0.5, 0.1)));
    let verdict = |printed, reading| Verdict::of(Expectation::Above(1.0), printed, reading);
    assert_eq!(verdict(yes, no), Verdict::Reproduced);
    assert_eq!(verdict(no, yes), Verdict::UnderReading);
    assert_eq!(verdict(None, yes), Verdict::UnderReading);
    assert_eq!(verdict(no, no), Verdict::NotReproduced);
    assert_eq!(verdict(no, None), Verdict::NotReproduced);
    assert_eq!(verdict(None, None), Verdict::Unknown);
}

#[test]
fn a_claim_that_one_ship_alone_can_test_is_still_a_finding() {
    let printed = [claim("F1", Some(number(0.5, 0.1)))];
    let reading = [claim("F1", Some(number(3.0, 0.1))), claim("F2", Some(number(3.0, 0.1)))];
    let all = findings(&printed, &reading);
    let seen: Vec<_> = all
        .iter()
        .map(|finding| (finding.claim.id.as_str(), finding.verdict))
        .collect();
    assert_eq!(seen, [("F1", Verdict::UnderReading), ("F2", Verdict::UnderReading)]);
    assert_eq!(all[1].claim.measured, None);
    let text = markdown(&all, "printed", "other");
    assert!(text.contains("- reproduced under the other reading: 2\n"), "{text}");
    assert!(
        text.contains("| F1 | it grows \\| a bar | growth | > 1 | 0.500 ± 0.100 | 3.00 ± 0.10 |"),
        "{text}"
    );
    let csv = table(&all, "other");
    assert_eq!(csv.lines().count(), 3);
    assert!(
        csv.ends_with("F2,it grows | a bar,growth,> 1,,,3,0.1,reproduced under the other reading\n"),
        "{csv}"
    );
}

#[test]
fn numbers_have_three_digits_and_their_errors_as_many_decimals() {
    assert_eq!(written(Some(number(0.00761234, 0.00012))), "0.00761 ± 0.00012");
    assert_eq!(written(Some(number(1627.4, 12.0))), "1627 ± 12");
    assert_eq!(written(None), "–");
}

#[test]
fn a_ratio_carries_both_standard_errors() {
    let known = ratio(number(2.0, 0.2), number(4.0, 0.4)).expect("not over nothing");
    assert_eq!(known.value, 0.5);
    // 10 % each, independent.
    assert!((known.standard_error.expect("both have one") - 0.5 * 0.02_f64.sqrt()).abs() < 1e-15);
    assert_eq!(ratio(number(2.0, 0.2), number(0.0, 0.0)), None);
}
