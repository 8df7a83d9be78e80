//! Runs of a toy pipeline in processes of their own: the test binary calls itself and asks for one test.

use crate::common::{Done, House};
use encounter::engine::arrow::{All, Each, PiecesOf};
use encounter::engine::error::Result;
use encounter::engine::event::Event;
use encounter::engine::node::{Node, node};
use encounter::engine::pipeline::Pipeline;
use encounter::engine::stage::{Here, Keep, Pieces, Published, Stage};
use encounter::numerics::random;
use serde::{Deserialize, Serialize};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::sync::Arc;
use std::time::Duration;

/// phases (left out of the store) -> slow -> total (published).
pub(super) const SLOW: Pipeline = Pipeline {
    axes: &[],
    contents: CONTENTS,
    optional: &[],
    on_request: &[],
};
const CONTENTS: &[&dyn Node] = &[node::<Phases>(), node::<Slow>(), node::<Total>()];

/// The parameters of the slow pipeline.
pub(super) const SLOW_PARAMS: &str = "
[run]
seed = 3
[phases]
count = 12
[slow]
milliseconds = 2
words = 300
[total]
shift = 0
";

struct Phases;

#[derive(Serialize, Deserialize)]
struct NoParams {}

impl Stage for Phases {
    const NAME: &'static str = "phases";
    const PAPER: &'static str = "§1";
    const PIECES: Pieces = Pieces::Counted("phases.count");
    const KEEP: Keep = Keep::Evict;
    const SCHEMA: &'static str = "slow-phases/1";
    type Params = NoParams;
    type Inputs = ();
    type Output = u64;

    fn run(_: &NoParams, (): (), here: Here<'_>) -> Result<u64> {
        Ok(random::below(&mut here.stream(here.first), 1_000_000) as u64)
    }
}

struct Slow;

#[derive(Serialize, Deserialize)]
struct SlowParams {
    slow: SlowTable,
}

#[derive(Serialize, Deserialize)]
struct SlowTable {
    milliseconds: u64,
    words: u64,
}

impl Stage for Slow {
    const NAME: &'static str = "slow";
    const PAPER: &'static str = "§2";
    const PIECES: Pieces = Pieces::AsUpstream;
    const SCHEMA: &'static str = "slow-words/1";
    type Params = SlowParams;
    type Inputs = (Each<Phases>,);
    type Output = Vec<u64>;

    fn run(p: &SlowParams, (phase,): (Arc<u64>,), _: Here<'_>) -> Result<Vec<u64>> {
        std::thread::sleep(Duration::from_millis(p.slow.milliseconds));
        Ok((0..p.slow.words).map(|word| word * *phase).collect())
    }
}

struct Total;

#[derive(Serialize, Deserialize)]
struct TotalParams {
    total: TotalTable,
}

#[derive(Serialize, Deserialize)]
struct TotalTable {
    shift: u64,
}

impl Stage for Total {
    const NAME: &'static str = "total";
    const PAPER: &'static str = "Table 1";
    const SCHEMA: &'static str = Published::SCHEMA;
    type Params = TotalParams;
    type Inputs = (All<Slow>,);
    type Output = Published;

    fn run(p: &TotalParams, (slow,): (PiecesOf<'_, Vec<u64>>,), _: Here<'_>) -> Result<Published> {
        let mut sum = p.total.shift;
        for piece in slow.iter() {
            sum += piece?.iter().sum::<u64>();
        }
        Ok(Published::new(Self::NAME, [("csv", format!("{sum}\n"))]))
    }
}

/// A house of the slow pipeline in a folder.
pub(super) fn slow_house(root: &Path) -> House {
    let mut house = House::at(root);
    house.pipeline = SLOW;
    SLOW_PARAMS.clone_into(&mut house.text);
    house
}

/// What a process of its own is to do, and what it said.
#[derive(Default, Serialize, Deserialize)]
pub(super) struct Task {
    pub(super) folder: String,
    pub(super) edits: Vec<String>,
    pub(super) targets: Vec<String>,
    pub(super) workers: usize,
}

const ASKED: &str = "ENCOUNTER_TEST_TASK";
const SAID: &str = "task said: ";

/// What came of a run in a process of its own.
#[derive(Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Answer {
    pub(super) ran: Vec<String>,
    pub(super) waited: Vec<String>,
    pub(super) reused: usize,
    pub(super) error: Option<String>,
    pub(super) lock: Option<String>,
}

impl Answer {
    fn of(done: Done) -> Self {
        let reused = |event: &&Event| matches!(event, Event::DidReuse { .. });
        Self {
            ran: done.ran(),
            waited: done.waited(),
            reused: done.events.iter().filter(reused).count(),
            error: done.outcome.as_ref().err().map(ToString::to_string),
            lock: done.lock.map(|lock| lock.text()),
        }
    }
}

/// Starts a process that does a task.
pub(super) fn start(task: &Task) -> Child {
    let task = serde_json::to_string(task).expect("a task is plain data");
    Command::new(std::env::current_exe().expect("the test binary has a path"))
        .args([
            "reliability::child::does_its_task",
            "--exact",
            "--ignored",
            "--nocapture",
        ])
        .env(ASKED, task)
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("the test binary runs")
}

/// Waits for a process and reads its answer; none if it was killed.
pub(super) fn answer(child: Child) -> Option<Answer> {
    let output = child.wait_with_output().expect("the process can be waited for");
    let text = String::from_utf8_lossy(&output.stdout);
    let said = text.lines().find_map(|line| line.split_once(SAID));
    assert!(
        said.is_some() || output.status.code().is_none(),
        "a process that was not killed answers: {text}{}",
        String::from_utf8_lossy(&output.stderr)
    );
    said.map(|(_, json)| serde_json::from_str(json).expect("an answer"))
}

#[test]
#[ignore = "does its task in processes that other tests start; without one it does nothing"]
fn does_its_task() {
    let Ok(task) = std::env::var(ASKED) else { return };
    let task: Task = serde_json::from_str(&task).expect("a task");
    let mut house = slow_house(Path::new(&task.folder));
    house.edits = task.edits;
    house.workers = task.workers;
    let targets: Vec<&str> = task.targets.iter().map(String::as_str).collect();
    let answer = Answer::of(house.run_targets(&targets));
    println!("{SAID}{}", serde_json::to_string(&answer).expect("plain data"));
}
