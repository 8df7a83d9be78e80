//! Each reason is shown to arise, and the walk ends at the root.

use crate::common::{House, records};
use encounter::engine::reason::Reason;
use encounter::engine::why::{Branch, Why};
use serde_json::json;
use std::fs;

/// `NODE: sentences` for every node of the tree, upstream ones behind those they lead to.
fn told(why: &Why) -> Vec<String> {
    fn add(branch: &Branch, lines: &mut Vec<String>) {
        let sentences: Vec<String> = branch.reasons.iter().map(ToString::to_string).collect();
        lines.push(
            format!("{}: {}", branch.node, sentences.join("; "))
                .trim_end()
                .to_owned(),
        );
        branch.because.iter().for_each(|branch| add(branch, lines));
    }
    let mut lines = Vec::new();
    why.because.iter().for_each(|branch| add(branch, &mut lines));
    lines
}

/// All reasons of a tree.
fn reasons(why: &Why) -> Vec<Reason> {
    fn add(branch: &Branch, found: &mut Vec<Reason>) {
        found.extend(branch.reasons.iter().cloned());
        branch.because.iter().for_each(|branch| add(branch, found));
    }
    let mut found = Vec::new();
    why.because.iter().for_each(|branch| add(branch, &mut found));
    found
}

#[test]
fn the_first_time() {
    let house = House::new();
    let why = house.why("total/a");
    assert_eq!(
        (why.state, told(&why)),
        ("will_run", vec!["total/a: first time".to_owned()])
    );
    let besides: Vec<(&str, usize, usize)> = why
        .besides
        .iter()
        .map(|it| (it.stage.as_str(), it.nodes, it.pieces))
        .collect();
    assert_eq!(besides, [("numbers", 1, 3), ("squares", 1, 3)]);
    assert_eq!((why.cost.certain, why.cost.untimed), (0.0, 7));
}

#[test]
fn a_parameter_with_old_new_and_the_place_where_it_was_written() {
    let mut house = House::lived_in(&[]);
    house.text = house.text.replace("offset = 2", "offset = 3");
    let parameter = Reason::Parameter {
        name: "base.b.offset".to_owned(),
        old: "2".to_owned(),
        new: "3".to_owned(),
        origin: "toy.toml:13".to_owned(),
    };
    assert_eq!(reasons(&house.why("squares/b")), [parameter]);
    assert_eq!(house.plan_of("squares/b").reason, "parameter `base.b.offset` 2 -> 3");
    house.set("base.b.offset=4");
    assert_eq!(reasons(&house.why("squares/b"))[0].origin(), Some("--set"));
    // The other base is as it was.
    assert_eq!(house.why("squares/a").state, "cached");
}

#[test]
fn a_parameter_of_a_row_under_its_place_in_the_file() {
    let mut house = House::lived_in(&[]);
    house.text = house.text.replace("level = 20", "level = 21");
    assert_eq!(
        told(&house.why("draws")),
        ["draws/b: parameter `draws.row[1].level` 20 -> 21"]
    );
    assert_eq!(reasons(&house.why("draws"))[0].origin(), Some("toy.toml:23"));
}

#[test]
fn the_seed() {
    let mut house = House::lived_in(&[]);
    house.set("run.seed=8");
    assert_eq!(told(&house.why("numbers")), ["numbers: seed `run.seed` 7 -> 8"]);
}

#[test]
fn a_file_and_a_crate() {
    let house = House::new();
    let (key, _) = house.run().known["aside/0"];
    let store = house.path("store");
    records::age(&house.record(&key), |record| {
        record["code"] = json!("1".repeat(64));
        record["parts"]["code"] = records::part(&store, &record["parts"]["code"], |part| {
            part["files"] = json!({"src/toy/aside.rs": "ab", "src/toy/gone.rs": "cd"});
            part["crates"] = json!({"pxfm": [{"version": "0.1.30", "checksum": "aa", "declared": "0.1"}]});
        });
    });
    // The toy's stages have no code table: all there was is gone. The real binary's is in tests/cli/why.rs.
    let expected = [
        "`src/toy/aside.rs` is no longer used",
        "`src/toy/gone.rs` is no longer used",
        "crate `pxfm` 0.1.30 -> none",
    ];
    assert_eq!(told(&house.why("aside")), [format!("aside: {}", expected.join("; "))]);
    assert_eq!(house.plan_of("echo").reason, "input `aside` runs first");
}

#[test]
fn the_key_schema() {
    let house = House::new();
    let (key, _) = house.run().known["aside/0"];
    records::age(&house.record(&key), |record| record["keys"] = json!(0));
    assert_eq!(told(&house.why("aside")), ["aside: key schema 0 -> 1"]);
}

