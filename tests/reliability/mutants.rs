//! Mutants: stages fed by what no key holds. A rebuild catches each, names it first, and tells it from a stage that is
//! only different from its lock; one that draws from its own streams passes.

use encounter::engine::arrow::{All, Each, PiecesOf};
use encounter::engine::error::{Error, Result};
use encounter::engine::event::Event;
use encounter::engine::graph::Graph;
use encounter::engine::lock::Lock;
use encounter::engine::node::node;
use encounter::engine::params::ParamsFile;
use encounter::engine::pipeline::Pipeline;
use encounter::engine::rebuild::{Against, Rebuilt, compare};
use encounter::engine::run::Run;
use encounter::engine::schedule;
use encounter::engine::stage::{Here, Keep, Pieces, Stage};
use encounter::engine::store::Store;
use encounter::engine::target::Target;
use encounter::numerics::random;
use rayon::iter::{IntoParallelIterator, ParallelIterator};
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, HashMap};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, SystemTime, UNIX_EPOCH};

const PIECES: u64 = 6;
const PARAMS: &str = "[run]\nseed = 5\n[mutant]\npieces = 6\n";

#[derive(Serialize, Deserialize)]
struct NoParams {}

/// What is sound above the mutant.
struct Steady;

impl Stage for Steady {
    const NAME: &'static str = "steady";
    const PAPER: &'static str = "§1";
    const PIECES: Pieces = Pieces::Counted("mutant.pieces");
    const SCHEMA: &'static str = "steady/1";
    type Params = NoParams;
    type Inputs = ();
    type Output = Vec<f64>;

    fn run(_: &NoParams, (): (), here: Here<'_>) -> Result<Vec<f64>> {
        let mut stream = here.stream(here.first);
        Ok((0..1000).map(|_| random::uniform(&mut stream)).collect())
    }
}

const SOUND: u8 = 0;
const TIME: u8 = 1;
const THREADS: u8 = 2;
const HASH_ORDER: u8 = 3;
const UNORDERED_SUM: u8 = 4;
const WEATHER: u8 = 5;
const EVICTED_TIME: u8 = 6;

/// Something outside the process that is the same each time it is asked, until it changes; one for each test.
static WEATHERS: [AtomicU64; 4] = [const { AtomicU64::new(1) }; 4];

/// What a mutant says of its piece.
#[derive(Debug, PartialEq, Serialize, Deserialize)]
struct Words {
    item: u64,
    numbers: Vec<f64>,
}

/// A stage that is fed by something that its key does not hold.
struct Mutant<const KIND: u8, const TEST: usize = 0>;

impl<const KIND: u8, const TEST: usize> Stage for Mutant<KIND, TEST> {
    const NAME: &'static str = "mutant";
    const PAPER: &'static str = "§2";
    const PIECES: Pieces = Pieces::AsUpstream;
    const KEEP: Keep = if KIND == EVICTED_TIME {
        Keep::Evict
    } else {
        Keep::Always
    };
    const SCHEMA: &'static str = "mutant/1";
    type Params = NoParams;
    type Inputs = (Each<Steady>,);
    type Output = Words;

    fn run(_: &NoParams, (steady,): (Arc<Vec<f64>>,), here: Here<'_>) -> Result<Words> {
        let mut numbers = vec![steady[0]];
        match KIND {
            TIME | EVICTED_TIME => {
                let now = SystemTime::now()
                    .duration_since(UNIX_EPOCH)
                    .expect("a clock after 1970");
                numbers.push(now.as_nanos() as f64);
            }
            THREADS => {
                // Long enough that no single worker takes every piece.
                std::thread::sleep(Duration::from_millis(20));
                numbers.push(rayon::current_thread_index().map_or(-1.0, |index| index as f64));
            }
            HASH_ORDER => {
                let shuffled: HashMap<usize, f64> = steady.iter().copied().enumerate().collect();
                numbers.extend(shuffled.into_values());
            }
            UNORDERED_SUM => {
                let terms: Vec<f64> = steady.iter().map(|x| 1.0 / (x + 1e-9)).collect();
                numbers.push(terms.into_par_iter().sum());
            }
            WEATHER => numbers.push(WEATHERS[TEST].load(Ordering::SeqCst) as f64),
            _ => numbers.extend(steady.iter().take(3)),
        }
        Ok(Words {
            item: here.first,
            numbers,
        })
    }
}

