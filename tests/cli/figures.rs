//! What-ifs and published sets on the real binary: names, folders, parameters, leftovers, links.

use crate::cli::verbs::SMALL;
use crate::common::program::Program;
use serde_json::{Value, json};
use std::fs;
use std::os::unix::fs::symlink;
use std::path::Path;

fn small(arguments: &[&'static str]) -> Vec<&'static str> {
    [arguments, SMALL.as_slice()].concat()
}

fn text(path: &Path) -> String {
    fs::read_to_string(path).unwrap_or_else(|why| panic!("{}: {why}", path.display()))
}

/// The paths of a status that are not missing, by state.
fn paths<'a>(answer: &'a Value, key: &str) -> Vec<&'a str> {
    let list = answer[key].as_array().expect("a list").iter();
    list.map(|path| path.as_str().expect("text")).collect()
}

#[test]
fn each_set_of_parameters_has_a_folder_of_its_own_that_says_which_they_are() {
    let program = Program::new("tiny");
    let one = program.json(&small(&["run", "truth", "--set", "run.seed=5"]));
    let two = program.json(&small(&["run", "truth", "--set", "run.seed=6"]));
    let again = program.json(&small(&["run", "truth", "--set", "run.seed=6", "--set", "run.seed=5"]));
    let (first, second) = (program.folder_of(&one), program.folder_of(&two));
    assert_ne!(first, second);
    assert_eq!(program.folder_of(&again), first);
    let name = first.file_name().expect("a name").to_string_lossy();
    let digits = name.strip_prefix("whatif-").expect("a name of its own");
    assert!(
        digits.len() == 8 && digits.bytes().all(|byte| byte.is_ascii_hexdigit()),
        "{name}"
    );
    assert_ne!(text(&first.join("truth.csv")), text(&second.join("truth.csv")));
    // The answer for people names the folder at its end.
    let said = program.exits(0, &small(&["run", "truth", "--set", "run.seed=5"]));
    let told = format!("1 file in artifacts/figures/{name}, 0 written");
    assert!(said.stdout.contains(&told), "{}", said.stdout);

    // The parameters inside give the same figures again, as an overlay of the profile.
    let parameters = text(&first.join("parameters.toml"));
    assert!(parameters.starts_with("# All parameters"), "{parameters}");
    assert!(parameters.contains("profile tiny"), "{parameters}");
    let overlay = first.join("parameters.toml").display().to_string();
    let same = program.json(&["run", "truth", "--overlay", &overlay, "--name", "same"]);
    assert_eq!(same["ran"], json!([]));
    let folder = program.checkout("artifacts/figures/same");
    assert_eq!(program.folder_of(&same), folder);
    assert_eq!(text(&folder.join("truth.csv")), text(&first.join("truth.csv")));
    assert!(text(&folder.join("parameters.toml")).contains("profile tiny, name same"));
}

#[test]
fn a_name_that_is_taken_by_other_parameters_is_refused_unless_it_may_be_replaced() {
    let program = Program::new("tiny");
    let run = |seed: &'static str, more: &[&'static str]| {
        let arguments = [&["run", "truth", "groups", "--name", "heavy", "--set", seed], more].concat();
        program.call(&small(&arguments))
    };
    assert_eq!(run("run.seed=5", &[]).code, 0);
    assert_eq!(run("run.seed=5", &[]).code, 0);
    let folder = program.checkout("artifacts/figures/heavy");
    let before = text(&folder.join("groups.csv"));
    let said = run("run.seed=6", &[]);
    assert_eq!((said.code, said.stdout.as_str()), (2, ""));
    assert!(
        said.stderr
            .contains("artifacts/figures/heavy: expected the figures of these parameters"),
        "{}",
        said.stderr
    );
    assert_eq!(text(&folder.join("groups.csv")), before);
    // Replaced by a run of one output alone, the other one of the old set goes.
    let arguments = ["run", "truth", "--name", "heavy", "--set", "run.seed=6", "--replace"];
    let answer = program.json(&small(&arguments));
    assert_eq!(paths(&answer, "removed"), ["groups.csv"]);
    assert!(!folder.join("groups.csv").exists());
}

