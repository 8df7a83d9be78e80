//! The model: random edits, targets and damage on the toy pipeline, against "recompute everything".
//!
//! The oracle knows the pipeline as a table of who reads what, and no key: contents are those of a run in an empty store,
//! and a piece runs if, and only if, no run before had the same stage, items, parameters and contents of inputs, or what
//! that run left behind has been damaged since.

use crate::common::{Done, House};
use encounter::engine::id::{Id, Key};
use encounter::numerics::random::below;
use rand_chacha::ChaCha12Rng;
use rand_chacha::rand_core::SeedableRng;
use std::collections::{BTreeMap, BTreeSet};
use std::fs;

/// The parameters that the edits turn.
#[derive(Clone, Debug)]
struct State {
    seed: u64,
    count: u64,
    span: u64,
    label: u64,
    bases: Vec<&'static str>,
    offsets: [u64; 3],
    modulo: u64,
    draws: u64,
    rows: BTreeMap<&'static str, u64>,
    pinned: (&'static str, u64),
    scales: Vec<&'static str>,
    factors: [u64; 2],
    aside: u64,
    shift: u64,
}

const BASES: [&str; 3] = ["a", "b", "c"];
const SCALES: [&str; 2] = ["small", "large"];

fn place(names: &[&str], name: &str) -> usize {
    names
        .iter()
        .position(|other| *other == name)
        .expect("a name of the toy")
}

impl State {
    fn new() -> Self {
        Self {
            seed: 7,
            count: 30,
            span: 1000,
            label: 0,
            bases: vec!["a", "b"],
            offsets: [1, 2, 1],
            modulo: 1_000_000_007,
            draws: 2,
            rows: BTreeMap::from([("a", 10), ("b", 20)]),
            pinned: ("b", 3),
            scales: vec!["small", "large"],
            factors: [1, 100],
            aside: 5,
            shift: 0,
        }
    }

