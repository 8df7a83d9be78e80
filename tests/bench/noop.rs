//! How long does it take to find that there is nothing to do, at 200, 1,000 and 5,000 keys; what does a cached key cost; how
//! long does the whole process take at quick size (at most 50 ms is wanted); how fast are bytes hashed; what does it cost to
//! look for numbers that are none?

use std::hint::black_box;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::{Arc, OnceLock};

use divan::Bencher;
use divan::counter::{BytesCount, ItemsCount};
use encounter::engine::arrow::{All, Each, PiecesOf};
use encounter::engine::codec::encode;
use encounter::engine::error::Result;
use encounter::engine::event::Event;
use encounter::engine::finite::check;
use encounter::engine::graph::Graph;
use encounter::engine::id::Id;
use encounter::engine::node::node;
use encounter::engine::params::ParamsFile;
use encounter::engine::pipeline::Pipeline;
use encounter::engine::run::Run;
use encounter::engine::schedule;
use encounter::engine::stage::{Here, Pieces, Stage};
use encounter::engine::store::Store;
use serde::{Deserialize, Serialize};
use tempfile::TempDir;

const KEYS: [u64; 3] = [200, 1_000, 5_000];
const PIPELINE: Pipeline = Pipeline {
    axes: &[],
    contents: &[node::<Gen>(), node::<Mid>(), node::<Fig>()],
    optional: &[],
    on_request: &[],
};

/// Half of the keys.
struct Gen;
/// The other half, piece by piece.
struct Mid;
/// One key that reads all pieces of [`Mid`].
struct Fig;

#[derive(Serialize, Deserialize)]
struct Params {
    gen_table: Table,
}

#[derive(Serialize, Deserialize)]
struct Table {
    seed: u64,
}

impl Stage for Gen {
    const NAME: &'static str = "gen";
    const PAPER: &'static str = "§1";
    const PIECES: Pieces = Pieces::Counted("gen_table.count");
    const SCHEMA: &'static str = "bench-gen/1";
    type Params = Params;
    type Inputs = ();
    type Output = Vec<u64>;

    fn run(p: &Params, (): (), here: Here<'_>) -> Result<Vec<u64>> {
        Ok(vec![p.gen_table.seed + here.first; 16])
    }
}

#[derive(Serialize, Deserialize)]
struct None {}

impl Stage for Mid {
    const NAME: &'static str = "mid";
    const PAPER: &'static str = "§2";
    const PIECES: Pieces = Pieces::AsUpstream;
    const SCHEMA: &'static str = "bench-mid/1";
    type Params = None;
    type Inputs = (Each<Gen>,);
    type Output = u64;

    fn run(_: &None, (numbers,): (Arc<Vec<u64>>,), _: Here<'_>) -> Result<u64> {
        Ok(numbers.iter().sum())
    }
}

impl Stage for Fig {
    const NAME: &'static str = "fig";
    const PAPER: &'static str = "Fig. 1";
    const SCHEMA: &'static str = "bench-fig/1";
    type Params = None;
    type Inputs = (All<Mid>,);
    type Output = u64;

    fn run(_: &None, (sums,): (PiecesOf<'_, u64>,), _: Here<'_>) -> Result<u64> {
        sums.iter().try_fold(0, |all, sum| Ok(all + *sum?))
    }
}

/// A store in which all keys have been made, and its parameters.
struct House {
    folder: TempDir,
    params: ParamsFile,
}

impl House {
    fn of(keys: u64) -> Self {
        let mut params = ParamsFile::default();
        let text = format!("[run]\nseed = 1\n[gen_table]\nseed = 7\ncount = {}\n", keys / 2);
        params.layer("bench.toml", &text).expect("the parameters are TOML");
        let house = Self {
            folder: tempfile::tempdir().expect("a temporary folder can be made"),
            params,
        };
        house.run();
        house
    }

    fn run(&self) {
        let graph = self.graph();
        let store = self.store();
        let run = Run::new(&graph, &store, &|_: &Event| {});
        schedule::execute(&run, 2).expect("the toy runs");
    }

    fn graph(&self) -> Graph {
        Graph::new(&PIPELINE, &self.params, &[]).expect("the parameters are in order")
    }

    fn store(&self) -> Store {
        Store::open(self.folder.path()).expect("a store can be opened")
    }
}

/// Graph, keys, a record read and parsed and a look for the object of each key: the decision of a run with nothing to do.
#[divan::bench(args = KEYS, sample_count = 20)]
fn nothing_to_do(bencher: Bencher<'_, '_>, keys: u64) {
    let house = House::of(keys);
    bencher.counter(ItemsCount::new(keys)).bench_local(|| house.run());
}

/// A store of the quick profile, kept beside the build.
fn quick() -> &'static Path {
    static STORE: OnceLock<PathBuf> = OnceLock::new();
    STORE.get_or_init(|| {
        let store = Path::new(env!("CARGO_TARGET_TMPDIR")).join("bench-quick");
        process("run", &store);
        store
    })
}

fn process(verb: &str, store: &Path) {
    let said = Command::new(env!("CARGO_BIN_EXE_encounter"))
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .args([verb, "--profile", "quick", "--store"])
        .arg(store)
        .arg("--figures")
        .arg(store.join("figures"))
        .output()
        .expect("the binary runs");
    assert!(said.status.success(), "{}", String::from_utf8_lossy(&said.stderr));
}

/// Process start to exit, nothing to do, quick profile (632 keys, 50 published files of 3 MB).
#[divan::bench(args = ["run", "status"])]
fn whole_process_at_quick_size(bencher: Bencher<'_, '_>, verb: &str) {
    let store = quick();
    bencher.bench_local(|| process(verb, store));
}

/// One core looks for NaN and infinity in an artifact of that size.
#[divan::bench]
fn look_through_16_megabytes_of_numbers(bencher: Bencher<'_, '_>) {
    let numbers = vec![vec![0.25_f64; 1 << 13]; 1 << 8];
    bencher
        .counter(BytesCount::new(16_usize << 20))
        .bench_local(|| check(black_box(&numbers)));
}

/// One core encodes it.
#[divan::bench]
fn encode_16_megabytes_of_numbers(bencher: Bencher<'_, '_>) {
    let numbers = vec![vec![0.25_f64; 1 << 13]; 1 << 8];
    bencher
        .counter(BytesCount::new(16_usize << 20))
        .bench_local(|| encode(black_box(&numbers)));
}

/// One core hashes an object: at least 1 GB/s.
#[divan::bench]
fn hash_16_megabytes(bencher: Bencher<'_, '_>) {
    let bytes = vec![0x5a; 16 << 20];
    bencher
        .counter(BytesCount::new(bytes.len()))
        .bench_local(|| black_box(Id::of(1, 2, black_box(&bytes))));
}
