//! Claims about `examples/ask_tell.rs`, as a process of its own: a whole loop with a stranger's simulator, and whatever
//! may go wrong on the way.

mod failures;
#[cfg(unix)]
mod folder;
mod forms;
mod hostile;
mod sizes;

use encounter::numerics::elementary::exp;
use encounter::numerics::normal::{distribution, from_uniform};
use encounter::numerics::random::uniform;
use rand_chacha::ChaCha12Rng;
use rand_chacha::rand_core::SeedableRng;
use std::collections::BTreeMap;
use std::fmt::Write;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::Duration;
use tempfile::TempDir;

const THETA_T: f64 = 0.75;

/// The example that Cargo has built beside the tests.
fn example() -> PathBuf {
    let tests = std::env::current_exe().expect("the test binary is a file");
    let profile = tests.parent().and_then(Path::parent).expect("target/PROFILE/deps");
    let path = profile.join("examples").join("ask_tell");
    assert!(
        path.exists(),
        "expected {}: cargo build --example ask_tell",
        path.display()
    );
    path
}

/// The call that begins a sequence of so many samples.
fn begin(total: &str) -> Vec<&str> {
    let call = "new DIR --groups DIR/groups.csv --t-p 15 --h-s 12 --theta-t 0.75 --total";
    call.split(' ').chain([total]).collect()
}

/// A folder with a sea's groups and a sequence.
struct Stranger {
    folder: TempDir,
}

impl Stranger {
    /// 2,000 groups in 20 fields, and a sequence of 36 samples.
    fn new() -> Self {
        let stranger = Self::without_sequence();
        stranger.said(&begin("36"));
        stranger
    }

