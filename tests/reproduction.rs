//! The whole paper, small, on the real binary: the same bits at any number of threads, and no more work than needed.

use crate::common::program::{Program, stages};
use encounter::engine::lock::Lock;
use encounter::engine::verify::between;
use std::collections::BTreeSet;
use std::path::Path;

/// The lock of a whole run in an empty store.
fn lock_of(profile: &'static str, workers: &str) -> Lock {
    let program = Program::new(profile);
    let said = program.call(&["run", "--update-lock", "-j", workers]);
    assert_eq!(said.code, 0, "{}", said.stderr);
    Lock::parse(&program.lock_text()).expect("our own lock")
}

fn committed(profile: &str) -> Lock {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("artifacts/{profile}.lock"));
    let text = std::fs::read_to_string(&path).unwrap_or_else(|why| {
        let path = path.display();
        panic!("{path}: {why}; `encounter run --profile {profile} --update-lock` writes it, and it is committed")
    });
    Lock::parse(&text).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

const NOTHING: [&str; 0] = [];

/// The paper's seas and ships at 1:64 by Froude's law: every factor is a power of two, so that the scaling is exact.
const MODEL_AT_1_TO_64: &str = "
record.lead_in = 62.5
detection.smallest_amplitude = 0.015625
sea.S1 = { significant_wave_height = 0.1875, peak_period = 1.875, bandwidth = 0.16 }
sea.S2 = { significant_wave_height = 0.1875, peak_period = 1.875, bandwidth = 0.24 }
sea.S3 = { significant_wave_height = 0.1875, peak_period = 1.875, bandwidth = 0.32 }
sea.S4 = { significant_wave_height = 0.1875, peak_period = 1.875 }
[ship.printed]
alpha_1 = 0.08
alpha_2 = 0.0065
beta_1 = 7.52
beta_2 = -5.76
epsilon_1 = [0.0, 81.92, 163.84]
epsilon_2 = 16.384
[ship.calibrated]
alpha_1 = 0.08
alpha_2 = 0.0065
beta_1 = 9.3824
beta_2 = -6.784
epsilon_1 = [0.0, 9.8304, 19.6608]
epsilon_2 = 9.78944
";

#[test]
fn tiny_is_the_same_on_one_and_two_threads() {
    let (one, two) = (lock_of("tiny", "1"), lock_of("tiny", "2"));
    assert_eq!(between(&one, &two), NOTHING);
    assert_eq!(one, two);
}

#[test]
fn tiny_is_the_committed_one() {
    assert_eq!(between(&committed("tiny"), &lock_of("tiny", "3")), NOTHING);
}

#[test]
fn quick_is_the_committed_one_on_one_and_two_threads() {
    let committed = committed("quick");
    for workers in ["2", "1"] {
        assert_eq!(between(&committed, &lock_of("quick", workers)), NOTHING, "-j {workers}");
    }
}

/// Lengths and times of the model in shares of the paper's, and the excitation's 1/(m s^2).
const MODEL_FACTORS: [f64; 3] = [1.0 / 64.0, 1.0 / 8.0, 64.0 * 64.0];

/// Whether a cell of the model's table is the paper's own, or its number times one of the factors, to the last bit.
fn is_scaled(found: &str, expected: &str) -> bool {
    let number = |cell: &str| cell.parse::<f64>().ok();
    let times_a_factor = |(found, expected): (f64, f64)| {
        MODEL_FACTORS
            .iter()
            .any(|factor| found.to_bits() == (expected * factor).to_bits())
    };
    found == expected || number(found).zip(number(expected)).is_some_and(times_a_factor)
}

#[test]
fn a_model_by_froudes_law_has_the_papers_groups_and_tables_to_the_bit() {
    let program = Program::new("tiny");
    let overlay = program.file("model.toml", MODEL_AT_1_TO_64);
    let [full, model] = ["full", "model"].map(|name| program.path(name));
    program.exits(0, &["run", "--figures", &full.display().to_string()]);
    let model_folder = model.display().to_string();
    program.exits(0, &["run", "--overlay", &overlay, "--figures", &model_folder]);
    let mut tables = 0;
    for folder in ["", "printed"] {
        for entry in std::fs::read_dir(full.join(folder)).expect("a folder of figures") {
            let name = entry.expect("an entry").file_name();
            let [expected, found] = [&full, &model].map(|root| root.join(folder).join(&name));
            if expected.extension().is_none_or(|extension| extension != "csv") {
                continue;
            }
            let [expected, found] = [expected, found].map(|path| std::fs::read_to_string(path).expect("a table"));
            if ["groups.csv", "table1.csv", "findings.csv"]
                .iter()
                .any(|own| name == *own)
            {
                assert_eq!(found, expected, "{folder}/{}", name.display());
            }
            assert_eq!(found.lines().count(), expected.lines().count());
            for (found, expected) in found.lines().zip(expected.lines()) {
                let mut cells = found.split(',').zip(expected.split(','));
                assert!(
                    cells.all(|(found, expected)| is_scaled(found, expected)),
                    "{found} for {expected}"
                );
            }
            tables += 1;
        }
    }
    assert!(tables > 20, "{tables}");
}

