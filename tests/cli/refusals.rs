//! Parameters that are refused: exit 2; place, key, expected, found, nearest; nothing is touched.

use crate::common::program::Program;
use std::fs;

/// Runs with some options, which must be refused with all of the given parts in the message.
#[track_caller]
pub(super) fn refused(program: &Program, options: &[&str], parts: &[&str]) {
    let figures = program.path("figures").display().to_string();
    for verb in [&["run"] as &[&str], &["status"], &["run", "--dry-run", "--json"]] {
        let said = program.call(&[verb, options, &["--figures", &figures]].concat());
        assert_eq!(said.code, 2, "{options:?}: {}", said.stderr);
        for part in parts {
            assert!(
                said.stderr.contains(part),
                "{options:?}: expected `{part}` in: {}",
                said.stderr
            );
        }
        assert_eq!(said.stdout, "", "{options:?}");
    }
    assert!(!program.path("store").exists(), "{options:?}");
    assert!(!program.path("figures").exists(), "{options:?}");
}

/// Every overlay text is refused with all of its parts; `@N` stands for its own name and line N.
#[track_caller]
fn overlays(cases: &[(&str, &[&str])]) {
    let program = Program::new("tiny");
    for (text, parts) in cases {
        let overlay = program.file("my.toml", text);
        let parts: Vec<String> = parts
            .iter()
            .map(|part| {
                part.strip_prefix('@')
                    .map_or((*part).to_owned(), |rest| format!("{overlay}:{rest}"))
            })
            .collect();
        let parts: Vec<&str> = parts.iter().map(String::as_str).collect();
        refused(&program, &["--overlay", &overlay], &parts);
    }
}

/// Every assignment is refused with all of its parts, and with its place.
#[track_caller]
pub(super) fn sets(cases: &[(&str, &[&str])]) {
    let program = Program::new("tiny");
    for (assignment, parts) in cases {
        refused(&program, &["--set", assignment], &[&["error: --set"], *parts].concat());
    }
}

#[test]
fn unknown_keys_and_tables() {
    let unknown = "expected a known key, found an unknown one";
    overlays(&[
        (
            "# mine\n[sea.S1]\nbandwith = 0.05\n",
            &["@3: sea.S1.bandwith: ", unknown, "nearest: `sea.S1.bandwidth`"],
        ),
        (
            "[ship.printed]\n\nalfa_1 = 1\n",
            &["@3: ship.printed.alfa_1: ", unknown, "`ship.printed.alpha_1`"],
        ),
        (
            "[recrod]\nfields = 10\n",
            &["@2: recrod.fields: ", unknown, "nearest: `record.fields`"],
        ),
        // Not in this run, and so on no page.
        (
            "[run]\nseas = [\"S1\"]\n[sea.S2]\nbandwith = 0.05\n",
            &["@4: sea.S2.bandwith: ", unknown, "nearest: `sea.S2.bandwidth`"],
        ),
        ("[recrod]\n", &["@1: recrod: ", unknown, "nearest: `record`"]),
        ("fields = 10\n", &["@1: fields: ", unknown, "nearest: "]),
        (
            "[vhgp_seq.fit]\nrestart = 2\n",
            &["@2: vhgp_seq.fit.restart: ", "nearest: `restarts`"],
        ),
        ("[case]\nsea = \"S1\"\n", &["@2: case.sea: ", unknown]),
        (
            "[run]\nseeds = 1\n",
            &["@2: run.seeds: ", unknown, "nearest: `run.seed`"],
        ),
    ]);
    sets(&[
        (
            "sea.S1.bandwith=0.05",
            &["--set: sea.S1.bandwith: ", unknown, "nearest: `sea.S1.bandwidth`"],
        ),
        (
            "truth.threshold.step=0.1",
            &["truth.threshold.step: ", unknown, "`truth.thresholds.step`"],
        ),
        (
            "sea.S9.bandwidth=0.05",
            &["sea.S9.spectrum: expected a value, found none"],
        ),
    ]);
}

