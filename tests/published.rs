//! The committed outputs: against the prototypes' tables, against themselves, and against what README.md says of them.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

type Row = BTreeMap<String, String>;

fn read(path: &str) -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(path);
    fs::read_to_string(&path).unwrap_or_else(|why| panic!("{}: {why}", path.display()))
}

fn rows(path: &str) -> Vec<Row> {
    let text = read(path);
    let mut lines = text.lines();
    let header: Vec<String> = lines.next().expect("a header").split(',').map(str::to_owned).collect();
    lines
        .map(|line| header.iter().cloned().zip(line.split(',').map(str::to_owned)).collect())
        .collect()
}

fn number(row: &Row, key: &str) -> f64 {
    row[key]
        .parse()
        .unwrap_or_else(|_| panic!("{key} of {row:?} is no number"))
}

const SHIPS: [(&str, &str); 2] = [("calibrated", "figures"), ("printed", "figures/printed")];

#[test]
fn every_probability_of_figure_3_has_its_standard_error() {
    for (ship, folder) in SHIPS {
        let rows = rows(&format!("{folder}/fig3_exceedance.csv"));
        assert_eq!(rows.len(), 4 * 3 * 5 * 49);
        for row in &rows {
            assert_eq!(row["ship"], ship);
            let (p, se, n) = (
                number(row, "probability"),
                number(row, "standard_error"),
                number(row, "n"),
            );
            assert!((0.0..=1.0).contains(&p) && n > 0.0, "{row:?}");
            // Groups of one field are not independent, but not far from it either.
            let binomial = (p * (1.0 - p) / n).sqrt();
            assert!(se >= 0.0 && se < 3.0 * binomial + 1e-12, "{row:?}");
        }
    }
}

#[test]
fn the_printed_ship_without_parametric_excitation_agrees_with_the_prototypes() {
    // (sea, theta_t, P, standard error of 500 fields); ours has 31,250.
    let table = [
        ("S1", "0.3", 0.7865, 0.0035),
        ("S1", "0.4", 0.4209, 0.0035),
        ("S1", "0.5", 0.0933, 0.0020),
        ("S1", "0.6", 0.0067, 0.0006),
        ("S2", "0.4", 0.783, 0.0031),
        ("S2", "0.5", 0.511, 0.0033),
        ("S2", "0.6", 0.2148, 0.0026),
        ("S2", "0.7", 0.0489, 0.0015),
        ("S2", "0.8", 0.0058, 0.0006),
    ];
    let rows = rows("figures/printed/fig3_exceedance.csv");
    for (sea, theta_t, p, se) in table {
        let same = |row: &&Row| {
            row["spectrum"] == sea && row["epsilon_1"] == "0" && row["theta_t"] == theta_t && row["method"] == "truth"
        };
        let row = rows.iter().find(same).expect("the figure has this point");
        let (ours, our_se) = (number(row, "probability"), number(row, "standard_error"));
        let allowed = 4.0 * (se * se + our_se * our_se).sqrt();
        assert!(
            (ours - p).abs() < allowed,
            "{sea} P(r > {theta_t}) = {ours}, expected {p} +- {se}"
        );
    }
}

#[test]
fn nic_on_the_record_follows_the_truth_of_the_calibrated_ship() {
    let rows = rows("figures/fig3_exceedance.csv");
    let of = |method: &str| rows.iter().filter(|row| row["method"] == method).collect::<Vec<_>>();
    let mut compared = 0;
    for (truth, nic) in of("truth").into_iter().zip(of("nic")) {
        let (p, q) = (number(truth, "probability"), number(nic, "probability"));
        if p > 1e-3 && p < 0.5 {
            let [of_p, of_q] = [truth, nic].map(|row| number(row, "standard_error"));
            // Two groups ahead leave a per cent or two; the rest is chance.
            let allowed = 0.02 * p + 4.0 * (of_p * of_p + of_q * of_q).sqrt();
            assert!((q - p).abs() < allowed, "{truth:?} {nic:?}");
            compared += 1;
        }
    }
    assert!(compared > 100, "{compared}");
}

#[test]
fn random_sampling_scatters_as_the_binomial_law_says() {
    for (_, folder) in SHIPS {
        for row in rows(&format!("{folder}/table1.csv")) {
            let (mean, sd) = (number(&row, "random_mean"), number(&row, "random_std"));
            let expected = (mean * (1.0 - mean) / 120.0).sqrt();
            // A standard deviation from 100 realisations is known to 7 %.
            assert!((sd / expected - 1.0).abs() < 0.28, "{row:?}");
        }
    }
}

#[test]
fn the_page_shows_every_table_in_force() {
    let page = read("figures/index.html");
    let parameters: toml::Table = read("stages/paper.toml").parse().expect("the parameters parse");
    let mut tables = vec![("ship.calibrated".to_owned(), &parameters["ship"]["calibrated"])];
    for (name, sea) in parameters["sea"].as_table().expect("tables") {
        tables.push((format!("sea.{name}"), sea));
    }
    let elsewhere = ["run", "sea", "ship", "calibration", "findings", "table1"];
    for (name, table) in &parameters {
        // Searches are a study of their own; what a figure picks stands in its caption.
        if !elsewhere.contains(&name.as_str()) && !name.starts_with("fig") {
            tables.push((name.clone(), table));
        }
    }
    assert!(tables.len() >= 15);
    for (name, table) in tables {
        let head = format!("[{name}]\n");
        let shown = page
            .split_once(&head)
            .unwrap_or_else(|| panic!("[{name}] is not on the page"))
            .1;
        let shown = shown.split_once("\n\n").expect("a table ends").0;
        for key in table.as_table().expect("a table").keys() {
            // Counts and the sea that a study picks are in no key, and so on no page; thresholds stand in Figure 3.
            let is_count = ["fields", "realisations", "sea", "thresholds"].contains(&key.as_str());
            let is_shown = shown.lines().any(|line| line.starts_with(&format!("{key} = ")));
            assert!(is_count || is_shown, "{name}.{key} is not on the page");
        }
    }
    assert!(page.contains("[sea.S2]\nbandwidth = 0.03\n"));
    assert!(!page.contains(" = null"));
}