#[test]
fn no_more_runs_than_an_edit_needs() {
    let program = Program::new("tiny");
    assert!(program.ran(&[]).len() > 50);

    let damping = program.ran(&["--set", "ship.calibrated.alpha_1=0.012"]);
    let ran = stages(&damping);
    for untouched in [
        "wave_synthesis",
        "envelope",
        "group_detection",
        "group_statistics",
        "group_sample",
        "groups",
    ] {
        assert!(!ran.contains(untouched), "{untouched} in {ran:?}");
    }
    for touched in [
        "ground_truth",
        "roll_ensemble",
        "cic",
        "pic",
        "nic",
        "nic_groups",
        "vhgp_seq",
        "table1",
    ] {
        assert!(ran.contains(touched), "{touched} not in {ran:?}");
    }
    // The findings compare both ships, and stand on the page of each.
    let of_the_other = |node: &&String| node.contains("printed") && *node != "index/printed";
    assert_eq!(damping.keys().find(of_the_other), None);

    // Designs that look ahead share the number of samples with the paper's method, not where it takes them.
    let moved = program.ran(&["--set", "vhgp_seq.tau=[0.3, 0.03]"]);
    let ran = stages(&moved);
    assert!(ran.contains("vhgp_seq") && ran.contains("table1"), "{ran:?}");
    for untouched in ["vhgp_best", "vhgp_control", "linear_response"] {
        assert!(!ran.contains(untouched), "{untouched} in {ran:?}");
    }

    let more = program.ran(&["--set", "vhgp_seq.realisations=4"]);
    let new: BTreeSet<u64> = [1, 2, 3].into();
    for stage in ["vhgp_seq", "random_sampling"] {
        for ship in ["calibrated", "printed"] {
            for sea in ["S1", "S2", "S3", "S4"] {
                assert_eq!(more[&format!("{stage}/{ship}-{sea}")], new);
            }
        }
    }
    let allowed = BTreeSet::from([
        "convergence",
        "fig5_vhgp_seq",
        "findings",
        "index",
        "random_sampling",
        "table1",
        "vhgp_best",
        "vhgp_control",
        "vhgp_lhs",
        "vhgp_seq",
    ]);
    assert!(stages(&more).is_subset(&allowed), "{more:?}");

    let back = program.ran(&[]);
    assert!(back.is_empty(), "{back:?}");
}

#[test]
fn a_part_of_the_paper_computes_only_what_it_needs() {
    let program = Program::new("tiny");
    let overlay = program.file("my.toml", "[run]\nseas = [\"S1\"]\nships = [\"calibrated\"]\n");
    let ran = program.ran(&["truth", "fig3_exceedance", "--overlay", &overlay, "--name", "part"]);
    let expected = [
        "cic",
        "envelope",
        "exceedance",
        "fig3_exceedance",
        "ground_truth",
        "group_detection",
        "group_sample",
        "group_statistics",
        "nic",
        "nic_groups",
        "pic",
        "roll_ensemble",
        "truth",
        "wave_synthesis",
    ];
    assert_eq!(stages(&ran), BTreeSet::from(expected));
    let is_own = |node: &String| !node.contains("printed") && ["S2", "S3", "S4"].iter().all(|sea| !node.contains(sea));
    assert!(ran.keys().all(is_own), "{ran:?}");
    let mut files: Vec<String> = std::fs::read_dir(program.checkout("artifacts/figures/part"))
        .expect("the folder of the what-if")
        .map(|entry| entry.expect("an entry").file_name().to_string_lossy().into_owned())
        .collect();
    files.sort();
    let expected = [
        "fig3_exceedance.csv",
        "fig3_exceedance.svg",
        "parameters.toml",
        "truth.csv",
    ];
    assert_eq!(files, expected);
}

