//! What published files were when last compared spares reading them, and can do nothing else, whatever is in it.

use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Duration;

use encounter::engine::disk::{Disk, System};
use encounter::engine::event::Event;
use encounter::engine::idle::{self, Traces};
use encounter::engine::index::{Belief, Index};
use encounter::engine::run::Run;
use encounter::engine::schedule;
use encounter::engine::store::Store;

use crate::common::House;
use crate::common::toy::SCALE;

/// A disk that counts what is read.
#[derive(Default)]
struct Counting(AtomicUsize);

impl Disk for Counting {
    fn read(&self, path: &Path) -> io::Result<Vec<u8>> {
        self.0.fetch_add(1, Ordering::Relaxed);
        System.read(path)
    }
    fn write(&self, path: &Path, bytes: &[u8]) -> io::Result<()> {
        System.write(path, bytes)
    }
    fn synchronise(&self, path: &Path) -> io::Result<()> {
        System.synchronise(path)
    }
    fn rename(&self, from: &Path, to: &Path) -> io::Result<()> {
        System.rename(from, to)
    }
    fn make_folder(&self, path: &Path) -> io::Result<()> {
        System.make_folder(path)
    }
    fn remove(&self, path: &Path) -> io::Result<()> {
        System.remove(path)
    }
    fn open_lock(&self, path: &Path, existing: bool) -> io::Result<File> {
        System.open_lock(path, existing)
    }
    fn try_lock(&self, file: &File, exclusive: bool) -> Result<(), fs::TryLockError> {
        System.try_lock(file, exclusive)
    }
}

/// A look under a name: whether there is nothing to do, and how many objects and records were read to know.
fn look_as(house: &House, name: &str, scales: [&str; 2]) -> (bool, usize) {
    let graph = house.graph(&[]).expect("the parameters are in order");
    let disk = Arc::new(Counting::default());
    let store = Store::open_on(&house.path("store"), disk.clone(), &|| ()).expect("a store can be opened");
    let index = Index::read(store.root(), name);
    let traces = Traces {
        axis: SCALE,
        values: &scales.map(str::to_owned),
        figures: &house.path("figures"),
        lock: None,
    };
    let is_idle = idle::is_idle(&Run::new(&graph, &store, &|_: &Event| {}), &index, &traces);
    (is_idle, disk.0.load(Ordering::Relaxed))
}

fn look(house: &House) -> (bool, usize) {
    look_as(house, "toy", ["small", "large"])
}

/// Nothing to do, and nothing read.
const CALM: (bool, usize) = (true, 0);

fn run_and_index(house: &House, name: &str) {
    house.run().expect_success();
    let (graph, store) = (house.graph(&[]).expect("the parameters are in order"), house.store());
    let run = Run::new(&graph, &store, &|_: &Event| {});
    schedule::execute(&run, 1).expect("nothing is left to do");
    Index::read(store.root(), name)
        .renew(&run)
        .expect("the index can be written");
}

fn grow_old() {
    std::thread::sleep(Duration::from_millis(2_100));
}

/// Makes objects and figures, and index and note of them, old enough to be believed.
fn settle(house: &House, name: &str) {
    run_and_index(house, name);
    grow_old();
    run_and_index(house, name);
    assert!(look_as(house, name, ["small", "large"]).0);
    assert_eq!(look_as(house, name, ["small", "large"]), CALM);
}

fn settled() -> House {
    let house = House::new();
    settle(&house, "toy");
    house
}

fn note(house: &House) -> PathBuf {
    house.path("store/shown.toy")
}

fn figure(house: &House) -> PathBuf {
    house.path("figures/report.csv")
}

/// Edits a figure without changing its length; size and mtime are as before.
fn edit_in_secret(path: &Path) {
    let mut bytes = fs::read(path).expect("a figure");
    let before = fs::metadata(path).expect("a figure");
    let last = bytes.len() - 2;
    bytes[last] ^= 1;
    fs::write(path, &bytes).expect("a figure can be edited");
    let file = File::options().append(true).open(path).expect("a figure can be opened");
    let times = before.modified().expect("files have times");
    file.set_modified(times).expect("times can be set back");
    let after = fs::metadata(path).expect("a figure");
    assert_eq!((after.len(), after.modified().ok()), (before.len(), Some(times)));
}

