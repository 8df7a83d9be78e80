//! States from strangers: sealed with a right checksum, yet with anything in them.

use super::Stranger;
use std::fs;
use std::process::{Command, Output};
use std::thread;
use std::time::{Duration, Instant};

/// What a call says within half a minute; killed after that, which fails the test.
#[track_caller]
pub(super) fn ends(command: &mut Command) -> Output {
    let mut child = command.spawn().expect("the example runs");
    let start = Instant::now();
    while child.try_wait().expect("a child can be waited for").is_none() {
        if start.elapsed() > Duration::from_secs(30) {
            child.kill().expect("a child can be killed");
            panic!("the call hangs");
        }
        thread::sleep(Duration::from_millis(5));
    }
    child.wait_with_output().expect("the output is there")
}

/// Whether a call takes the state; in any case it ends in good order and writes no control characters to the terminal.
#[track_caller]
fn takes(stranger: &Stranger, call: &[&str], what: &str) -> bool {
    let output = ends(&mut stranger.command(call));
    let said = [output.stdout, output.stderr].concat();
    let said = String::from_utf8(said).expect("messages are text");
    let code = output.status.code();
    assert!(matches!(code, Some(0 | 2)), "{what}: {:?} {said}", output.status);
    assert!(said.len() < 3000 && !said.contains("panicked"), "{what}: {said}");
    let moves_the_cursor = |c: char| c.is_control() || ('\u{202a}'..='\u{2069}').contains(&c);
    let controls = said.trim_end_matches('\n').chars().any(moves_the_cursor);
    assert!(!controls, "{what}: {said:?}");
    if code == Some(2) {
        let parts = ["refused: ", ": expected ", ", found ", "; "];
        assert!(parts.iter().all(|part| said.contains(part)), "{what}: {said}");
    }
    code == Some(0)
}

fn seal(stranger: &Stranger, body: &[u8]) {
    let head = format!("# blake3 {}\n", blake3::hash(body));
    let state = [head.as_bytes(), body].concat();
    fs::write(stranger.path("state.toml"), state).expect("a file can be written");
}

/// A sequence with its first batch told, and the body of its state.
fn told() -> (Stranger, String) {
    let stranger = Stranger::new();
    stranger.said(&["ask", "DIR"]);
    stranger.simulate(stranger.batch());
    stranger.said(&["tell", "DIR", "DIR/maxima.csv"]);
    let text = stranger.text("state.toml");
    let body = text.split_once('\n').expect("a state has a head").1.to_owned();
    (stranger, body)
}

const VALUES: [&str; 18] = [
    "-1",
    "0",
    "nan",
    "-inf",
    "inf",
    "1e308",
    "5e-324",
    "4294967295",
    "4294967296",
    "9223372036854775807",
    "99999999999999999999",
    "true",
    "[]",
    "{}",
    "\"\"",
    "\"\\u001b[2J\\u0007\\u202e\"",
    "\"../../../../etc/passwd\"",
    "1979-05-27",
];

#[test]
fn a_state_with_any_value_at_any_key_is_refused_or_replayed() {
    let (stranger, body) = told();
    let keys = [
        "sequence", "groups", "settings", "seed", "t_p", "h_s", "theta_t", "cap", "total", "sample", "group", "r",
    ];
    let (mut tried, mut taken) = (0, Vec::new());
    for key in keys {
        let line = body
            .lines()
            .find(|line| line.starts_with(&format!("{key} = ")))
            .expect("each key is in a state");
        let mut lines: Vec<String> = VALUES.map(|value| format!("{key} = {value}")).to_vec();
        lines.extend([
            String::new(),
            format!("{line}\n{line}"),
            format!("\"\\u001b[31m\" = 1\n{line}"),
            key.to_owned(),
        ]);
        for other in lines {
            seal(&stranger, body.replacen(line, &other, 1).as_bytes());
            tried += 1;
            if takes(&stranger, &["ask", "DIR"], &other) {
                taken.push(other);
            }
        }
    }
    assert_eq!(tried, 12 * 22);
    // What nobody can tell from an honest state: another maximum, or none, of one sample.
    let honest = ["", "r = -1", "r = 0", "r = 5e-324"];
    let harmless = |other: &String| honest.contains(&other.as_str());
    assert!(taken.iter().all(harmless) && taken.len() == honest.len(), "{taken:?}");
}

