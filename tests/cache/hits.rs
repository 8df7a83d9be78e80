//! What runs and what does not.

use std::fs::{self, File};
use std::path::{Path, PathBuf};

use crate::common::{EVERYTHING, House};

const NOTHING: [&str; 0] = [];

#[test]
fn the_first_run_runs_everything_and_the_second_nothing() {
    let house = House::new();
    let first = house.run();
    first.expect_success();
    assert_eq!(first.ran(), EVERYTHING);
    assert_eq!(first.reused(), NOTHING);
    let files = [
        "large/pinned.csv",
        "large/report.csv",
        "large/report.md",
        "pinned.csv",
        "report.csv",
        "report.md",
    ];
    assert_eq!(first.written(), files);
    let second = house.run();
    assert_eq!(second.ran(), NOTHING);
    assert_eq!(second.reused(), EVERYTHING);
    assert_eq!(second.written(), NOTHING);
    assert_eq!(first.known, second.known);
    assert_eq!(first.locked(), second.locked());
}

#[test]
fn an_edited_parameter_reruns_the_stage_that_reads_it_and_what_changes_below() {
    let mut house = House::lived_in(&[]);
    house.set("witness.shift=1");
    assert_eq!(house.run().ran(), ["witness/0"]);
    house.set("aside.value=6");
    assert_eq!(house.run().ran(), ["aside/0", "echo/0"]);
    house.set("scale.large.factor=7");
    assert_eq!(house.run().ran(), ["report/large/0"]);
    house.set("total.modulo=999983");
    let below_total = [
        "draws/a/0",
        "draws/a/1",
        "draws/b/0",
        "draws/b/1",
        "pinned/b/0",
        "report/large/0",
        "report/small/0",
        "total/a/0",
        "total/b/0",
    ];
    assert_eq!(house.run().ran(), below_total);
    assert_eq!(house.run().ran(), NOTHING);
}

#[test]
fn equal_bytes_upstream_rerun_nothing_below() {
    let mut house = House::lived_in(&[]);
    house.set("numbers.label=another");
    let done = house.run();
    assert_eq!(done.ran(), ["numbers/0", "numbers/1", "numbers/2"]);
    assert_eq!(done.reused().len(), EVERYTHING.len() - 3);
    assert_eq!(done.written(), NOTHING);
}

#[test]
fn the_edit_of_a_published_stage_writes_only_the_files_that_change() {
    let mut house = House::lived_in(&[]);
    house.set("pinned.item=4");
    let done = house.run();
    assert_eq!(done.ran(), ["pinned/b/0"]);
    assert_eq!(done.written(), ["large/pinned.csv", "pinned.csv"]);
}

#[test]
fn reverting_an_edit_runs_nothing_and_brings_the_files_back() {
    let mut house = House::new();
    let before = house.run().locked();
    house.set("base.a.offset=9");
    house.set("run.seed=8");
    let edited = house.run();
    assert!(edited.ran().len() > 15, "{:?}", edited.ran());
    house.edits.clear();
    let done = house.run();
    assert_eq!(done.ran(), NOTHING);
    assert_eq!(done.written().len(), 6);
    assert_eq!(done.locked(), before);
}

#[test]
fn a_target_runs_what_it_needs_and_publishes_itself_alone() {
    let house = House::new();
    let done = house.run_targets(&["pinned"]);
    done.expect_success();
    let needed = [
        "numbers/0",
        "numbers/1",
        "numbers/2",
        "pinned/b/0",
        "squares/b/0",
        "squares/b/1",
        "squares/b/2",
        "total/b/0",
    ];
    assert_eq!(done.ran(), needed);
    assert_eq!(done.written(), ["large/pinned.csv", "pinned.csv"]);
    assert_eq!(house.run_targets(&["echo"]).ran(), ["aside/0", "echo/0"]);
}

#[test]
fn a_failure_is_not_cached_and_stops_its_own_downstream_alone() {
    let mut house = House::new();
    house.set("aside.fail=true");
    for attempt in 0..2 {
        let done = house.run();
        let error = done.outcome.as_ref().expect_err("the run fails");
        let message = "aside failed: told to fail\n2 nodes are not done; the others are kept";
        assert_eq!((error.to_string().as_str(), error.exit_code()), (message, 1));
        assert_eq!(done.failed(), ["aside/0"]);
        let ran = if attempt == 0 { EVERYTHING.len() - 2 } else { 0 };
        assert_eq!(done.ran().len(), ran);
    }
    house.set("aside.fail=false");
    assert_eq!(house.run().ran(), ["aside/0", "echo/0"]);
}

#[test]
fn every_failed_piece_is_listed_and_its_neighbours_are_kept() {
    let mut house = House::new();
    house.set("squares.fail_at=13");
    let done = house.run();
    let message = done.outcome.as_ref().expect_err("the run fails").to_string();
    assert_eq!(done.failed(), ["squares/a/1", "squares/b/1"]);
    let told: Vec<&str> = message.lines().collect();
    let expected = [
        "squares/a/1 failed: cannot square item 13",
        "squares/b/1 failed: cannot square item 13",
        "9 nodes are not done; the others are kept",
    ];
    assert_eq!(told, expected);
    assert!(done.ran().contains(&"squares/a/0".to_owned()));
    assert!(!house.path("figures").exists());
    // Another key, but for these two pieces alone nothing else was missing above them.
    house.set("squares.fail_at=1000000");
    assert!(!house.run().ran().iter().any(|piece| piece.starts_with("numbers")));
}

