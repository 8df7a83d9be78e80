//! Garbage collection: what goes, what stays, and that what went comes back with the same bits.

use crate::common::{EVERYTHING, House};
use encounter::engine::gc::Alone;
use encounter::engine::store::Store;
use std::fs;
use std::sync::mpsc::channel;
use std::thread;
use std::time::Duration;

const NOTHING: [&str; 0] = [];

#[test]
fn what_the_last_runs_used_stays_and_the_rest_goes() {
    let mut house = House::new();
    for seed in 1..=5 {
        house.edits.clear();
        house.set(&format!("run.seed={seed}"));
        house.run().expect_success();
    }
    let sweep = house.gc(u64::MAX, false).expect("garbage is collected");
    assert!(
        sweep.unreached > 0 && sweep.freed > 0 && sweep.evicted() == 0,
        "{sweep:?}"
    );
    for seed in [5, 4, 3] {
        house.edits.clear();
        house.set(&format!("run.seed={seed}"));
        let done = house.run();
        assert_eq!((done.ran(), done.healed()), (Vec::new(), Vec::new()), "seed {seed}");
    }
    house.edits.clear();
    house.set("run.seed=2");
    let done = house.run();
    assert!(
        done.ran().len() > 10 && done.healed().is_empty(),
        "what went left no record behind"
    );
}

#[test]
fn what_a_lock_names_stays_however_many_runs_ago() {
    let mut house = House::new();
    let lock = house.run().locked();
    let committed = house.path("artifacts/toy.lock");
    fs::create_dir_all(house.path("artifacts")).expect("a folder can be made");
    fs::write(&committed, lock.text()).expect("a lock can be written");
    for seed in 1..=4 {
        house.edits.clear();
        house.set(&format!("run.seed={seed}"));
        house.run().expect_success();
    }
    house.gc(u64::MAX, false).expect("garbage is collected");
    house.edits.clear();
    let done = house.run();
    assert_eq!((done.ran(), done.healed()), (Vec::new(), Vec::new()));
    // A lock that cannot be read may name anything.
    fs::write(&committed, "<<<<<<< ours\n").expect("a lock can be written");
    let error = house.gc(0, true).expect_err("a refusal");
    assert!(error.to_string().contains("toy.lock, line 1 is damaged"), "{error}");
    assert_eq!(error.exit_code(), 5);
}

#[test]
fn the_work_of_a_run_that_was_killed_stays() {
    let mut house = House::lived_in(&[]);
    thread::sleep(Duration::from_millis(20));
    house.set("run.seed=8");
    house.run_targets(&["squares"]).expect_success();
    // As if it had been killed: it left no word of what it used.
    let runs = house.files_in("store/runs");
    fs::remove_file(runs.last().expect("a run")).expect("a file can be removed");
    house.gc(u64::MAX, false).expect("garbage is collected");
    let done = house.run_targets(&["squares"]);
    assert_eq!(done.ran(), NOTHING);
}

#[test]
fn without_room_bytes_go_records_stay_and_nothing_below_runs() {
    let mut house = House::new();
    let before = house.run().locked();
    let dry = house.gc(0, true).expect("a plan");
    assert_eq!(house.run().ran(), NOTHING, "a dry run takes nothing");
    let sweep = house.gc(0, false).expect("garbage is collected");
    assert_eq!((sweep.freed, sweep.evicted()), (dry.freed, dry.evicted()));
    assert!(sweep.evicted() >= 10, "{sweep:?}");
    // Only the published outputs keep their bytes.
    let kept = house.files_in("store/objects");
    assert_eq!(kept.len(), 3, "{kept:?}");
    let done = house.run();
    assert_eq!((done.ran(), done.healed()), (Vec::new(), Vec::new()));
    assert_eq!(done.reused(), EVERYTHING);
    assert_eq!(done.locked(), before);
    // Needed again, they are made again, checked, and not called damage.
    house.set("total.modulo=999983");
    let done = house.run();
    assert!(
        !done.ran().iter().any(|piece| piece.starts_with("squares")),
        "{:?}",
        done.ran()
    );
    assert_eq!(done.healed(), NOTHING);
    assert!(
        house.files_in("store/objects").len() > 10,
        "and stay for the next reader"
    );
    let fresh = House::lived_in(&["total.modulo=999983"]);
    assert_eq!(done.locked(), fresh.run().locked());
}

#[test]
fn an_evicted_output_that_comes_back_different_is_reported() {
    let house = House::new();
    let done = house.run();
    let (key, id) = done.known["squares/a/0"];
    let other = done.known["squares/a/1"].1;
    house.gc(0, false).expect("garbage is collected");
    let path = house.record(&key);
    let text = fs::read_to_string(&path).expect("the record stays");
    let (body, _) = text.rsplit_once(",\"check\":\"").expect("a check");
    let body = body.replace(&id.to_string(), &other.to_string());
    let forged = format!("{body},\"check\":\"{}\"}}\n", blake3::hash(body.as_bytes()).to_hex());
    fs::write(&path, forged).expect("the record can be written");
    let outcome = house.run().outcome;
    assert_eq!(outcome.expect_err("another content").exit_code(), 4);
}

