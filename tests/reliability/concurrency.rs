//! Runs at once: each key is made once, nobody fails, everybody ends with the same contents.

use super::child::{Answer, Task, answer, slow_house, start};
use super::disk::{Deed, watched};
use crate::common::House;
use std::collections::BTreeMap;
use std::io;
use std::path::Path;
use std::thread;
use tempfile::TempDir;

fn folder() -> TempDir {
    tempfile::tempdir().expect("a temporary folder can be made")
}

/// Runs tasks at once, all in one folder.
fn at_once(folder: &Path, tasks: Vec<Task>) -> Vec<Answer> {
    let children: Vec<_> = tasks
        .into_iter()
        .map(|mut task| {
            task.folder = folder.display().to_string();
            task.workers = task.workers.max(1);
            start(&task)
        })
        .collect();
    // All answers fit into their pipes, so waiting one by one blocks nobody.
    let answers = children
        .into_iter()
        .map(|child| answer(child).expect("nobody is killed"));
    answers.collect()
}

/// How often each piece was made by all of them together.
fn times(answers: &[Answer]) -> BTreeMap<&str, usize> {
    let mut times = BTreeMap::new();
    for piece in answers.iter().flat_map(|answer| &answer.ran) {
        *times.entry(piece.as_str()).or_default() += 1;
    }
    times
}

#[track_caller]
fn nobody_failed(answers: &[Answer]) {
    for answer in answers {
        assert_eq!(answer.error, None);
    }
}

#[test]
fn four_runs_of_the_same_share_the_work() {
    let folder = folder();
    let tasks = (0..4).map(|i| Task {
        edits: vec!["slow.milliseconds=20".to_owned()],
        workers: 1 + i % 2,
        ..Task::default()
    });
    let answers = at_once(folder.path(), tasks.collect());
    nobody_failed(&answers);
    let times = times(&answers);
    assert_eq!(times.len(), 12 + 12 + 1);
    assert!(times.values().all(|times| *times == 1), "{times:?}");
    assert!(answers.iter().all(|answer| answer.lock == answers[0].lock));
    let sharing = answers.iter().filter(|answer| !answer.ran.is_empty()).count();
    assert!(sharing > 1, "a run that finds a key taken turns to other pieces");
    for answer in &answers {
        assert_eq!(answer.ran.len() + answer.reused, 25);
    }
}

#[test]
fn runs_of_overlapping_targets_make_each_key_once() {
    let folder = folder();
    let shapes = [(12, "total"), (18, "slow"), (7, "total"), (18, "total")];
    let tasks = shapes.map(|(count, target)| Task {
        edits: vec![format!("phases.count={count}"), "slow.milliseconds=10".to_owned()],
        targets: vec![target.to_owned()],
        workers: 2,
        ..Task::default()
    });
    let answers = at_once(folder.path(), tasks.into());
    nobody_failed(&answers);
    let mut times = times(&answers);
    // Three counts, three totals.
    assert_eq!(times.remove("total/0"), Some(3));
    assert_eq!(times.len(), 18 + 18);
    assert!(times.values().all(|times| *times == 1), "{times:?}");
}

#[test]
fn a_run_waits_only_when_nothing_else_is_left() {
    let folder = folder();
    let task = || Task {
        edits: vec!["phases.count=1".to_owned(), "slow.milliseconds=1500".to_owned()],
        ..Task::default()
    };
    let answers = at_once(folder.path(), vec![task(), task()]);
    nobody_failed(&answers);
    let waited: Vec<&String> = answers.iter().flat_map(|answer| &answer.waited).collect();
    assert!(waited.iter().any(|piece| *piece == "slow/0"), "{answers:?}");
    assert!(times(&answers).values().all(|times| *times == 1));
}

#[test]
fn equal_cases_are_made_once_by_many_workers() {
    let mut house = House::new();
    house.workers = 8;
    house.set("run.bases=[\"a\", \"c\"]");
    let done = house.run();
    done.expect_success();
    let squares = done.ran().into_iter().filter(|piece| piece.starts_with("squares"));
    // Three pieces for a and c together; those of b are there for the pinned figure.
    assert_eq!(squares.count(), 6, "{:?}", done.ran());
}

#[test]
fn garbage_is_collected_between_runs_never_during_one() {
    let folder = folder();
    let task = |shift: usize| Task {
        edits: vec![format!("total.shift={shift}"), "slow.milliseconds=5".to_owned()],
        ..Task::default()
    };
    thread::scope(|scope| {
        let path = folder.path();
        let runs: Vec<_> = (0..3)
            .map(|i| {
                scope.spawn(move || {
                    (0..4)
                        .flat_map(|j| at_once(path, vec![task(4 * i + j)]))
                        .collect::<Vec<_>>()
                })
            })
            .collect();
        let collector = scope.spawn(move || {
            for _ in 0..6 {
                std::fs::create_dir_all(path.join("store")).expect("a folder can be made");
                slow_house(path).gc(0, false).expect("garbage can be collected");
                thread::sleep(std::time::Duration::from_millis(30));
            }
        });
        for run in runs {
            nobody_failed(&run.join().expect("no panic"));
        }
        collector.join().expect("no panic");
    });
    let again = slow_house(folder.path()).run().locked();
    let fresh = tempfile::tempdir().expect("a temporary folder can be made");
    assert_eq!(again, slow_house(fresh.path()).run().locked());
}

#[test]
fn without_locks_work_is_doubled_and_nothing_corrupted() {
    let folder = folder();
    let house = || {
        let mut house = slow_house(folder.path());
        house.disk = watched(|_, deed| match deed {
            Deed::TryLock => Err(io::ErrorKind::Unsupported.into()),
            _ => Ok(()),
        });
        house
    };
    assert!(house().store().is_without_locks());
    let locks: Vec<_> = thread::scope(|scope| {
        let runs: Vec<_> = (0..4).map(|_| scope.spawn(|| house().run().locked())).collect();
        runs.into_iter().map(|run| run.join().expect("no panic")).collect()
    });
    assert!(locks.iter().all(|lock| *lock == locks[0]));
    let again = house().run();
    assert_eq!((again.ran(), again.healed()), (Vec::new(), Vec::new()));
    assert_eq!(
        slow_house(folder.path()).files_in("store/tmp"),
        Vec::<std::path::PathBuf>::new()
    );
}
