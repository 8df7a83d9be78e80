//! Cases: what is equal is shared; pinned axes and rows choose their own.

use crate::common::House;

const NOTHING: [&str; 0] = [];

#[test]
fn cases_share_what_is_equal() {
    // [base.c] says what [base.a] says.
    let mut house = House::lived_in(&["run.bases=[\"a\"]"]);
    house.set("run.bases=[\"a\", \"c\"]");
    let done = house.run();
    assert_eq!(done.ran(), ["report/large/0", "report/small/0"]);
    assert_eq!(done.known["squares/a/1"], done.known["squares/c/1"]);
}

#[test]
fn equal_cases_of_one_run_are_made_once() {
    let mut house = House::new();
    house.workers = 1;
    house.set("run.bases=[\"a\", \"c\"]");
    let done = house.run();
    done.expect_success();
    let squares: Vec<String> = done
        .ran()
        .into_iter()
        .filter(|piece| piece.starts_with("squares"))
        .collect();
    // Those of b are there for the pinned figure alone.
    assert_eq!(squares.len(), 6, "{squares:?}");
}

#[test]
fn a_pinned_axis_takes_its_value_from_elsewhere() {
    let mut house = House::new();
    house.set("run.bases=[\"a\"]");
    let done = house.run();
    done.expect_success();
    assert!(done.ran().contains(&"total/b/0".to_owned()));
    let text = |house: &House| std::fs::read_to_string(house.path("figures/pinned.csv")).expect("a file");
    assert!(text(&house).starts_with("b 3 "), "{}", text(&house));
    // c is made of the same pieces as a: only the figure itself is new.
    house.set("pinned.base=c");
    assert_eq!(house.run().ran(), ["pinned/c/0"]);
    assert!(text(&house).starts_with("c 3 "), "{}", text(&house));
}

#[test]
fn an_edited_row_reruns_its_own_case() {
    let mut house = House::lived_in(&[]);
    house.set("draws.row=[{ base = \"a\", level = 10 }, { base = \"b\", level = 21 }]");
    let ran = ["draws/b/0", "draws/b/1", "report/large/0", "report/small/0"];
    assert_eq!(house.run().ran(), ran);
    house.set("draws.row=[{ base = \"b\", level = 21 }, { base = \"a\", level = 10 }]");
    assert_eq!(house.run().ran(), NOTHING);
}

#[test]
fn a_case_without_a_row_is_left_out() {
    let mut house = House::new();
    house.set("draws.row=[{ base = \"b\", level = 20 }]");
    let done = house.run();
    done.expect_success();
    assert!(!done.ran().iter().any(|piece| piece.starts_with("draws/a")));
    let report = std::fs::read_to_string(house.path("figures/report.csv")).expect("a file");
    assert_eq!(report.lines().count(), 4, "{report}");
}

#[test]
fn the_order_of_the_list_is_the_order_of_the_cases() {
    let mut house = House::lived_in(&[]);
    house.set("run.bases=[\"b\", \"a\"]");
    assert_eq!(house.run().ran(), ["report/large/0", "report/small/0"]);
    let report = std::fs::read_to_string(house.path("figures/report.csv")).expect("a file");
    assert!(report.starts_with("b "), "{report}");
}

#[test]
fn the_first_scale_writes_to_the_folder_itself() {
    let mut house = House::lived_in(&[]);
    let large = std::fs::read(house.path("figures/large/report.csv")).expect("a file");
    house.set("run.scales=[\"large\"]");
    let done = house.run();
    assert_eq!(done.ran(), NOTHING);
    assert_eq!(done.written(), ["report.csv", "report.md"]);
    assert_eq!(std::fs::read(house.path("figures/report.csv")).expect("a file"), large);
}