#[test]
fn a_name_that_is_none_or_that_names_no_what_if_is_refused() {
    let program = Program::new("tiny");
    for name in ["", "..", "a/b", "quick", "Tiny", "a.lock", "/x"] {
        let said = program.exits(2, &[&["status", "--name", name], SMALL.as_slice()].concat());
        assert!(said.stderr.contains("--name: expected "), "{name}: {}", said.stderr);
    }
    let said = program.exits(2, &["run", "truth", "--name", "mine"]);
    assert!(
        said.stderr.contains("expected --overlay or --set with it"),
        "{}",
        said.stderr
    );
    program.exits(2, &small(&["run", "truth", "--replace"]));
    assert!(!program.checkout("artifacts/figures").exists() && !program.path("store").exists());
}

#[test]
fn figures_of_a_ship_that_is_no_longer_run_are_named_by_status_and_verify_and_removed_by_one_command() {
    let program = Program::new("tiny");
    let figures = program.path("figures").display().to_string();
    let both = [
        "run",
        "truth",
        "groups",
        "--set",
        "run.seas=[\"S1\"]",
        "--figures",
        &figures,
    ];
    assert_eq!(program.call(&both).code, 0);
    let printed = program.path("figures/printed");
    assert!(printed.join("truth.csv").is_file());
    fs::write(printed.join("groups.csv"), "mine").expect("a figure can be edited");
    fs::write(printed.join("notes.csv"), "a stranger's").expect("a file can be written");
    let one = [SMALL.as_slice(), &["--figures", &figures]].concat();
    let expected = ["printed/groups.csv", "printed/truth.csv"];
    assert_eq!(
        paths(&program.json(&[&["status"], one.as_slice()].concat()), "stale_files"),
        expected
    );
    let said = program.call(&[&["status"], one.as_slice()].concat());
    assert!(
        said.stdout
            .contains("stale, `encounter gc --stale` removes: printed/truth.csv"),
        "{}",
        said.stdout
    );
    assert!(
        said.stdout
            .contains("stale and edited by hand, for you to remove: printed/groups.csv"),
        "{}",
        said.stdout
    );
    program.commit_lock();
    let said = program.call(&[&["verify", "--lock", "--json"], one.as_slice()].concat());
    assert_eq!(paths(&said.json(), "stale"), expected);

    let dry = program.json(&[&["gc", "--stale", "--dry-run"], one.as_slice()].concat());
    assert_eq!(
        (paths(&dry, "removed"), paths(&dry, "kept")),
        (vec!["printed/truth.csv"], vec!["printed/groups.csv"])
    );
    assert!(printed.join("truth.csv").is_file());
    let done = program.json(&[&["gc", "--stale"], one.as_slice()].concat());
    assert_eq!((&done["removed"], &done["kept"]), (&dry["removed"], &dry["kept"]));
    assert!(!printed.join("truth.csv").exists());
    assert_eq!(text(&printed.join("groups.csv")), "mine");
    assert_eq!(text(&printed.join("notes.csv")), "a stranger's");
    assert!(program.path("figures/truth.csv").is_file());
}

#[test]
fn a_link_below_the_figures_of_the_checkout_is_refused_by_name() {
    for link in [
        "artifacts/figures",
        "artifacts/figures/mine",
        "artifacts/figures/mine/printed",
    ] {
        let program = Program::new("tiny");
        let target = program.path("elsewhere");
        fs::create_dir(&target).expect("a folder can be made");
        let link = program.checkout(link);
        fs::create_dir_all(link.parent().expect("a folder")).expect("a folder can be made");
        symlink(&target, &link).expect("a link can be made");
        let said = program.exits(2, &["run", "truth", "--set", "run.seas=[\"S1\"]", "--name", "mine"]);
        assert!(
            said.stderr.contains(": expected a folder, found a link"),
            "{}",
            said.stderr
        );
        assert_eq!(fs::read_dir(&target).expect("a folder").count(), 0);
    }
}
