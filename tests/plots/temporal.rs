//! Claims about Figure 7.

use encounter::plot::temporal::{csv, draw};

use super::samples;

#[test]
fn rows_of_the_whole_record_have_no_detection() {
    let text = csv(&samples::temporal()).expect("the samples are sound");
    let rows: Vec<Vec<&str>> = text.lines().skip(1).map(|line| line.split(',').collect()).collect();
    assert_eq!(rows.len(), 3 * 13);
    assert!(
        rows[..13]
            .iter()
            .all(|row| row[1] == "S1" && row[4] == "31250" && row[7..] == ["", "", "", ""])
    );
    assert!(
        rows[13..]
            .iter()
            .all(|row| row[1] == "S2" && row[4] == "960" && !row[8].is_empty())
    );
    assert_eq!((rows[13][7], rows[26][7]), ("0.75", "0.85"));
}

#[test]
fn a_study_without_the_reference_names_none_and_compares_with_none() {
    let mut figure = samples::temporal();
    let with = draw(&figure).expect("the sample is sound");
    figure.reference = None;
    let without = draw(&figure).expect("a study may leave the reference out");
    assert!(!without.contains("(reference)") && without.len() < with.len());
}

#[test]
fn the_reference_is_named_once() {
    let drawn = draw(&samples::temporal()).expect("the samples are sound");
    assert_eq!(drawn.matches("(reference)").count(), 1);
}

#[test]
fn a_detection_without_groups_leaves_the_others() {
    let mut figure = samples::temporal();
    let line = &mut figure.studies[0].detections[1].by_groups;
    line.theta_t.clear();
    line.probability.clear();
    line.standard_error.clear();
    let text = csv(&figure).expect("the samples are sound");
    assert!(text.lines().last().expect("there are rows").contains(",0.85,,,"));
}
