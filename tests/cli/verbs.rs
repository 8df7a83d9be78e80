//! Verbs, JSON, published files and their folders.

use crate::common::program::{Program, keys};
use serde_json::Value;
use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

const EXACT: [&str; 13] = [
    "fig1_wave_groups",
    "fig2_flowchart",
    "fig3_exceedance",
    "fig4_response_moments",
    "fig5_vhgp_seq",
    "fig6_jonswap_groups",
    "fig7_temporal",
    "fig8_method_error",
    "table1",
    "groups",
    "truth",
    "findings",
    "index",
];

/// Every published file of one ship.
fn published() -> BTreeSet<String> {
    let extensions = |name: &str| match name {
        "groups" | "truth" => vec!["csv"],
        "table1" => vec!["svg", "csv", "md", "tex"],
        "findings" => vec!["md", "csv"],
        "index" => vec!["html"],
        _ => vec!["svg", "csv"],
    };
    let of = |name: &&str| {
        extensions(name)
            .into_iter()
            .map(|e| format!("{name}.{e}"))
            .collect::<Vec<_>>()
    };
    EXACT.iter().flat_map(of).collect()
}

fn files_in(folder: &Path) -> BTreeSet<String> {
    let entries = fs::read_dir(folder).into_iter().flatten().flatten();
    let files = entries.filter(|entry| entry.path().is_file());
    files
        .map(|entry| entry.file_name().to_string_lossy().into_owned())
        .collect()
}

fn states(status: &Value) -> BTreeSet<(String, String)> {
    let files = status["files"].as_array().expect("a list").iter();
    let text = |value: &Value| value.as_str().expect("text").to_owned();
    files.map(|file| (text(&file["path"]), text(&file["state"]))).collect()
}

#[test]
fn a_whole_run_is_told_shown_verified_and_repaired() {
    let program = Program::new("tiny");
    let before = program.json(&["status"]);
    let expected = [
        "cost",
        "figures",
        "files",
        "folder",
        "format",
        "nodes",
        "profile",
        "stale",
        "stale_files",
        "warnings",
    ];
    assert_eq!(keys(&before), expected);
    assert_eq!(before["profile"], "tiny");
    let node_keys = [
        "cached",
        "may_run",
        "node",
        "paper",
        "pieces",
        "reason",
        "reasons",
        "seconds",
        "seconds_certain",
        "untimed",
        "will_run",
    ];
    let sum = |status: &Value, key: &str| {
        let nodes = status["nodes"].as_array().expect("a list").iter();
        nodes.map(|node| node[key].as_u64().expect("a number")).sum::<u64>()
    };
    for node in before["nodes"].as_array().expect("a list") {
        assert_eq!(keys(node), node_keys);
        assert_eq!(
            (&node["reason"], &node["reasons"][0]["kind"]),
            (&"first time".into(), &"first_time".into())
        );
    }
    assert_eq!(sum(&before, "cached"), 0);
    assert_eq!(sum(&before, "pieces"), sum(&before, "will_run"));
    assert_eq!(before["figures"].as_array().map(Vec::len), Some(20));
    assert_eq!(before["cost"]["untimed"].as_u64(), Some(sum(&before, "pieces")));
    assert!(states(&before).iter().all(|(_, state)| state == "missing"));
    assert!(!program.checkout("artifacts/figures").exists());

    let run = program.json(&["run", "--update-lock"]);
    let expected = [
        "failed", "files", "folder", "format", "healed", "lock", "ran", "removed", "replaced", "reused", "seconds",
        "stale", "warnings",
    ];
    assert_eq!(keys(&run), expected);
    let ran = run["ran"].as_array().expect("a list");
    assert_eq!(ran.len() as u64, sum(&before, "pieces"));
    assert_eq!(keys(&ran[0]), ["node", "piece", "seconds"]);
    assert_eq!(
        (run["reused"].as_u64(), run["failed"].as_array().map(Vec::len)),
        (Some(0), Some(0))
    );
    let file = &run["files"][0];
    assert_eq!(keys(file), ["id", "path", "written"]);
    assert_eq!(file["id"].as_str().map(str::len), Some(64));
    let figures = program.checkout("artifacts/figures/tiny");
    assert_eq!(program.folder_of(&run), figures);
    let mut expected = published();
    expected.insert("parameters.toml".to_owned());
    assert_eq!(files_in(&figures), expected);
    assert_eq!(files_in(&figures.join("printed")), published());
    assert_eq!(run["files"].as_array().map(Vec::len), Some(2 * published().len()));

    let again = program.json(&["run"]);
    assert_eq!(again["ran"].as_array().map(Vec::len), Some(0));
    assert_eq!(again["reused"].as_u64(), Some(ran.len() as u64));
    let after = program.json(&["status"]);
    assert_eq!(sum(&after, "cached"), sum(&after, "pieces"));
    assert!(states(&after).iter().all(|(_, state)| state == "current"));
    let nothing = serde_json::json!({"certain": 0.0, "at_most": 0.0, "untimed": 0});
    assert_eq!((&after["cost"], &after["figures"]), (&nothing, &serde_json::json!([])));
    let dry = program.json(&["run", "--dry-run"]);
    assert_eq!((&dry["nodes"], &dry["files"]), (&after["nodes"], &after["files"]));

    shows_nodes(&program);
    csv_follows_the_contract(&figures);
    verifies(&program, &figures);
}

