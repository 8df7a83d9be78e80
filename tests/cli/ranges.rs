//! Values that are refused: out of range, or at odds with another parameter.

use super::refusals::{refused, sets};
use crate::common::program::Program;

#[test]
fn numbers_out_of_range() {
    sets(&[
        (
            "sea.S1.significant_wave_height=-12",
            &["sea.S1.significant_wave_height: expected a number > 0, found -12"],
        ),
        (
            "sea.S1.significant_wave_height=0",
            &["sea.S1.significant_wave_height: expected a number > 0, found 0"],
        ),
        (
            "sea.S1.peak_period=nan",
            &["sea.S1.peak_period: expected a number > 0, found NaN"],
        ),
        ("sea.S1.bandwidth=nan", &["sea.S1.bandwidth: expected ", "found NaN"]),
        (
            "sea.S2.peak_period=inf",
            &["sea.S2.peak_period: expected a number > 0, found inf"],
        ),
        (
            "ship.printed.beta_2=-inf",
            &["ship.printed.beta_2: expected a finite number, found -inf"],
        ),
        (
            "record.fields=0",
            &["record.fields: expected a whole number from 1 to 100000000, found 0"],
        ),
        (
            "record.fields=-3",
            &["record.fields: expected a whole number from 1 to 100000000, found -3"],
        ),
        (
            "record.fields=nan",
            &["record.fields: expected a whole number from 1 to 100000000, found nan"],
        ),
        (
            "record.periods_per_field=100",
            &[
                "record.periods_per_field: expected a power of two from 2 to ",
                "found 100",
            ],
        ),
        (
            "record.modes=0",
            &["record.modes: expected a whole number from 1 to ", "found 0"],
        ),
        (
            "record.modes=256",
            &[
                "record.modes: expected more than periods_per_field, 256, and at most ",
                "found 256",
            ],
        ),
        (
            "record.modes=4000000000",
            &["record.modes: expected more than ", "found 4000000000"],
        ),
        (
            "nic.groups_ahead=0",
            &["nic.groups_ahead: expected a whole number from 1 to ", "found 0"],
        ),
        (
            "detection.similarity_threshold=1.0",
            &["detection.similarity_threshold: expected 0 to below 1, found 1"],
        ),
        (
            "detection.similarity_threshold=-0.1",
            &["detection.similarity_threshold: ", "below 1, found -0.1"],
        ),
        (
            "detection.similarity_threshold=nan",
            &["detection.similarity_threshold: expected ", "found NaN"],
        ),
        (
            "moments.half_width=[0.0, 0.1]",
            &["moments.half_width: expected two numbers > 0, found [0.0, 0.1]"],
        ),
        ("run.seed=-1", &["run.seed: expected a whole number >= 0, found -1"]),
        (
            "vhgp_seq.realisations=0",
            &["vhgp_seq.realisations: expected a whole number from 1 to ", "found 0"],
        ),
        (
            "vhgp_seq.total=5",
            &["vhgp_seq.total: expected at least initial = 12, found 5"],
        ),
    ]);
}

#[test]
fn thresholds_and_capsize_angle() {
    sets(&[
        (
            "truth.thresholds.step=0",
            &["truth.thresholds.step: expected a number > 0, found 0"],
        ),
        (
            "truth.thresholds.step=-0.1",
            &["truth.thresholds.step: expected a number > 0, found -0.1"],
        ),
        (
            "truth.thresholds={from = 0.5, to = 0.4, step = 0.1}",
            &["--set: truth.thresholds.to: expected a number from 0.5 (`from`), found 0.4"],
        ),
        (
            "truth.thresholds.step=1e-9",
            &["truth.thresholds.step: expected at most 10000 thresholds, found "],
        ),
        ("vhgp_seq.cap=0.5", &["vhgp_seq.cap: expected more than theta_t = "]),
    ]);
    // The key that no longer fits is the paper's own: the place is its line there.
    let program = Program::new("tiny");
    let parts = [
        "stages/paper.toml:",
        ": truth.thresholds.to: ",
        "below capsize_angle = 0.3, found 1.2",
    ];
    let levels = "truth.temporal_levels={from=0.0,to=0.1,step=0.1}";
    refused(&program, &["--set", levels, "--set", "truth.capsize_angle=0.3"], &parts);
    let parts = [
        "stages/paper.toml:",
        ": truth.temporal_level: ",
        "below capsize_angle = 0.2, found 0.25",
    ];
    refused(&program, &["--set", levels, "--set", "truth.capsize_angle=0.2"], &parts);
    let parts = [
        "stages/paper.toml:",
        ": truth.temporal_levels.to: ",
        "below capsize_angle = 0.3, found 1.2",
    ];
    refused(&program, &["--set", "truth.capsize_angle=0.3"], &parts);
}