#[test]
fn within_the_bound_nothing_but_garbage_goes() {
    let house = House::lived_in(&[]);
    let sweep = house.gc(u64::MAX, true).expect("a plan");
    assert_eq!((sweep.unreached, sweep.evicted()), (0, 0));
    assert!(sweep.seconds == 0.0);
    assert_eq!(house.gc(sweep.bytes, true).expect("a plan").evicted(), 0);
    assert_eq!(house.gc(sweep.bytes - 1, true).expect("a plan").evicted(), 1);
    let tight = house.gc(sweep.bytes / 2, true).expect("a plan");
    let all = house.gc(0, true).expect("a plan");
    assert!(tight.freed <= all.freed && tight.evicted() <= all.evicted());
}

#[test]
fn who_collects_waits_for_runs_and_runs_wait_for_it() {
    let house = House::lived_in(&[]);
    let disk = || Store::disk(&house.path("store")).expect("the store is there");
    let running = house.store();
    assert!(Alone::now(disk()).is_none(), "a run lives");
    let (told, hears) = channel();
    thread::scope(|scope| {
        let told_too = told.clone();
        let collector = scope.spawn(|| {
            let waiting = move || told_too.send("gc waits").expect("somebody listens");
            Alone::wait(disk(), &waiting)
                .expect("the store can be locked")
                .expect("a store")
        });
        assert_eq!(hears.recv_timeout(Duration::from_secs(20)), Ok("gc waits"));
        drop(running);
        let alone = collector.join().expect("no panic");
        let run = scope.spawn(|| {
            let done = house.run();
            told.send("run has run").expect("somebody listens");
            done
        });
        assert!(
            hears.recv_timeout(Duration::from_millis(200)).is_err(),
            "a run waits for gc"
        );
        drop(alone);
        assert_eq!(hears.recv_timeout(Duration::from_secs(20)), Ok("run has run"));
        run.join().expect("no panic").expect_success();
    });
}

#[test]
fn a_stranger_s_file_in_a_folder_of_the_store_stays() {
    let house = House::lived_in(&[]);
    let strangers = [
        "tmp/mine/thesis.txt",
        "tmp/notes",
        "tmp/0123456789abcdef-photo.jpg",
        "records/vinyl.txt",
        "objects/stone",
        "objects/ab/stone",
        "parts/cad/hull.step",
        "parts/hull.step",
        "manifests/ab/cargo.csv",
        "manifests/cargo/list.csv",
        "quarantine/letter.txt",
        "quarantine/0123456789abcdef.pdf",
        "locks/door",
        "runs/marathon.json",
        "yarn.lock",
        "fig3.0123456789abcdef.tmp",
    ];
    for name in strangers {
        let path = house.path("store").join(name);
        fs::create_dir_all(path.parent().expect("a folder")).expect("a folder can be made");
        fs::write(path, "mine").expect("a file can be written");
    }
    let sweep = house.gc(0, false).expect("garbage is collected");
    for name in strangers {
        assert!(house.path("store").join(name).is_file(), "{name}");
    }
    assert_eq!(sweep.foreign.len(), 14, "{:?}", sweep.foreign);
}

#[test]
fn a_lock_that_cannot_be_read_stops_the_collection() {
    let house = House::lived_in(&[]);
    fs::create_dir_all(house.path("artifacts")).expect("a folder can be made");
    fs::write(house.path("artifacts/toy.lock"), [0xff, 0xfe]).expect("a lock can be written");
    let before = house.files_in("store/objects");
    let error = house.gc(0, false).expect_err("what the lock keeps is not known");
    assert!(error.to_string().contains("read the lock"), "{error}");
    assert_eq!(house.files_in("store/objects"), before);
}

#[test]
fn runs_at_once_take_a_number_each() {
    let house = House::new();
    std::thread::scope(|scope| {
        for value in 0..6 {
            let mut other = House::at(&house.path(""));
            other.set(&format!("aside.value={value}"));
            scope.spawn(move || other.run_targets(&["aside"]).expect_success());
        }
    });
    let names: Vec<String> = house
        .files_in("store/runs")
        .iter()
        .map(|path| path.file_name().expect("a name").to_string_lossy().into_owned())
        .collect();
    let of_none = |number: u64| format!("{:016x}-{number}.json", 0);
    assert_eq!(names, [of_none(4), of_none(5), of_none(6)]);
}

#[test]
fn a_number_that_no_run_could_have_reached_ends_no_counting() {
    let mut house = House::lived_in(&[]);
    for number in [u64::MAX - 1, u64::MAX] {
        let strange = house.path("store/runs").join(format!("{:016x}-{number}.json", 0));
        fs::write(strange, "{}").expect("a file can be written");
    }
    for value in 10..13 {
        house.set(&format!("aside.value={value}"));
        house.run().expect_success();
    }
    // What they say of themselves does not hold, so that nothing is known to be of no use.
    let before = house.files_in("store/objects");
    house.gc(u64::MAX, false).expect("garbage can be collected");
    assert_eq!(house.files_in("store/objects"), before);
    assert!(house.run().ran().is_empty());
}