fn shows_nodes(program: &Program) {
    let shown = program.json(&["show", "ground_truth/calibrated-S1/0"]);
    let expected = [
        "bytes", "code", "format", "id", "inputs", "key", "node", "params", "piece", "seconds", "value",
    ];
    assert_eq!(keys(&shown), expected);
    assert_eq!(shown["node"], "ground_truth/calibrated-S1");
    assert_eq!(shown["params"]["ship"]["beta_1"], 0.1466);
    assert_eq!(shown["inputs"].as_array().map(Vec::len), Some(2));
    assert_eq!(shown["value"]["fields"][0].as_array().map(Vec::len), Some(16));
    // An evicted output is made again to be shown; epsilon_1 may be named in a case.
    assert_eq!(
        program.json(&["show", "wave_synthesis/S1"])["node"],
        "wave_synthesis/S1"
    );
    assert_eq!(
        program.json(&["show", "nic/calibrated-S1-0.002"])["node"],
        "nic/calibrated-S1"
    );
    let text = program.call(&["show", "table1"]);
    assert_eq!(text.code, 0);
    assert!(
        text.stdout.starts_with("Table 1  table1/calibrated\n"),
        "{}",
        text.stdout
    );
    let other = program.call(&["show", "table1", "--set", "vhgp_seq.total=20"]);
    assert_eq!(other.code, 2);
    assert!(other.stderr.contains("not made yet"), "{}", other.stderr);
}

