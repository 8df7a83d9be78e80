//! Every size is bounded where it enters, and the message gives the reason.

use super::{Stranger, begin};
use std::fmt::Write;
use std::fs::File;
use std::time::{Duration, Instant};

/// What `new` says to another option.
fn refused(stranger: &Stranger, option: &str, value: &str) -> String {
    let mut call = begin("36");
    call[1] = "DIR/other";
    match call.iter().position(|word| *word == option) {
        Some(i) => call[i + 1] = value,
        None => call.extend([option, value]),
    }
    let start = Instant::now();
    let why = stranger.refused(&call);
    assert!(
        start.elapsed() < Duration::from_secs(30),
        "{option} {value} takes too long"
    );
    assert!(!stranger.path("other").exists(), "nothing is written");
    why
}

#[test]
fn numbers_beyond_what_a_sequence_can_be_are_refused_with_the_reason() {
    let stranger = Stranger::without_sequence();
    let period = "--t-p: expected a peak period in s, of a tank or a sea, from 0.01 to 1000.0, found";
    for (option, value, says) in [
        ("--t-p", "0.001", period),
        ("--t-p", "1e9", period),
        ("--t-p", "inf", period),
        ("--h-s", "1e300", "--h-s: expected a significant wave height in m"),
        ("--h-s", "1e-9", "--h-s: expected a significant wave height in m"),
        (
            "--theta-t",
            "1e300",
            "--theta-t: expected a threshold in the unit of the maxima, from",
        ),
        (
            "--theta-t",
            "1e-300",
            "--theta-t: expected a threshold in the unit of the maxima, from",
        ),
        ("--cap", "1e300", "and at most 1000000.0 times it"),
        ("--cap", "inf", "and at most 1000000.0 times it"),
        (
            "--total",
            "301",
            "--total: expected 30 to 300 samples: the design begins with 30, and each call fits",
        ),
        ("--total", "1000000000", "--total: expected 30 to 300 samples"),
        ("--total", "4294967295", "--total: expected 30 to 300 samples"),
        (
            "--seed",
            "18446744073709551615",
            "--seed: expected at most 9223372036854775807",
        ),
        // All groups are far too long or too high for such scales: most likely a unit is wrong.
        (
            "--t-p",
            "0.01",
            "groups.csv, line 2: expected l from 0.0001 to 10, 0.01 to 1000 T_p",
        ),
        ("--t-p", "0.1", "expected a wave train of at most 1024 T_p"),
        ("--h-s", "0.001", "groups.csv, line 2: expected a from"),
    ] {
        let why = refused(&stranger, option, value);
        assert!(why.contains(says), "{option} {value}: {why}");
    }
}

#[test]
fn groups_beyond_what_a_sea_can_hold_are_refused_at_their_line() {
    let stranger = Stranger::without_sequence();
    for (row, says) in [
        ("0,50,1e9,5", "line 2: expected l from"),
        ("0,50,1e-320,5", "line 2: expected l from"),
        ("0,50,20,1e308", "line 2: expected a from"),
        ("0,50,20,1e-300", "line 2: expected a from"),
        ("0,1e300,20,5", "line 2: expected t_c within 1e10 T_p of 0"),
        (
            "0,50,20,5\n0,16000,20,5",
            "line 3: expected a wave train of at most 1024 T_p",
        ),
        ("0,50,14000,5", "line 2: expected a wave train of at most 1024 T_p"),
    ] {
        stranger.file("wrong.csv", &format!("field,t_c,l,a\n{row}\n"));
        let why = refused(&stranger, "--groups", "DIR/wrong.csv");
        assert!(why.contains(says) && why.contains("check the units"), "{row}: {why}");
    }
    let mut text = "field,t_c,l,a\n".to_owned();
    for i in 0..=1_000_000 {
        writeln!(text, "{i},0,9,9").expect("a text grows");
    }
    stranger.file("wrong.csv", &text);
    let why = refused(&stranger, "--groups", "DIR/wrong.csv");
    let says = "line 1000002: expected at most 1000000 groups, since each call reads all of them";
    assert!(why.contains(says), "{why}");
}

#[test]
fn files_without_end_or_of_huge_size_are_refused_unread() {
    let stranger = Stranger::new();
    stranger.said(&["ask", "DIR"]);
    let huge = File::create(stranger.path("huge.csv")).and_then(|file| file.set_len(1 << 40));
    huge.expect("a file without content may be of any length");
    let why = stranger.refused(&["tell", "DIR", "DIR/huge.csv"]);
    assert!(why.contains("huge.csv: expected at most 16777216 bytes"), "{why}");
    let why = refused(&stranger, "--groups", "DIR/huge.csv");
    assert!(why.contains("huge.csv: expected at most 268435456 bytes"), "{why}");
    for endless in ["/dev/zero", "/dev/urandom"] {
        let why = stranger.refused(&["tell", "DIR", endless]);
        assert!(
            why.contains("expected a regular file, found a pipe, socket or device"),
            "{why}"
        );
    }
}

#[test]
fn the_longest_wave_train_that_is_let_in_is_written() {
    let stranger = Stranger::without_sequence();
    let mut text = "field,t_c,l,a\n".to_owned();
    for i in 0..40 {
        // 5 l = 1000 T_p.
        writeln!(text, "{i},0,3000,{}", 5.0 + 0.1 * f64::from(i)).expect("a text grows");
    }
    stranger.file("groups.csv", &text);
    stranger.said(&begin("36"));
    stranger.said(&["ask", "DIR"]);
    assert_eq!(stranger.text("waves.csv").lines().count(), 1 + 30 * (64_000 + 1));
    // A sea whose groups differ in one coordinate only is no trouble.
    assert!(stranger.to_the_end().contains("36 of 36 told"));
}
