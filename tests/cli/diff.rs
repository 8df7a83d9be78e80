//! `encounter diff` on the real binary, in a repository of its own.

use crate::common::program::keys;
use serde_json::{Value, json};
use std::fs;
use std::path::Path;
use std::process::{Command, Output};
use tempfile::TempDir;

/// The committed files of the paper in a repository with one commit.
struct Repository(TempDir);

const TREE: [&str; 8] = [
    "stages/paper.toml",
    "stages/quick.toml",
    "artifacts/paper.lock",
    "artifacts/quick.lock",
    "figures/table1.csv",
    "figures/fig3_exceedance.csv",
    "figures/printed/table1.csv",
    "figures/printed/fig3_exceedance.csv",
];

impl Repository {
    fn new() -> Self {
        let repository = Self(tempfile::tempdir().expect("a temporary folder can be made"));
        for path in TREE {
            let text = fs::read(Path::new(env!("CARGO_MANIFEST_DIR")).join(path)).expect("the file is committed");
            let copy = repository.0.path().join(path);
            fs::create_dir_all(copy.parent().expect("a folder")).expect("a folder can be made");
            fs::write(copy, text).expect("a file can be written");
        }
        repository.git(&["init", "--quiet"]);
        repository.commit();
        repository
    }

    fn git(&self, arguments: &[&str]) {
        let who = ["-c", "user.name=toy", "-c", "user.email=toy@example.org"];
        let mut git = Command::new("git");
        git.env("GIT_CONFIG_GLOBAL", "/dev/null")
            .env("GIT_CONFIG_NOSYSTEM", "1");
        let status = git.current_dir(self.0.path()).args(who).args(arguments).status();
        assert!(status.expect("git runs").success(), "{arguments:?}");
    }

    fn commit(&self) {
        self.git(&["add", "--all"]);
        self.git(&["commit", "--quiet", "--message", "A state"]);
    }

    /// Replaces the first occurrence of a passage, which must be there.
    fn edit(&self, path: &str, old: &str, new: &str) {
        let path = self.0.path().join(path);
        let text = fs::read_to_string(&path).expect("the file is there");
        assert!(text.contains(old), "{} lacks `{old}`", path.display());
        fs::write(path, text.replacen(old, new, 1)).expect("the file can be written");
    }

    fn command(&self, arguments: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_encounter"));
        command.current_dir(self.0.path()).arg("diff").args(arguments);
        command
    }

    fn call(&self, arguments: &[&str]) -> Output {
        self.command(arguments).output().expect("the binary runs")
    }

    #[track_caller]
    fn json(&self, arguments: &[&str]) -> Value {
        let output = self.call(&[arguments, &["--json"]].concat());
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        serde_json::from_slice(&output.stdout).expect("one JSON object")
    }
}

#[track_caller]
fn refusal(output: &Output) -> String {
    assert_eq!((output.status.code(), output.stdout.len()), (Some(2), 0));
    String::from_utf8_lossy(&output.stderr).into_owned()
}

#[test]
fn nothing_edited_is_all_equal() {
    let repository = Repository::new();
    let diff = repository.json(&["HEAD"]);
    let expected = [
        "commit",
        "files",
        "format",
        "nodes",
        "parameters",
        "profile",
        "revision",
        "tables",
    ];
    assert_eq!(keys(&diff), expected);
    assert_eq!(
        (&diff["parameters"], &diff["nodes"], &diff["files"]),
        (&json!([]), &json!([]), &json!([]))
    );
    assert_eq!(diff["commit"].as_str().map(str::len), Some(40));
    let tables = diff["tables"].as_array().expect("a list");
    assert_eq!(tables.len(), 4);
    assert!(tables.iter().all(|table| table["cells"] == json!([])));
}

