//! Rot: every byte of an object or record may be wrong, cut off, or another's; what is read is healed or made again, and
//! garbage collection never takes what a damaged list no longer names.

use super::bad_entries;
use super::child::slow_house;
use crate::common::House;
use encounter::engine::graph::Graph;
use encounter::engine::id::{Id, Key};
use encounter::engine::run::Run;
use encounter::engine::schedule;
use std::fs;
use std::path::{Path, PathBuf};
use tempfile::TempDir;

const NOTHING: [&str; 0] = [];

/// A small store that is complete, and its graph.
struct Kept {
    house: House,
    graph: Graph,
    key: Key,
    id: Id,
    _folder: TempDir,
}

impl Kept {
    fn new() -> Self {
        let folder = tempfile::tempdir().expect("a temporary folder can be made");
        let mut house = slow_house(folder.path());
        for edit in ["phases.count=3", "slow.milliseconds=0", "slow.words=6"] {
            house.set(edit);
        }
        let done = house.run();
        done.expect_success();
        let (key, id) = done.known["slow/1"];
        let graph = house.graph(&[]).expect("the parameters are in order");
        Self {
            house,
            graph,
            key,
            id,
            _folder: folder,
        }
    }

    /// The bytes of every piece, read anew.
    fn read(&self) -> Vec<Vec<u8>> {
        let silent = |_: &_| {};
        // Opened anew, so that garbage can be collected in between.
        let store = self.house.store();
        let run = Run::new(&self.graph, &store, &silent);
        schedule::execute(&run, 1).expect("a run");
        let nodes = self.graph.nodes.iter().enumerate();
        let pieces = nodes.flat_map(|(i, node)| (0..node.pieces.len()).map(move |piece| (i, piece)));
        pieces
            .map(|(node, piece)| run.bytes(node, piece).expect("a piece"))
            .collect()
    }

    /// Damages a file in every given way; each time all pieces must read as before, and the file be as it was.
    fn survives(&self, path: &Path, damages: impl IntoIterator<Item = Vec<u8>>) {
        let before = self.read();
        let good = fs::read(path).expect("the file is there");
        for (i, damaged) in damages.into_iter().enumerate() {
            fs::write(path, damaged).expect("the file can be damaged");
            assert_eq!(self.read(), before, "damage {i} of {}", path.display());
            let now = fs::read(path).expect("the file is there");
            assert!(now == good || self.is_record(path), "damage {i} of {}", path.display());
        }
        assert_eq!(bad_entries(&self.house), NOTHING);
    }

    /// A record tells how long its piece took, so one made again is another.
    fn is_record(&self, path: &Path) -> bool {
        path == self.house.record(&self.key)
    }
}

fn cuts(good: &[u8]) -> impl Iterator<Item = Vec<u8>> + '_ {
    (0..good.len()).map(|length| good[..length].to_vec())
}

/// One bit of each byte flipped, another bit each time.
fn flips(good: &[u8]) -> impl Iterator<Item = Vec<u8>> + '_ {
    (0..good.len()).map(|byte| {
        let mut bytes = good.to_vec();
        bytes[byte] ^= 1 << (byte * 5 % 8);
        bytes
    })
}

#[test]
fn an_object_wrong_or_cut_at_any_byte_is_healed() {
    let kept = Kept::new();
    let object = kept.house.object(&kept.id);
    let good = fs::read(&object).expect("the object is there");
    assert_eq!(good.len(), 64 + 8 + 6 * 8, "header, length of the list, numbers");
    kept.survives(&object, cuts(&good).chain(flips(&good)));
}

#[test]
fn a_record_wrong_or_cut_at_any_byte_is_none() {
    let kept = Kept::new();
    let path = kept.house.record(&kept.key);
    let good = fs::read(&path).expect("the record is there");
    let record = kept.house.store().record(&kept.key).expect("an undamaged record");
    for damaged in cuts(&good).chain(flips(&good)) {
        fs::write(&path, &damaged).expect("the record can be damaged");
        assert_eq!(
            kept.house.store().record(&kept.key),
            None,
            "{}",
            String::from_utf8_lossy(&damaged)
        );
    }
    fs::write(&path, &good).expect("the record can be written");
    assert_eq!(kept.house.store().record(&kept.key), Some(record));
    kept.survives(&path, cuts(&good).chain(flips(&good)).step_by(97));
}