/// What only follows from the mutant.
struct Follower<const KIND: u8, const TEST: usize = 0>;

impl<const KIND: u8, const TEST: usize> Stage for Follower<KIND, TEST> {
    const NAME: &'static str = "follower";
    const PAPER: &'static str = "§3";
    const SCHEMA: &'static str = "follower/1";
    type Params = NoParams;
    type Inputs = (All<Mutant<KIND, TEST>>,);
    type Output = Vec<f64>;

    fn run(_: &NoParams, (words,): (PiecesOf<'_, Words>,), _: Here<'_>) -> Result<Vec<f64>> {
        words
            .iter()
            .map(|words| Ok(words?.numbers.iter().fold(0.0, |sum, x| sum + x)))
            .collect()
    }
}

const fn pipeline<const KIND: u8, const TEST: usize>() -> Pipeline {
    Pipeline {
        axes: &[],
        contents: const {
            &[
                node::<Steady>(),
                node::<Mutant<KIND, TEST>>(),
                node::<Follower<KIND, TEST>>(),
            ]
        },
        optional: &[],
        on_request: &[],
    }
}

/// A folder with an ordinary store, and the pipeline of one mutant.
struct Cage {
    folder: tempfile::TempDir,
    pipeline: Pipeline,
}

impl Cage {
    fn of<const KIND: u8, const TEST: usize>() -> Self {
        let folder = tempfile::tempdir().expect("a temporary folder can be made");
        Self {
            folder,
            pipeline: pipeline::<KIND, TEST>(),
        }
    }

    fn graph(&self) -> Graph {
        let mut params = ParamsFile::default();
        params
            .layer("mutants.toml", PARAMS)
            .expect("the parameters are in order");
        Graph::new(&self.pipeline, &params, &[] as &[Target]).expect("the graph is in order")
    }

    fn ordinary(&self) -> Store {
        Store::open(&self.folder.path().join("store")).expect("a store can be opened")
    }

    /// A run in the ordinary store: what is committed.
    fn lock(&self, workers: usize) -> Lock {
        let (graph, store) = (self.graph(), self.ordinary());
        let silent = |_: &Event| {};
        let run = Run::new(&graph, &store, &silent);
        schedule::execute(&run, workers).expect("the run succeeds");
        Lock::of(&run, "mutants", encounter::engine::code::RUSTC, &BTreeMap::new()).expect("a finished run")
    }

    /// A run from nothing, compared with a lock; the ordinary store may be one that has nothing.
    fn rebuild(&self, lock: &Lock, workers: usize, ordinary: &Store) -> Result<Rebuilt> {
        let graph = self.graph();
        let folder = tempfile::tempdir().expect("a temporary folder can be made");
        let store = Store::open(folder.path())?;
        let silent = |_: &Event| {};
        let run = Run::new(&graph, &store, &silent);
        schedule::execute(&run, workers)?;
        let made = Lock::of(&run, "mutants", encounter::engine::code::RUSTC, &BTreeMap::new())?;
        let whole = true;
        let against = Against {
            lock,
            ordinary,
            whole,
            workers,
        };
        compare(&run, &made, &against)
    }

