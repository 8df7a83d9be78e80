//! Steps and grids that do not resolve what they are for: refused where the method itself would blow up, told of where it
//! is merely too coarse.

use super::refusals::refused;
use crate::common::program::Program;

/// Waves of a millimetre, in which an unstable integration counted 4,803 capsizes.
const UNSTABLE: &str = r#"
[run]
seas = ["S1"]
ships = ["printed"]
[record]
samples_per_period = 16
[sea.S1]
peak_period = 100.0
significant_wave_height = 0.001
bandwidth = 0.003
[moments]
sea = "S1"
"#;

#[test]
fn an_unstable_integration_is_refused_before_anything_is_written() {
    let program = Program::new("tiny");
    let overlay = program.file("my.toml", UNSTABLE);
    let place =
        format!("{overlay}:6: record.samples_per_period: expected at least 32 for a stable integration, or 512");
    refused(
        &program,
        &["--overlay", &overlay],
        &[&place, "found 16", "`ship.printed.beta_1`"],
    );
}

#[test]
fn every_pair_of_ship_and_sea_is_asked_not_only_one_of_each() {
    let program = Program::new("tiny");
    // The second ship with the first sea, a pair that no list of single tables holds.
    let fast = "[ship.fast]\nalpha_1 = 0.01\nalpha_2 = 0.052\ndamping = \"cubic\"\nbeta_1 = 4.0\nbeta_2 = -0.09\n\
                epsilon_1 = [0.0, 0.02, 0.04]\nepsilon_2 = 0.004\n[run]\nships = [\"calibrated\", \"fast\"]\n\
                [sea.S1]\npeak_period = 120.0\n";
    let overlay = program.file("my.toml", fast);
    let parts = ["record.samples_per_period: expected at least 256", "`ship.fast.beta_1`"];
    refused(&program, &["ground_truth/fast-S1", "--overlay", &overlay], &parts);
    // Each of them with another is well.
    for target in ["ground_truth/calibrated-S1", "ground_truth/fast-S2"] {
        program.exits(0, &["status", target, "--overlay", &overlay]);
    }
}

#[test]
fn states_at_more_instants_than_steps_are_refused() {
    let program = Program::new("tiny");
    let parts = ["record.envelope_samples_per_period: expected at most 64", "found 128"];
    refused(&program, &["--set", "record.envelope_samples_per_period=128"], &parts);
}

#[test]
fn a_coarse_step_is_told_of_once_and_runs() {
    let program = Program::new("tiny");
    let coarse = ["--set", "record.samples_per_period=32"];
    for verb in [
        &["status"] as &[&str],
        &["run", "fig1_wave_groups"],
        &["run", "cic/printed-S1"],
    ] {
        let said = program.exits(0, &[verb, &coarse].concat());
        let warnings: Vec<&str> = said
            .stderr
            .lines()
            .filter(|line| line.starts_with("warning: "))
            .collect();
        // Both ships, one warning each; a figure of waves alone rolls no ship.
        let expected = match verb {
            ["status"] => 2,
            [_, "fig1_wave_groups"] => 0,
            _ => 1,
        };
        assert_eq!(warnings.len(), expected, "{verb:?}: {}", said.stderr);
        let json = program.json(&[verb, &coarse].concat());
        assert_eq!(json["warnings"].as_array().map(Vec::len), Some(expected));
        for warning in warnings {
            assert!(
                warning.starts_with("warning: --set: record.samples_per_period: expected at least "),
                "{warning}"
            );
        }
    }
}

#[test]
fn the_profiles_are_neither_refused_nor_warned_of() {
    for profile in ["paper", "quick", "tiny"] {
        let program = Program::new(profile);
        for target in [&[] as &[&str], &["calibration"]] {
            let json = program.json(&[&["status"], target].concat());
            assert_eq!(
                json["warnings"].as_array().map(Vec::len),
                Some(0),
                "{profile}: {}",
                json["warnings"]
            );
        }
    }
}

#[test]
fn a_calibration_is_refused_for_what_its_searches_may_try() {
    let program = Program::new("tiny");
    let bounds =
        "calibration.bounds=[[0.001, 30.0], [0.005, 5.0], [0.06, 0.2], [0.012, 0.45], [2e-4, 0.04], [0.001, 0.02]]";
    let parts = [
        "record.samples_per_period: expected at least 512",
        "`calibration.bounds`",
        "`alpha_1` = 30",
    ];
    refused(&program, &["calibration", "--set", bounds], &parts);
    let parts = ["sea.S2.peak_period: expected 15", "found 14"];
    refused(&program, &["calibration", "--set", "sea.S2.peak_period=14.0"], &parts);
}