#[test]
fn objects_and_records_that_changed_places_are_not_believed() {
    let kept = Kept::new();
    for folder in ["store/objects", "store/records"] {
        let before = kept.read();
        let files: Vec<PathBuf> = kept.house.files_in(folder);
        assert!(files.len() >= 4);
        for (one, other) in files.iter().flat_map(|one| files.iter().map(move |other| (one, other))) {
            let (first, second) = (fs::read(one).expect("a file"), fs::read(other).expect("a file"));
            fs::write(one, second).expect("a file can be written");
            fs::write(other, first).expect("a file can be written");
            assert_eq!(kept.read(), before, "{} and {}", one.display(), other.display());
            assert_eq!(bad_entries(&kept.house), NOTHING);
        }
    }
}

#[test]
fn objects_deleted_under_their_records_are_made_again() {
    let kept = Kept::new();
    let before = kept.read();
    for object in kept.house.files_in("store/objects") {
        fs::remove_file(&object).expect("an object can be deleted");
        assert_eq!(kept.read(), before);
        assert!(object.is_file());
    }
    fs::remove_dir_all(kept.house.path("store/objects")).expect("objects can be deleted");
    assert_eq!(kept.read(), before);
    assert_eq!(bad_entries(&kept.house), NOTHING);
}

#[test]
fn an_object_damaged_with_its_times_kept_is_healed_when_read() {
    let kept = Kept::new();
    let before = kept.read();
    let object = kept.house.object(&kept.id);
    let times = fs::metadata(&object)
        .and_then(|found| found.modified())
        .expect("a time");
    let mut bytes = fs::read(&object).expect("the object is there");
    bytes[100] ^= 4;
    fs::write(&object, bytes).expect("the object can be damaged");
    let file = fs::File::options()
        .write(true)
        .open(&object)
        .expect("the object is there");
    file.set_modified(times).expect("a time can be set");
    assert_eq!(kept.read(), before);
    assert_eq!(bad_entries(&kept.house), NOTHING);
}

#[test]
fn what_a_damaged_list_of_pieces_named_is_still_kept() {
    let kept = Kept::new();
    let before = kept.read();
    let objects = kept.house.files_in("store/objects");
    // The content of the slow pieces, the only ones that are several and have objects.
    let lists = [
        kept.house.files_in("store/manifests"),
        kept.house.files_in("store/runs"),
    ]
    .concat();
    assert!(lists.len() > 2, "{lists:?}");
    for path in lists {
        let good = fs::read(&path).expect("a file");
        let damages = [
            Vec::new(),
            good[..good.len() / 2].to_vec(),
            flips(&good).nth(40).expect("longer"),
        ];
        for damaged in damages {
            fs::write(&path, damaged).expect("a file can be damaged");
            kept.house.gc(u64::MAX, false).expect("garbage can be collected");
            assert_eq!(kept.house.files_in("store/objects"), objects, "{}", path.display());
            assert_eq!(kept.read(), before);
        }
        assert!(path.is_file(), "a run writes its lists again");
    }
}

#[test]
fn a_damaged_memory_of_published_files_only_keeps_more_copies() {
    let mut house = House::lived_in(&[]);
    let memory = house.path("artifacts/published");
    fs::write(&memory, b"\xff\xfe\n\0").expect("a file can be damaged");
    house.set("pinned.item=4");
    let done = house.run();
    done.expect_success();
    assert_eq!(done.set_aside(), ["large/pinned.csv", "pinned.csv"]);
    assert_eq!(house.run().written(), NOTHING);
    house.set("pinned.item=5");
    assert_eq!(house.run().set_aside(), NOTHING);
}

/// A file that says it is longer than an object may be takes no room on the disk, and none in memory.
#[test]
fn what_is_too_long_or_no_file_is_damage_and_is_made_again() {
    let kept = Kept::new();
    let before = kept.read();
    let object = kept.house.object(&kept.id);
    let good = fs::read(&object).expect("an object can be read");
    let file = fs::OpenOptions::new()
        .write(true)
        .open(&object)
        .expect("an object can be opened");
    file.set_len(6 << 30).expect("a sparse file");
    assert_eq!(kept.read(), before);
    assert_eq!(fs::read(&object).expect("an object can be read"), good);

    fs::remove_file(&object).expect("an object can be removed");
    let piped = std::process::Command::new("mkfifo").arg(&object).status();
    assert!(piped.expect("mkfifo runs").success());
    assert_eq!(kept.read(), before);
    assert_eq!(fs::read(&object).expect("an object can be read"), good);
}
