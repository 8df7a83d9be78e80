//! Pieces: more of them keep the old ones.

use crate::common::House;

const NOTHING: [&str; 0] = [];

#[test]
fn raising_a_count_keeps_the_old_pieces() {
    let mut house = House::lived_in(&["draws.count=100"]);
    house.set("draws.count=200");
    let ran = house.run().ran();
    let of = |node: &str| ran.iter().filter(|piece| piece.starts_with(node)).count();
    assert_eq!((of("draws/a/"), of("draws/b/"), of("report/")), (100, 100, 2));
    assert_eq!(ran.len(), 202);
    assert!(!ran.contains(&"draws/a/99".to_owned()) && ran.contains(&"draws/a/199".to_owned()));
    house.set("draws.count=100");
    assert_eq!(house.run().ran(), NOTHING);
}

#[test]
fn a_longer_record_keeps_its_full_batches() {
    let mut house = House::lived_in(&["numbers.count=25"]);
    house.set("numbers.count=45");
    let ran: Vec<String> = house.run().ran();
    let numbers: Vec<&String> = ran.iter().filter(|piece| piece.starts_with("numbers")).collect();
    // The third batch held five items and now holds ten.
    assert_eq!(numbers, ["numbers/2", "numbers/3", "numbers/4"]);
    let squares = ran.iter().filter(|piece| piece.starts_with("squares/a")).count();
    assert_eq!(squares, 3);
}

#[test]
fn one_changed_piece_reruns_its_own_followers_alone() {
    // The third batch of 25 numbers is shorter: only it differs from that of 30.
    let mut house = House::lived_in(&[]);
    house.set("numbers.count=25");
    let ran = house.run().ran();
    let each: Vec<&String> = ran.iter().filter(|piece| piece.starts_with("squares")).collect();
    assert_eq!(each, ["squares/a/2", "squares/b/2"]);
    assert!(ran.contains(&"total/a/0".to_owned()));
}

#[test]
fn a_piece_that_is_named_runs_alone_with_what_it_reads() {
    let house = House::new();
    let named = house.run_targets(&["squares/a/1"]);
    assert_eq!(named.ran(), ["numbers/1", "squares/a/1"]);
    assert_eq!(house.run_targets(&["squares/a/1"]).ran(), NOTHING);
    // Two of one node; one that reads a whole node.
    assert_eq!(
        house.run_targets(&["squares/a/0", "squares/a/1"]).ran(),
        ["numbers/0", "squares/a/0"]
    );
    let draw = house.run_targets(&["draws/a/1"]).ran();
    assert_eq!(draw, ["draws/a/1", "numbers/2", "squares/a/2", "total/a/0"]);
    // The whole run makes the rest, and comes to what it always comes to.
    let whole = house.run();
    assert!(!whole.ran().iter().any(|piece| draw.contains(piece)));
    assert_eq!(whole.locked(), House::new().run().locked());
}

#[test]
fn more_than_one_shared_synchronisation_loses_no_record() {
    let house = House::lived_in(&["draws.count=150"]);
    assert_eq!(house.run().ran(), NOTHING);
    assert_eq!(house.files_in("store/tmp"), Vec::<std::path::PathBuf>::new());
}
