//! The calibration study, drawn and written from made-up sets.

use encounter::plot::calibration::{InSea, Search, Set, Study, draw};
use encounter::plot::calibration_table::{csv, markdown, searches_csv};

use super::svg;

fn set(name: &str, values: [f64; 6], changed: [bool; 6], factor: f64) -> Set {
    let sea = |sea: &str, paper: f64, cic: f64| InSea {
        sea: sea.into(),
        theta_t: 0.7,
        paper,
        p_true: vec![0.4 * paper, factor * paper, 1.5 * paper],
        standard_error: 0.03 * paper,
        cic: vec![0.1 * paper, cic * factor * paper, paper],
        pic: vec![0.5 * paper, factor * paper, paper],
        nic: vec![0.4 * paper, 1.05 * factor * paper, paper],
        method_groups: 5000,
        capsizes_per_field: 0.25,
        spread: Some(0.05 * factor),
    };
    Set {
        name: name.into(),
        reading: "plain".into(),
        values: values.to_vec(),
        changed: changed.to_vec(),
        size: 3.09,
        misfit: 0.45,
        fields: 1440,
        seas: vec![sea("S1", 0.0421, 0.2), sea("S4", 0.0076, 0.8)],
    }
}

fn study() -> Study {
    let names = ["alpha_1", "alpha_2", "beta_1", "beta_2", "epsilon_1", "epsilon_2"];
    let search = |i: u32| Search {
        free: "beta_1 epsilon_1".into(),
        changes: 1 + i % 6,
        reading: if i % 7 == 6 {
            "signed roll".into()
        } else {
            "plain".into()
        },
        is_plain: i % 7 != 6,
        size: 0.4 + 0.11 * f64::from(i),
        misfit: 5000.0 / f64::from((i + 1) * (i + 1)),
        ranking: 0.5,
        evaluations: 100,
        accepted: 3,
    };
    let x = |t: f64| vec![0.0, t, 0.2 - 0.1 * t, -t, -2.2, 0.5 * t];
    Study {
        names: names.map(str::to_owned).to_vec(),
        accepted_below: 9.49,
        searches: (0..40).map(search).collect(),
        sets: vec![
            set(
                "present",
                [0.01, 0.4, 0.13, -0.06, 0.002, 0.0043],
                [false, true, true, true, true, true],
                1.1,
            ),
            set(
                "4 changed",
                [0.01, 0.052, 0.147, -0.11, 0.0023, 0.00242],
                [false, false, true, true, true, true],
                1.0,
            ),
        ],
        accepted: vec![(x(0.0), 0.0), (x(1.0), 0.3), (x(2.0), 4.0)],
    }
}

#[test]
fn the_table_shows_changes_findings_and_ratios() {
    let text = markdown(&study());
    for wanted in [
        "| 4 changed | 0.01 | 0.052 | **0.147** | **−0.11** | **0.0023** | **0.00242** | 4 | 3.09 | 0.45 | 2/2 | 1/2 | 2/2 | 2/2 |",
        "| 4 changed | S1 | 0.0421 | 0.0421 ± 0.0013 | 0.20 | 1.00 | 1.05 | 0.0168, 0.0631 | 0.250 | 0.050 (0.91) |",
        "40 searches tried 4000 candidates; 3 of them agree",
        "2 of these keep the ranking",
        "| α₂ | 1.000 to 7.389 | 1.000 to 2.718 |",
        "| α₁ | 1.000 to 1.000 | 1.000 to 1.000 |",
        "β₁: -1.00",
    ] {
        assert!(text.contains(wanted), "{wanted} is missing in\n{text}");
    }
}

#[test]
fn the_csv_has_a_line_per_set_and_sea_and_one_per_search() {
    let text = csv(&study());
    assert_eq!(text.lines().count(), 1 + 4);
    assert!(text.contains("4 changed,plain,4,3.09,0.45,0.01,0.052,0.147,-0.11,0.0023,0.00242,S1,0.7,0.0421,0.0421,"));
    assert_eq!(searches_csv(&study()).lines().count(), 41);
    assert!(!text.contains("NaN"));
}