#[test]
fn wrong_types() {
    overlays(&[
        (
            "[sea.S1]\nsignificant_wave_height = \"high\"\n",
            &["@2: sea.S1.significant_wave_height: expected a number, found string \"high\""],
        ),
        (
            "[record]\nfields = 1.5\n",
            &["@2: record.fields: expected a whole number from 1 to ", "found 1.5"],
        ),
        (
            "[record]\nmodes = 1024.0\n",
            &["@2: record.modes: expected a whole number, found floating point `1024.0`"],
        ),
        ("sea = 1\n", &["@1: sea: expected tables [sea.NAME], found 1"]),
        (
            "[vhgp_seq]\nstandardise = 1\n",
            &["@2: vhgp_seq.standardise: expected a boolean, found integer `1`"],
        ),
        (
            "[findings]\nrealisations = 1\n",
            &["findings.realisations: expected at least 2, found 1"],
        ),
        (
            "[findings]\nagreement = -1.0\n",
            &["findings.agreement: expected a number > 0, found -1"],
        ),
        (
            "[linear_response]\namplitudes = [0.5, 1e200]\n",
            &["linear_response.amplitudes: expected numbers above 0 and up to 10, at least one, found"],
        ),
        (
            "[vhgp_best]\ncap = 1.0\n",
            &["vhgp_best.cap: expected more than 1 (theta_t), found 1"],
        ),
        (
            "[vhgp_control]\nresponse_scale = \"log\"\n",
            &["vhgp_control.response_scale", "log"],
        ),
        (
            "[vhgp_control]\nlog_odds_deviation = -1.0\n",
            &["vhgp_control.log_odds_deviation: expected a number >= 0, found -1"],
        ),
        (
            "[sampling_floor]\ncontrol_bandwidth = [0.0, 1.0]\n",
            &["sampling_floor.control_bandwidth: expected numbers > 0, found [0.0, 1.0]"],
        ),
        (
            "[run]\nseed = 1979-05-27\n",
            &["@2: run.seed: expected a whole number >= 0, found 1979-05-27"],
        ),
        (
            "[pic]\nperiods = 1979-05-27\n",
            &["@2: pic.periods: expected a whole number, found date 1979-05-27"],
        ),
        (
            "[moments]\nhalf_width = 0.1\n",
            &["@2: moments.half_width: expected an array of length 2, found "],
        ),
        (
            "[sea.S1]\nspectrum = \"gausian\"\n",
            &["@2: sea.S1.spectrum: expected `gaussian` or `jonswap`, found `gausian`; nearest: `gaussian`"],
        ),
        (
            "[nic]\ninput = \"records\"\n",
            &["@2: nic.input: ", "found `records`; nearest: `record`"],
        ),
    ]);
}

#[test]
fn lists_of_seas_and_ships() {
    let seas = "run.seas: expected a list of names of [sea.*] tables (S1, S2, S3, S4), found ";
    let ships = "run.ships: expected a list of names of [ship.*] tables (calibrated, printed), found ";
    sets(&[
        ("run.seas=[\"S7\"]", &[seas, "\"S7\"; nearest: `S1`"]),
        ("run.ships=[\"print\"]", &[ships, "\"print\"; nearest: `printed`"]),
        ("run.seas=[]", &[seas, "an empty list"]),
        ("run.ships=[]", &[ships, "an empty list"]),
        ("run.seas=[\"S1\", \"S2\", \"S1\"]", &[seas, "\"S1\" twice"]),
        ("run.seas=[1]", &[seas, "found 1"]),
        ("run.seas=S1", &[seas, "found \"S1\""]),
        (
            "fig6_jonswap_groups.sea=S5",
            &["fig6_jonswap_groups.sea: expected the name of ", "\"S5\"; nearest: `S"],
        ),
    ]);
}

#[test]
fn new_tables_that_are_not_whole() {
    let jonswap = "[sea.Mine]\nspectrum = \"jonswap\"\nsignificant_wave_height = 3.0\npeak_period = 8.0\n";
    let gaussian = jonswap.replace("jonswap", "gaussian");
    let both = format!("{gaussian}bandwidth = 0.1\ngamma = 3.3\n");
    overlays(&[
        (jonswap, &["@1: sea.Mine.gamma: expected 1 to 100, found nothing"]),
        (&gaussian, &["@1: sea.Mine.bandwidth: expected ", "found nothing"]),
        (
            &both,
            &["@6: sea.Mine.gamma: expected nothing for this spectrum, found 3.3"],
        ),
        (
            "[sea.Mine]\nspectrum = \"gaussian\"\nbandwidth = 0.1\npeak_period = 8.0\n",
            &["@1: sea.Mine.significant_wave_height: expected a value, found none"],
        ),
        ("[sea.Mine]\n", &["@1: sea.Mine.spectrum: expected a value, found none"]),
        (
            "[ship.Mine]\nalpha_1 = 0.1\n",
            &["@1: ship.Mine.alpha_2: expected a value, found none"],
        ),
        (
            "[sea.\"../x\"]\n",
            &["@1: sea.\"../x\": expected a name of letters, digits and `_`"],
        ),
    ]);
}

#[test]
fn overlays_that_cannot_be_read() {
    let program = Program::new("tiny");
    let missing = program.path("missing.toml").display().to_string();
    let folder = program.path("folder").display().to_string();
    fs::create_dir(&folder).expect("a folder can be made");
    let bytes = program.file("bytes.toml", b"[run]\nseed = 1 # \xff\n");
    for (file, found) in [(&missing, "No such file"), (&folder, "directory"), (&bytes, "UTF-8")] {
        let place = format!("error: {file}: expected a readable parameter file in TOML, found: ");
        refused(&program, &["--overlay", file], &[&place, found]);
    }
    overlays(&[
        ("[run]\nseed = \n", &["@2: expected TOML, found: "]),
        ("[run\n", &["@1: expected TOML, found: "]),
        (
            "[run]\nseed = 1\n\nseed = 2\n",
            &["@4: expected TOML, found: duplicate key"],
        ),
    ]);
}

