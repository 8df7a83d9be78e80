//! Verify: rot found exactly where it is, and a rebuild that says who differs.

use crate::common::House;
use crate::common::records;
use encounter::engine::audit::{Audit, Finding, audit};
use encounter::engine::id::Id;
use std::fs;
use std::path::{Path, PathBuf};

const NOTHING: [&str; 0] = [];

fn audited(house: &House) -> Audit {
    audit(&house.store(), 2, &|done, all| assert!(done <= all)).expect("the store can be read")
}

fn paths(findings: &[Finding]) -> Vec<&str> {
    findings.iter().map(|finding| finding.path.as_str()).collect()
}

/// The path within the store.
fn within(house: &House, path: &Path) -> String {
    let inner = path.strip_prefix(house.path("store")).expect("a file of the store");
    inner.display().to_string()
}

fn flip(path: &Path, byte: usize) {
    let mut bytes = fs::read(path).expect("the file is there");
    bytes[byte] ^= 1 << (byte % 8);
    fs::write(path, bytes).expect("the file can be damaged");
}

#[test]
fn a_sound_store_has_nothing_to_tell() {
    let house = House::lived_in(&[]);
    let found = audited(&house);
    assert_eq!(
        (found.objects, found.records),
        (
            house.files_in("store/objects").len() as u64,
            house.files_in("store/records").len() as u64
        )
    );
    let files = ["objects", "records", "parts", "manifests"].map(|kind| house.files_in(&format!("store/{kind}")));
    let length = |path: &PathBuf| fs::metadata(path).expect("the file is there").len();
    assert_eq!(found.bytes, files.iter().flatten().map(length).sum::<u64>());
    assert!(
        found.damaged.is_empty() && found.missing.is_empty() && found.orphaned.is_empty(),
        "{found:?}"
    );
}

#[test]
fn a_flipped_bit_in_any_file_is_found_there_and_nowhere_else() {
    let house = House::new();
    let done = house.run();
    let (key, id) = done.known["squares/a/1"];
    let lists = [part(&house), manifest(&house, &[id, done.known["squares/a/2"].1])];
    for path in [house.object(&id), house.record(&key)].into_iter().chain(lists) {
        let good = fs::read(&path).expect("the file is there");
        for byte in (0..good.len())
            .step_by(7)
            .chain([0, 8, 16, 24, 32, 63, 64, good.len() - 1])
        {
            if byte >= good.len() {
                continue;
            }
            flip(&path, byte);
            let found = audited(&house);
            assert_eq!(paths(&found.damaged), [within(&house, &path)], "byte {byte}");
            assert!(!path.exists(), "byte {byte}");
            let is_object = path == house.object(&id);
            let node = if is_object { "squares/a, items 10 to 19" } else { "" };
            assert_eq!(found.damaged[0].node, node);
            assert_eq!(paths(&found.missing), NOTHING);
            fs::write(&path, &good).expect("the file can be put back");
        }
        let found = audited(&house);
        assert!(found.damaged.is_empty(), "{found:?}");
    }
    assert_eq!(house.files_in("store/quarantine").len(), 4);
}

/// Puts a manifest into the store: ids in a row, named by their hash.
fn manifest(house: &House, ids: &[Id]) -> PathBuf {
    let hex = Id::of_manifest(ids).to_string();
    let path = house.path("store/manifests").join(&hex[..2]).join(&hex[2..]);
    fs::create_dir_all(path.parent().expect("a folder")).expect("a folder can be made");
    let bytes: Vec<u8> = ids.iter().flat_map(|id| id.0).collect();
    fs::write(&path, bytes).expect("a manifest can be written");
    path
}

/// Puts a part into the store: an object whose last field is the BLAKE3 of what is before it, which is its name.
fn part(house: &House) -> PathBuf {
    let body = "{\"files\":{\"src/ship/roll_equation.rs\":\"00ff\"}";
    let hash = blake3::hash(body.as_bytes()).to_hex();
    let folder = house.path("store/parts");
    fs::create_dir_all(&folder).expect("a folder can be made");
    let path = folder.join(format!("{hash}.json"));
    fs::write(&path, format!("{body},\"check\":\"{hash}\"}}\n")).expect("a part can be written");
    path
}

#[test]
fn truncated_swapped_and_swollen_files_are_damaged() {
    let house = House::new();
    let done = house.run();
    let (key, id) = done.known["squares/a/1"];
    let (other_key, other_id) = done.known["squares/b/1"];
    for (path, other) in [
        (house.object(&id), house.object(&other_id)),
        (house.record(&key), house.record(&other_key)),
    ] {
        let good = fs::read(&path).expect("the file is there");
        let other = fs::read(other).expect("the file is there");
        let mut damages: Vec<Vec<u8>> = (0..good.len())
            .step_by(11)
            .map(|length| good[..length].to_vec())
            .collect();
        damages.extend([
            other,
            [good.as_slice(), b"x"].concat(),
            [good.as_slice(), vec![0; 1 << 20].as_slice()].concat(),
        ]);
        for (i, damaged) in damages.iter().enumerate() {
            fs::write(&path, damaged).expect("the file can be damaged");
            assert_eq!(paths(&audited(&house).damaged), [within(&house, &path)], "damage {i}");
        }
        fs::write(&path, &good).expect("the file can be put back");
    }
}

