//! Files of maxima in the forms that spreadsheets and scripts write, and those that must be refused.

use super::Stranger;
use std::fmt::Write;
use std::fs;

/// A sequence with its first batch, and the numbers of three samples of it.
fn asked() -> (Stranger, [usize; 3]) {
    let stranger = Stranger::new();
    stranger.said(&["ask", "DIR"]);
    let mut samples = stranger.batch().into_keys();
    let mut next = || samples.next().expect("30 samples are asked for");
    let three = [next(), next(), next()];
    (stranger, three)
}

#[test]
fn maxima_are_read_by_column_name_in_every_harmless_form() {
    let (stranger, [a, b, c]) = asked();
    let before = stranger.text("state.toml");
    let told = |bytes: &[u8]| {
        stranger.file("state.toml", &before);
        fs::write(stranger.path("form.csv"), bytes).expect("a file can be written");
        stranger.said(&["tell", "DIR", "DIR/form.csv"]);
        stranger.text("state.toml")
    };
    let plain = told(format!("sample,r\n{a},0.001\n{b},1.5\n{c},1\n").as_bytes());
    assert!(plain != before);
    let whole = format!("{a}.0,1e-3");
    for text in [
        format!("\u{feff}sample,r\n{a},0.001\n{b},1.5\n{c},1\n"),
        format!("\u{feff}\"sample\",\"r\"\r\n\"{a}\",\"0.001\"\r\n\"{b}\",\"1.5\"\r\n{c},1\r\n"),
        format!("r,sample\n1e-3,{a}\n+1.5,{b}\n1.0E+00,{c}\n"),
        format!("sample,r\n\n{a},0.001\n{b},1.5\n   \n{c},1\n\n\n"),
        format!("sample,r\r{a},0.001\r{b},1.5\r{c},1\r"),
        format!(" sample , r \n {a} ,\t.001\n  {b}, 1.5 \n{c},1.\n"),
        format!(",sample,group,r,note\n0,{a},7,0.001,\"one, two\"\n1,{b},8,1.5,\n2,{c},9,1.000000,\"\"\n"),
        format!("# Sample,R\n{a}.0,1.000000000000000e-03\n{:e},1.5\n{c},1\n", b as f64),
        format!("sample,r,,\n{a},0.001,,\n{b},1.5,,\n{c},1,,\n,,,\n"),
        format!("sample,r\n{whole}\n{b},1.5,\n{c},1\n{whole}\n"),
    ] {
        assert_eq!(told(text.as_bytes()), plain, "{text:?}");
    }
    // A column that is not read may be in any encoding.
    let latin = [
        &b"sample,r,gr\xf6\xdfe\n"[..],
        format!("{a},0.001,1\n{b},1.5,2\n{c},1,\n").as_bytes(),
    ]
    .concat();
    assert_eq!(told(&latin), plain);
}

#[test]
fn groups_are_read_by_column_name_too() {
    let (plain, other) = (Stranger::new(), Stranger::without_sequence());
    let mut text = "\u{feff}A,\"l\",field,t_c,remark\r\n".to_owned();
    for line in other.text("groups.csv").lines().skip(1) {
        let cells: Vec<&str> = line.split(',').collect();
        let [field, t_c, l, a] = [0, 1, 2, 3].map(|i| cells[i]);
        write!(text, "{a}, {l},{field},\"{t_c}\",\r\n").expect("a text grows");
    }
    other.file("groups.csv", &text);
    other.said(&super::begin("36"));
    plain.said(&["ask", "DIR"]);
    other.said(&["ask", "DIR"]);
    let samples = |stranger: &Stranger| stranger.batch().into_values().collect::<Vec<_>>();
    assert_eq!(samples(&plain), samples(&other));
}

#[test]
fn maxima_that_are_malformed_or_contradict_are_refused_whole() {
    let (stranger, [a, b, c]) = asked();
    stranger.simulate(stranger.batch().into_iter().take(2));
    stranger.said(&["tell", "DIR", "DIR/maxima.csv"]);
    let number = "expected a finite number, or `failed` for a failed run, found";
    let mut cases = vec![
        (String::new(), "line 1: expected sample,r, found no header".to_owned()),
        (
            format!("sample;r\n{c};0.5\n"),
            "line 1: expected the columns sample,r, found `sample;r`".to_owned(),
        ),
        (
            "sample,r,R\n".to_owned(),
            "line 1: expected one column r, found two".to_owned(),
        ),
        (
            format!("sample,r\n{c},0.5\n4\n"),
            "line 3: expected 2 cells, found 1".to_owned(),
        ),
        (
            format!("sample,r\n{c},0,5\n"),
            "line 2: expected 2 cells, found 3".to_owned(),
        ),
        (
            format!("sample,r\n{c},0.5\n{c},0.61"),
            "line 3: expected a line end, found the end of a file that may have been cut short".to_owned(),
        ),
        (
            format!("sample,r\n{c},0.5\n{c},0.6\n"),
            format!("line 3: expected sample {c} = 0.5 as told, found 0.6"),
        ),
        (
            format!("sample,r\n{c},0.5\n{c},failed\n"),
            format!("line 3: expected sample {c} = 0.5 as told, found failed"),
        ),
        (
            format!("sample,r\n{a},9\n"),
            format!("line 2: expected sample {a} = 0."),
        ),
        (
            format!("sample,r\n{b},failed\n"),
            format!("line 2: expected sample {b} = 0."),
        ),
        (
            format!("sample,r\n{c},1e9\n"),
            "line 2, r: expected a maximum in the unit of theta_t = 0.75".to_owned(),
        ),
    ];
    for cell in [
        "large",
        "NaN",
        "nan",
        "inf",
        "-Inf",
        "1e999",
        "",
        "0.5 m",
        "0x1p3",
        "1.0D+00",
        "\u{1b}[2J",
    ] {
        let shown = cell.replace('\u{1b}', "\\u{1b}");
        cases.push((
            format!("sample,r\n{c},0.5\n{c},{cell}\n"),
            format!("line 3, r: {number} `{shown}`"),
        ));
    }
    are_refused(&stranger, cases);
}

