//! Claims about stages that run only when they, or what reads them, are named.

use crate::common::{EVERYTHING, House};
use encounter::engine::pipeline::Pipeline;

fn house(on_request: &'static [&'static str]) -> House {
    let mut house = House::new();
    house.pipeline = Pipeline {
        on_request,
        ..house.pipeline
    };
    house
}

fn is_aside(node: &&str) -> bool {
    node.starts_with("aside") || node.starts_with("echo")
}

#[test]
fn a_run_of_everything_leaves_out_what_runs_on_request() {
    let house = house(&["aside", "echo"]);
    let done = house.run();
    done.expect_success();
    let expected: Vec<&str> = EVERYTHING.iter().copied().filter(|node| !is_aside(node)).collect();
    assert!(expected.len() < EVERYTHING.len());
    let mut ran = done.ran();
    ran.sort();
    assert_eq!(ran, expected);
    let lock = done.locked();
    assert!(lock.lines.iter().all(|line| !is_aside(&line.name.as_str())));
}

#[test]
fn named_it_runs_with_what_it_reads_and_nothing_else() {
    let house = house(&["aside", "echo"]);
    let mut ran = house.run_targets(&["echo"]).ran();
    ran.sort();
    let expected: Vec<&str> = EVERYTHING.iter().copied().filter(is_aside).collect();
    assert_eq!(ran, expected);
    assert_eq!(house.run_targets(&["echo"]).ran(), Vec::<String>::new());
}

#[test]
fn what_others_read_runs_for_them_even_if_it_is_on_request_itself() {
    let house = house(&["aside"]);
    let ran = house.run().ran();
    assert!(ran.iter().any(|node| node.starts_with("aside")), "{ran:?}");
}

#[test]
fn its_parameters_are_checked_all_the_same() {
    let mut house = house(&["aside", "echo"]);
    house.set("aside.value=\"many\"");
    assert!(house.refusal().contains("aside.value"), "{}", house.refusal());
}