#[test]
fn what_was_damaged_is_missing_afterwards_and_made_again_by_a_run() {
    let house = House::new();
    let done = house.run();
    let (key, id) = done.known["squares/a/1"];
    flip(&house.object(&id), 70);
    assert_eq!(audited(&house).damaged.len(), 1);
    let found = audited(&house);
    assert_eq!(
        (found.damaged.len(), paths(&found.missing)),
        (0, vec![within(&house, &house.object(&id)).as_str()])
    );
    assert_eq!(found.missing[0].node, "squares/a, items 10 to 19");
    // A damaged record takes its object's name with it.
    flip(&house.record(&key), 9);
    let found = audited(&house);
    assert_eq!((found.damaged.len(), found.missing.len()), (1, 0));
    house.run().expect_success();
    let found = audited(&house);
    assert_eq!(
        found.damaged.len() + found.missing.len() + found.orphaned.len(),
        0,
        "{found:?}"
    );
}

#[test]
fn what_no_record_names_is_orphaned_and_stays() {
    let house = House::new();
    let done = house.run();
    let (key, id) = done.known["squares/a/1"];
    let stray = house.path("store/objects/00/notes.txt");
    fs::create_dir_all(stray.parent().expect("a folder")).expect("a folder can be made");
    fs::write(&stray, "mine").expect("a file can be written");
    fs::remove_file(house.record(&key)).expect("the record can be deleted");
    let found = audited(&house);
    let mut expected = vec![within(&house, &house.object(&id)), "objects/00/notes.txt".to_owned()];
    expected.sort();
    assert_eq!(paths(&found.orphaned), expected);
    assert_eq!((found.damaged.len(), found.missing.len()), (0, 0));
    assert!(stray.exists() && house.object(&id).exists());
}

#[test]
fn a_store_that_is_not_there_is_an_error_and_stays_so() {
    let house = House::new();
    let error = audit(
        &encounter::engine::store::Store::look(&house.path("store")),
        1,
        &|_, _| (),
    )
    .expect_err("there is no store");
    assert_eq!(error.exit_code(), 5);
    assert!(!house.path("store").exists());
}

#[test]
fn a_lock_that_says_otherwise_than_the_store_is_told() {
    let house = House::new();
    let lock = house.run().locked();
    assert_eq!(house.against_store(&lock), NOTHING);
    let flipped = |line: usize| {
        let mut lock = lock.clone();
        lock.lines[line].content.0[5] ^= 4;
        house.against_store(&lock)
    };
    for (place, line) in lock.lines.iter().enumerate().filter(|(_, line)| line.pieces.is_some()) {
        let differences = flipped(place);
        assert_eq!(differences.len(), 1, "{differences:?}");
        assert!(
            differences[0].starts_with(&format!("{}: the lock says ", line.name)),
            "{differences:?}"
        );
    }
    let mut longer = lock.clone();
    longer.lines[2].bytes += 1;
    assert_eq!(
        house.against_store(&longer),
        ["squares/b: another number of bytes in the lock than in the store"]
    );
}

#[test]
fn a_rebuild_of_an_unchanged_house_differs_in_nothing() {
    let mut house = House::new();
    let lock = house.run().locked();
    for workers in [1, 4] {
        house.workers = workers;
        let rebuilt = house.rebuild(&[], &lock).expect("a rebuild succeeds");
        assert_eq!((rebuilt.differences.as_slice(), rebuilt.downstream), ([].as_slice(), 0));
        assert!(rebuilt.first.is_none() && rebuilt.error(Path::new("toy.lock")).is_none());
    }
}

#[test]
fn a_rebuild_names_the_first_node_that_changed_and_its_first_value() {
    let mut house = House::new();
    let lock = house.run().locked();
    house.set("squares.fail_at=1000001");
    house.set("base.a.offset=3");
    let rebuilt = house.rebuild(&[], &lock).expect("a rebuild succeeds");
    let first = rebuilt.first.clone().expect("squares differ");
    assert_eq!(first.node, "squares/a/0", "its manifest leads to the old pieces");
    assert!(first.reproducible);
    assert!(first.verdict.contains("it came out the same"), "{}", first.verdict);
    // The other base has another recipe too, but the same squares; totals and reports follow.
    let names: Vec<&str> = rebuilt
        .differences
        .iter()
        .filter_map(|line| line.split(": ").next())
        .collect();
    assert_eq!(names, ["squares/a", "squares/b"]);
    assert!(rebuilt.downstream > 0);
    let error = rebuilt.error(Path::new("toy.lock")).expect("an error");
    assert_eq!(error.exit_code(), 3);
    assert!(
        error
            .to_string()
            .starts_with("toy.lock differs: squares/a: the lock says "),
        "{error}"
    );
}