fn csv_follows_the_contract(figures: &Path) {
    let heads = [
        (
            "fig3_exceedance",
            "ship,spectrum,epsilon_1,theta_t,method,probability,standard_error,n",
        ),
        ("fig5_vhgp_seq", "method,n_samples,mean,std"),
        (
            "table1",
            "spectrum,theta_t,p_true,p_true_se,sequential_mean,sequential_std,random_mean,random_std,paper_p_true,\
             paper_sequential_mean,paper_sequential_std_percent,paper_random_mean,paper_random_std_percent,best_mean,best_std,\
             lhs_mean,lhs_std,control_mean,control_std",
        ),
        (
            "groups",
            "spectrum,fields,groups_per_tp,l_over_tp_mean,l_over_tp_sd,a_over_hs_mean,a_over_hs_sd,correlation,\
             share_a_over_hs_gt_1",
        ),
        (
            "truth",
            "ship,spectrum,epsilon_1,fields,groups,capsizes,temporal_exceedance_025",
        ),
    ];
    for (name, head) in heads {
        let text = fs::read_to_string(figures.join(format!("{name}.csv"))).expect("a published file");
        assert_eq!(text.lines().next(), Some(head));
        let commas = head.matches(',').count();
        assert!(text.lines().all(|line| line.matches(',').count() == commas), "{name}");
        assert!(
            text.ends_with('\n') && !text.contains('\r') && !text.contains("NaN"),
            "{name}"
        );
        assert!(text.lines().count() > 1, "{name}");
    }
    let rows = |name: &str| fs::read_to_string(figures.join(name)).expect("a published file");
    assert!(
        rows("fig3_exceedance.csv")
            .lines()
            .skip(1)
            .all(|row| row.starts_with("calibrated,"))
    );
    assert!(
        rows("printed/fig3_exceedance.csv")
            .lines()
            .skip(1)
            .all(|row| row.starts_with("printed,"))
    );
    // What does not depend on the ship is the same bytes twice.
    for same in ["groups.csv", "truth.csv", "fig1_wave_groups.svg", "fig2_flowchart.svg"] {
        assert_eq!(rows(same), rows(&format!("printed/{same}")), "{same}");
    }
}

fn verifies(program: &Program, figures: &Path) {
    let equal = program.json(&["verify", "--lock"]);
    assert_eq!(
        keys(&equal),
        [
            "compared",
            "differences",
            "format",
            "lines",
            "lock",
            "stale",
            "toolchains"
        ]
    );
    assert_eq!(equal["differences"].as_array().map(Vec::len), Some(0));
    let lock = program.lock_text();
    let lines = lock.lines().filter(|line| !line.starts_with("made-with ")).count();
    assert_eq!(equal["lines"].as_u64(), Some(lines as u64 - 2));

    let parameter = program.exits(3, &["verify", "--lock", "--set", "ship.printed.alpha_1=0.02"]);
    assert!(
        parameter
            .stderr
            .contains("its parameters or inputs are not those of the lock, its code is"),
        "{}",
        parameter.stderr
    );
    assert!(!parameter.stderr.contains("calibrated"), "{}", parameter.stderr);

    let table = figures.join("table1.csv");
    let ours = fs::read(&table).expect("a published file");
    fs::write(&table, "mine").expect("the file can be written");
    let edited = states(&program.json(&["status"]));
    let not_current: Vec<_> = edited.iter().filter(|(_, state)| state != "current").collect();
    assert_eq!(not_current, [&("table1.csv".to_owned(), "edited".to_owned())]);
    let said = program.call(&["verify", "--lock", "--json"]);
    assert_eq!(
        (said.code, said.json()["differences"].as_array().map(Vec::len)),
        (3, Some(1))
    );
    assert!(
        said.stderr
            .contains("file table1.csv: its bytes are not those of the lock"),
        "{}",
        said.stderr
    );
    program.exits(0, &["run"]);
    assert_eq!(fs::read(&table).expect("a published file"), ours);
    program.exits(0, &["verify", "--lock"]);
    assert_eq!(program.lock_text(), lock);

    program.exits(0, &["verify", "--rebuild", "-j", "1"]);
    let lock_file = program.checkout("artifacts/tiny.lock");
    let line = lock
        .lines()
        .find(|line| line.starts_with("cic/printed-S2 "))
        .expect("a line");
    let content = line.split_whitespace().nth(3).expect("its content");
    fs::write(&lock_file, lock.replace(content, &"0".repeat(64))).expect("the lock can be written");
    let rebuilt = program.exits(3, &["verify", "--rebuild"]);
    assert!(
        rebuilt.stderr.contains("differs: cic/printed-S2: the lock says 000"),
        "{}",
        rebuilt.stderr
    );
    fs::write(&lock_file, "hostile").expect("the lock can be written");
    program.exits(5, &["verify", "--lock"]);
    fs::remove_file(&lock_file).expect("the lock can be deleted");
    program.exits(5, &["verify", "--lock"]);
}

