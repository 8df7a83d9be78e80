//! A toy pipeline in a temporary folder, run in the test's own process; what it did is an event log.

pub(crate) mod paper;
pub(crate) mod program;
pub(crate) mod records;
pub(crate) mod toy;

use encounter::engine::checkout::Checkout;
use encounter::engine::disk::Disk;
use encounter::engine::error::Error;
use encounter::engine::event::Event;
use encounter::engine::gc::{self, Alone, Sweep};
use encounter::engine::graph::{Graph, NodeCase};
use encounter::engine::id::{Id, Key};
use encounter::engine::leftover::Due;
use encounter::engine::lock::{self, Lock};
use encounter::engine::params::ParamsFile;
use encounter::engine::pipeline::Pipeline;
use encounter::engine::plan::{NodePlan, Plan};
use encounter::engine::published::Set;
use encounter::engine::rebuild::{Against, Rebuilt};
use encounter::engine::run::Run;
use encounter::engine::store::Store;
use encounter::engine::target::Target;
use encounter::engine::why::{Why, why};
use encounter::engine::{publish, rebuild, schedule, verify};
use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};
use tempfile::TempDir;
use toy::{SCALE, TOY};

/// The parameters of the toy pipeline.
pub(crate) const PARAMS: &str = r#"
[run]
seed = 7
scales = ["small", "large"]
bases = ["a", "b"]
[numbers]
count = 30
span = 1000
label = "any"
[base.a]
offset = 1
[base.b]
offset = 2
[base.c]
offset = 1
[squares]
fail_at = 1000000
panic_at = 1000000
[total]
modulo = 1000000007
[draws]
count = 2
row = [{ base = "a", level = 10 }, { base = "b", level = 20 }]
[pinned]
base = "b"
item = 3
[scale.small]
factor = 1
[scale.large]
factor = 100
[aside]
value = 5
fail = false
[fickle]
steady = true
[witness]
shift = 0
"#;

/// What makes another disk of one.
pub(crate) type Wrap = Box<dyn Fn(Arc<dyn Disk>) -> Arc<dyn Disk> + Send + Sync>;

/// A store, a figures folder and the parameters in force.
pub(crate) struct House {
    root: PathBuf,
    /// None in a process that another one gave the folder.
    _folder: Option<TempDir>,
    /// What the store's disk is wrapped in.
    pub(crate) disk: Wrap,
    pub(crate) pipeline: Pipeline,
    pub(crate) text: String,
    pub(crate) edits: Vec<String>,
    pub(crate) workers: usize,
    /// The text of the parameters beside the figures.
    pub(crate) parameters: Option<String>,
    pub(crate) may_replace: bool,
}

/// What a run did.
pub(crate) struct Done {
    pub(crate) events: Vec<Event>,
    pub(crate) outcome: Result<(), Error>,
    /// `NODE/PIECE` -> key and id, of every piece that is known.
    pub(crate) known: BTreeMap<String, (Key, Id)>,
    /// The lock of a run that succeeded.
    pub(crate) lock: Option<Lock>,
}

impl House {
    pub(crate) fn new() -> Self {
        let folder = tempfile::tempdir().expect("a temporary folder can be made");
        Self::with(folder.path().to_owned(), Some(folder))
    }

    /// A house in a folder that is there already.
    pub(crate) fn at(root: &Path) -> Self {
        Self::with(root.to_owned(), None)
    }

    fn with(root: PathBuf, own: Option<TempDir>) -> Self {
        Self {
            root,
            _folder: own,
            disk: Box::new(|disk| disk),
            pipeline: TOY,
            text: PARAMS.to_owned(),
            edits: Vec::new(),
            workers: 2,
            parameters: None,
            may_replace: true,
        }
    }

    /// The same with the given edits and one run behind it.
    pub(crate) fn lived_in(edits: &[&str]) -> Self {
        let mut house = Self::new();
        for edit in edits {
            house.set(edit);
        }
        house.run().expect_success();
        house
    }

    /// Edits one parameter, `table.key=value`.
    pub(crate) fn set(&mut self, assignment: &str) {
        self.edits.push(assignment.to_owned());
    }

    pub(crate) fn path(&self, name: &str) -> PathBuf {
        self.root.join(name)
    }