#[test]
fn sets_that_are_no_assignment() {
    let expected = "expected table.key=value, such as sea.S2.bandwidth=0.035, found ";
    sets(&[
        ("sea.S1.bandwidth", &[expected, "found no `=`"]),
        ("seed=1", &[expected, "found `seed`"]),
        ("=1", &[expected]),
        ("sea..bandwidth=1", &[expected, "found `sea..bandwidth`"]),
        ("sea.S1.bandwidth=", &[expected]),
        ("sea.S1.bandwidth=0.1.2", &[expected, "found `0.1.2`"]),
        ("sea.S1.bandwidth=0.1\nx = 2", &[expected]),
    ]);
}

#[test]
fn targets() {
    let program = Program::new("tiny");
    let cases: [(&str, &[&str]); 6] = [
        (
            "fig3_excedance",
            &[
                "target `fig3_excedance`: expected the name of a stage or output",
                "nearest: `fig3_exceedance`",
            ],
        ),
        ("tabel1", &["nearest: `table1`"]),
        (
            "vhgp_seq/calibratd-S1",
            &["expected a case of vhgp_seq (", "nearest: `calibrated-S1`"],
        ),
        (
            "wave_synthesis/S9",
            &["expected a case of wave_synthesis (S1, S2, S3, S4)", "nearest: `S1`"],
        ),
        ("ground_truth/printed-S4/1", &["expected a piece from 0 to 0, found 1"]),
        (
            "ground_truth/printed-S4/x",
            &["expected STAGE[/CASE[/PIECE]]", "found the piece `x`"],
        ),
    ];
    for (target, parts) in cases {
        refused(&program, &[target], parts);
    }
}

#[test]
fn rules_of_a_study_that_is_asked_for() {
    let program = Program::new("tiny");
    let digits = "calibration.digits: expected at most 17, found 70000";
    refused(
        &program,
        &["calibration", "--set", "calibration.digits=70000"],
        &[digits],
    );
}

/// A row of `[table1] paper` with one key changed.
fn printed_row(changed: &str) -> String {
    let key = changed.split(' ').next().unwrap_or_default();
    let keys = [
        "sea = \"S1\"",
        "theta_t = 0.7",
        "p_true = 0.0421",
        "sequential_mean = 0.0416",
        "sequential_std_percent = 5.0",
        "random_mean = 0.042",
        "random_std_percent = 44.0",
    ];
    let kept = keys.iter().map(|own| {
        if own.starts_with(&format!("{key} ")) {
            changed
        } else {
            own
        }
    });
    format!("{{ {} }}", kept.collect::<Vec<_>>().join(", "))
}

#[test]
fn the_papers_table_is_checked_like_our_own() {
    let table = |rows: &[String]| format!("[table1]\npaper = [{}]\n", rows.join(", "));
    let one = |changed: &str| table(&[printed_row(changed)]);
    overlays(&[
        (
            &one("p_true = nan"),
            &["table1.paper[0].p_true: ", "a number between 0 and 1", "NaN"],
        ),
        (&one("p_true = 1.5"), &["table1.paper[0].p_true: ", "found 1.5"]),
        (&one("p_true = 0.0"), &["table1.paper[0].p_true: ", "found 0"]),
        (
            &one("random_mean = -0.1"),
            &["table1.paper[0].random_mean: ", "found -0.1"],
        ),
        (
            &one("sequential_std_percent = -5.0"),
            &[
                "table1.paper[0].sequential_std_percent: ",
                "expected a number > 0, found -5",
            ],
        ),
        (
            &one("theta_t = 4.0"),
            &[
                "table1.paper[0].theta_t: ",
                "expected a number below capsize_angle = 3.14",
                "found 4",
            ],
        ),
        (
            &one("sea = \"S9\""),
            &[
                "table1.paper: row 0: expected sea = the name of a [sea.*] table",
                "\"S9\"",
            ],
        ),
        (
            &table(&[printed_row(""), printed_row("theta_t = 0.8")]),
            &["table1.paper: row 1: ", "found \"S1\" twice"],
        ),
    ]);
}

#[test]
fn a_claim_is_put_to_a_ship_that_exists() {
    sets(&[(
        "findings.printed=nosuch",
        &["findings.printed: expected the name of a [ship.*] table (calibrated, printed), found \"nosuch\""],
    )]);
}

#[test]
fn a_calibration_keeps_fields_to_check_on() {
    let program = Program::new("tiny");
    for fields in ["8", "1"] {
        let said = program.call(&["run", "calibration", "--set", &format!("calibration.fields={fields}")]);
        assert_eq!(said.code, 2, "{}", said.stderr);
        let wanted = format!(
            "calibration.polish_fields: expected a whole number in whole blocks of 8 below calibration.fields = {fields}, found 8"
        );
        assert!(said.stderr.contains(&wanted), "{}", said.stderr);
    }
    let overlay = ["calibration.fields=16", "calibration.polish_fields=9"];
    let said = program.call(&["run", "calibration", "--set", overlay[0], "--set", overlay[1]]);
    assert_eq!(said.code, 2, "nine fields are two blocks of eight: {}", said.stderr);
}
