//! What a run would do, told without doing it, against what it then does.

use crate::common::{EVERYTHING, House};
use encounter::engine::plan::NodePlan;
use std::collections::BTreeMap;
use std::fs;

/// (cached, will run, may run) of every node.
fn states(house: &House) -> BTreeMap<String, (usize, usize, usize)> {
    let state = |plan: NodePlan| (plan.node, (plan.cached, plan.will_run, plan.may_run));
    house.plan(|plan, _| plan.nodes()).into_iter().map(state).collect()
}

/// The nodes that are not all cached, each with what will and what may run.
fn running(house: &House) -> Vec<(String, usize, usize)> {
    let running = states(house).into_iter().filter(|(_, (_, will, may))| will + may > 0);
    running.map(|(node, (_, will, may))| (node, will, may)).collect()
}

fn owned(rows: &[(&str, usize, usize)]) -> Vec<(String, usize, usize)> {
    rows.iter()
        .map(|(node, will, may)| ((*node).to_owned(), *will, *may))
        .collect()
}

#[test]
fn in_an_empty_store_everything_will_run_for_certain() {
    let house = House::new();
    let plans = house.plan(|plan, _| plan.nodes());
    assert_eq!(plans.iter().map(|plan| plan.will_run).sum::<usize>(), EVERYTHING.len());
    assert!(
        plans
            .iter()
            .all(|plan| plan.reason == "first time" || plan.reason.starts_with("first time; "))
    );
    assert!(plans.iter().all(|plan| plan.untimed == plan.pieces));
    assert!(!house.path("store").exists());
}

#[test]
fn after_a_run_everything_is_cached_and_costs_nothing() {
    let house = House::lived_in(&[]);
    assert_eq!(running(&house), []);
    let plans = house.plan(|plan, _| plan.nodes());
    assert!(plans.iter().all(|plan| plan.reason.is_empty() && plan.seconds == 0.0));
    assert_eq!(house.plan(|plan, _| plan.affected()), Vec::<String>::new());
}

#[test]
fn what_is_below_a_rerun_may_run_and_is_spared_if_the_content_comes_out_equal() {
    let mut house = House::lived_in(&[]);
    house.set("numbers.label=another");
    let expected = owned(&[
        ("draws/a", 0, 2),
        ("draws/b", 0, 2),
        ("numbers", 3, 0),
        ("pinned/b", 0, 1),
        ("report/large", 0, 1),
        ("report/small", 0, 1),
        ("squares/a", 0, 3),
        ("squares/b", 0, 3),
        ("total/a", 0, 1),
        ("total/b", 0, 1),
    ]);
    assert_eq!(running(&house), expected);
    let affected = ["pinned/b", "report/small", "report/large"];
    assert_eq!(house.plan(|plan, _| plan.affected()), affected);
    assert_eq!(house.run().ran(), ["numbers/0", "numbers/1", "numbers/2"]);
    assert_eq!(running(&house), []);
}

#[test]
fn what_no_record_can_match_will_run_whatever_its_inputs() {
    let mut house = House::lived_in(&[]);
    house.set("numbers.label=another");
    house.set("total.modulo=999983");
    let states = states(&house);
    assert_eq!(states["squares/a"], (0, 0, 3));
    // The parameter is the total's own: equal squares cannot spare it.
    assert_eq!(states["total/a"], (0, 1, 0));
    assert_eq!(states["pinned/b"], (0, 0, 1));
}

#[test]
fn an_evicted_output_runs_again_for_whoever_needs_it() {
    let mut house = House::lived_in(&[]);
    house.set("base.a.offset=5");
    assert_eq!(states(&house)["numbers"], (0, 3, 0));
    assert_eq!(house.plan_of("numbers").reason, "evicted, and needed by `squares/a`");
    // Fickle is evicted too, but nobody needs it.
    assert_eq!(states(&house)["fickle"], (1, 0, 0));
}

#[test]
fn an_evicted_output_is_needed_piece_by_piece() {
    let mut house = House::new();
    let done = house.run();
    fs::remove_file(house.object(&done.known["squares/a/1"].1)).expect("the object can be deleted");
    assert_eq!(running(&house), owned(&[]));
    house.set("total.modulo=900001");
    let plan = states(&house);
    assert_eq!((plan["numbers"], plan["squares/a"]), ((2, 1, 0), (2, 1, 0)));
    assert_eq!(house.run().healed(), ["squares/a/1"]);
}

#[test]
fn what_is_made_again_from_its_record_changes_nothing_below() {
    let house = House::new();
    let done = house.run();
    // Published outputs are read by every run; totals by none.
    fs::remove_file(house.object(&done.known["total/a/0"].1)).expect("the object can be deleted");
    fs::remove_file(house.object(&done.known["pinned/b/0"].1)).expect("the object can be deleted");
    assert_eq!(running(&house), owned(&[("pinned/b", 1, 0)]));
    let again = house.run();
    assert_eq!(again.ran(), ["pinned/b/0"]);
    assert_eq!(running(&house), owned(&[]));
}

#[test]
fn a_plan_looks_and_touches_nothing() {
    let mut house = House::new();
    let done = house.run();
    let object = house.object(&done.known["report/small/0"].1);
    fs::write(&object, "damaged").expect("the object can be damaged");
    house.set("base.a.offset=5");
    let before = house.files_in("store");
    house.plan(|plan, _| plan.nodes());
    assert_eq!(house.files_in("store"), before);
    assert_eq!(fs::read(&object).expect("the object is there"), b"damaged");
}

#[test]
fn a_rerun_costs_what_the_same_piece_took_and_the_rest_is_at_most() {
    let mut house = House::lived_in(&[]);
    let records: f64 = ["total/a", "total/b"].map(|node| recorded(&house, node)).iter().sum();
    house.set("total.modulo=999983");
    let cost = house.plan(|plan, _| plan.cost());
    let certain: f64 = ["total/a", "total/b"]
        .map(|node| house.plan_of(node).seconds_certain)
        .iter()
        .sum();
    assert_eq!((certain, cost.untimed), (records, 0));
    assert_eq!(cost.certain, certain);
    assert!(cost.at_most > certain);
    let draws = house.plan_of("draws/a");
    assert!(draws.seconds > 0.0 && draws.seconds_certain == 0.0);
}

fn recorded(house: &House, node: &str) -> f64 {
    house.why(node).records.iter().map(|kept| kept.record.seconds).sum()
}

#[test]
fn a_piece_never_made_costs_the_median_of_its_node_or_else_of_its_stage() {
    let mut house = House::lived_in(&[]);
    let mut times: Vec<f64> = house
        .why("draws/a")
        .records
        .iter()
        .map(|kept| kept.record.seconds)
        .collect();
    times.sort_by(f64::total_cmp);
    house.set("draws.count=3");
    assert_eq!(house.plan_of("draws/a").seconds_certain, times[1]);
    house.set("run.bases=[\"a\",\"b\",\"c\"]");
    house.set("base.c.offset=7");
    let squares = house.plan_of("squares/c");
    assert_eq!((squares.will_run, squares.untimed), (3, 0));
    assert!(squares.seconds_certain > 0.0);
}
