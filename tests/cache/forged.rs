//! Artifacts with the right hash and the wrong content: whatever a store says that a stage made, what reads it refuses it,
//! fails with a word, or gives a value; nothing panics.
//!
//! Every artifact of the tiny paper is changed part by part: numbers that are none, negative, huge; lists one short, one
//! long, empty, backwards. Each is sealed under its right hash, its record names it, and all its readers run.

use super::forged_plant::{Plant, plant};
use crate::common::records;
use encounter::calibration::bench::Fields;
use encounter::calibration::choice::{Checked, Found};
use encounter::design::convergence::Convergence;
use encounter::design::floor::Floors;
use encounter::design::response_pool::{RandomEstimates, ResponsePool};
use encounter::design::sequential::Realisation;
use encounter::engine::codec;
use encounter::engine::error::Error;
use encounter::engine::event::Event;
use encounter::engine::graph::Graph;
use encounter::engine::id::{Id, Key, schema_number};
use encounter::engine::node::Node;
use encounter::engine::params::ParamsFile;
use encounter::engine::run::Run;
use encounter::engine::schedule;
use encounter::engine::stage::{Artifact, Published};
use encounter::engine::store::Store;
use encounter::engine::target::Target;
use encounter::sea::envelope::Envelopes;
use encounter::sea::statistics::Statistics;
use encounter::sea::wave_field::WaveFields;
use encounter::sea::wave_group::{Groups, Sample};
use encounter::ship::exceedance::Probabilities;
use encounter::ship::initial_condition::Ensemble;
use encounter::ship::linear_response::LinearResponses;
use encounter::ship::response::{Point, Truths};
use encounter::ship::sample::SampledResponses;
use encounter::ship::temporal::DetectionStudy;
use encounter::stages::PIPELINE;
use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Mutex;

type Planting = fn(&[u8]) -> Plant;

fn planted<T: Artifact>(bytes: &[u8]) -> Plant {
    let value: T = codec::decode(bytes).expect("a stage's own output");
    plant(&value)
}

/// What each stage makes.
fn planting(stage: &str) -> Option<Planting> {
    Some(match stage {
        "wave_synthesis" => planted::<WaveFields>,
        "envelope" => planted::<Envelopes>,
        "group_detection" => planted::<Groups>,
        "group_statistics" => planted::<Statistics>,
        "group_sample" => planted::<Sample>,
        "ground_truth" => planted::<Truths>,
        "roll_ensemble" => planted::<Ensemble>,
        "cic" | "pic" | "nic" | "nic_groups" => planted::<SampledResponses>,
        "exceedance" => planted::<Probabilities>,
        "response_moments" => planted::<Vec<Point>>,
        "detection_study" => planted::<DetectionStudy>,
        "linear_response" => planted::<LinearResponses>,
        "response_pool" => planted::<ResponsePool>,
        "sampling_floor" => planted::<Floors>,
        "vhgp_seq" | "vhgp_best" | "vhgp_control" | "vhgp_lhs" => planted::<Realisation>,
        "random_sampling" => planted::<RandomEstimates>,
        "convergence" => planted::<Convergence>,
        "calibration_fields" => planted::<Fields>,
        "calibration_search" => planted::<Found>,
        "calibration_check" => planted::<Option<Checked>>,
        _ => {
            let node = PIPELINE.contents.iter().find(|node| node.name() == stage)?;
            assert!(node.is_published(), "{stage}: what does it make?");
            planted::<Published>
        }
    })
}

fn params() -> ParamsFile {
    let stages = Path::new(env!("CARGO_MANIFEST_DIR")).join("stages");
    let files = [stages.join("paper.toml"), stages.join("tiny.toml")];
    let files: Vec<&Path> = files.iter().map(PathBuf::as_path).collect();
    ParamsFile::read(&files, &[]).expect("the parameters are readable")
}

fn graph(params: &ParamsFile, target: &str) -> Graph {
    let targets: Vec<Target> = [target]
        .iter()
        .filter(|target| !target.is_empty())
        .map(|target| Target::parse(target).expect("a target"))
        .collect();
    Graph::new(&PIPELINE, params, &targets).expect("the parameters are in order")
}

/// What came of a run: the messages of what failed.
struct Outcome {
    result: Result<(), Error>,
    failed: Vec<String>,
}