#[test]
fn the_readme_shows_the_committed_table() {
    let readme = read("README.md");
    let percent = |row: &Row, mean: &str, sd: &str| 100.0 * number(row, sd) / number(row, mean);
    for (ship, folder) in SHIPS {
        for row in rows(&format!("{folder}/table1.csv")) {
            let line = format!(
                "| {ship} | {} | {} | {:.4} ± {:.4} | {:.4} | {:.4} ({:.0} %) | {:.4} ({} %) | {:.4} ({:.0} %) | {:.4} ({} %) |",
                row["spectrum"],
                row["theta_t"],
                number(&row, "p_true"),
                number(&row, "p_true_se"),
                number(&row, "paper_p_true"),
                number(&row, "sequential_mean"),
                percent(&row, "sequential_mean", "sequential_std"),
                number(&row, "paper_sequential_mean"),
                row["paper_sequential_std_percent"],
                number(&row, "random_mean"),
                percent(&row, "random_mean", "random_std"),
                number(&row, "paper_random_mean"),
                row["paper_random_std_percent"],
            );
            assert!(readme.contains(&line), "README.md lacks\n{line}");
        }
    }
}

#[test]
fn the_readme_shows_the_committed_errors() {
    let readme = read("README.md");
    for (folder, methods) in [
        ("", &["sequential", "best", "control", "lhs"][..]),
        ("printed/", &["sequential", "best", "control"]),
    ] {
        let rows = rows(&format!("figures/{folder}table1.csv"));
        for method in methods {
            let cell = |row: &Row| {
                let of = |key: &str| 100.0 * number(row, &format!("{method}_{key}")) / number(row, "p_true");
                format!("{:+.1}, {:.1}", of("mean") - 100.0, of("std"))
            };
            let cells: Vec<String> = rows.iter().map(cell).collect();
            let line = format!("| {} |\n", cells.join(" | "));
            assert!(readme.contains(&line), "{folder}{method}: expected {line}");
        }
    }
}

#[test]
fn the_readme_has_no_blanks() {
    assert!(!read("README.md").contains('@'), "a placeholder is left");
}

/// Calls git in a folder, without the settings of whoever runs the tests.
fn git(folder: &Path, arguments: &[&str]) {
    let who = ["-c", "user.name=toy", "-c", "user.email=toy@example.org"];
    let mut git = Command::new("git");
    git.env("GIT_CONFIG_GLOBAL", "/dev/null")
        .env("GIT_CONFIG_NOSYSTEM", "1");
    let output = git
        .current_dir(folder)
        .args(who)
        .args(arguments)
        .output()
        .expect("git runs");
    assert!(
        output.status.success(),
        "{arguments:?}: {}",
        String::from_utf8_lossy(&output.stderr)
    );
}

/// Every committed file that is compared or hashed byte by byte, by path.
fn compared() -> Vec<String> {
    let mut paths = vec!["Cargo.lock".to_owned(), "Cargo.toml".to_owned()];
    for folder in ["artifacts", "figures", "figures/printed", "stages", "src/ship"] {
        let entries = fs::read_dir(Path::new(env!("CARGO_MANIFEST_DIR")).join(folder)).expect("a folder");
        let files = entries.flatten().filter(|entry| entry.path().is_file());
        let is_lock = |name: &str| Path::new(name).extension().is_some_and(|extension| extension == "lock");
        let is_store = |name: &str| folder == "artifacts" && (!is_lock(name) || name == "store.lock");
        let names = files.map(|entry| entry.file_name().to_string_lossy().into_owned());
        paths.extend(
            names
                .filter(|name| !is_store(name))
                .map(|name| format!("{folder}/{name}")),
        );
    }
    paths
}

#[test]
fn a_clone_that_converts_line_ends_holds_the_same_bytes() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let folder = tempfile::tempdir().expect("a temporary folder can be made");
    let origin = folder.path().join("origin");
    let paths = compared();
    assert!(paths.len() > 60, "{paths:?}");
    for path in paths.iter().map(String::as_str).chain([".gitattributes"]) {
        let copy = origin.join(path);
        fs::create_dir_all(copy.parent().expect("a folder")).expect("a folder can be made");
        fs::copy(root.join(path), copy).expect("the file is committed");
    }
    git(&origin, &["init", "--quiet"]);
    git(&origin, &["add", "--all", "--force"]);
    git(&origin, &["commit", "--quiet", "--message", "A state"]);
    let clone = |name: &str| {
        let to = folder.path().join(name);
        let (from, into) = (origin.display().to_string(), to.display().to_string());
        git(
            folder.path(),
            &["clone", "--quiet", "-c", "core.autocrlf=true", &from, &into],
        );
        to
    };
    let changed = |clone: PathBuf| {
        let differs = |path: &&String| fs::read(clone.join(path)).ok() != fs::read(root.join(path)).ok();
        paths.iter().filter(differs).count()
    };
    assert_eq!(changed(clone("clone")), 0);
    // It is the attributes that do it.
    git(&origin, &["rm", "--quiet", ".gitattributes"]);
    git(&origin, &["commit", "--quiet", "--message", "Without them"]);
    assert!(changed(clone("other")) > 60);
}
