//! How a key is named: as a list of keys, at the place where it stands, in characters that leave a terminal alone.

use std::time::Instant;

use crate::common::House;
use encounter::engine::key_path::KeyPath;
use encounter::engine::params::ParamsFile;

const UNKNOWN: &str = "expected a known key, found an unknown one";

/// What is said of the toy's parameters with an overlay.
#[track_caller]
fn refused(overlay: &str) -> String {
    let house = House::new();
    let mut params = house.params().expect("the parameters are in order");
    match params.layer("my.toml", overlay) {
        Ok(()) => house.refusal_of(&params),
        Err(error) => error.to_string(),
    }
}

/// What is said of the toy's parameters with an assignment.
#[track_caller]
fn refused_set(assignment: &str) -> String {
    let mut house = House::new();
    house.set(assignment);
    house.refusal()
}

#[test]
fn a_quoted_key_with_dots_is_one_key_and_unknown() {
    for (overlay, place, key) in [
        ("[\"base.a\"]\noffset = 5\n", 2, "\"base.a\".offset"),
        ("\"run.seed\" = 7\n", 1, "\"run.seed\""),
        ("run.\"seed.x\" = 7\n", 1, "run.\"seed.x\""),
        ("[base]\n\"a.offset\" = 7\n", 2, "base.\"a.offset\""),
        ("[base.a]\n'offset ' = 7\n", 2, "base.a.\"offset \""),
        ("[base.a]\n\"\" = 7\n", 2, "base.a.\"\""),
        ("\"numbers.count\" = 7\n", 1, "\"numbers.count\""),
        ("[run]\n\"bases.x\" = []\n", 2, "run.\"bases.x\""),
    ] {
        let said = refused(overlay);
        let expected = format!("my.toml:{place}: {key}: ");
        assert!(said.starts_with(&expected), "{overlay}: {said}");
        assert!(!said.contains('\n'), "{said}");
        assert!(said.contains("expected a "), "{said}");
    }
    assert_eq!(
        refused("\"run.seed\" = 7\n"),
        format!("my.toml:1: \"run.seed\": {UNKNOWN}; nearest: `run.seed`")
    );
}

#[test]
fn a_quoted_key_of_a_set_is_one_key_and_unknown() {
    for (assignment, key) in [
        ("\"base.a\".offset=5", "\"base.a\".offset"),
        ("run.\"seed.x\"=5", "run.\"seed.x\""),
        ("base.'a.offset'.x=5", "base.\"a.offset\""),
        ("pinned.\"ba=se\"=a", "pinned.\"ba=se\""),
        ("pinned.\"\"=a", "pinned.\"\""),
    ] {
        let said = refused_set(assignment);
        assert!(said.starts_with(&format!("--set: {key}")), "{assignment}: {said}");
    }
    for no_path in [
        "\"base.a=5",
        "base.\"a\"x.offset=5",
        "\"base.a.offset\"=5",
        "base.a[0]=5",
        "base.a\noffset=5",
    ] {
        let said = refused_set(no_path);
        assert!(said.contains("expected table.key=value"), "{no_path}: {said}");
    }
}

#[test]
fn a_quoted_key_without_need_is_the_bare_one() {
    let mut params = House::new().params().expect("the parameters are in order");
    params
        .layer("my.toml", "[\"base\".'a']\n\"offset\" = 5\n")
        .expect("TOML");
    params.set("base.\"b\".'offset'=6").expect("an assignment");
    let get = |path: &str| params.get(&KeyPath::of(path)).and_then(toml::Value::as_integer);
    assert_eq!((get("base.a.offset"), get("base.b.offset")), (Some(5), Some(6)));
}