fn run(graph: &Graph, store: &Path, mut then: impl FnMut(&Run<'_>)) -> Outcome {
    let store = Store::open(store).expect("a store can be opened");
    let failed = Mutex::new(Vec::new());
    let listener = |event: &Event| {
        if let Event::DidFail { node, message, .. } = event {
            failed.lock().expect("no panic").push(format!("{node}: {message}"));
        }
    };
    let run = Run::new(graph, &store, &listener);
    let result = schedule::execute(&run, 1);
    then(&run);
    let failed = failed.into_inner().expect("no panic");
    Outcome { result, failed }
}

/// A store with the whole tiny paper in it, and the key and bytes of every node's first piece.
struct Tiny {
    folder: tempfile::TempDir,
    known: BTreeMap<String, (Key, Vec<u8>)>,
    params: ParamsFile,
}

impl Tiny {
    fn new(targets: &[&str]) -> Self {
        let folder = tempfile::tempdir().expect("a temporary folder can be made");
        let params = params();
        let mut known = BTreeMap::new();
        for target in targets {
            let graph = graph(&params, target);
            let done = run(&graph, folder.path(), |run| {
                for (i, node) in graph.nodes.iter().enumerate() {
                    let key = run.key(i, 0).expect("every input is known");
                    known.insert(node.name(), (key, run.bytes(i, 0).expect("the piece is at hand")));
                }
            });
            done.result.expect("the tiny paper runs");
        }
        Self { folder, known, params }
    }

    /// Puts bytes into the store under their right hash and lets the record of a key name them; gives the old record.
    fn forge(&self, node: &'static dyn Node, key: &Key, payload: &[u8]) -> (PathBuf, Vec<u8>) {
        let schema = schema_number(node.schema());
        let id = Id::of(codec::CODEC, schema, payload);
        let head = [
            b"ENCOUNT1",
            &codec::CODEC.to_le_bytes()[..],
            &[0; 6],
            &schema.to_le_bytes(),
            &(payload.len() as u64).to_le_bytes(),
            &id.0,
        ];
        let hex = id.to_string();
        let folder = self.folder.path().join("objects").join(&hex[..2]);
        fs::create_dir_all(&folder).expect("a folder can be made");
        fs::write(folder.join(&hex[2..]), [&head.concat(), payload].concat()).expect("an object can be written");
        let hex = key.to_string();
        let record = self
            .folder
            .path()
            .join("records")
            .join(&hex[..2])
            .join(format!("{}.json", &hex[2..]));
        let old = fs::read(&record).expect("a record");
        records::edit(&record, |record| {
            record["id"] = id.to_string().into();
            record["bytes"] = payload.len().into();
        });
        (record, old)
    }

    /// Lets one node of each stage that reads `stage` read a forged output of it.
    fn readers(&self, stage: &str) -> Vec<String> {
        let reads = |node: &&&'static dyn Node| node.arrows().iter().any(|(_, up)| up.name() == stage);
        let stages = PIPELINE.contents.iter().filter(reads);
        let known = |node: &&'static dyn Node| {
            let own = |name: &&String| *name == node.name() || name.starts_with(&format!("{}/", node.name()));
            self.known.keys().find(own).cloned()
        };
        stages.filter_map(known).collect()
    }
}

/// Whether a forgery can be told for one by itself: a number that is none, and a list with another length. Some lists have
/// any length: those of a sea's groups and samples, of trials and files.
fn must_be_refused(node: &dyn Node, what: &str) -> bool {
    let has_free_lists = [
        "group_detection",
        "group_sample",
        "ground_truth",
        "linear_response",
        "calibration_fields",
        "calibration_search",
        "calibration_check",
    ];
    let is_length = ["one short", "one long"].contains(&what);
    let is_free = has_free_lists.contains(&node.name()) || node.is_published();
    ["NaN", "infinity"].contains(&what) || (is_length && !is_free)
}

/// Forges every part of what the stages of some targets make; gives how many of how many were refused, and what panicked.
fn forge_all(tiny: &Tiny) -> (usize, usize, Vec<String>) {
    let (mut tried, mut refused, mut wrong) = (0, 0, Vec::new());
    for node in PIPELINE.contents.iter().copied() {
        let Some(planting) = planting(node.name()) else {
            continue;
        };
        for reader in tiny.readers(node.name()) {
            let graph = graph(&tiny.params, &reader);
            let up = graph.nodes.iter().find(|up| up.node.name() == node.name());
            let up = up.expect("a reader needs what it reads");
            let (key, bytes) = &tiny.known[&up.name()];
            let whole = planting(bytes);
            assert_eq!(whole.bytes(), *bytes, "{}: the plant is the artifact", up.name());
            up.decode(0, bytes).expect("its own output");
            for (path, what, forged) in whole.forged() {
                let payload = forged.bytes();
                if payload == *bytes {
                    continue;
                }
                let (record, old) = tiny.forge(node, key, &payload);
                let outcome = run(&graph, tiny.folder.path(), |_| ());
                fs::write(record, old).expect("the record can be put back");
                tried += 1;
                let place = format!("{}{path} {what}", up.name());
                let panics = outcome.failed.iter().filter(|message| message.contains("panicked"));
                wrong.extend(panics.map(|message| format!("{place}: {message}")));
                match up.decode(0, &payload) {
                    Err(_) => refused += 1,
                    Ok(_) if must_be_refused(node, what) => wrong.push(format!("{place}: it was taken")),
                    Ok(_) => {}
                }
            }
        }
    }
    (tried, refused, wrong)
}

#[test]
fn no_forged_artifact_makes_a_stage_panic() {
    let tiny = Tiny::new(&[""]);
    let (tried, refused, wrong) = forge_all(&tiny);
    assert!(wrong.is_empty(), "{} of {tried}:\n{}", wrong.len(), wrong.join("\n"));
    assert!(tried >= 1000, "{tried}");
    // What is left are values that a stage could have made.
    assert!(10 * refused >= 7 * tried, "{refused} of {tried}");
    println!("{refused} of {tried} forged artifacts refused");
}
