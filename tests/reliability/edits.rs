//! Edits: of published files, and of parameters while a run is at work.

use crate::cli::verbs::SMALL;
use crate::common::House;
use crate::common::program::Program;
use std::fs;
use std::thread::sleep;
use std::time::Duration;

const NOTHING: [&str; 0] = [];

#[test]
fn a_figure_edited_by_hand_is_kept_aside_and_restored() {
    let house = House::lived_in(&[]);
    let path = house.path("figures/large/report.csv");
    let ours = fs::read(&path).expect("the file is published");
    for edit in ["mine", "mine again", "mine"] {
        fs::write(&path, edit).expect("the file can be edited");
        let done = house.run();
        assert_eq!(done.ran(), NOTHING);
        assert_eq!(
            (done.set_aside(), done.written()),
            (done.written(), vec!["large/report.csv".to_owned()])
        );
        assert_eq!(fs::read(&path).expect("the file is restored"), ours);
    }
    // The same edit twice is one copy.
    let kept = house.files_in("artifacts/edited");
    let texts: Vec<String> = kept
        .iter()
        .map(|path| fs::read_to_string(path).expect("a copy"))
        .collect();
    assert_eq!(
        (texts.len(), texts.concat().len()),
        (2, "mine again".len() + "mine".len())
    );
    assert!(
        kept.iter()
            .all(|path| path.starts_with(house.path("artifacts/edited/large")))
    );
    assert_eq!(house.run().set_aside(), NOTHING);
}

#[test]
fn a_figure_of_an_earlier_run_is_outdated_not_edited() {
    let mut house = House::lived_in(&[]);
    house.set("pinned.item=4");
    let done = house.run();
    assert_eq!((done.written().len(), done.set_aside()), (2, Vec::new()));
    house.edits.clear();
    assert_eq!(house.run().set_aside(), NOTHING);
}

#[test]
fn a_figure_that_the_lock_names_is_ours_in_a_new_clone() {
    let mut house = House::new();
    let lock = house.run().locked();
    fs::remove_file(house.path("artifacts/published")).expect("the list can be deleted");
    fs::write(house.path("artifacts/toy.lock"), lock.text()).expect("a lock can be written");
    house.set("pinned.item=4");
    assert_eq!(house.run().set_aside(), NOTHING);
    // Without the lock nobody knows whose the files are.
    fs::remove_dir_all(house.path("artifacts")).expect("the folder can be deleted");
    house.set("pinned.item=5");
    assert_eq!(house.run().set_aside(), ["large/pinned.csv", "pinned.csv"]);
}

#[test]
fn status_and_run_tell_of_an_edited_figure() {
    let program = Program::new("tiny");
    let arguments = [&["truth", "groups"], SMALL.as_slice()].concat();
    let run = [&["run"], arguments.as_slice()].concat();
    let file = program.folder_of(&program.json(&run)).join("groups.csv");
    let ours = fs::read(&file).expect("the file is published");
    fs::write(&file, "sea\nmine\n").expect("the file can be edited");
    let states = |program: &Program, more: &[&str]| {
        let status = program.json(&[&["status"], arguments.as_slice(), more].concat());
        let files = status["files"].as_array().expect("a list").iter();
        let text = |value: &serde_json::Value| value.as_str().expect("text").to_owned();
        files
            .map(|file| (text(&file["path"]), text(&file["state"])))
            .collect::<Vec<_>>()
    };
    let state = |file: &str, state: &str| (file.to_owned(), state.to_owned());
    assert_eq!(
        states(&program, &[]),
        [state("groups.csv", "edited"), state("truth.csv", "current")]
    );
    // Also where the nodes themselves would run anew.
    let folder = file.parent().expect("a folder").display().to_string();
    let other = ["--set", "run.seed=5", "--figures", &folder];
    assert_eq!(
        states(&program, &other),
        [state("groups.csv", "edited"), state("truth.csv", "outdated")]
    );
    let said = program.call(&run);
    assert_eq!(said.code, 0);
    assert!(
        said.stderr.contains("groups.csv: edited by hand; moved to "),
        "{}",
        said.stderr
    );
    assert_eq!(fs::read(&file).expect("the file is restored"), ours);
    let kept: Vec<_> = fs::read_dir(program.checkout("artifacts/edited"))
        .expect("a folder")
        .flatten()
        .collect();
    assert_eq!(kept.len(), 1);
    assert_eq!(fs::read_to_string(kept[0].path()).expect("a copy"), "sea\nmine\n");
}

#[test]
fn parameters_changed_during_a_run_are_the_next_runs_reason() {
    let program = Program::new("tiny");
    let text = |shift: &str| {
        format!("[run]\nseas = [\"S1\"]\nships = [\"calibrated\"]\n[ship.calibrated]\nalpha_1 = {shift}\n")
    };
    let overlay = program.file("my.toml", text("0.06"));
    let child = program.start(&["run", "truth", "--json", "--overlay", &overlay]);
    // The parameters were read before the first record is there.
    let begun = || fs::read_dir(program.path("store/objects")).is_ok_and(|objects| objects.count() > 0);
    while !begun() {
        sleep(Duration::from_millis(5));
    }
    program.file("my.toml", text("0.07"));
    assert!(child.wait_with_output().expect("the process ends").status.success());
    let damping = |program: &Program| {
        let shown = program.json(&["show", "ground_truth/calibrated-S1", "--overlay", &overlay]);
        shown["params"]["ship"]["alpha_1"].as_f64().expect("a number")
    };
    let changed = program.ran(&["truth", "--overlay", &overlay]);
    assert!(changed.contains_key("ground_truth/calibrated-S1"), "{changed:?}");
    assert!(!changed.contains_key("group_detection/S1"), "{changed:?}");
    assert_eq!(damping(&program), 0.07);
    // What the first run made is recorded under what it read.
    program.file("my.toml", text("0.06"));
    assert_eq!(program.ran(&["truth", "--overlay", &overlay]).len(), 0);
    assert_eq!(damping(&program), 0.06);
}