    /// One random edit; small ranges, so that values come back and outputs coincide.
    fn edit(&mut self, rng: &mut ChaCha12Rng) {
        let mut pick = |n: usize| below(rng, n) as u64;
        match pick(14) {
            0 => self.seed = 7 + pick(2),
            1 => self.count = 5 + 5 * pick(7),
            2 => self.span = [1, 2, 1000][pick(3) as usize],
            3 => self.label = pick(3),
            4 => {
                let choices: [&[&'static str]; 4] = [&["a", "b"], &["b"], &["b", "a", "c"], &["b", "c"]];
                self.bases = choices[pick(4) as usize].to_vec();
            }
            5 => self.offsets[pick(3) as usize] = pick(3),
            6 => self.modulo = [1, 2, 1_000_000_007][pick(3) as usize],
            7 => self.draws = 1 + pick(4),
            8 => {
                self.rows.insert(BASES[pick(3) as usize], 10 * pick(3));
            }
            9 => self.pinned.1 = pick(5),
            10 => self.scales = SCALES[pick(2) as usize..].to_vec(),
            11 => self.factors[pick(2) as usize] = pick(3),
            12 => self.aside = pick(3),
            _ => self.shift = pick(3),
        }
    }

    fn house(&self, mut house: House) -> House {
        let quoted = |names: &[&str]| {
            names
                .iter()
                .map(|name| format!("{name:?}"))
                .collect::<Vec<_>>()
                .join(", ")
        };
        let rows = self
            .rows
            .iter()
            .map(|(base, level)| format!("{{ base = \"{base}\", level = {level} }}"));
        house.edits = vec![
            format!("run.seed={}", self.seed),
            format!("run.bases=[{}]", quoted(&self.bases)),
            format!("run.scales=[{}]", quoted(&self.scales)),
            format!("numbers.count={}", self.count),
            format!("numbers.span={}", self.span),
            format!("numbers.label=\"{}\"", self.label),
            format!("total.modulo={}", self.modulo),
            format!("draws.count={}", self.draws),
            format!("draws.row=[{}]", rows.collect::<Vec<_>>().join(", ")),
            format!("pinned.base=\"{}\"", self.pinned.0),
            format!("pinned.item={}", self.pinned.1),
            format!("aside.value={}", self.aside),
            format!("witness.shift={}", self.shift),
        ];
        house.edits.extend(
            BASES
                .iter()
                .zip(self.offsets)
                .map(|(base, offset)| format!("base.{base}.offset={offset}")),
        );
        house.edits.extend(
            SCALES
                .iter()
                .zip(self.factors)
                .map(|(scale, factor)| format!("scale.{scale}.factor={factor}")),
        );
        house
    }

    /// What a piece depends on, told without the engine: stage, seed and items, parameters, contents of inputs.
    fn signature(&self, name: &str, known: &BTreeMap<String, (Key, Id)>) -> String {
        let words: Vec<&str> = name.split('/').collect();
        let (stage, case, piece) = (words[0], words[1], *words.last().expect("a name has words"));
        let whole = |node: &str| -> Vec<Id> {
            let pieces = (0..).map_while(|piece| known.get(&format!("{node}/{piece}")));
            pieces.map(|(_, id)| *id).collect()
        };
        let offset = || self.offsets[place(&BASES, case)];
        let batch = |piece: &str| {
            let first = 10 * piece.parse::<u64>().expect("a piece is a number");
            (first, 10.min(self.count - first))
        };
        let reads = match stage {
            "numbers" => format!("{:?} {} {}", batch(piece), self.span, self.label),
            "squares" => format!(
                "{:?} {} {:?}",
                batch(piece),
                offset(),
                known[&format!("numbers/{piece}")].1
            ),
            "total" => format!("{} {:?}", self.modulo, whole(&format!("squares/{case}"))),
            "draws" => format!(
                "{piece} {case} {} {:?}",
                self.rows[case],
                whole(&format!("total/{case}"))
            ),
            "pinned" => format!("{:?} {:?}", self.pinned, whole(&format!("total/{case}"))),
            "report" => {
                let of_bases = |stage: &str| {
                    let cases = self.bases.iter().map(|base| (*base, whole(&format!("{stage}/{base}"))));
                    cases.filter(|(_, pieces)| !pieces.is_empty()).collect::<Vec<_>>()
                };
                format!(
                    "{} {:?} {:?}",
                    self.factors[place(&SCALES, case)],
                    of_bases("total"),
                    of_bases("draws")
                )
            }
            "aside" => self.aside.to_string(),
            "echo" => format!("{:?}", whole("aside")),
            "fickle" => String::new(),
            "witness" => format!("{} {:?}", self.shift, whole("fickle")),
            other => panic!("{other} is no stage of the toy"),
        };
        format!("{stage} seed {} {reads}", self.seed)
    }
}

/// Deletes, cuts or flips something in the store; the keys or ids it bore, as the files are named.
fn damage(house: &House, rng: &mut ChaCha12Rng) -> Option<String> {
    let folder = ["store/objects", "store/records"][below(rng, 2)];
    let files = house.files_in(folder);
    if files.is_empty() {
        return None;
    }
    let path = &files[below(rng, files.len())];
    let bytes = fs::read(path).expect("an entry can be read");
    let at = below(rng, bytes.len());
    match below(rng, 3) {
        0 => fs::remove_file(path).expect("an entry can be removed"),
        1 => fs::write(path, &bytes[..at]).expect("an entry can be cut"),
        _ => {
            let mut bytes = bytes;
            bytes[at] ^= 1 << below(rng, 8);
            fs::write(path, bytes).expect("an entry can be damaged");
        }
    }
    Some(super::hex_of(path, ".json"))
}

/// What has run in a store, by signature, and how its entries are named.
#[derive(Default)]
struct History {
    ran: BTreeSet<String>,
    entries: BTreeMap<String, BTreeSet<String>>,
    hurt: BTreeSet<String>,
}

impl History {
    /// Checks one run against the model and takes note of it.
    fn check(&mut self, state: &State, done: &Done, context: &str) {
        let signature = |name: &String| state.signature(name, &done.known);
        let mut now = BTreeSet::new();
        for name in done.ran() {
            let signature = signature(&name);
            let is_needed = !self.ran.contains(&signature) || self.hurt.contains(&signature);
            assert!(is_needed, "{context}: {name} need not have run: {signature}");
            assert!(
                now.insert(signature.clone()),
                "{context}: {name} ran twice: {signature}"
            );
        }
        for (name, (key, id)) in &done.known {
            let signature = signature(name);
            let is_done = now.contains(&signature) || self.ran.contains(&signature);
            assert!(is_done, "{context}: {name} should have run: {signature}");
            for entry in [key.to_string(), id.to_string()] {
                self.entries.entry(entry).or_default().insert(signature.clone());
            }
        }
        self.hurt = &self.hurt - &now;
        self.ran.extend(now);
    }
}

fn live(seed: u64, steps: usize) {
    let mut rng = ChaCha12Rng::seed_from_u64(seed);
    let mut state = State::new();
    let mut house = House::new();
    let mut history = History::default();
    for step in 0..steps {
        for _ in 0..below(&mut rng, 3) {
            state.edit(&mut rng);
        }
        if below(&mut rng, 3) == 0 {
            let entry = damage(&house, &mut rng);
            let hurt = entry.and_then(|entry| history.entries.get(&entry)).cloned();
            history.hurt.extend(hurt.unwrap_or_default());
        }
        house = state.house(house);
        house.workers = 1 + below(&mut rng, 4);
        let choices: [&[&str]; 4] = [&[], &["report"], &["pinned", "echo"], &["squares"]];
        let targets = choices[below(&mut rng, 4)];
        let context = format!("seed {seed}, step {step}, {targets:?}, {state:?}");
        let done = house.run_targets(targets);
        assert!(done.outcome.is_ok(), "{context}: {:?}", done.outcome);
        history.check(&state, &done, &context);
        let anew = state.house(House::new()).run_targets(targets);
        let ids = |done: &Done| {
            done.known
                .iter()
                .map(|(name, (_, id))| (name.clone(), *id))
                .collect::<Vec<_>>()
        };
        assert_eq!(ids(&done), ids(&anew), "{context}");
        assert_eq!(done.locked(), anew.locked(), "{context}");
    }
}

#[test]
fn random_edits_give_what_an_empty_store_gives_and_run_no_more_than_they_must() {
    (0..10).for_each(|seed| live(seed, 12));
}

#[test]
#[ignore = "minutes: `cargo test --release -- --ignored model`"]
fn many_random_edits_give_what_an_empty_store_gives() {
    (10..400).for_each(|seed| live(seed, 20));
}