    pub(crate) fn params(&self) -> Result<ParamsFile, Error> {
        let mut params = ParamsFile::default();
        params.layer("toy.toml", &self.text)?;
        self.edits.iter().try_for_each(|edit| params.set(edit))?;
        Ok(params)
    }

    pub(crate) fn graph(&self, targets: &[&str]) -> Result<Graph, Error> {
        let targets: Result<Vec<Target>, Error> = targets.iter().map(|text| Target::parse(text)).collect();
        Graph::new(&self.pipeline, &self.params()?, &targets?)
    }

    /// The refusal of the parameters in force.
    pub(crate) fn refusal(&self) -> String {
        match self.params() {
            Ok(params) => self.refusal_of(&params),
            Err(error) => error.to_string(),
        }
    }

    /// The refusal of some parameters.
    pub(crate) fn refusal_of(&self, params: &ParamsFile) -> String {
        match Graph::new(&self.pipeline, params, &[]) {
            Err(error @ Error::Usage(_)) => error.to_string(),
            other => panic!("expected a refusal, found {:?}", other.map(|graph| graph.nodes.len())),
        }
    }

    pub(crate) fn store(&self) -> Store {
        self.open().expect("a store can be opened")
    }

    fn open(&self) -> Result<Store, Error> {
        Store::open_on((self.disk)(Store::disk(&self.path("store"))?), &|| ())
    }

    /// What `gc` would take to come within a size; takes it, unless the run is dry.
    pub(crate) fn gc(&self, bound: u64, dry: bool) -> Result<Sweep, Error> {
        let disk = (self.disk)(Store::disk(&self.path("store"))?);
        let Some(alone) = Alone::wait(disk, &|| ())? else {
            return Ok(Sweep::default());
        };
        let locks = lock::committed(&self.checkout().artifacts(), &|stem| stem == "toy")?;
        let sweep = gc::plan(alone.store(), &self.pipeline, &locks, bound)?;
        if !dry {
            alone.carry_out(&sweep)?;
        }
        Ok(sweep)
    }

    pub(crate) fn run(&self) -> Done {
        self.run_targets(&[])
    }

    pub(crate) fn run_targets(&self, targets: &[&str]) -> Done {
        self.walk(targets, |_| ())
    }

    /// Runs, then decodes a piece, `(STAGE, CASE, piece)`.
    pub(crate) fn value<T: serde::de::DeserializeOwned>(&self, name: &str, piece: usize) -> T {
        let bytes = Mutex::new(Vec::new());
        let done = self.walk(&[], |run| {
            let graph = self.graph(&[]).expect("the parameters are in order");
            let node = graph.nodes.iter().position(|node| node.name() == name);
            let node = node.expect("the node exists");
            *bytes.lock().expect("no panic") = run.bytes(node, piece).expect("the piece is at hand");
        });
        done.expect_success();
        let bytes = bytes.into_inner().expect("no panic");
        encounter::engine::codec::decode(&bytes).expect("the bytes are of this type")
    }