    fn quarantined(&self) -> usize {
        let entries = std::fs::read_dir(self.folder.path().join("store/quarantine"));
        entries.expect("the store has a quarantine").count()
    }
}

fn error_of(rebuilt: &Rebuilt) -> Error {
    rebuilt.error(Path::new("mutants.lock")).expect("something differs")
}

/// Makes a lock on one thread, rebuilds on four, with and without the old objects: the mutant is named first, exit 4.
#[track_caller]
fn is_caught<const KIND: u8>(path: &str) {
    let cage = Cage::of::<KIND, 0>();
    let lock = cage.lock(1);
    let nowhere = tempfile::tempdir().expect("a temporary folder can be made");
    for ordinary in [cage.ordinary(), Store::look(&nowhere.path().join("none"))] {
        let rebuilt = cage.rebuild(&lock, 4, &ordinary).expect("the rebuild ends");
        let first = rebuilt.first.as_ref().expect("the mutant differs");
        assert!(first.node.starts_with("mutant/"), "{first:?}");
        assert!(!first.reproducible, "{first:?}");
        let difference = first.difference.as_ref().expect("both outputs are at hand");
        assert!(difference.path.starts_with(path), "{difference}");
        assert!(difference.ulp.is_some_and(|ulp| ulp > 0), "{difference}");
        assert!(
            rebuilt.differences[0].starts_with("mutant: "),
            "{:?}",
            rebuilt.differences
        );
        assert_eq!(
            (rebuilt.differences.len(), rebuilt.downstream),
            (1, 1),
            "the follower follows"
        );
        let error = error_of(&rebuilt);
        assert_eq!(error.exit_code(), 4);
        assert!(error.to_string().starts_with("mutant/"), "{error}");
        assert!(error.to_string().contains("it differs from itself"), "{error}");
        assert_eq!(cage.quarantined(), 2, "both outputs are kept, once");
    }
    assert!(!nowhere.path().join("none").exists());
}

#[test]
fn a_stage_fed_by_the_clock_is_caught() {
    is_caught::<TIME>("numbers[1]");
}

#[test]
fn a_stage_fed_by_the_order_of_threads_is_caught() {
    is_caught::<THREADS>("numbers[1]");
}

#[test]
fn a_stage_fed_by_the_order_of_a_hash_map_is_caught() {
    is_caught::<HASH_ORDER>("numbers[");
}

#[test]
fn a_stage_fed_by_an_unordered_sum_is_caught() {
    is_caught::<UNORDERED_SUM>("numbers[1]");
}

#[test]
fn a_mutant_that_is_left_out_of_the_store_is_caught() {
    let cage = Cage::of::<EVICTED_TIME, 0>();
    let lock = cage.lock(1);
    let rebuilt = cage.rebuild(&lock, 2, &cage.ordinary()).expect("the rebuild ends");
    let first = rebuilt.first.as_ref().expect("the mutant differs");
    assert_eq!((first.node.as_str(), first.reproducible), ("mutant/0", false));
    assert!(
        first
            .verdict
            .starts_with("made three times just now, on 2 and 1 threads"),
        "{}",
        first.verdict
    );
    assert_eq!(error_of(&rebuilt).exit_code(), 4);
}

#[test]
fn a_run_that_needs_a_damaged_output_again_catches_a_mutant_too() {
    let cage = Cage::of::<HASH_ORDER, 0>();
    cage.lock(2);
    let store = cage.folder.path().join("store");
    let files = |kind: &str| -> Vec<(String, PathBuf)> {
        let folders = std::fs::read_dir(store.join(kind)).expect("a folder").flatten();
        let files = folders.flat_map(|folder| std::fs::read_dir(folder.path()).into_iter().flatten().flatten());
        files
            .map(|file| (std::fs::read_to_string(file.path()).unwrap_or_default(), file.path()))
            .collect()
    };
    // The follower is to run again, and finds a mutant's object damaged.
    let records = files("records");
    let of = |node: &str| {
        let node = format!("\"node\":\"{node}\"");
        records.iter().find(|(text, _)| text.contains(&node)).expect("a record")
    };
    std::fs::remove_file(&of("follower").1).expect("the record can be deleted");
    let id = of("mutant")
        .0
        .split("\"id\":\"")
        .nth(1)
        .and_then(|rest| rest.get(..64))
        .expect("an id");
    let object = store.join("objects").join(&id[..2]).join(&id[2..]);
    let bytes = std::fs::read(&object).expect("the object is there");
    std::fs::write(&object, &bytes[..bytes.len() - 1]).expect("the object can be damaged");

    let (graph, ordinary) = (cage.graph(), cage.ordinary());
    let silent = |_: &Event| {};
    let error = schedule::execute(&Run::new(&graph, &ordinary, &silent), 2).expect_err("the mutant differs");
    assert_eq!(error.exit_code(), 4);
    let text = error.to_string();
    assert!(
        text.starts_with("mutant/") && text.contains(&format!("recorded {id}")),
        "{text}"
    );
    assert!(text.contains("\n  numbers[") && text.contains(" ULP"), "{text}");
    assert!(
        text.contains("it differs from itself; the new output is kept in quarantine/"),
        "{text}"
    );
    assert_eq!(cage.quarantined(), 2, "the damaged output and the new one");
    // In a rebuild the same error is its verdict.
    let rebuilt = Rebuilt::cut_short(&error).expect("a verdict");
    assert_eq!(error_of(&rebuilt).to_string(), text);
    assert!(Rebuilt::cut_short(&Error::stage("another error")).is_none());
}

#[test]
fn a_sound_stage_passes_on_any_number_of_threads() {
    let cage = Cage::of::<SOUND, 0>();
    let lock = cage.lock(1);
    assert_eq!(lock.lines[1].pieces, Some(PIECES as usize));
    for workers in [1, 2, 4] {
        let rebuilt = cage
            .rebuild(&lock, workers, &cage.ordinary())
            .expect("the rebuild ends");
        assert_eq!(rebuilt, Rebuilt::default());
        assert!(rebuilt.error(Path::new("mutants.lock")).is_none());
    }
    assert_eq!(cage.quarantined(), 0);
}

#[test]
fn what_changed_between_runs_is_told_by_the_record_of_the_same_key() {
    let cage = Cage::of::<WEATHER, 1>();
    let lock = cage.lock(2);
    WEATHERS[1].store(2, Ordering::SeqCst);
    let rebuilt = cage.rebuild(&lock, 2, &cage.ordinary()).expect("the rebuild ends");
    let first = rebuilt.first.as_ref().expect("the mutant differs");
    assert_eq!((first.node.as_str(), first.reproducible), ("mutant/0", false));
    let difference = first.difference.as_ref().expect("both outputs are at hand").to_string();
    assert!(difference.starts_with("numbers[1]  1.0 / 2.0 ("), "{difference}");
    assert!(difference.contains("; 1 of 3 differ, at most "), "{difference}");
    assert!(
        first
            .verdict
            .contains("recorded otherwise by the same compiler on the same system"),
        "{}",
        first.verdict
    );
    assert_eq!(error_of(&rebuilt).exit_code(), 4);
    assert_eq!(cage.quarantined(), 2);
}

#[test]
fn without_the_old_objects_a_change_is_a_difference_of_a_stage_that_reproduces_itself() {
    let cage = Cage::of::<WEATHER, 2>();
    let lock = cage.lock(2);
    WEATHERS[2].store(2, Ordering::SeqCst);
    let nowhere = Store::look(&cage.folder.path().join("none"));
    let rebuilt = cage.rebuild(&lock, 2, &nowhere).expect("the rebuild ends");
    let first = rebuilt.first.as_ref().expect("the mutant differs");
    assert_eq!((first.node.as_str(), first.reproducible), ("mutant", true));
    assert!(first.difference.is_none());
    assert!(
        first
            .verdict
            .starts_with("made once more, on 1 thread, it came out the same; "),
        "{}",
        first.verdict
    );
    let error = error_of(&rebuilt);
    assert_eq!(error.exit_code(), 3);
    assert!(
        error.to_string().contains("1 more line of the lock follows from this"),
        "{error}"
    );
}

#[test]
fn bits_that_another_compiler_recorded_are_a_difference_and_name_it() {
    let cage = Cage::of::<WEATHER, 3>();
    let lock = cage.lock(2);
    WEATHERS[3].store(2, Ordering::SeqCst);
    let mut forged = 0;
    let records = cage.folder.path().join("store/records");
    for folder in std::fs::read_dir(records).expect("records").flatten() {
        for file in std::fs::read_dir(folder.path()).expect("records").flatten() {
            let text = std::fs::read_to_string(file.path()).expect("a record");
            let (body, _) = text.rsplit_once(",\"check\":\"").expect("a record ends in its check");
            let body = body.replace(encounter::engine::code::RUSTC, "rustc 1.0.0");
            let check = blake3::hash(body.as_bytes()).to_hex();
            std::fs::write(file.path(), format!("{body},\"check\":\"{check}\"}}\n"))
                .expect("the record can be written");
            forged += 1;
        }
    }
    assert_eq!(forged, 2 * PIECES + 1);
    let rebuilt = cage.rebuild(&lock, 2, &cage.ordinary()).expect("the rebuild ends");
    let first = rebuilt.first.as_ref().expect("the mutant differs");
    assert!(first.reproducible && first.difference.is_some(), "{first:?}");
    assert!(
        first.verdict.contains("it was recorded with rustc 1.0.0 on "),
        "{}",
        first.verdict
    );
    assert_eq!(error_of(&rebuilt).exit_code(), 3);
}