#[test]
fn lists_of_excitations() {
    let key = "ship.calibrated.epsilon_1: expected ";
    sets(&[
        (
            "ship.calibrated.epsilon_1=[0.004, 0.002]",
            &[key, "strictly ascending numbers, found 0.004 before 0.002"],
        ),
        (
            "ship.calibrated.epsilon_1=[0.0, 0.0]",
            &[key, "strictly ascending numbers"],
        ),
        (
            "ship.calibrated.epsilon_1=[]",
            &[key, "at least one number, found none"],
        ),
        (
            "ship.calibrated.epsilon_1=[0.0, nan]",
            &[key, "numbers >= 0, found NaN"],
        ),
        ("ship.calibrated.epsilon_1=[-0.1]", &[key, "numbers >= 0, found -0.1"]),
        (
            "vhgp_seq.epsilon_1_index=3",
            &[
                "vhgp_seq.epsilon_1_index: ",
                "below 3, the length of `ship.calibrated.epsilon_1`, found 3",
            ],
        ),
        (
            "vhgp_seq.epsilon_1_index=-1",
            &["vhgp_seq.epsilon_1_index: expected a whole number, found integer `-1`"],
        ),
    ]);
    // The index is the paper's own; the list of one ship became too short for it.
    let program = Program::new("tiny");
    let parts = [
        "stages/paper.toml:",
        "vhgp_seq.epsilon_1_index: expected a whole number below 1, the length of `ship.printed.epsilon_1`, found 1",
    ];
    refused(&program, &["--set", "ship.printed.epsilon_1=[0.02]"], &parts);
}

#[test]
fn rows_of_the_sequential_design() {
    sets(&[
        (
            "vhgp_seq.case=[{sea = \"S2\", theta_t = 0.5}, {sea = \"S8\", theta_t = 0.5}]",
            &[
                "vhgp_seq.case: row 1: expected sea = the name of a [sea.*] table (S1, S2, S3, S4), found \"S8\"; nearest: `S1`",
            ],
        ),
        (
            "vhgp_seq.case=[{sea = \"S2\", theta_t = 0.5}, {sea = \"S2\", theta_t = 0.6}]",
            &["vhgp_seq.case: row 1: ", "found \"S2\" twice"],
        ),
        (
            "vhgp_seq.case=[{theta_t = 0.5}]",
            &["vhgp_seq.case", "expected ", "found none"],
        ),
        (
            "vhgp_seq.case=[{sea = \"S2\", theta_t = nan}]",
            &["vhgp_seq.case", "expected a number", "found NaN"],
        ),
        (
            "vhgp_seq.case=[{sea = \"S2\", theta_t = -1}]",
            &["vhgp_seq.case", "expected a number", "found -1"],
        ),
        (
            "vhgp_seq.case=[{sea = \"S2\", thetat = 0.5}]",
            &["--set: vhgp_seq.case[0].thetat: expected `sea` or `theta_t`, found `thetat`; nearest: `theta_t`"],
        ),
        (
            "vhgp_seq.case=S2",
            &["vhgp_seq.case: expected a list, found string \"S2\""],
        ),
        (
            "vhgp_seq.domain=[[1.0, 0.5], [0.1, 0.2]]",
            &["vhgp_seq.domain[0]: expected two ascending numbers, found [1, 0.5]"],
        ),
        (
            "moments.half_width=[0.1, 0.2, 0.3]",
            &["--set: moments.half_width: expected 2 elements, found 3"],
        ),
        (
            "moments.half_width=[0.1]",
            &["--set: moments.half_width: expected an array of length 2, found 1"],
        ),
        (
            "vhgp_seq.fit.k_f.length=[{start = 1.0, from = 0.2, to = 20.0}, {start = 0.3, from = 0.05, to = 4.0, top = 5}]",
            &["--set: vhgp_seq.fit.k_f.length[1].top: expected "],
        ),
        (
            "vhgp_seq.fit.k_f.variance={start = 1.0, from = 2.0, to = 3.0}",
            &["--set: vhgp_seq.fit.k_f.variance: expected 0 < from <= start <= to, found from = 2, start = 1, to = 3"],
        ),
    ]);
}

#[test]
fn fields_beyond_the_record() {
    let beyond = "expected a whole number below record.fields = 16, found ";
    sets(&[
        (
            "fig1_wave_groups.field=16",
            &["fig1_wave_groups.field: ", beyond, "found 16"],
        ),
        (
            "fig6_jonswap_groups.field=99",
            &["fig6_jonswap_groups.field: ", beyond, "found 99"],
        ),
        (
            "fig6_jonswap_groups.field=-1",
            &["fig6_jonswap_groups.field: expected "],
        ),
        (
            "fig1_wave_groups.to=300",
            &["fig1_wave_groups.to: expected 0 <= from < to <= 256 (periods_per_field)"],
        ),
    ]);
}

#[test]
fn runs_that_would_never_end_are_refused() {
    let program = Program::new("tiny");
    refused(
        &program,
        &["--set", "record.lead_in=1e9"],
        &["--set", "record.lead_in", "expected at most"],
    );
    refused(
        &program,
        &["--set", "truth.window=1e7"],
        &["--set", "truth.window", "expected at most"],
    );
}