#[test]
fn a_record_from_before_parts_is_a_hit_and_tells_what_it_can() {
    let house = House::new();
    let done = house.run();
    for (key, _) in done.known.values() {
        records::edit(&house.record(key), |record| {
            for later in ["parts", "keys", "made"] {
                record.as_object_mut().expect("an object").remove(later);
            }
        });
    }
    fs::remove_dir_all(house.path("store/parts")).expect("the parts can be deleted");
    assert_eq!(house.run().ran(), [""; 0]);
    let mut house = house;
    house.set("total.modulo=999983");
    let sentence = "its parameters changed (recorded before the old ones were kept)";
    assert_eq!(house.plan_of("total/a").reason, sentence);
    assert_eq!(
        told(&house.why("report/small")),
        [
            "report/small:".to_owned(),
            "draws/a:".to_owned(),
            format!("total/a: {sentence}"),
        ]
    );
}

#[test]
fn a_damaged_part_makes_why_say_less_and_nothing_else() {
    let mut house = House::lived_in(&[]);
    for path in house.files_in("store/parts") {
        fs::write(path, "{}").expect("the part can be damaged");
    }
    assert_eq!(house.run().ran(), [""; 0]);
    house.set("aside.value=6");
    assert!(house.plan_of("aside").reason.starts_with("its parameters changed ("));
    // The next record's parts are whole again.
    house.run().expect_success();
    house.set("aside.value=7");
    assert_eq!(house.plan_of("aside").reason, "parameter `aside.value` 6 -> 7");
}

#[test]
fn an_object_missing() {
    let mut house = House::new();
    let done = house.run();
    fs::remove_file(house.object(&done.known["total/a/0"].1)).expect("the object can be deleted");
    // Nobody needs it.
    assert_eq!(house.why("total").state, "cached");
    assert_eq!(house.why("report/small").state, "cached");
    house.set("draws.count=3");
    assert_eq!(told(&house.why("total")), ["total/a: object missing"]);
}

#[test]
fn an_object_or_record_damaged() {
    let house = House::new();
    let done = house.run();
    let (key, id) = done.known["total/a/0"];
    fs::write(house.object(&id), "short").expect("the object can be damaged");
    let sentence = "object damaged: 5 bytes, too short for a header";
    assert_eq!(told(&house.why("total")), [format!("total/a: {sentence}")]);
    let quarantine = house.path("store/quarantine").join(id.to_string());
    fs::rename(house.object(&id), quarantine).expect("the object can be moved");
    assert_eq!(
        told(&house.why("total")),
        ["total/a: object damaged: it lies in quarantine"]
    );
    fs::write(house.record(&key), "{}").expect("the record can be damaged");
    assert_eq!(told(&house.why("total")), ["total/a: record damaged"]);
}

#[test]
fn evicted_and_needed() {
    let mut house = House::lived_in(&[]);
    assert_eq!(house.why("numbers").state, "cached");
    house.set("base.a.offset=5");
    assert_eq!(
        told(&house.why("numbers")),
        ["numbers: evicted, and needed by `squares/a`"]
    );
    // That is no reason for what reads it.
    assert_eq!(
        told(&house.why("squares/a")),
        ["squares/a: parameter `base.a.offset` 1 -> 5"]
    );
}

#[test]
fn an_input_that_changed_already_is_followed_to_what_changed_there() {
    let mut house = House::lived_in(&[]);
    house.set("base.a.offset=5");
    house.run_targets(&["total"]).expect_success();
    let why = house.why("report/small");
    assert_eq!(
        (why.state, told(&why)),
        (
            "will_run",
            vec![
                "report/small:".to_owned(),
                "draws/a:".to_owned(),
                "total/a:".to_owned(),
                "squares/a: parameter `base.a.offset` 1 -> 5".to_owned(),
            ]
        )
    );
    let total = &why.because[0].because[0].because[0];
    assert_eq!((total.state, total.pieces), ("changed", 0));
    let reason = house.plan_of("draws/a").reason;
    assert!(
        reason.starts_with("input `total/a` ") && reason.contains(".. -> "),
        "{reason}"
    );
}

#[test]
fn an_input_whose_past_is_gone_is_itself_the_root() {
    let mut house = House::new();
    let old = house.run().known["total/a/0"];
    house.set("total.modulo=999983");
    let new = house.run_targets(&["total"]).known["total/a/0"].1;
    fs::remove_file(house.record(&old.0)).expect("the record can be deleted");
    let input = Reason::Input {
        name: "total/a".to_owned(),
        old: old.1.to_string(),
        new: new.to_string(),
    };
    assert!(reasons(&house.why("draws/a")).contains(&input));
}

#[test]
fn a_count_that_was_raised_or_lowered() {
    let mut house = House::lived_in(&[]);
    house.set("draws.count=3");
    assert_eq!(
        told(&house.why("report/small")),
        ["report/small:", "draws/a: parameter `draws.count` 2 -> 3",]
    );
    let draws = &house.why("report/small").because[0].because[0];
    assert_eq!((draws.cases, draws.pieces, draws.of), (2, 2, 6));
    house.run().expect_success();
    house.set("draws.count=1");
    assert_eq!(
        told(&house.why("report/small")),
        ["report/small:", "draws/a: parameter `draws.count` 3 -> 1",]
    );
}