#[test]
fn no_name_of_a_stranger_reaches_the_terminal_as_it_is() {
    let tricky = [
        "\u{1b}[2J",
        "\u{7f}",
        "\u{9b}31m",
        "\u{202e}txt",
        "\u{200b}",
        "a\nb",
        "\u{feff}",
        "\u{2028}",
    ];
    for name in tricky {
        let quoted: Vec<String> = name.chars().map(|c| format!("\\U{:08X}", u32::from(c))).collect();
        let quoted = quoted.concat();
        let overlays = [
            format!("\"{quoted}\" = 1\n"),
            format!("[base.\"{quoted}\"]\noffset = 1\n"),
            format!("[pinned]\nbase = \"{quoted}\"\n"),
            format!("[draws]\nrow = [{{ base = \"{quoted}\", level = 1 }}]\n"),
            format!("[base.a]\noffset = \"{quoted}\"\n"),
        ];
        for overlay in overlays {
            let said = refused(&overlay);
            let shown = |c: &char| c.is_control() || name.trim_matches(|c: char| c.is_ascii()).contains(*c);
            assert_eq!(said.chars().find(shown), None, "{overlay}: {said:?}");
            assert!(said.starts_with("my.toml:"), "{said:?}");
        }
        let said = refused_set(&format!("base.a.offset=\"{name}"));
        assert!(!said.contains(name), "{said:?}");
    }
}

#[test]
fn a_path_reads_back_as_it_was_printed() {
    for path in [
        "a",
        "a.b_c-d",
        "\"a.b\".c",
        "\"\"",
        "a[3].b[0][1]",
        "\"\\U0000001B\".\"\\\"\\\\\"",
        "\"ä\".x",
    ] {
        let read = KeyPath::parse(path).expect("a path");
        assert_eq!(read.to_string(), path);
        assert_eq!(KeyPath::of(&read.to_string()), read);
    }
    for text in ["", ".", "a.", "a..b", "a b", "a[", "a[x]", "\"a", "a\"b\""] {
        assert_eq!(KeyPath::parse(text), None, "{text}");
    }
}

#[test]
fn what_replaces_a_table_is_blamed_for_the_keys_that_went_with_it() {
    for (overlay, expected) in [
        ("numbers = 5\n", "my.toml:1: numbers: expected a table, found 5"),
        ("\nrun = 5\n", "my.toml:2: run: expected a table, found 5"),
        ("pinned = [1]\n", "my.toml:1: pinned: expected a table, found [1]"),
        (
            "[[numbers]]\ncount = 5\n",
            "my.toml:1: numbers: expected a table, found a list of tables",
        ),
        (
            "[base]\na = 5\n",
            "my.toml:2: base.a: expected a table [base.a], found 5",
        ),
        (
            "[[base.a]]\noffset = 5\n",
            "my.toml:1: base.a: expected a table [base.a], found a list of tables",
        ),
        ("base = 5\n", "my.toml:1: base: expected tables [base.NAME], found 5"),
        (
            "[base.a.offset]\nx = 5\n",
            "my.toml:1: base.a.offset: expected a whole number, found a table",
        ),
        (
            "[base.a]\noffset = [\n1,\n2]\n",
            "my.toml:2: base.a.offset: expected a whole number, found a list",
        ),
        (
            "draws = { row = 1 }\n",
            "my.toml:1: draws.row: expected a list, found integer `1`",
        ),
    ] {
        assert_eq!(refused(overlay), expected);
    }
    let mut house = House::new();
    house.set("numbers.count={x = 1}");
    assert!(
        house
            .refusal()
            .starts_with("--set: numbers.count: expected a whole number"),
        "{}",
        house.refusal()
    );
}

#[test]
fn a_table_laid_over_a_scalar_is_blamed_for_what_it_lacks() {
    let mut params = House::new().params().expect("the parameters are in order");
    params.layer("one.toml", "numbers = 5\n").expect("TOML");
    params.layer("two.toml", "\n[numbers]\nspam = 5\n").expect("TOML");
    let said = House::new().refusal_of(&params);
    assert_eq!(
        said,
        "two.toml:2: numbers.count: expected a whole number from 1 to 100000000, found none"
    );
}

#[test]
fn a_fault_in_a_row_is_told_at_its_own_line_and_place() {
    let rows = "[draws]\nrow = [\n  { base = \"a\", level = 1 },\n  { base = \"b\", level = \"high\" },\n]\n";
    assert_eq!(
        refused(rows),
        "my.toml:4: draws.row[1].level: expected a whole number, found string \"high\""
    );
    let rows = "[[draws.row]]\nbase = \"a\"\nlevel = 1\n\n[[draws.row]]\nbase = \"b\"\n";
    assert_eq!(
        refused(rows),
        "my.toml:5: draws.row[1].level: expected a value, found none"
    );
    let rows = "[draws]\nrow = [{ base = \"a\", level = 1 }, 5]\n";
    assert_eq!(
        refused(rows),
        "my.toml:2: draws.row: row 1: expected base = the name of a [base.*] table (a, b, c), found none"
    );
}

