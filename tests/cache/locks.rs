//! Locks: the committed lines, what differs from them, hostile ones; golden keys and bytes.

use crate::common::House;
use encounter::engine::lock::Lock;
use encounter::engine::verify::between;
use std::fs;

const NOTHING: [&str; 0] = [];

#[test]
fn the_text_of_a_lock_reads_back_as_the_lock() {
    let lock = House::new().run().locked();
    let text = lock.text();
    let read = Lock::parse(&text).expect("our own text");
    assert_eq!(read, lock);
    assert_eq!(read.text(), text);
    assert!(text.starts_with("encounter-lock 1  profile toy  seed 7  keys 1  made-with rustc of the test\n"));
    let names: Vec<&str> = lock.lines.iter().map(|line| line.name.as_str()).collect();
    let expected = [
        "numbers",
        "squares/a",
        "squares/b",
        "total/a",
        "total/b",
        "draws/a",
        "draws/b",
        "pinned/b",
        "report/small",
        "report/large",
        "aside",
        "echo",
        "fickle",
        "witness",
        "file large/pinned.csv",
        "file large/report.csv",
        "file large/report.md",
        "file pinned.csv",
        "file report.csv",
        "file report.md",
    ];
    assert_eq!(names, expected);
}

#[test]
fn a_hostile_lock_is_an_error_with_its_line() {
    let lock = House::new().run().locked();
    let good = lock.text();
    let hash = "0".repeat(64);
    let head = good.lines().next().expect("a lock has a first line").to_owned();
    let after_head = |line: String| format!("{head}\n# comment\n{line}\n");
    let bad = [
        (String::new(), 1),
        ("\0".to_owned(), 1),
        (head.replace("lock 1", "lock 2"), 1),
        (head.replace("seed 7", "seed -7"), 1),
        (head.replace("seed 7", "seed 99999999999999999999"), 1),
        (head.replace("profile toy", "toy"), 1),
        (head.replace("keys 1", "keys one"), 1),
        (head.replace("profile toy", "profile t\u{7}oy"), 1),
        (after_head("squares/a\u{1b}[2J 1".to_owned()), 3),
        (after_head("squares/a".to_owned()), 3),
        (after_head(format!("squares/a -1 {hash} {hash} 3")), 3),
        (after_head(format!("squares/a 1 {hash} {hash} -3")), 3),
        (
            after_head(format!("squares/a 1 {hash} {hash} 99999999999999999999999")),
            3,
        ),
        (after_head(format!("squares/a 1 {hash} {hash}0 3")), 3),
        (after_head(format!("squares/a 1 {} {hash} 3", "g".repeat(64))), 3),
        (after_head(format!("squares/a 1 {} {hash} 3", "é".repeat(32))), 3),
        (after_head(format!("file two words - - {hash} 3")), 3),
        (after_head(format!("file a.csv 1 - {hash} 3")), 3),
    ];
    for (text, line) in bad {
        let error = Lock::parse(&text).expect_err("a refusal");
        let message = error.to_string();
        assert!(
            message.starts_with(&format!("the lock, line {line} is damaged: ")),
            "{text}: {message}"
        );
        assert_eq!(error.exit_code(), 5);
    }
    // Cut anywhere, it is an error or a shorter lock: never a panic.
    for length in (0..good.len()).filter(|length| good.is_char_boundary(*length)) {
        if let Ok(cut) = Lock::parse(&good[..length]) {
            assert!(cut.lines.len() <= lock.lines.len());
        }
    }
}

#[test]
fn what_a_lock_was_made_with_is_read_and_never_compared() {
    let house = House::new();
    let lock = house.run().locked();
    let (head, rest) = lock
        .text()
        .split_once('\n')
        .map(|(a, b)| (a.to_owned(), b.to_owned()))
        .expect("lines");
    let words = [
        (
            "made-with crates pxfm 0.1.30, syn 2.0.1 3.0.9\nmade-with code cic 00ff, nic 11ff",
            2,
            2,
        ),
        ("made-with crates , ,,\nmade-with code ,", 0, 0),
        ("made-with crates pxfm\nmade-with code cic", 1, 1),
        ("made-with crates pxfm 1, pxfm 2", 1, 0),
    ];
    for (text, crates, code) in words {
        let read = Lock::parse(&format!("{head}\n{text}\n{rest}")).expect("a lock");
        assert_eq!((read.crates.len(), read.code.len()), (crates, code), "{text}");
        assert_eq!(read.lines, lock.lines);
        assert_eq!(house.against(&read), NOTHING);
        assert_eq!(between(&read, &lock), NOTHING);
        assert_eq!(Lock::parse(&read.text()).expect("our own text").crates, read.crates);
    }
    assert!(Lock::parse(&format!("{head}\nmade-with something else\n{rest}")).is_err());
}