#[test]
fn figures_of_other_seas_work_where_only_one_is_run() {
    let program = Program::new("tiny");
    let one_sea = [
        "--set",
        "run.seas=[\"S1\"]",
        "--set",
        "run.ships=[\"calibrated\"]",
        "--name",
        "one_sea",
    ];
    let figures = ["fig4_response_moments", "fig5_vhgp_seq", "fig6_jonswap_groups"];
    let ran = program.ran(&[figures.as_slice(), one_sea.as_slice()].concat());
    for node in [
        "fig4_response_moments/calibrated-S1",
        "fig5_vhgp_seq/calibrated-S2",
        "fig6_jonswap_groups/S4",
    ] {
        assert!(ran.contains_key(node), "{node} not in {ran:?}");
    }
    // Without --targets too: everything there is, for one sea.
    let all = program.ran(&one_sea);
    assert!(all.contains_key("table1/calibrated"), "{all:?}");
    for figure in figures {
        assert!(
            program
                .checkout(&format!("artifacts/figures/one_sea/{figure}.svg"))
                .is_file()
        );
    }
}

#[test]
fn a_pool_of_one_group_ends_its_realisations_at_once() {
    let program = Program::new("tiny");
    let said = program.call(&["run", "--set", "estimate.samples=1"]);
    assert_eq!(said.code, 0, "{}", said.stderr);
}

#[test]
fn a_domain_without_groups_is_sampled_by_the_nearest_ones() {
    let program = Program::new("tiny");
    let domain = "vhgp_seq.domain=[[5.8,6.0],[1.0,1.1]]";
    let said = program.call(&["run", "vhgp_seq/calibrated-S2", "--set", domain]);
    assert_eq!(said.code, 0, "{}", said.stderr);
}

#[test]
fn a_truth_whose_fields_are_all_discarded_leaves_cells_empty() {
    let program = Program::new("tiny");
    let figures = program.path("figures");
    let folder = figures.display().to_string();
    let said = program.call(&["run", "--set", "truth.capsize=discard_field", "--figures", &folder]);
    assert_eq!(said.code, 0, "{}", said.stderr);
    let table = std::fs::read_to_string(figures.join("printed/table1.csv")).expect("the table is published");
    let last = table.lines().last().expect("a row");
    assert!(last.starts_with("S4,1.05,,,"), "{last}");
    let truth = std::fs::read_to_string(figures.join("truth.csv")).expect("the counts are published");
    assert!(truth.contains("printed,S4,0.04,0,0,"), "{truth}");
}

#[test]
fn a_run_is_not_refused_for_a_rule_of_what_it_does_not_use() {
    let program = Program::new("tiny");
    let one = [
        "--set",
        "ship.calibrated.epsilon_1=[0.002]",
        "--set",
        "run.ships=[\"calibrated\"]",
    ];
    let said = program.call(&[&["run", "truth", "fig3_exceedance"] as &[&str], &one].concat());
    assert_eq!(said.code, 0, "{}", said.stderr);
    let said = program.call(&[&["run", "table1"] as &[&str], &one].concat());
    assert_eq!(said.code, 2, "{}", said.stderr);
    assert!(said.stderr.contains("vhgp_seq.epsilon_1_index"), "{}", said.stderr);
}

#[test]
fn the_calibration_study_runs_on_request_into_a_lock_of_its_own() {
    let program = Program::new("tiny");
    let made = |workers: &str| {
        let said = program.call(&["run", "calibration", "--update-lock", "-j", workers]);
        assert_eq!(said.code, 0, "{}", said.stderr);
        std::fs::read_to_string(program.checkout("artifacts/tiny.calibration.lock")).expect("its lock is written")
    };
    assert_eq!(program.call(&["run", "calibration_check"]).code, 0);
    assert!(!program.checkout("artifacts/tiny.calibration_check.lock").exists());
    let text = made("2");
    assert!(!program.checkout("artifacts/tiny.lock").exists());
    let lock = Lock::parse(&text).expect("our own lock");
    assert!(lock.lines.iter().any(|line| line.name == "file calibration.md"));
    assert!(lock.lines.iter().all(|line| !line.name.starts_with("ground_truth")));
    assert_eq!(made("1"), text);
    assert_eq!(program.call(&["verify", "--lock", "calibration"]).code, 0);
    assert_eq!(
        program
            .call(&["verify", "--lock", "calibration", "--set", "calibration.accepted=9.0"])
            .code,
        3
    );
    let rebuilt = program.call(&["verify", "--rebuild", "calibration"]);
    assert_eq!(rebuilt.code, 0, "{}", rebuilt.stderr);
}