/// Each text is refused whole, and the message says so.
fn are_refused(stranger: &Stranger, cases: Vec<(String, String)>) {
    for (text, says) in cases {
        stranger.file("wrong.csv", &text);
        let why = stranger.refused(&["tell", "DIR", "DIR/wrong.csv"]);
        assert!(why.contains(&format!("wrong.csv, {says}")), "{text:?}: {why}");
        assert!(why.contains("nothing") && !why.contains('\u{1b}'), "{why}");
    }
}

#[test]
fn samples_never_asked_for_and_files_that_are_no_tables_are_refused() {
    let (stranger, [_, _, c]) = asked();
    let mut cases = Vec::new();
    let unknown = "line 2: expected a sample that this sequence has asked for, as in its batch.csv, found";
    for sample in [
        "0",
        "2.5",
        "-1",
        "1e300",
        &format!("{c}.5"),
        &format!("{}", c + 1),
        &format!("{:e}", c / 10 * 10),
    ] {
        cases.push((format!("sample,r\n{sample},0.5\n"), format!("{unknown} {sample};")));
    }
    are_refused(&stranger, cases);
    for (bytes, says) in [
        (
            &[0xff, 0xfe, b's', 0][..],
            "wrong.csv: expected a text file in UTF-8, found UTF-16",
        ),
        (&[0xc3, 0x28, b'\n'], "wrong.csv, line 1: expected the columns sample,r"),
        (&[0, 0, 0, b'\n'], "wrong.csv, line 1: expected the columns sample,r"),
    ] {
        fs::write(stranger.path("wrong.csv"), bytes).expect("a file can be written");
        let why = stranger.refused(&["tell", "DIR", "DIR/wrong.csv"]);
        assert!(why.contains(says), "{why}");
    }
    let why = stranger.refused(&["tell", "DIR", "DIR/absent.csv"]);
    assert!(
        why.contains("absent.csv: expected a regular file") && why.contains("check the path"),
        "{why}"
    );
}

#[test]
fn answers_of_another_sequence_are_refused_though_all_its_settings_are_the_same() {
    let (one, two) = (Stranger::new(), Stranger::new());
    for stranger in [&one, &two] {
        stranger.said(&["ask", "DIR"]);
        stranger.simulate(stranger.batch());
    }
    let samples = |stranger: &Stranger| stranger.batch().into_values().collect::<Vec<_>>();
    assert_eq!(samples(&one), samples(&two), "the same groups are asked for");
    two.file("foreign.csv", &one.text("maxima.csv"));
    let why = two.refused(&["tell", "DIR", "DIR/foreign.csv"]);
    assert!(
        why.contains("expected a sample that this sequence has asked for"),
        "{why}"
    );
    // A sequence begun anew in the same folder does not take the answers of the one before.
    fs::remove_file(one.path("state.toml")).expect("a state can be removed");
    one.said(&super::begin("36"));
    let why = one.refused(&["tell", "DIR", "DIR/maxima.csv"]);
    assert!(
        why.contains("expected a sample that this sequence has asked for"),
        "{why}"
    );
    two.said(&["tell", "DIR", "DIR/maxima.csv"]);
}

#[test]
fn a_number_rounded_to_five_digits_names_no_sample() {
    let (stranger, _) = asked();
    let long: Vec<usize> = stranger
        .batch()
        .into_keys()
        .filter(|sample| *sample >= 100_000)
        .collect();
    assert_eq!(long.len(), 20, "samples from the eleventh on have six digits");
    for sample in long {
        for rounded in [sample / 10 * 10, sample / 10 * 10 + 10, sample / 100 * 100] {
            stranger.file("maxima.csv", &format!("sample,r\n{rounded},0.5\n"));
            stranger.refused(&["tell", "DIR", "DIR/maxima.csv"]);
        }
    }
}