/// Writes the note anew with another text, rightly sealed.
fn forge(house: &House, from: &str, to: &str) {
    let text = fs::read_to_string(note(house)).expect("there is a note");
    let (body, _) = text.rsplit_once(r#","check":""#).expect("it is sealed");
    assert!(body.contains(from), "{from} in {body}");
    let body = body.replace(from, to);
    let check = blake3::hash(body.as_bytes()).to_hex();
    fs::write(note(house), format!("{body},\"check\":\"{check}\"}}\n")).expect("a note can be forged");
}

/// The stat of a file as a note has it.
fn stat(path: &Path) -> String {
    use std::os::unix::fs::MetadataExt;
    let found = fs::metadata(path).expect("a figure");
    format!(
        r#"{{"size":{},"mtime":[{},{}],"ctime":[{},{}],"inode":{}}}"#,
        found.len(),
        found.mtime(),
        found.mtime_nsec(),
        found.ctime(),
        found.ctime_nsec(),
        found.ino()
    )
}

/// Whether all figures are again what they were.
fn are_restored(house: &House, good: &[(PathBuf, Vec<u8>)]) {
    for (path, bytes) in good {
        assert_eq!(&fs::read(path).expect("a figure"), bytes, "{}", path.display());
    }
    assert_eq!(house.files_in("figures").len(), good.len());
}

fn figures(house: &House) -> Vec<(PathBuf, Vec<u8>)> {
    let paths = house.files_in("figures").into_iter();
    paths
        .map(|path| (path.clone(), fs::read(path).expect("a figure")))
        .collect()
}

#[test]
fn untouched_figures_and_outputs_are_not_read() {
    let house = House::new();
    run_and_index(&house, "toy");
    grow_old();
    run_and_index(&house, "toy");
    // Compared once, and noted.
    let (is_idle, read) = look(&house);
    assert!(is_idle && read > 0);
    assert_eq!(look(&house), CALM);
    fs::remove_file(note(&house)).expect("there is a note");
    assert!(look(&house).1 > 0);
    assert_eq!(look(&house), CALM);
}

#[test]
fn an_edited_figure_under_the_same_size_and_mtime_is_seen_and_restored() {
    let house = settled();
    let good = figures(&house);
    assert!(good.len() > 4);
    for (path, _) in &good {
        edit_in_secret(path);
        assert!(!look(&house).0, "{}", path.display());
        let done = house.run();
        assert_eq!((done.set_aside().len(), done.written().len()), (1, 1));
        are_restored(&house, &good);
        // Restored a moment ago, it is compared until it has lain still.
        assert!(look(&house).0 && look(&house).1 > 0);
    }
    grow_old();
    assert!(look(&house).1 > 0);
    assert_eq!(look(&house), CALM);
}

#[test]
fn a_figure_as_young_as_the_note_is_compared_whatever_its_stat() {
    let house = settled();
    fs::write(figure(&house), fs::read(figure(&house)).expect("a figure")).expect("a figure can be touched");
    assert!(look(&house).0);
    // Edited within the tick of the clock in which it was noted: the note has the stat of the edited file.
    let noted = stat(&figure(&house));
    edit_in_secret(&figure(&house));
    forge(&house, &noted, &stat(&figure(&house)));
    assert!(!look(&house).0);
    // It is its age alone that keeps the stat from being believed.
    let text = fs::read_to_string(note(&house)).expect("there is a note");
    let (_, began) = text.split_once(r#""began":["#).expect("a note has its time");
    let (seconds, _) = began.split_once(',').expect("a time has two parts");
    let later = seconds.parse::<i64>().expect("a time is a number") + 10;
    forge(
        &house,
        &format!(r#""began":[{seconds}"#),
        &format!(r#""began":[{later}"#),
    );
    assert_eq!(look(&house), CALM);
}

#[test]
fn a_figure_deleted_replaced_or_turned_into_a_link_is_seen() {
    let house = settled();
    let good = figures(&house);
    fs::remove_file(figure(&house)).expect("a figure can be deleted");
    assert!(!look(&house).0);
    house.run().expect_success();
    are_restored(&house, &good);
    let (mine, other) = (house.path("mine.csv"), house.path("figures/large/report.csv"));
    fs::copy(figure(&house), &mine).expect("a figure can be copied");
    fs::rename(&mine, figure(&house)).expect("a figure can be replaced");
    let (is_idle, read) = look(&house);
    assert!(is_idle && read > 0);
    fs::remove_file(figure(&house)).expect("a figure can be deleted");
    std::os::unix::fs::symlink(other, figure(&house)).expect("a link can be made");
    assert!(!look(&house).0);
    house.run().expect_success();
    are_restored(&house, &good);
}

#[test]
fn figures_of_other_parameters_are_not_taken_for_current() {
    let mut house = House::new();
    house.set("scale.small.factor=3");
    settle(&house, "toy");
    house.edits.clear();
    settle(&house, "toy");
    let good = figures(&house);
    // Every output of the former parameters is there and believed; the files lie as they were noted, but are not theirs.
    house.set("scale.small.factor=3");
    let graph = house.graph(&[]).expect("the parameters are in order");
    let store = house.store();
    let believed = Index::read(store.root(), "toy").believe(&Run::new(&graph, &store, &|_: &Event| {}));
    assert_eq!(believed, Belief::All { rehashed: false });
    assert!(!look(&house).0);
    house.edits.clear();
    assert_eq!(look(&house), CALM);
    are_restored(&house, &good);
    // Nor are files that are due in another folder.
    assert!(!look_as(&house, "toy", ["large", "small"]).0);
}

#[test]
fn two_profiles_do_not_disturb_each_other() {
    let mut house = settled();
    house.set("run.seed=8");
    run_and_index(&house, "other");
    assert!(look_as(&house, "other", ["small", "large"]).0);
    house.edits.clear();
    // The figures are the other's now; the objects are as they were.
    assert!(!look(&house).0);
    house.run().expect_success();
    let (index, note) = (house.path("store/index.toy"), note(&house));
    grow_old();
    assert!(look(&house).0);
    let mine = [&index, &note].map(|path| fs::read(path).expect("it is there"));
    house.set("run.seed=8");
    run_and_index(&house, "other");
    grow_old();
    run_and_index(&house, "other");
    assert!(look_as(&house, "other", ["small", "large"]).0);
    assert_eq!(look_as(&house, "other", ["small", "large"]), CALM);
    assert_eq!([&index, &note].map(|path| fs::read(path).expect("it is there")), mine);
}

#[test]
fn a_damaged_note_is_none() {
    let house = settled();
    let good = fs::read(note(&house)).expect("there is a note");
    let shorter = (0..good.len()).step_by(67).map(|length| good[..length].to_vec());
    let flipped = (0..good.len()).step_by(71).map(|byte| {
        let mut bytes = good.clone();
        bytes[byte] ^= 1 << (byte % 7);
        bytes
    });
    for damaged in shorter.chain(flipped) {
        fs::write(note(&house), damaged).expect("a note can be damaged");
        let (is_idle, read) = look(&house);
        assert!(is_idle && read > 0);
        assert_eq!(look(&house), CALM);
    }
    edit_in_secret(&figure(&house));
    fs::write(note(&house), &good[1..]).expect("a note can be damaged");
    assert!(!look(&house).0);
}

#[test]
fn a_note_of_another_layout_or_of_other_outputs_is_none() {
    let house = settled();
    forge(&house, r#""format":1"#, r#""format":2"#);
    assert!(look(&house).1 > 0);
    let text = fs::read_to_string(note(&house)).expect("there is a note");
    let (_, outputs) = text
        .split_once(r#""outputs":""#)
        .expect("a note has the hash of the outputs");
    let outputs = &outputs[..64];
    forge(&house, outputs, &"0".repeat(64));
    assert!(look(&house).1 > 0);
    assert_eq!(look(&house), CALM);
}