#[test]
fn a_name_that_reads_like_a_number_is_asked_for_in_quotes() {
    for (name, found) in [
        ("nan", "the number nan"),
        ("1", "the number 1"),
        ("true", "the truth value true"),
    ] {
        let mut house = House::new();
        house.text.push_str(&["\n[base.", name, "]\noffset = 4\n"].concat());
        house.set(&format!("pinned.base={name}"));
        let said = house.refusal();
        let hint = format!("found {found}; as a name it is written in quotes: \"{name}\"");
        assert!(said.ends_with(&hint), "{said}");
        let mut house = House::new();
        house.text.push_str(&["\n[base.", name, "]\noffset = 4\n"].concat());
        house.set(&format!("run.bases=[{name}]"));
        assert!(house.refusal().ends_with(&hint), "{}", house.refusal());
        let mut house = House::new();
        house.text.push_str(&["\n[base.", name, "]\noffset = 4\n"].concat());
        house.set(&format!("pinned.base=\"{name}\""));
        assert!(house.graph(&[]).is_ok());
    }
}

#[test]
fn many_unknown_keys_are_refused_at_once_and_ten_of_them_named() {
    let overlay: Vec<String> = (0..16_000).map(|i| format!("key{i} = {i}\n")).collect();
    let overlay = overlay.concat();
    let began = Instant::now();
    let said = refused(&format!("[numbers]\n{overlay}"));
    assert!(began.elapsed().as_secs_f64() < 5.0, "{:?}", began.elapsed());
    assert_eq!(said.lines().count(), 11, "{said}");
    assert!(
        said.starts_with("my.toml:2: numbers.key0: expected a known key"),
        "{said}"
    );
    assert!(said.ends_with("\n  15990 more unknown keys"), "{said}");
}

#[test]
fn a_million_keys_are_refused_before_any_stage_sees_them() {
    let many = |line: &dyn Fn(u32) -> String| (0..1_000_000).map(line).collect::<String>();
    let keys = many(&|i| format!("k{i} = 1\n"));
    let tables = many(&|i| format!("[t{i}]\n"));
    let list = format!("[base.a]\noffset = [\n{}]\n", many(&|_| "1,\n".to_owned()));
    for (overlay, line, found) in [
        (keys, 20_001, 1_000_000),
        (tables, 20_001, 1_000_000),
        (list, 20_000, 1_000_003),
    ] {
        let began = Instant::now();
        let said = refused(&overlay);
        let place = format!("my.toml:{line}: expected at most 20000 keys and list elements");
        assert!(said.starts_with(&place), "{said}");
        assert!(said.ends_with(&format!("found {found} of them")), "{said}");
        assert!(began.elapsed().as_secs_f64() < 10.0, "{:?}", began.elapsed());
    }
}

#[test]
fn keys_and_values_without_end_are_told_in_part() {
    let key = "k".repeat(1_000_000);
    let said = refused(&format!("{key} = 1\n"));
    assert!(said.len() < 1_500, "{}", said.len());
    let said = refused(&format!("[base.a]\noffset = \"{key}\"\n"));
    assert!(
        said.len() < 1_500 && said.contains("expected a whole number"),
        "{}",
        said.len()
    );
    let deep = format!("{}x = 1\n", "a.".repeat(50_000));
    assert!(refused(&deep).starts_with("my.toml:1: expected TOML, found: "));
    let said = refused_set(&format!("{}x=1", "a.".repeat(1_000)));
    assert!(said.contains("expected table.key=value"), "{said}");
    let lists = format!("x = {}\n", "[".repeat(100_000));
    assert!(refused(&lists).starts_with("my.toml:1: expected TOML, found: "));
}

#[test]
fn a_layer_that_is_no_toml_leaves_the_parameters_as_they_were() {
    let mut params = ParamsFile::default();
    params.layer("one.toml", "[a]\nb = 1\n").expect("TOML");
    params
        .layer("two.toml", "[a]\nb = 2\nb = 3\n")
        .expect_err("a duplicate key");
    assert_eq!(params.origin(&KeyPath::of("a.b")), "one.toml:2");
}
