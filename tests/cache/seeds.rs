//! Random streams come from names: not from counts, batches, threads or cases.

use crate::common::House;
use crate::common::toy::{NUMBERS, OTHER_BATCHES};
use encounter::engine::pipeline::Pipeline;

/// All numbers of a pipeline that makes nothing else.
fn numbers(pipeline: Pipeline, count: usize, batch: usize, edits: &[&str]) -> Vec<u64> {
    let mut house = House::new();
    house.pipeline = pipeline;
    "[run]\nseed = 7\n[numbers]\nspan = 1000000\nlabel = \"any\"\n".clone_into(&mut house.text);
    house.set(&format!("numbers.count={count}"));
    for edit in edits {
        house.set(edit);
    }
    let all: Vec<u64> = (0..count.div_ceil(batch))
        .flat_map(|piece| house.value::<Vec<u64>>("numbers", piece))
        .collect();
    assert_eq!(all.len(), count);
    all
}

#[test]
fn seeds_do_not_depend_on_counts() {
    let few = numbers(NUMBERS, 25, 10, &[]);
    let many = numbers(NUMBERS, 43, 10, &[]);
    assert_eq!(few, many[..25]);
    let mut distinct = many.clone();
    distinct.sort_unstable();
    distinct.dedup();
    assert!(distinct.len() >= 42, "{many:?}");
}

#[test]
fn seeds_do_not_depend_on_batches() {
    assert_eq!(numbers(NUMBERS, 43, 10, &[]), numbers(OTHER_BATCHES, 43, 7, &[]));
}

#[test]
fn the_root_seed_changes_every_stream() {
    let one = numbers(NUMBERS, 43, 10, &[]);
    let other = numbers(NUMBERS, 43, 10, &["run.seed=8"]);
    assert!(one.iter().zip(&other).filter(|(a, b)| a == b).count() <= 1);
}

#[test]
fn one_and_many_workers_give_the_same_lock() {
    let locks: Vec<_> = [1, 2, 7]
        .into_iter()
        .map(|workers| {
            let mut house = House::new();
            house.workers = workers;
            house.set("draws.count=40");
            house.run().locked()
        })
        .collect();
    assert_eq!(locks[0], locks[1]);
    assert_eq!(locks[0], locks[2]);
}

#[test]
fn stages_and_items_have_streams_of_their_own() {
    let house = House::lived_in(&[]);
    let draws = |base: &str, piece| house.value::<Vec<u64>>(&format!("draws/{base}"), piece)[2];
    // All cases meet the same stream.
    assert_eq!(draws("a", 0), draws("b", 0));
    assert_ne!(draws("a", 0), draws("a", 1));
}
