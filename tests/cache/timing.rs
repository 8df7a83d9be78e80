//! What each stage took, by a run's events and by the records of a store.

use crate::common::{Done, EVERYTHING, House};
use encounter::engine::event::Event;
use encounter::engine::store::Store;
use encounter::engine::timing::{StageTime, by_stage, recorded};

fn of_run(house: &House, done: &Done) -> Vec<StageTime> {
    let graph = house.graph(&[]).expect("the parameters are in order");
    let pieces = done.events.iter().filter_map(|event| match event {
        Event::DidRun {
            node, seconds, bytes, ..
        } => Some((&**node, *seconds, *bytes)),
        _ => None,
    });
    by_stage(&graph, pieces)
}

fn of_records(house: &House, targets: &[&str]) -> Vec<StageTime> {
    let graph = house.graph(targets).expect("the parameters are in order");
    recorded(&graph, &Store::look(&house.path("store")))
}

fn stages(times: &[StageTime]) -> Vec<&str> {
    times.iter().map(|of| of.stage).collect()
}

#[test]
fn the_records_tell_of_each_stage_what_the_run_that_made_it_told() {
    let house = House::new();
    let done = house.run();
    let (ran, kept) = (of_run(&house, &done), of_records(&house, &[]));
    assert_eq!(stages(&ran), stages(&kept));
    for (ran, kept) in ran.iter().zip(&kept) {
        assert_eq!(
            (ran.nodes, ran.pieces, ran.bytes),
            (kept.nodes, kept.pieces, kept.bytes),
            "{}",
            ran.stage
        );
        // The sums are over the same numbers in another order.
        assert!(
            (ran.seconds - kept.seconds).abs() <= 1e-9 * kept.seconds,
            "{}",
            ran.stage
        );
    }
    assert_eq!(kept.iter().map(|of| of.pieces).sum::<usize>(), EVERYTHING.len());
    let squares = kept.iter().find(|of| of.stage == "squares").expect("squares were made");
    assert_eq!((squares.nodes, squares.pieces), (2, 6));
}

#[test]
fn stages_are_told_in_paper_order_whatever_ran_first() {
    let house = House::new();
    let graph = house.graph(&[]).expect("the parameters are in order");
    let mut order: Vec<&str> = graph.nodes.iter().map(|it| it.node.name()).collect();
    order.dedup();
    assert_eq!(stages(&of_run(&house, &house.run())), order);
}

#[test]
fn what_did_not_run_is_not_among_what_ran_and_stays_in_the_records() {
    let mut house = House::lived_in(&[]);
    house.set("witness.shift=1");
    let done = house.run();
    assert_eq!(stages(&of_run(&house, &done)), ["witness"]);
    assert_eq!(of_run(&house, &house.run()), []);
    assert_eq!(
        of_records(&house, &[]).iter().map(|of| of.pieces).sum::<usize>(),
        EVERYTHING.len()
    );
}

#[test]
fn of_a_target_only_what_it_needs_is_told() {
    let house = House::lived_in(&[]);
    assert_eq!(
        stages(&of_records(&house, &["total/a"])),
        ["numbers", "squares", "total"]
    );
}

#[test]
fn a_piece_that_two_cases_share_was_made_once_and_is_counted_once() {
    let mut house = House::new();
    house.set("run.bases=[\"a\", \"c\"]");
    house.set("draws.row=[{ base = \"a\", level = 10 }, { base = \"c\", level = 20 }]");
    house.set("pinned.base=\"a\"");
    house.run().expect_success();
    let kept = of_records(&house, &["squares"]);
    let squares = kept.iter().find(|of| of.stage == "squares").expect("squares were made");
    assert_eq!((squares.nodes, squares.pieces), (1, 3));
}

#[test]
fn an_object_deleted_or_a_store_that_is_not_there_is_no_matter() {
    let house = House::new();
    assert_eq!(of_records(&house, &[]), []);
    assert!(!house.path("store").exists());
    let done = house.run();
    std::fs::remove_file(house.object(&done.known["total/a/0"].1)).expect("the object can be deleted");
    assert_eq!(
        of_records(&house, &[]).iter().map(|of| of.pieces).sum::<usize>(),
        EVERYTHING.len()
    );
}