#[test]
fn an_empty_study_is_drawn_too() {
    let empty = Study {
        searches: Vec::new(),
        sets: Vec::new(),
        accepted: Vec::new(),
        ..study()
    };
    draw(&empty).expect("nothing to draw is no failure");
    assert!(markdown(&empty).contains("| α₁ | – | – |"));
    assert_eq!(csv(&empty).lines().count(), 1);
}

#[test]
fn equal_input_gives_an_equal_small_figure_with_every_coefficient() {
    let figure = draw(&study()).expect("the sample is sound");
    assert_eq!(figure, draw(&study()).expect("the sample is sound"));
    assert!(figure.len() < 100_000, "{}", figure.len());
    let words = svg::words(&figure);
    for name in ["α₁", "α₂", "β₁", "β₂", "ε₁", "ε₂", "misfit", "changed coefficients"] {
        assert!(words.iter().any(|word| word.contains(name)), "{name} is missing");
    }
    if let Some(folder) = std::env::var_os("ENCOUNTER_PLOTS") {
        std::fs::write(std::path::Path::new(&folder).join("calibration.svg"), figure).expect("the folder is there");
    }
}

#[test]
fn nothing_measured_is_never_agreement() {
    let mut study = study();
    study.sets.truncate(1);
    for sea in &mut study.sets[0].seas {
        sea.p_true.clear();
        (sea.standard_error, sea.method_groups) = (0.0, 0);
        for shares in [&mut sea.cic, &mut sea.pic, &mut sea.nic] {
            shares.fill(0.0);
        }
    }
    let text = markdown(&study);
    assert!(
        text.contains("| 5 | 3.09 | no data | no data | no data | no data | no data |"),
        "{text}"
    );
    assert!(
        text.contains("| present | S1 | 0.0421 | no data | – | – | – | –, – |"),
        "{text}"
    );
    assert!(!text.contains("NaN") && !text.contains("0.0000 ±"), "{text}");
    let row = csv(&study);
    let row = row.lines().nth(1).expect("a row per set and sea");
    assert!(
        row.starts_with("present,plain,5,3.09,,") && row.contains(",S1,0.7,0.0421,,,,,,,,,0,"),
        "{row}"
    );
}

#[test]
fn a_set_of_which_some_sea_has_no_error_has_no_misfit() {
    let mut study = study();
    study.sets.truncate(1);
    // None exceeds in one sea, or all its groups lie in one field: its distance from the paper cannot be told.
    study.sets[0].seas[0].standard_error = 0.0;
    let row = csv(&study);
    assert!(
        row.lines()
            .nth(1)
            .is_some_and(|row| row.starts_with("present,plain,5,3.09,,")),
        "{row}"
    );
}

#[test]
fn no_set_is_no_data_and_one_search_is_one() {
    let mut study = study();
    (study.sets, study.accepted) = (Vec::new(), study.accepted.into_iter().take(2).collect());
    study.searches.truncate(1);
    study.searches[0].evaluations = 1;
    let text = markdown(&study);
    assert!(text.contains("No data: no set was checked."), "{text}");
    assert!(text.contains("1 search tried 1 candidate; 2 of them"), "{text}");
    assert!(
        !text.contains("correlations"),
        "two trials always lie on a line: {text}"
    );
}

#[test]
fn a_name_from_an_overlay_stays_text_in_every_format() {
    let mut study = study();
    study.sets[0].name = "=1+1 <img src=x> | \u{1b}[2J [a](http://b)".into();
    let text = markdown(&study);
    assert!(
        text.contains("| =1+1 &lt;img src=x&gt; \\|  \\[2J \\[a\\](http://b) |"),
        "{text}"
    );
    assert!(!text.contains('\u{1b}') && !text.contains("<img"));
    let data = csv(&study);
    assert!(
        data.contains("\n\"'=1+1 <img src=x> |  [2J [a](http://b)\",plain,"),
        "{data}"
    );
}
