//! Kills: a run that is killed at any moment leaves nothing bad, and the next one gives what an undisturbed one gives; a
//! run that is asked to end does so within a second.

use super::bad_entries;
use super::child::{Task, answer, slow_house, start};
use crate::cli::verbs::SMALL;
use crate::common::program::Program;
use encounter::numerics::random;
use rand_chacha::ChaCha12Rng;
use rand_chacha::rand_core::SeedableRng;
use std::fs;
use std::process::{Command, Output, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

const NOTHING: [&str; 0] = [];

/// Objects long enough to be torn while they are written.
const LONG: &str = "slow.words=8000";

/// Kills runs at random moments: up to three in a row, then one that nobody kills.
fn kill(times: usize) {
    let folder = tempfile::tempdir().expect("a temporary folder can be made");
    let fresh = tempfile::tempdir().expect("a temporary folder can be made");
    let path = folder.path().display().to_string();
    let mut rng = ChaCha12Rng::seed_from_u64(12);
    let task = |seed: usize, workers: usize| Task {
        folder: path.clone(),
        edits: vec![format!("run.seed={seed}"), LONG.to_owned()],
        workers,
        ..Task::default()
    };
    let begin = Instant::now();
    assert!(answer(start(&task(1_000_000, 1))).is_some_and(|answer| answer.error.is_none()));
    let undisturbed = begin.elapsed();
    let (mut killed, mut early) = (0, 0);
    for seed in 0.. {
        for _ in 0..=random::below(&mut rng, 3) {
            let mut child = start(&task(seed, 1 + killed % 2));
            sleep(undisturbed.mul_f64(0.1 + 0.85 * random::uniform(&mut rng)));
            child.kill().expect("a process can be killed");
            killed += 1;
            early += usize::from(answer(child).is_none());
            assert_eq!(bad_entries(&slow_house(folder.path())), NOTHING, "kill {killed}");
        }
        let mut after = slow_house(folder.path());
        after.set(&format!("run.seed={seed}"));
        after.set(LONG);
        let done = after.run();
        assert_eq!(done.healed(), NOTHING);
        let mut oracle = slow_house(fresh.path());
        oracle.set(&format!("run.seed={seed}"));
        oracle.set(LONG);
        assert_eq!(done.locked(), oracle.run().locked(), "kill {killed}");
        assert_eq!(bad_entries(&after), NOTHING);
        let ours = fs::read(after.path("figures/total.csv")).expect("the figure is published");
        assert_eq!(
            ours,
            fs::read(oracle.path("figures/total.csv")).expect("the figure is published")
        );
        if killed >= times {
            break;
        }
    }
    println!("{killed} kills, {early} of them before the run was over");
    assert!(early * 3 > killed, "many kills fall into the run: {early} of {killed}");
    // Locks and temporary files of the dead are in nobody's way, and gc takes them.
    let house = slow_house(folder.path());
    house.gc(u64::MAX, false).expect("garbage can be collected");
    assert_eq!(
        house.files_in("store/tmp").len() + house.files_in("store/locks").len(),
        0
    );
}

#[test]
fn a_killed_run_leaves_nothing_bad() {
    kill(60);
}

#[test]
#[ignore = "500 kills take minutes: cargo test --release a_run_killed_500_times -- --ignored --nocapture"]
fn a_run_killed_500_times_leaves_nothing_bad() {
    kill(500);
}

#[test]
fn the_binary_killed_while_it_works_goes_on_from_there() {
    let program = Program::new("tiny");
    let arguments = [&["run", "truth", "--json", "-j", "2"], SMALL.as_slice()].concat();
    for milliseconds in [40, 90, 160, 250] {
        let mut child = program.start(&arguments);
        sleep(Duration::from_millis(milliseconds));
        child.kill().expect("a process can be killed");
        child.wait().expect("the process can be waited for");
    }
    assert_eq!(program.call(&arguments).code, 0);
    let shown = |program: &Program| {
        let shown = program.json(&[&["show", "truth"], SMALL.as_slice()].concat());
        shown["id"].as_str().expect("an id").to_owned()
    };
    let fresh = Program::new("tiny");
    assert_eq!(fresh.call(&arguments).code, 0);
    assert_eq!(shown(&program), shown(&fresh));
}

/// Sends a signal to a run after some time: what it said, and how long it took to end.
fn signalled(program: &Program, signal: &str, arguments: &[&str], after: Duration) -> (Output, Duration) {
    let child = program.start(arguments);
    sleep(after);
    let sent = Command::new("kill").args([signal, &child.id().to_string()]).status();
    assert!(sent.expect("kill runs").success(), "the run was over before the signal");
    let begin = Instant::now();
    let output = child.wait_with_output().expect("the process can be waited for");
    (output, begin.elapsed())
}

#[test]
fn an_interrupted_run_ends_within_a_second_and_the_next_goes_on() {
    let program = Program::new("quick");
    let arguments = ["run"];
    for signal in ["-INT", "-TERM", "-HUP"] {
        let (output, took) = signalled(&program, signal, &arguments, Duration::from_secs(1));
        let said = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(130), "{said}");
        assert!(took < Duration::from_millis(1300), "{took:?}");
        let lines: Vec<&str> = said.lines().filter(|line| !line.contains(": ran ")).collect();
        assert_eq!(
            lines,
            ["interrupted; what is finished is kept, the next run goes on from there"]
        );
        assert!(output.stdout.is_empty());
    }
    let records = fs::read_dir(program.path("store/records")).expect("a store");
    assert!(records.count() > 0, "what was finished is kept");
}

#[test]
fn a_run_under_nohup_outlives_its_terminal() {
    let program = Program::new("quick");
    let run = program.command(&["run"]);
    let begin = Instant::now();
    let mut child = Command::new("sh")
        .args(["-c", "trap '' HUP; exec \"$0\" \"$@\""])
        .arg(run.get_program())
        .args(run.get_args())
        .current_dir(program.path("checkout"))
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .expect("a shell runs");
    let signal = |signal: &str| {
        let sent = Command::new("kill").args([signal, &child.id().to_string()]).status();
        assert!(sent.expect("kill runs").success());
    };
    sleep(Duration::from_secs(1));
    signal("-HUP");
    sleep(Duration::from_millis(1500));
    // Other signals are heard all the same.
    signal("-INT");
    let ended = child.wait().expect("the process can be waited for");
    assert_eq!(ended.code(), Some(130));
    assert!(
        begin.elapsed() > Duration::from_millis(2400),
        "the first signal was ignored"
    );
}