    /// 2,000 groups in 20 fields.
    fn without_sequence() -> Self {
        let folder = tempfile::tempdir().expect("a folder can be made");
        let stranger = Self { folder };
        let mut s = ChaCha12Rng::seed_from_u64(3);
        let mut groups = "field,t_c,l,a\n".to_owned();
        for field in 0..20 {
            for i in 0..100 {
                let (u, v) = (from_uniform(uniform(&mut s)), from_uniform(uniform(&mut s)));
                let (l, a) = (20.0 * exp(0.4 * u), 12.0 * exp(0.3 * (0.5 * u + 0.87 * v) - 0.7));
                writeln!(groups, "{field},{},{l},{a}", 100 * i + 50).expect("a text grows");
            }
        }
        stranger.file("groups.csv", &groups);
        stranger
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn file(&self, name: &str, text: &str) {
        fs::write(self.path(name), text).expect("a file can be written");
    }

    fn text(&self, name: &str) -> String {
        fs::read_to_string(self.path(name)).expect("the file is there")
    }

    fn command(&self, arguments: &[&str]) -> Command {
        let folder = self.folder.path().display().to_string();
        let mut command = Command::new(example());
        command.args(arguments.iter().map(|word| word.replace("DIR", &folder)));
        command.stdout(Stdio::piped()).stderr(Stdio::piped());
        command
    }

    /// What a call that must succeed says.
    #[track_caller]
    fn said(&self, arguments: &[&str]) -> String {
        let output = self.command(arguments).output().expect("the example runs");
        let (out, err) = (
            String::from_utf8_lossy(&output.stdout),
            String::from_utf8_lossy(&output.stderr),
        );
        assert!(output.status.success(), "{arguments:?}: {err}");
        out.into_owned()
    }

    /// Why a call is refused; the state must be what it was.
    #[track_caller]
    fn refused(&self, arguments: &[&str]) -> String {
        let before = fs::read(self.path("state.toml")).ok();
        let output = self.command(arguments).output().expect("the example runs");
        assert_eq!(output.status.code(), Some(2), "{arguments:?} must be refused");
        assert_eq!(fs::read(self.path("state.toml")).ok(), before, "nothing is taken");
        let folder = format!("{}/", self.folder.path().display());
        String::from_utf8_lossy(&output.stderr).replace(&folder, "")
    }

    /// The samples asked for: sample -> (l, a).
    fn batch(&self) -> BTreeMap<usize, (f64, f64)> {
        let text = self.text("batch.csv");
        let row = |line: &str| {
            let cells: Vec<f64> = line.split(',').map(|cell| cell.parse().expect("a number")).collect();
            (cells[0] as usize, (cells[2], cells[3]))
        };
        text.lines().skip(1).map(row).collect()
    }

    /// Simulates samples: the stranger's ship, which nobody but the tests knows.
    fn simulate(&self, samples: impl IntoIterator<Item = (usize, (f64, f64))>) {
        self.answer(samples, |l, a| {
            // The sample's number differs between sequences, its group does not.
            let noise = from_uniform(uniform(&mut ChaCha12Rng::seed_from_u64(l.to_bits())));
            (roll(l, a) + 0.05 * noise).to_string()
        });
    }

    /// Writes maxima.csv with another ship.
    fn answer(&self, samples: impl IntoIterator<Item = (usize, (f64, f64))>, ship: impl Fn(f64, f64) -> String) {
        let mut text = "sample,r\n".to_owned();
        for (sample, (l, a)) in samples {
            writeln!(text, "{sample},{}", ship(l, a)).expect("a text grows");
        }
        self.file("maxima.csv", &text);
    }

    /// Whether a temporary file lies in the folder.
    fn has_leftovers(&self) -> bool {
        let entries = fs::read_dir(self.folder.path()).expect("the folder is there");
        let names = entries.map(|entry| entry.expect("an entry").file_name());
        names.into_iter().any(|name| name.to_string_lossy().ends_with(".tmp"))
    }

    /// Asks, simulates and tells until it is done; returns what was said last.
    fn to_the_end(&self) -> String {
        self.to_the_end_with(|| self.simulate(self.batch()))
    }

    /// The same with another way to write maxima.csv.
    fn to_the_end_with(&self, mut simulate: impl FnMut()) -> String {
        for _ in 0..20 {
            self.said(&["ask", "DIR"]);
            simulate();
            let said = self.said(&["tell", "DIR", "DIR/maxima.csv"]);
            if said.contains("done") {
                return said;
            }
        }
        panic!("36 samples are told in at most 20 batches");
    }
}

fn roll(l: f64, a: f64) -> f64 {
    0.07 * a + 0.004 * l
}

#[test]
fn a_stranger_s_simulator_is_driven_to_an_estimate_near_the_truth() {
    let stranger = Stranger::new();
    let said = stranger.to_the_end();
    assert!(said.starts_with("36 of 36 told; P(r > 0.75) = "), "{said}");
    let text = stranger.text("estimate.csv");
    let mut lines = text.lines();
    assert_eq!(lines.next(), Some("n_samples,probability,std,at_least,at_most"));
    let last: Vec<f64> = lines
        .last()
        .expect("an estimate")
        .split(',')
        .take(3)
        .map(|v| v.parse().expect("a number"))
        .collect();
    let groups = stranger.text("groups.csv");
    let exceeds = |line: &str| {
        let v: Vec<f64> = line.split(',').map(|v| v.parse().expect("a number")).collect();
        distribution((roll(v[2], v[3]) - THETA_T) / 0.05)
    };
    let truth = groups.lines().skip(1).map(exceeds).sum::<f64>() / 2000.0;
    assert_eq!(last[0], 36.0);
    assert!(
        last[2] > 0.0 && (last[1] - truth).abs() < 4.0 * last[2] + 0.1 * truth,
        "{last:?} {truth}"
    );
    stranger.said(&["ask", "DIR"]);
    assert_eq!(stranger.batch().len(), 0, "nothing more is asked");
}

#[test]
fn asking_twice_asks_the_same_and_the_wave_trains_are_those_of_the_batch() {
    let stranger = Stranger::new();
    stranger.said(&["ask", "DIR"]);
    let first = (stranger.text("batch.csv"), stranger.text("waves.csv"));
    stranger.said(&["ask", "DIR"]);
    assert_eq!((stranger.text("batch.csv"), stranger.text("waves.csv")), first);
    assert_eq!(stranger.batch().len(), 30);
    for line in first.0.lines().skip(1) {
        let cell: Vec<f64> = line.split(',').map(|v| v.parse().expect("a number")).collect();
        let (a, from, to) = (cell[3], cell[4], cell[5]);
        let own = |line: &&str| line.starts_with(&format!("{},", cell[0]));
        let train: Vec<(f64, f64)> = first
            .1
            .lines()
            .filter(own)
            .map(|line| {
                let v: Vec<f64> = line.split(',').map(|v| v.parse().expect("a number")).collect();
                (v[1], v[2])
            })
            .collect();
        assert!(
            train[0].0 <= from && train[train.len() - 1].0 >= to,
            "the whole segment is covered"
        );
        let largest = train
            .iter()
            .filter(|(t, _)| (from..=to).contains(t))
            .map(|(_, eta)| eta.abs());
        assert!(largest.fold(0.0, f64::max) > 0.85 * a, "the group is in its train");
    }
}

#[test]
fn some_now_and_others_later_ends_as_all_at_once_does() {
    let (whole, parts) = (Stranger::new(), Stranger::new());
    whole.to_the_end();
    for _ in 0..40 {
        parts.said(&["ask", "DIR"]);
        // The last first, a few at a time, each told twice.
        parts.simulate(parts.batch().into_iter().rev().take(11));
        parts.said(&["tell", "DIR", "DIR/maxima.csv"]);
        let known = parts.text("state.toml");
        let said = parts.said(&["tell", "DIR", "DIR/maxima.csv"]);
        assert_eq!(parts.text("state.toml"), known, "told twice is told once");
        if said.contains("done") {
            break;
        }
    }
    assert_eq!(parts.text("estimate.csv"), whole.text("estimate.csv"));
}

#[test]
fn a_call_killed_at_any_time_changes_nothing_but_what_it_was_for() {
    let (whole, killed) = (Stranger::new(), Stranger::new());
    whole.to_the_end();
    for i in 0..24 {
        for call in [&["ask", "DIR"][..], &["tell", "DIR", "DIR/maxima.csv"]] {
            if call[0] == "tell" {
                killed.simulate(killed.batch());
            }
            let mut child = killed.command(call).spawn().expect("the example runs");
            std::thread::sleep(Duration::from_millis(5 * (i % 6)));
            child.kill().expect("a child can be killed");
            child.wait().expect("a child ends");
            let said = killed.said(call);
            assert!(!killed.has_leftovers(), "the call after removes what a killed one left");
            if said.contains("done") {
                assert_eq!(killed.text("estimate.csv"), whole.text("estimate.csv"));
                return;
            }
        }
    }
    panic!("36 samples are told in at most 24 batches");
}

#[test]
fn a_damaged_state_is_refused_and_the_one_before_goes_on() {
    let (whole, damaged) = (Stranger::new(), Stranger::new());
    whole.to_the_end();
    damaged.said(&["ask", "DIR"]);
    damaged.simulate(damaged.batch());
    damaged.said(&["tell", "DIR", "DIR/maxima.csv"]);
    let good = damaged.text("state.toml");
    for text in [
        String::new(),
        good[..good.len() / 2].to_owned(),
        good.replacen("theta_t = 0.75", "theta_t = 0.70", 1),
        good.replacen("r = 0.", "r = 1.", 1),
    ] {
        damaged.file("state.toml", &text);
        for call in [&["ask", "DIR"][..], &["tell", "DIR", "DIR/maxima.csv"]] {
            let why = damaged.refused(call);
            assert!(
                why.contains("state.toml: expected what was saved, found a damaged or edited file"),
                "{why}"
            );
            assert!(
                why.contains("copy state.before.toml over it and tell the last maxima again"),
                "{why}"
            );
        }
    }
    damaged.file("state.toml", &damaged.text("state.before.toml"));
    damaged.said(&["tell", "DIR", "DIR/maxima.csv"]);
    assert_eq!(damaged.text("state.toml"), good);
    damaged.to_the_end();
    assert_eq!(damaged.text("estimate.csv"), whole.text("estimate.csv"));
}

#[test]
fn a_sequence_is_begun_once_with_sound_numbers_and_keeps_its_groups() {
    let stranger = Stranger::new();
    let why = stranger.refused(&begin("36"));
    assert!(why.contains("state.toml: expected no sequence yet, found one"), "{why}");
    let why = stranger.refused(&["ask", "DIR/absent"]);
    assert!(why.contains("absent: expected the folder of a sequence"), "{why}");
    for (option, value, says) in [
        ("--t-p", "0", "--t-p: expected a peak period in s"),
        (
            "--theta-t",
            "NaN",
            "--theta-t: expected a threshold in the unit of the maxima",
        ),
        ("--cap", "0.5", "--cap: expected a number above theta_t = 0.75"),
        ("--total", "20", "--total: expected 30 to 300 samples"),
    ] {
        let mut call = begin("36");
        call[1] = "DIR/other";
        match call.iter().position(|word| *word == option) {
            Some(i) => call[i + 1] = value,
            None => call.extend([option, value]),
        }
        assert!(stranger.refused(&call).contains(says), "{}", stranger.refused(&call));
    }
    let groups = stranger.text("groups.csv");
    let lines: Vec<&str> = groups.lines().collect();
    for (text, says) in [
        (
            groups.replacen("field,", "sea,", 1),
            "groups.csv, line 1: expected the columns field,t_c,l,a, found `sea,t_c,l,a`",
        ),
        (
            format!("{}\n{}\n{}\n", lines[0], lines[2], lines[1]),
            "line 3: expected what follows field 0, t_c 150",
        ),
        (
            lines[..37].join("\n") + "\n",
            "groups.csv: expected more than 36 groups, since no sample and no failed run takes one twice, found 36",
        ),
        (
            "field,t_c,l,a\n0,50,-3,2\n".to_owned(),
            "line 2: expected l from 0.15 to 15000",
        ),
    ] {
        stranger.file("wrong.csv", &text);
        let mut call = begin("36");
        (call[1], call[3]) = ("DIR/other", "DIR/wrong.csv");
        let why = stranger.refused(&call);
        assert!(why.contains(&says.replace("groups.csv", "wrong.csv")), "{why}");
    }
    stranger.file("groups.csv", &groups.replacen(",50,", ",51,", 1));
    let why = stranger.refused(&["ask", "DIR"]);
    assert!(
        why.contains("groups.csv: expected groups of blake3 ") && why.contains("restore the file"),
        "{why}"
    );
}