#[test]
fn a_path_in_a_lock_never_leaves_the_figures_folder() {
    let house = House::new();
    let mut lock = house.run().locked();
    fs::write(house.path("secret"), "x").expect("a file can be written");
    for path in [
        "../secret",
        "/etc/hostname",
        "a/../../secret",
        "./report.csv",
        "..\\secret",
        "a//b",
    ] {
        let mut line = lock.lines.last().expect("the lock has files").clone();
        line.name = format!("file {path}");
        lock.lines.push(line);
    }
    let differences = house.against(&lock);
    assert_eq!(differences.len(), 6);
    assert!(
        differences
            .iter()
            .all(|line| line.ends_with("no path within the figures folder"))
    );
}

#[test]
fn a_lock_agrees_with_what_made_it_without_a_store() {
    let house = House::new();
    let lock = house.run().locked();
    fs::remove_dir_all(house.path("store")).expect("the store can be deleted");
    assert_eq!(house.against(&lock), NOTHING);
    let read = Lock::parse(&lock.text()).expect("our own text");
    assert_eq!(house.against(&read), NOTHING);
}

#[test]
fn an_edited_parameter_shows_against_the_lock() {
    let mut house = House::new();
    let lock = house.run().locked();
    house.set("total.modulo=5");
    let differs = |name: &str| format!("{name}: its code, parameters or inputs are not those of the lock");
    assert_eq!(house.against(&lock), [differs("total/a"), differs("total/b")]);
    house.edits.clear();
    house.set("run.seed=9");
    assert_eq!(house.against(&lock).len(), 14);
}

#[test]
fn a_changed_count_shows_against_the_lock() {
    let mut house = House::new();
    let lock = house.run().locked();
    house.set("draws.count=3");
    let pieces = |name: &str| format!("{name}: 3 pieces, the lock says 2");
    assert_eq!(house.against(&lock), [pieces("draws/a"), pieces("draws/b")]);
    // As many pieces, but another number of items.
    house.edits.clear();
    house.set("numbers.count=29");
    let numbers = house.against(&lock);
    assert_eq!(numbers.len(), 3, "{numbers:?}");
    assert!(
        numbers[0].starts_with("numbers: its code, parameters or inputs"),
        "{numbers:?}"
    );
}

#[test]
fn a_changed_or_missing_file_shows_against_the_lock() {
    let house = House::new();
    let lock = house.run().locked();
    fs::write(house.path("figures/report.csv"), "mine").expect("the file can be written");
    fs::remove_file(house.path("figures/large/report.md")).expect("the file can be deleted");
    let differences = house.against(&lock);
    assert_eq!(differences.len(), 2, "{differences:?}");
    assert!(differences[0].starts_with("file large/report.md: "), "{differences:?}");
    assert_eq!(differences[1], "file report.csv: its bytes are not those of the lock");
}

#[test]
fn nodes_that_came_or_went_show_against_the_lock() {
    let mut house = House::new();
    let mut lock = house.run().locked();
    house.set("run.scales=[\"small\"]");
    assert_eq!(
        house.against(&lock),
        ["report/large: in the lock, but no node of this pipeline"]
    );
    house.edits.clear();
    let gone = lock.lines.remove(0);
    lock.lines.push(lock.lines[0].clone());
    let differences = house.against(&lock);
    assert!(
        differences.contains(&"numbers: not in the lock".to_owned()),
        "{differences:?}"
    );
    let twice = "squares/a: in the lock, but no node of this pipeline".to_owned();
    assert!(differences.contains(&twice), "{differences:?}");
    assert_eq!(gone.name, "numbers");
}