#[test]
fn a_state_that_is_cut_stuffed_or_no_state_at_all_is_refused() {
    let (stranger, body) = told();
    let entry = body.split("[[told]]").last().expect("a state has answers");
    let many = |count: usize, of: &dyn Fn(usize) -> String| (0..count).map(of).collect::<String>();
    let bodies: Vec<Vec<u8>> = vec![
        vec![0; 4096],
        vec![0xff; 4096],
        [body.as_bytes(), &[0xc3, 0x28]].concat(),
        (body.clone()
            + &many(40_000, &|i| {
                format!("\n[[told]]\nsample = {}\ngroup = 1\nr = 1.0", 1_000_000 + i)
            }))
            .into(),
        (body.clone()
            + &many(8_000, &|i| {
                format!("\n[[told]]\nsample = {}\ngroup = 1\nr = 1.0", 1_000_000 + i)
            }))
            .into(),
        (body.clone() + &many(20_000, &|i| format!("\n[a{i}]\nb = 1"))).into(),
        (many(40_000, &|i| format!("k{i} = 1\n")) + &body).into(),
        (many(90, &|i| format!("k{i}{} = 1\n", "x".repeat(9000))) + &body).into(),
        format!("a = {}\n{body}", "[".repeat(200_000)).into(),
        format!("a = {}\n{body}", "{b = ".repeat(100_000)).into(),
        format!("{}\n{body}", "a.".repeat(200_000)).into(),
        format!("a = \"{}\"\n{body}", "\u{9b}31m".repeat(1000)).into(),
        format!("{body}\n[[told]]{entry}").into(),
        body.replacen("[[told]]", "[told]", 1).into(),
        body.replace("r = ", "failed = ").into(),
        body.replace("r = ", "# r = ").into(),
        body.replace("group = ", "group = 1").into(),
        body.replace("sample = ", "sample = 1").into(),
    ];
    let mut taken = Vec::new();
    for (i, body) in bodies.iter().enumerate() {
        seal(&stranger, body);
        for call in [&["ask", "DIR"][..], &["tell", "DIR", "DIR/maxima.csv"]] {
            if takes(&stranger, call, &format!("body {i}")) {
                taken.push((i, call[0]));
            }
        }
    }
    // A state in which all runs of the first batch failed is an honest one.
    assert_eq!(taken, [(15, "ask")]);
}

#[test]
fn a_state_cut_at_any_place_and_sealed_anew_ends_in_good_order() {
    let (stranger, body) = told();
    let refused = (0..60).filter(|i| {
        seal(&stranger, &body.as_bytes()[..body.len() * i / 60]);
        !takes(&stranger, &["ask", "DIR"], &format!("cut {i}/60"))
    });
    // A cut inside a number, or after a row, leaves a state that says less.
    assert!(refused.count() >= 30);
}

#[test]
fn groups_of_a_stranger_with_any_number_are_refused_or_replayed() {
    let (stranger, body) = told();
    let groups = stranger.text("groups.csv");
    let line = groups.lines().nth(7).expect("2,000 groups");
    for i in 0..4 {
        for value in [
            "-1",
            "0",
            "nan",
            "inf",
            "1e308",
            "-1e308",
            "5e-324",
            "1e-5",
            "1e5",
            "\u{1b}[2J",
            "",
        ] {
            let mut cells: Vec<&str> = line.split(',').collect();
            cells[i] = value;
            let other = groups.replacen(line, &cells.join(","), 1);
            stranger.file("groups.csv", &other);
            // Where the numbers are sound, the checksum of the text still tells; it is made right.
            let why = stranger
                .command(&["ask", "DIR"])
                .output()
                .expect("the example runs")
                .stderr;
            let why = String::from_utf8_lossy(&why).into_owned();
            let found = why.split("found ").nth(1).and_then(|rest| rest.split(';').next());
            if let Some(hash) = found.filter(|hash| hash.len() == 64) {
                let sealed = body
                    .lines()
                    .find(|line| line.starts_with("groups = "))
                    .expect("a state names its groups");
                seal(
                    &stranger,
                    body.replacen(sealed, &format!("groups = \"{hash}\""), 1).as_bytes(),
                );
            }
            takes(&stranger, &["ask", "DIR"], &format!("column {i}: {value:?}"));
            seal(&stranger, body.as_bytes());
        }
    }
}