#[test]
fn parameters_nodes_and_cells_with_old_new_and_relative_change() {
    let repository = Repository::new();
    let lock = fs::read_to_string(repository.0.path().join("artifacts/paper.lock")).expect("the lock is there");
    let content = |name: &str| {
        let line = lock.lines().find(|line| line.starts_with(name)).expect("a line");
        line.split_whitespace().nth(3).expect("its content").to_owned()
    };
    let (cic, other) = (content("cic/calibrated-S2 "), "0".repeat(64));
    repository.edit("artifacts/paper.lock", &cic, &other);
    repository.edit("stages/paper.toml", "bandwidth = 0.03 ", "bandwidth = 0.035 ");
    // The same number spelt otherwise is the same number.
    repository.edit("stages/paper.toml", "peak_period = 15.0", "peak_period = 15");
    let table = fs::read_to_string(repository.0.path().join("figures/table1.csv")).expect("the table is there");
    let row = table.lines().find(|line| line.starts_with("S2,0.9,")).expect("its row");
    let p_true = row.split(',').nth(2).expect("its probability");
    let doubled = 2.0 * p_true.parse::<f64>().expect("a number");
    repository.edit(
        "figures/table1.csv",
        &format!("S2,0.9,{p_true},"),
        &format!("S2,0.9,{doubled},"),
    );
    repository.edit(
        "figures/fig3_exceedance.csv",
        "calibrated,S1,0,0,truth,1,",
        "calibrated,S1,0,0,truth,0.5,",
    );
    let diff = repository.json(&["HEAD"]);
    let parameter = &diff["parameters"];
    assert_eq!(parameter.as_array().map(Vec::len), Some(1), "{parameter}");
    assert_eq!(parameter[0]["name"], "sea.S2.bandwidth");
    assert_eq!(
        (&parameter[0]["old"], &parameter[0]["new"]),
        (&json!("0.03"), &json!("0.035"))
    );
    assert!(
        parameter[0]["origin"]
            .as_str()
            .is_some_and(|place| place.starts_with("stages/paper.toml:"))
    );
    let node = json!([{"name": "cic/calibrated-S2", "change": "content", "old": cic, "new": other}]);
    assert_eq!(diff["nodes"], node);
    let cells = |ship: &str, file: &str| {
        let tables = diff["tables"].as_array().expect("a list").iter();
        let of = tables
            .clone()
            .find(|table| table["ship"] == ship && table["file"] == file);
        of.expect("the table is compared")["cells"].clone()
    };
    let table = cells("calibrated", "table1.csv");
    assert_eq!(
        (&table[0]["row"], &table[0]["column"]),
        (&json!("S2"), &json!("p_true"))
    );
    assert_eq!(
        (table.as_array().map(Vec::len), &table[0]["relative"]),
        (Some(1), &json!(1.0))
    );
    let figure = cells("calibrated", "fig3_exceedance.csv");
    assert_eq!(
        (&figure[0]["row"], &figure[0]["relative"]),
        (&json!("calibrated S1 0 0 truth"), &json!(-0.5))
    );
    assert_eq!(cells("printed", "table1.csv"), json!([]));
    let text = String::from_utf8(repository.call(&["HEAD"]).stdout).expect("text");
    for part in [
        "  sea.S2.bandwidth  0.03 -> 0.035  stages/paper.toml:",
        "nodes: 1 changed\n",
        "-> 0000..",
        "table1 of calibrated: 1 cell\n  S2  p_true  0.0",
        "  +100.00 %",
        "fig3_exceedance of calibrated: 1 cell\n",
        "table1 of printed: equal",
    ] {
        assert!(text.contains(part), "`{part}`: {text}");
    }
}

#[test]
fn the_past_is_read_from_the_revision_and_not_from_the_work_tree() {
    let repository = Repository::new();
    repository.edit("stages/paper.toml", "seed = 2022", "seed = 2023");
    repository.commit();
    repository.edit("stages/paper.toml", "seed = 2023", "seed = 2024");
    let seeds = |revision: &str| {
        let diff = repository.json(&[revision]);
        (
            diff["parameters"][0]["old"].clone(),
            diff["parameters"][0]["new"].clone(),
        )
    };
    assert_eq!(seeds("HEAD"), (json!("2023"), json!("2024")));
    assert_eq!(seeds("HEAD~1"), (json!("2022"), json!("2024")));
    let what_if = repository.json(&["HEAD~1", "--set", "run.seed=2022"]);
    assert_eq!(what_if["parameters"], json!([]));
}