/// What makes a run cheap: one sea and one ship.
pub(crate) const SMALL: [&str; 4] = ["--set", "run.seas=[\"S1\"]", "--set", "run.ships=[\"calibrated\"]"];

#[test]
fn a_what_if_writes_to_a_folder_of_its_own_and_no_lock() {
    let program = Program::new("tiny");
    let run = program.json(&[&["run", "groups"], SMALL.as_slice()].concat());
    let first = program.folder_of(&run);
    let files = BTreeSet::from(["groups.csv".to_owned(), "parameters.toml".to_owned()]);
    assert_eq!(files_in(&first), files);
    assert_eq!(run["files"][0]["path"], "groups.csv");
    let overlay = program.file("my.toml", "[run]\nseas = [\"S2\"]\n");
    let second = program.folder_of(&program.json(&["run", "groups", "--overlay", &overlay]));
    assert_ne!(first, second);
    let text = fs::read_to_string(second.join("groups.csv")).expect("a published file");
    assert!(text.lines().nth(1).is_some_and(|row| row.starts_with("S2,")), "{text}");
    assert!(!program.checkout("artifacts/tiny.lock").exists());
    assert!(!program.checkout("artifacts/figures/tiny").exists());
    assert!(!program.path("store/figures").exists());
    // A named figures folder is obeyed, and a target alone writes no lock either.
    let figures = program.path("elsewhere").display().to_string();
    assert_eq!(program.call(&["run", "groups", "--figures", &figures]).code, 0);
    assert_eq!(files_in(&program.path("elsewhere")), files);
    assert!(!program.checkout("artifacts/tiny.lock").exists());
}

#[test]
fn an_overlay_may_add_a_sea_and_a_ship() {
    let program = Program::new("tiny");
    let overlay = program.file(
        "mine.toml",
        "[run]\nseas = [\"North\"]\nships = [\"tanker_2\"]\n\
         [sea.North]\nspectrum = \"jonswap\"\nsignificant_wave_height = 9\npeak_period = 13.0\ngamma = 3.3\n\
         [ship.tanker_2]\nalpha_1 = 0.02\nalpha_2 = 0.3\ndamping = \"quadratic\"\nbeta_1 = 0.12\nbeta_2 = -0.05\n\
         epsilon_1 = [0.0, 0.001]\nepsilon_2 = 0.003\n",
    );
    let folder = program.folder_of(&program.json(&["run", "truth", "--overlay", &overlay]));
    let text = fs::read_to_string(folder.join("truth.csv")).expect("a published file");
    let rows: Vec<&str> = text.lines().skip(1).collect();
    assert_eq!(rows.len(), 2, "{text}");
    assert!(rows.iter().all(|row| row.starts_with("tanker_2,North,")), "{text}");
}

#[test]
fn sets_come_after_overlays_and_later_overlays_after_earlier_ones() {
    let program = Program::new("tiny");
    let first = program.file("first.toml", "[sea.S1]\npeak_period = 11.0\nbandwidth = 0.05\n");
    let second = program.file(
        "second.toml",
        "[sea.S1]\npeak_period = 12.0\nsignificant_wave_height = 7\n",
    );
    let node = "wave_synthesis/S1";
    let options = [
        "--overlay",
        &first,
        "--overlay",
        &second,
        "--set",
        "sea.S1.significant_wave_height=8.5",
    ];
    assert_eq!(program.call(&[&["run", node], options.as_slice()].concat()).code, 0);
    let sea = &program.json(&[&["show", node], options.as_slice()].concat())["params"]["sea"];
    let found = [&sea["significant_wave_height"], &sea["peak_period"], &sea["bandwidth"]];
    assert_eq!(found.map(Value::as_f64), [Some(8.5), Some(12.0), Some(0.05)]);
}