#[test]
fn a_list_of_cases_that_was_edited() {
    let mut house = House::lived_in(&[]);
    house.set("run.bases=[\"b\"]");
    let expected = ["report/small: parameter `run.bases` [\"a\", \"b\"] -> [\"b\"]"];
    assert_eq!(told(&house.why("report/small")), expected);
}

#[test]
fn the_walk_ends_at_the_root_and_tells_equal_roots_once() {
    let mut house = House::lived_in(&[]);
    house.set("numbers.label=another");
    let why = house.why("report");
    assert_eq!(why.state, "may_run");
    // Both reports, both bases and both ways from report to total lead to the one root.
    let expected = [
        "report/small:",
        "draws/a:",
        "total/a:",
        "squares/a:",
        "numbers: parameter `numbers.label` \"any\" -> \"another\"",
    ];
    assert_eq!(told(&why), expected);
    let report = &why.because[0];
    let squares = &report.because[0].because[0].because[0];
    assert_eq!((report.cases, squares.cases, squares.pieces, squares.of), (2, 2, 6, 6));
    assert_eq!(why.besides, []);
    let numbers = &squares.because[0];
    assert!(numbers.cost.certain > 0.0 && squares.cost.certain == 0.0 && squares.cost.at_most > 0.0);
    assert_eq!(why.cost.certain, numbers.cost.certain);
}

#[test]
fn two_roots_are_both_told_each_where_it_lies() {
    let mut house = House::lived_in(&[]);
    house.set("base.a.offset=5");
    house.set("total.modulo=999983");
    house.set("scale.large.factor=7");
    assert_eq!(
        told(&house.why("report/large")),
        [
            "report/large: parameter `scale.large.factor` 100 -> 7",
            "draws/a:",
            "total/a: parameter `total.modulo` 1000000007 -> 999983",
            "squares/a: parameter `base.a.offset` 1 -> 5",
        ]
    );
}

#[test]
fn content_that_came_out_equal_leaves_everything_below_cached() {
    let mut house = House::lived_in(&[]);
    house.set("numbers.label=another");
    house.run_targets(&["numbers"]).expect_success();
    let why = house.why("report");
    assert_eq!((why.state, why.because.len(), why.records.len()), ("cached", 0, 2));
    assert_eq!(why.cost.at_most, 0.0);
}

#[test]
fn a_cached_node_answers_with_the_record_that_makes_it_so() {
    let house = House::new();
    let done = house.run();
    let why = house.why("squares/a/1");
    assert_eq!(why.state, "cached");
    let (key, id) = done.known["squares/a/1"];
    let record = &why.records[0].record;
    assert_eq!((&record.key, &record.id), (&key.to_string(), &id.to_string()));
    assert_eq!((why.records.len(), record.first, record.items), (1, 10, 10));
    assert_eq!(why.records[0].reads, ["numbers"]);
    assert_eq!(house.why("squares/a").records.len(), 3);
}

#[test]
fn one_piece_costs_no_more_than_what_it_reads() {
    let mut house = House::lived_in(&[]);
    house.set("numbers.label=another");
    let piece = house.why("squares/a/1");
    let all = house.why("squares/a");
    assert_eq!(piece.state, "may_run");
    assert!(piece.cost.certain > 0.0 && piece.cost.certain < all.cost.certain);
}

#[test]
fn the_nearest_record_explains_not_the_last_one() {
    let mut house = House::lived_in(&[]);
    // Another scale of the same paper, in the same store, run later.
    let own = std::mem::take(&mut house.edits);
    house.set("total.modulo=11");
    house.set("base.a.offset=70");
    house.run().expect_success();
    house.edits = own;
    house.set("squares.fail_at=2000000");
    assert_eq!(
        told(&house.why("squares/a")),
        ["squares/a: parameter `squares.fail_at` 1000000 -> 2000000"]
    );
}

#[test]
fn of_equally_near_records_the_latest_explains() {
    let mut house = House::lived_in(&["aside.value=6"]);
    std::thread::sleep(std::time::Duration::from_millis(2));
    house.set("aside.value=9");
    house.run().expect_success();
    house.set("aside.value=7");
    assert_eq!(told(&house.why("aside")), ["aside: parameter `aside.value` 9 -> 7"]);
}

#[test]
fn reasons_are_data_with_their_kind() {
    let mut house = House::lived_in(&[]);
    house.set("aside.value=6");
    let json = serde_json::to_value(house.why("echo")).expect("JSON");
    let root = &json["because"][0]["because"][0];
    assert_eq!(root["node"], "aside");
    let expected = json!({"kind": "parameter", "name": "aside.value", "old": "5", "new": "6", "origin": "--set"});
    assert_eq!(root["reasons"], json!([expected]));
    assert_eq!(root["state"], "will_run");
    assert_eq!(json["because"][0]["state"], "may_run");
}