#[test]
fn the_old_pieces_are_found_whatever_their_key_was() {
    let mut house = House::new();
    let done = house.run();
    let pieces = [0, 1, 2].map(|piece| done.known[&format!("squares/a/{piece}")].1);
    manifest(&house, &pieces);
    let lock = done.locked();
    // Squares come in pieces and are found by their manifest.
    house.set("base.a.offset=3");
    let first = house
        .rebuild(&[], &lock)
        .expect("a rebuild succeeds")
        .first
        .expect("squares differ");
    assert_eq!(
        (first.node.as_str(), first.earlier),
        ("squares/a/0", pieces[0].to_string())
    );
    let difference = first.difference.expect("the old object is there").to_string();
    assert!(
        difference.starts_with("[0]  ") && difference.ends_with("; 10 of 10 differ"),
        "{difference}"
    );
    // A total is in one piece: its content is its id.
    house.edits.clear();
    house.set("total.modulo=5");
    let first = house
        .rebuild(&[], &lock)
        .expect("a rebuild succeeds")
        .first
        .expect("the total differs");
    assert_eq!(first.node, "total/a");
    let difference = first.difference.expect("the old object is there").to_string();
    assert!(
        difference.starts_with("value  ") && difference.ends_with("; 1 of 1 differ"),
        "{difference}"
    );
}

#[test]
fn a_rebuild_of_a_target_compares_what_it_needs_and_no_more() {
    let house = House::new();
    let mut lock = house.run().locked();
    let line = lock.lines.iter_mut().find(|line| line.name == "aside").expect("a line");
    line.content.0[0] ^= 1;
    let rebuilt = house.rebuild(&["report"], &lock).expect("a rebuild succeeds");
    assert_eq!(rebuilt.differences, NOTHING);
    let rebuilt = house.rebuild(&["echo"], &lock).expect("a rebuild succeeds");
    assert_eq!(rebuilt.first.expect("aside differs").node, "aside");
}

#[test]
fn another_number_of_pieces_is_told_as_such() {
    let mut house = House::new();
    let lock = house.run().locked();
    house.set("draws.count=3");
    let rebuilt = house.rebuild(&[], &lock).expect("a rebuild succeeds");
    let first = rebuilt.first.clone().expect("draws differ");
    assert_eq!(
        (first.node.as_str(), first.verdict.as_str()),
        ("draws/a", "2 pieces -> 3")
    );
    assert_eq!(
        rebuilt.error(Path::new("toy.lock")).map(|error| error.exit_code()),
        Some(3)
    );
}

#[test]
fn a_lock_that_was_edited_is_a_difference_of_a_reproducible_stage() {
    let house = House::new();
    let mut lock = house.run().locked();
    let line = lock
        .lines
        .iter_mut()
        .find(|line| line.name == "total/a")
        .expect("a line");
    line.content.0[31] ^= 1;
    let rebuilt = house.rebuild(&[], &lock).expect("a rebuild succeeds");
    let error = rebuilt.error(Path::new("toy.lock")).expect("an error");
    assert_eq!(error.exit_code(), 3);
    let text = error.to_string();
    assert!(
        text.contains("total/a: the lock says ") && text.contains("or was edited"),
        "{text}"
    );
    assert!(
        text.contains("the lock was made with rustc of the test, this is rustc "),
        "{text}"
    );
}

#[test]
fn a_key_made_twice_with_two_ids_in_a_run_keeps_both_and_says_where_they_differ() {
    let mut house = House::lived_in(&["fickle.steady=false"]);
    // Fickle is left out of the store, so a new witness has it made again.
    house.set("witness.shift=1");
    let error = house.run().outcome.expect_err("fickle gives another number each time");
    assert_eq!(error.exit_code(), 4);
    let text = error.to_string();
    assert!(text.starts_with("fickle is not reproducible: recorded "), "{text}");
    assert!(text.contains("\n  value  ") && text.contains("1 of 1 differ"), "{text}");
    assert!(
        text.contains("it differs from itself; the new output is kept in quarantine/"),
        "{text}"
    );
    assert_eq!(house.files_in("store/quarantine").len(), 1);
}

#[test]
fn numbers_that_do_not_add_up_are_told_and_stop_nothing() {
    let house = House::new();
    let done = house.run();
    let (key, id) = done.known["squares/a/1"];
    records::edit(&house.record(&key), |record| {
        record["first"] = u64::MAX.into();
        record["items"] = u64::MAX.into();
        record["bytes"] = u64::MAX.into();
    });
    for number in 0..3 {
        let sparse = house.path("store/objects/00").join(format!("sparse-{number}"));
        fs::create_dir_all(sparse.parent().expect("a folder")).expect("a folder can be made");
        let file = fs::File::create(sparse).expect("a file can be made");
        // As long as the file system allows.
        (30..63)
            .rev()
            .find(|bits| file.set_len(1 << bits).is_ok())
            .expect("a sparse file");
    }
    flip(&house.object(&id), 70);
    let found = audited(&house);
    assert_eq!(found.damaged.len(), 1);
    assert_eq!(found.damaged[0].node, format!("squares/a, items {0} to {0}", u64::MAX));
    house.gc(0, true).expect("a plan");
    house.run().expect_success();
}