#[test]
fn a_small_profile_compares_parameters_and_lock() {
    let repository = Repository::new();
    repository.edit("stages/quick.toml", "fields = 960", "fields = 480");
    let diff = repository.json(&["HEAD", "--profile", "quick"]);
    assert_eq!(
        (&diff["parameters"][0]["name"], &diff["nodes"]),
        (&json!("record.fields"), &json!([]))
    );
    assert_eq!(diff["tables"], json!([]));
}

#[test]
fn what_one_side_lacks_is_said() {
    let repository = Repository::new();
    fs::remove_file(repository.0.path().join("figures/table1.csv")).expect("the file can be deleted");
    fs::remove_file(repository.0.path().join("artifacts/paper.lock")).expect("the file can be deleted");
    let text = String::from_utf8(repository.call(&["HEAD"]).stdout).expect("text");
    assert!(text.contains("nodes: no paper.lock on both sides"), "{text}");
    assert!(text.contains("table1 of calibrated: no figures/table1.csv"), "{text}");
    repository.commit();
    repository.git(&["checkout", "--quiet", "HEAD~1", "--", "figures/table1.csv"]);
    let text = String::from_utf8(repository.call(&["HEAD"]).stdout).expect("text");
    assert!(text.contains("table1 of calibrated: not committed at HEAD"), "{text}");
}

#[test]
fn an_unknown_revision_no_work_tree_and_no_git_are_told_apart() {
    let repository = Repository::new();
    repository.git(&["branch", "feature"]);
    let unknown = refusal(&repository.call(&["featrue"]));
    assert!(
        unknown.contains("revision `featrue`: expected a commit, tag or branch"),
        "{unknown}"
    );
    assert!(unknown.contains("nearest: `feature`"), "{unknown}");
    let option = refusal(&repository.call(&["--", "--output=stolen"]));
    assert!(option.contains("found none of that name"), "{option}");
    let no_git = refusal(
        &repository
            .command(&["HEAD"])
            .env("PATH", "")
            .output()
            .expect("the binary runs"),
    );
    assert!(no_git.contains("expected the program `git`, found none"), "{no_git}");
    fs::remove_dir_all(repository.0.path().join(".git")).expect("the repository can be deleted");
    let output = repository
        .command(&["HEAD"])
        .env("GIT_CEILING_DIRECTORIES", "/")
        .output();
    let no_tree = refusal(&output.expect("the binary runs"));
    assert!(no_tree.contains("expected a git work tree, found none"), "{no_tree}");
}

#[test]
fn a_lock_that_is_none_is_named() {
    let repository = Repository::new();
    repository.edit("artifacts/paper.lock", "seed", "sed");
    let said = |revision: &str| {
        let output = repository.call(&[revision]);
        assert_eq!(output.status.code(), Some(5));
        String::from_utf8(output.stderr).expect("text")
    };
    let present = said("HEAD");
    assert!(present.contains("artifacts/paper.lock, line 1 is damaged"), "{present}");
    repository.commit();
    repository.git(&["checkout", "--quiet", "HEAD~1", "--", "artifacts/paper.lock"]);
    let past = said("HEAD");
    assert!(past.contains("HEAD:artifacts/paper.lock, line 1 is damaged"), "{past}");
}

#[test]
fn a_parameter_that_no_run_would_take_is_refused() {
    let repository = Repository::new();
    let refused = refusal(&repository.call(&["HEAD", "--set", "sea.S1.bandwith=0.05"]));
    assert!(refused.contains("nearest: `sea.S1.bandwidth`"), "{refused}");
}
