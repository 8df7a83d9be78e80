//! Claims about verdicts.

use encounter::report::evidence::{Measured, ratio};
use encounter::report::finding::{Claim, Expectation, Outcome, Verdict, findings};
use encounter::report::findings_text::{Ships, markdown, table, written};

fn number(value: f64, standard_error: f64) -> Measured {
    Measured::with_error(value, standard_error)
}

const BOTH: Ships<'_> = Ships {
    printed: "printed",
    printed_was_run: true,
    reading: Some("other"),
    left_out: &[],
};

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
fn two_standard_errors_on_the_wrong_side_fail_and_on_the_right_side_hold() {
    use Outcome::{Fails, Holds, Open};
    let outcome = |expectation: Expectation, value: f64| expectation.outcome(number(value, 0.1));
    for (expectation, value, wanted) in [
        (Expectation::Above(1.0), 1.21, Holds),
        (Expectation::Above(1.0), 1.19, Open),
        (Expectation::Above(1.0), 0.81, Open),
        (Expectation::Above(1.0), 0.79, Fails),
        (Expectation::Below(1.0), 0.79, Holds),
        (Expectation::Below(1.0), 0.81, Open),
        (Expectation::Below(1.0), 1.19, Open),
        (Expectation::Below(1.0), 1.21, Fails),
        (Expectation::AtMost(1.0), 1.0, Holds),
        (Expectation::AtMost(1.0), 1.19, Open),
        (Expectation::AtMost(1.0), 1.21, Fails),
    ] {
        assert_eq!(outcome(expectation, value), wanted, "{expectation:?} {value}");
    }
    let exact = Measured::exact(1.0);
    assert_eq!(Expectation::Above(1.0).outcome(exact), Fails, "no more than the bound");
}

#[test]
fn the_papers_number_has_a_standard_error_of_its_own() {
    use Outcome::{Fails, Holds, Open};
    let near = |error: f64| Expectation::Near {
        wanted: 1.0,
        share: 0.05,
        error,
    };
    let says = |error: f64, values: [f64; 3]| values.map(|value| near(error).outcome(number(value, 0.03)));
    assert_eq!(says(0.0, [1.04, 1.10, 1.12]), [Holds, Open, Fails]);
    assert_eq!(says(0.0, [0.96, 0.90, 0.88]), [Holds, Open, Fails]);
    // Two of its errors widen the range; .03 and .04 make .05.
    assert_eq!(says(0.04, [1.12, 1.14, 1.16]), [Holds, Open, Fails]);
    assert_eq!(near(0.04).words(), "1.00 ± 0.04 within 5 %");
    assert_eq!(near(0.0).words(), "1 within 5 %");
}

#[test]
fn both_readings_make_the_verdict() {
    let [yes, open, no] = [2.0, 1.1, 0.5].map(|value| Some(number(value, 0.1)));
    let verdict = |printed, reading| Verdict::of(Expectation::Above(1.0), printed, reading);
    assert_eq!(verdict(yes, yes), Verdict::Reproduced);
    assert_eq!(verdict(yes, None), Verdict::Reproduced);
    assert_eq!(verdict(yes, no), Verdict::AsPrinted);
    assert_eq!(verdict(yes, open), Verdict::AsPrinted);
    assert_eq!(verdict(no, yes), Verdict::UnderReading);
    assert_eq!(verdict(None, yes), Verdict::UnderReading);
    assert_eq!(verdict(no, open), Verdict::Undecided);
    assert_eq!(verdict(open, no), Verdict::Undecided);
    assert_eq!(verdict(no, no), Verdict::NotReproduced);
    assert_eq!(verdict(no, None), Verdict::NotReproduced);
    assert_eq!(verdict(None, None), Verdict::Unknown);
}

#[test]
fn a_claim_has_one_line_and_a_table_of_its_cases() {
    let (yes, no) = (Some(number(3.0, 0.1)), Some(number(0.5, 0.1)));
    let printed = [claim("F1-S1", no), claim("F1-S2", no)];
    let reading = [claim("F1-S1", yes), claim("F1-S2", no), claim("F2", yes)];
    let all = findings(&printed, &reading);
    assert_eq!(all[2].claim.measured, None, "one ship alone can test it");
    let text = markdown(&all, &BOTH);
    for wanted in [
        "- reproduced under the other reading: 2\n- not reproduced: 1\n",
        "| F1 | it grows \\| a bar | S1: reproduced under the other reading; S2: not reproduced |\n",
        "| F2 | it grows \\| a bar | reproduced under the other reading |\n",
        "### F1: it grows | a bar\n\nGrowth.\n",
        "| S1 | > 1 | 0.50 ± 0.10, fails | 3.00 ± 0.10, holds | reproduced under the other reading |\n",
        "| all | > 1 | – | 3.00 ± 0.10, holds | reproduced under the other reading |\n",
    ] {
        assert!(text.contains(wanted), "{wanted} in {text}");
    }
    let csv = table(&all, &BOTH);
    assert_eq!(csv.lines().count(), 4);
    assert!(
        csv.ends_with("F2,it grows | a bar,growth,> 1,,,,3,0.1,holds,reproduced under the other reading\n"),
        "{csv}"
    );
}

#[test]
fn a_number_has_the_digits_that_its_error_allows() {
    for (value, error, wanted) in [
        (0.007_612_34, 0.000_12, "0.00761 ± 0.00012"),
        (2496.3, 252.0, "2500 ± 250"),
        (1627.4, 12.0, "1627 ± 12"),
        (0.247_16, 0.000_41, "0.2472 ± 0.0004"),
        (0.007_63, 0.007_64, "0.008 ± 0.008"),
        (-0.0333, 0.0207, "−0.033 ± 0.021"),
        (126.2, 1.8, "126.2 ± 1.8"),
    ] {
        assert_eq!(written(Some(number(value, error))), wanted);
    }
    let exact = |value: f64| written(Some(Measured::exact(value)));
    assert_eq!(
        (exact(0.75), exact(0.0), exact(1234.0)),
        ("0.75".into(), "0".into(), "1230".into())
    );
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

#[test]
fn a_ship_that_was_not_run_is_said_to_have_no_data() {
    let yes = [claim("F1-S1", Some(number(3.0, 0.1)))];
    let alone = Ships { reading: None, ..BOTH };
    let text = markdown(&findings(&yes, &[]), &alone);
    assert!(
        text.contains("No data: this run has no ship but the printed one."),
        "{text}"
    );
    let left_out = ["third".to_owned()];
    let others = Ships {
        printed_was_run: false,
        left_out: &left_out,
        ..BOTH
    };
    let text = markdown(&findings(&[], &yes), &others);
    assert!(
        text.contains("No data: *printed* is not among the ships of this run."),
        "{text}"
    );
    assert!(text.contains("Not compared: *third*"), "{text}");
    assert!(!markdown(&findings(&yes, &yes), &BOTH).contains("No data"));
}

#[test]
fn a_bound_is_written_as_one_and_is_no_error_in_the_data() {
    assert_eq!(written(Some(Measured::none_among(3000.0))), "0, at most 0.0010");
    let bounded = [claim("F1", Some(Measured::none_among(3000.0)))];
    let text = table(&findings(&bounded, &[]), &BOTH);
    assert!(
        text.contains("\nF1,it grows | a bar,growth,> 1,0,,fails,,,,not reproduced\n"),
        "{text}"
    );
}