    /// Walks until nothing is left in the store that no stage has made.
    fn walk(&self, targets: &[&str], then: impl Fn(&Run<'_>)) -> Done {
        loop {
            let done = self.walk_once(targets, &then);
            if !matches!(done.outcome, Err(Error::Distrusted { .. })) {
                return done;
            }
        }
    }

    fn walk_once(&self, targets: &[&str], then: impl Fn(&Run<'_>)) -> Done {
        let graph = self.graph(targets).expect("the parameters are in order");
        let store = match self.open() {
            Ok(store) => store,
            Err(error) => return Done::refused(error),
        };
        let events = Mutex::new(Vec::new());
        let listener = |event: &Event| events.lock().expect("no panic").push(event.clone());
        let run = Run::new(&graph, &store, &listener);
        let mut lock = None;
        let scales = self.params().and_then(|params| params.list(SCALE));
        // A pipeline without scales publishes once.
        let scales = scales.unwrap_or_else(|_| vec![String::new()]);
        let outcome = schedule::execute(&run, self.workers).and_then(|()| {
            let texts = publish::texts(&run, SCALE, &scales)?;
            let layout = publish::layout(&graph, SCALE, &scales);
            let due = Due::new(&self.pipeline, &scales).exactly(&run, &layout, &texts, |_| true);
            self.with_set(|set| publish::publish(&run, &texts, &due, set))?;
            lock = Some(Lock::of(&run, "toy", "rustc of the test", &texts)?);
            Ok(())
        });
        if outcome.is_ok() {
            then(&run);
        }
        let mut known = BTreeMap::new();
        for (i, node) in graph.nodes.iter().enumerate() {
            for piece in 0..node.pieces.len() {
                if let Some(found) = run.key(i, piece).zip(run.id(i, piece)) {
                    known.insert(format!("{}/{piece}", node.name()), found);
                }
            }
        }
        let events = events.into_inner().expect("no panic");
        Done {
            events,
            outcome,
            known,
            lock,
        }
    }

    /// The checkout of this house.
    pub(crate) fn checkout(&self) -> Checkout {
        Checkout::at(&self.root)
    }

    /// The set of figures of this house: its parameters stand beside them if a test gave any.
    pub(crate) fn with_set<T>(&self, then: impl FnOnce(&Set<'_>) -> T) -> T {
        then(&Set {
            checkout: &self.checkout(),
            folder: &self.path("figures"),
            home: Some("toy"),
            parameters: self.parameters.as_deref(),
            may_replace: self.may_replace,
        })
    }

    /// What `verify --lock` says of a lock, without the store.
    pub(crate) fn against(&self, lock: &Lock) -> Vec<String> {
        let graph = self.graph(&[]).expect("the parameters are in order");
        let folder = tempfile::tempdir().expect("a temporary folder can be made");
        let store = Store::open(folder.path()).expect("a store can be opened");
        let silent = |_: &Event| {};
        let run = Run::new(&graph, &store, &silent);
        verify::against_lock(&run, lock, &self.path("figures"))
    }

    /// What `verify --store` says of a lock.
    pub(crate) fn against_store(&self, lock: &Lock) -> Vec<String> {
        let graph = self.graph(&[]).expect("the parameters are in order");
        let store = self.store();
        let silent = |_: &Event| {};
        verify::against_store(&Run::new(&graph, &store, &silent), lock)
    }

    /// What `verify --rebuild` finds: a run in an empty store, compared with a lock and this house's own store.
    pub(crate) fn rebuild(&self, targets: &[&str], lock: &Lock) -> Result<Rebuilt, Error> {
        let graph = self.graph(targets)?;
        let folder = tempfile::tempdir().expect("a temporary folder can be made");
        let store = Store::open(folder.path())?;
        let silent = |_: &Event| {};
        let run = Run::new(&graph, &store, &silent);
        schedule::execute(&run, self.workers)?;
        let scales = self.params().and_then(|params| params.list(SCALE)).unwrap_or_default();
        let texts = publish::texts(&run, SCALE, &scales)?;
        let made = Lock::of(&run, "toy", "rustc of the test", &texts)?;
        let against = Against {
            lock,
            ordinary: &Store::look(&self.path("store")),
            whole: targets.is_empty(),
            workers: self.workers,
        };
        rebuild::compare(&run, &made, &against)
    }

    /// The plan of the parameters in force.
    pub(crate) fn plan<T>(&self, look: impl FnOnce(&Plan<'_>, &Graph) -> T) -> T {
        let graph = self.graph(&[]).expect("the parameters are in order");
        let store = Store::look(&self.path("store"));
        look(&Plan::new(&graph, &store, &[]), &graph)
    }

    /// The plan of one node.
    pub(crate) fn plan_of(&self, node: &str) -> NodePlan {
        let nodes = self.plan(|plan, _| plan.nodes());
        nodes
            .into_iter()
            .find(|plan| plan.node == node)
            .expect("the node exists")
    }

    /// Why some nodes, named `NODE` or `STAGE`, are not cached.
    pub(crate) fn why(&self, target: &str) -> Why {
        let target = Target::parse(target).expect("a target");
        let graph = self.graph(&[]).expect("the parameters are in order");
        let named = |node: &NodeCase| {
            let of_case = target.case.as_ref().is_none_or(|case| *case == node.case.to_string());
            node.node.name() == target.stage && of_case
        };
        let nodes: Vec<usize> = (0..graph.nodes.len())
            .filter(|node| named(&graph.nodes[*node]))
            .collect();
        let store = Store::look(&self.path("store"));
        why(&Plan::new(&graph, &store, &nodes), &nodes, target.piece)
    }

    pub(crate) fn object(&self, id: &Id) -> PathBuf {
        let hex = id.to_string();
        self.path("store/objects").join(&hex[..2]).join(&hex[2..])
    }

    pub(crate) fn record(&self, key: &Key) -> PathBuf {
        let hex = key.to_string();
        let name = format!("{}.json", &hex[2..]);
        self.path("store/records").join(&hex[..2]).join(name)
    }

    pub(crate) fn files_in(&self, folder: &str) -> Vec<PathBuf> {
        let mut files = Vec::new();
        collect(&self.path(folder), &mut files);
        files.sort();
        files
    }
}

fn collect(folder: &Path, files: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
        let path = entry.path();
        if path.is_dir() {
            collect(&path, files);
        } else {
            files.push(path);
        }
    }
}

impl Done {
    /// A run whose store could not be opened.
    fn refused(error: Error) -> Self {
        Self {
            events: Vec::new(),
            outcome: Err(error),
            known: BTreeMap::new(),
            lock: None,
        }
    }

    #[track_caller]
    pub(crate) fn expect_success(&self) {
        if let Err(error) = &self.outcome {
            panic!("{error}");
        }
    }

    #[track_caller]
    pub(crate) fn locked(self) -> Lock {
        self.expect_success();
        self.lock.expect("a run that succeeded has a lock")
    }

    fn told(&self, what: impl Fn(&Event) -> Option<String>) -> Vec<String> {
        let mut told: Vec<String> = self.events.iter().filter_map(what).collect();
        told.sort();
        told
    }

    /// The pieces that ran, sorted.
    pub(crate) fn ran(&self) -> Vec<String> {
        self.told(|event| match event {
            Event::DidRun { node, piece, .. } => Some(format!("{node}/{piece}")),
            _ => None,
        })
    }

    /// The pieces found in the store, sorted.
    pub(crate) fn reused(&self) -> Vec<String> {
        self.told(|event| match event {
            Event::DidReuse { node, piece } => Some(format!("{node}/{piece}")),
            _ => None,
        })
    }

    /// The pieces that were healed, sorted.
    pub(crate) fn healed(&self) -> Vec<String> {
        self.told(|event| match event {
            Event::DidHeal { node, piece, .. } => Some(format!("{node}/{piece}")),
            _ => None,
        })
    }

    /// The pieces that failed, sorted.
    pub(crate) fn failed(&self) -> Vec<String> {
        self.told(|event| match event {
            Event::DidFail { node, piece, .. } => Some(format!("{node}/{piece}")),
            _ => None,
        })
    }

    /// The pieces that another run was making, sorted.
    pub(crate) fn waited(&self) -> Vec<String> {
        self.told(|event| match event {
            Event::DidWait { node, piece } => Some(format!("{node}/{piece}")),
            _ => None,
        })
    }

    /// The published files that were moved aside, sorted.
    pub(crate) fn set_aside(&self) -> Vec<String> {
        self.told(|event| match event {
            Event::DidSetAside { path, .. } => Some(path.clone()),
            _ => None,
        })
    }

    /// The published files of earlier runs that this one did not make, each with its fate, sorted.
    pub(crate) fn old(&self) -> Vec<String> {
        self.told(|event| match event {
            Event::DidFindOld { path, fate } => Some(format!("{path} {fate:?}")),
            _ => None,
        })
    }

    /// The published files that were written, sorted.
    pub(crate) fn written(&self) -> Vec<String> {
        self.told(|event| match event {
            Event::DidPublish {
                path, written: true, ..
            } => Some(path.clone()),
            _ => None,
        })
    }
}

/// Every piece of the toy pipeline, sorted.
pub(crate) const EVERYTHING: &[&str] = &[
    "aside/0",
    "draws/a/0",
    "draws/a/1",
    "draws/b/0",
    "draws/b/1",
    "echo/0",
    "fickle/0",
    "numbers/0",
    "numbers/1",
    "numbers/2",
    "pinned/b/0",
    "report/large/0",
    "report/small/0",
    "squares/a/0",
    "squares/a/1",
    "squares/a/2",
    "squares/b/0",
    "squares/b/1",
    "squares/b/2",
    "total/a/0",
    "total/b/0",
    "witness/0",
];