#[test]
fn a_stage_that_panics_is_a_failure_and_nobody_waits_for_it() {
    let mut house = House::new();
    house.set("squares.panic_at=0");
    let done = house.run();
    assert_eq!(done.failed(), ["squares/a/0", "squares/b/0"]);
    assert_eq!(done.outcome.expect_err("the run fails").exit_code(), 1);
}

#[test]
fn a_stage_made_twice_with_two_contents_is_reported() {
    let mut house = House::lived_in(&["fickle.steady=false"]);
    assert_eq!(house.run().ran(), NOTHING);
    house.set("witness.shift=1");
    let error = house.run().outcome.expect_err("fickle is made again");
    assert_eq!(error.exit_code(), 4);
    let message = error.to_string();
    assert!(
        message.starts_with("fickle is not reproducible: recorded "),
        "{message}"
    );
}

#[test]
fn a_file_edited_by_hand_is_restored() {
    let house = House::lived_in(&[]);
    let path = house.path("figures/report.csv");
    let ours = std::fs::read(&path).expect("the file is published");
    std::fs::write(&path, "mine").expect("the file can be written");
    let done = house.run();
    assert_eq!((done.ran().len(), done.written()), (0, vec!["report.csv".to_owned()]));
    assert_eq!(std::fs::read(&path).expect("the file is published"), ours);
}

/// Edits a file without changing its length; size and time of modification are as before.
fn edit_in_secret(path: &Path, byte: usize) {
    let mut bytes = fs::read(path).expect("a file");
    let before = fs::metadata(path).expect("a file");
    bytes[byte] ^= 1;
    fs::write(path, &bytes).expect("a file can be edited");
    let file = File::options().append(true).open(path).expect("a file can be opened");
    let times = before.modified().expect("files have times");
    file.set_modified(times).expect("times can be set back");
    let after = fs::metadata(path).expect("a file");
    assert_eq!((after.len(), after.modified().ok()), (before.len(), Some(times)));
}

fn figures(house: &House) -> Vec<(PathBuf, Vec<u8>)> {
    let paths = house.files_in("figures").into_iter();
    paths
        .map(|path| (path.clone(), fs::read(path).expect("a figure")))
        .collect()
}

#[test]
fn an_edited_figure_under_the_same_size_and_time_is_seen_and_restored() {
    let house = House::lived_in(&[]);
    let good = figures(&house);
    assert_eq!(good.len(), 6);
    for (path, bytes) in &good {
        edit_in_secret(path, bytes.len() - 2);
        let done = house.run();
        let counts = (done.ran().len(), done.set_aside().len(), done.written().len());
        assert_eq!(counts, (0, 1, 1), "{}", path.display());
        assert_eq!(figures(&house), good);
    }
}

#[test]
fn a_figure_deleted_replaced_or_turned_into_a_link_is_made_again_and_the_target_of_the_link_stays() {
    let house = House::lived_in(&[]);
    let good = figures(&house);
    let (figure, mine) = (house.path("figures/report.csv"), house.path("mine.csv"));
    fs::remove_file(&figure).expect("a figure can be deleted");
    assert_eq!(house.run().written(), ["report.csv"]);
    fs::write(&mine, "mine").expect("a file can be written");
    fs::rename(&mine, &figure).expect("a figure can be replaced");
    assert_eq!(house.run().written(), ["report.csv"]);
    assert_eq!(figures(&house), good);
    for target in [house.path("figures/large/report.csv"), house.path("nowhere")] {
        let before = fs::read(&target).ok();
        fs::remove_file(&figure).expect("a figure can be deleted");
        std::os::unix::fs::symlink(&target, &figure).expect("a link can be made");
        house.run().expect_success();
        assert!(figure.symlink_metadata().expect("a figure").is_file());
        assert_eq!((fs::read(&target).ok(), figures(&house)), (before, good.clone()));
    }
}

#[test]
fn a_published_output_with_a_flipped_bit_under_the_same_time_is_healed_by_the_next_run() {
    let house = House::lived_in(&[]);
    let done = house.run();
    let object = house.object(&done.known["report/small/0"].1);
    let good = fs::read(&object).expect("the object is there");
    edit_in_secret(&object, 80);
    let done = house.run();
    assert_eq!(
        (done.healed(), done.written().len()),
        (vec!["report/small/0".to_owned()], 0)
    );
    assert_eq!(fs::read(&object).expect("the object is there"), good);
}

#[test]
fn an_inner_output_with_a_flipped_bit_is_left_while_nobody_reads_it_and_healed_by_the_first_reader() {
    let mut house = House::lived_in(&[]);
    let done = house.run();
    let object = house.object(&done.known["total/a/0"].1);
    let good = fs::read(&object).expect("the object is there");
    edit_in_secret(&object, 66);
    assert_eq!(house.run().healed(), NOTHING);
    house.set("scale.small.factor=3");
    let done = house.run();
    done.expect_success();
    assert_eq!(done.healed(), ["total/a/0"]);
    assert_eq!(fs::read(&object).expect("the object is there"), good);
}

#[test]
fn a_record_that_is_lost_or_damaged_is_made_again() {
    let house = House::lived_in(&[]);
    let known = house.run().known;
    let records: Vec<PathBuf> = house.files_in("store/records");
    assert!(records.len() > 5);
    for (i, record) in records.iter().enumerate() {
        let whole = fs::read(record).expect("a record");
        if i % 2 == 0 {
            fs::remove_file(record).expect("a record can be deleted");
        } else {
            edit_in_secret(record, i % whole.len());
        }
        let done = house.run();
        assert!(!done.ran().is_empty() && record.is_file(), "{}", record.display());
        assert_eq!(done.known, known);
    }
}