#[test]
fn two_locks_differ_in_the_order_of_the_first() {
    let mut house = House::new();
    let committed = house.run().locked();
    assert_eq!(between(&committed, &committed), NOTHING);
    house.set("total.modulo=999983");
    let made = house.run().locked();
    let differences = between(&committed, &made);
    assert!(differences[0].starts_with("total/a: the lock says "), "{differences:?}");
    house.edits.clear();
    house.set("numbers.label=other");
    let relabelled = house.run().locked();
    assert_eq!(
        between(&committed, &relabelled),
        ["numbers: same content, another recipe"]
    );
    // The same recipe, and another number that goes with it.
    let mut counted = committed.clone();
    counted.lines[0].bytes += 1;
    let total = counted
        .lines
        .iter()
        .position(|line| line.name == "total/a")
        .expect("a line");
    counted.lines[total].pieces = Some(2);
    assert_eq!(
        between(&committed, &counted),
        [
            "numbers: same content, another number of bytes",
            "total/a: same content, another number of pieces"
        ]
    );
}

/// A changed key without a changed key schema, or changed bytes under an old SCHEMA, fail here.
#[test]
fn golden_keys_ids_and_object_bytes() {
    let house = House::new();
    let done = house.run();
    let keys_and_ids = |piece: &str| format!("{piece} {} {}", done.known[piece].0, done.known[piece].1);
    let found: Vec<String> = GOLDEN_PIECES.map(keys_and_ids).into();
    let object = fs::read(house.object(&done.known["total/a/0"].1)).expect("the object is there");
    let digits: Vec<String> = object.iter().map(|byte| format!("{byte:02x}")).collect();
    let hex = digits.concat();
    let recipe = done.locked().lines[1].recipe.expect("a node has a recipe").to_string();
    assert_eq!(
        (found, hex.as_str(), recipe.as_str()),
        (GOLDEN.map(str::to_owned).into(), GOLDEN_OBJECT, GOLDEN_RECIPE)
    );
}

const GOLDEN_PIECES: [&str; 6] = [
    "numbers/0",
    "squares/a/1",
    "total/a/0",
    "draws/b/1",
    "pinned/b/0",
    "report/large/0",
];

const GOLDEN: [&str; 6] = [
    "numbers/0 b76fbbfbccff2e24ff400ab4fda83444b98eff825e7b7126cadc0d2a907096dd 4503b7ac1baee37b3b7a4c73879b51b4937938582d4c3b555b9d533f469e73bb",
    "squares/a/1 755cc1c47f857ba1b9283383aeb46505488a081fe5ed6ace6934658595c54b9a a28665fc078b29e3fa29954e5b33ece88a3c7ae6eff96150619d1c5d53041cef",
    "total/a/0 c69707cf466fd8063396c95a7f976df60e906a2a8017e05cff57f1f688edf72b d9f183b7c0ceea8ff56533bc7fa93b661aaa973ef23448702a6517d8f8aa4c27",
    "draws/b/1 1c47e3718e525fb275b43a80c0801f257b98a9a3f64cd26dcfd6b191f2635c01 1d222304204e69019d24e00774a7c7b469275f08e63b4bcd06495cddb86db393",
    "pinned/b/0 2ea89b10db9383d698feffcbc3a0db57c94003b2bf843e5f3033f2bda9081dd9 157f27483df694a441390338eed26d89ea3b9bcc347c8e620663d9e0ffbe852e",
    "report/large/0 5974540cf3833281a7a3dadf459858afc9b0579667b3ba7298ec57adce334d61 d7a9f16ffa1ce500f9cc6bbaacdb3b160a02b4aac4503b318ab0bf3dbffdb168",
];

/// Header (magic, codec, schema, length, id) and payload: one u64.
const GOLDEN_OBJECT: &str = "454e434f554e5431010000000000000061371cd614585dff0800000000000000\
    d9f183b7c0ceea8ff56533bc7fa93b661aaa973ef23448702a6517d8f8aa4c27\
    3bdca80000000000";

const GOLDEN_RECIPE: &str = "f441630c8d085dc1f606302d4f69c342e50c622d88dcae7008270e31ed4ae167";
