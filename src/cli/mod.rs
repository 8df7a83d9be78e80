//! The command line: verbs, options, and what every verb needs. It speaks; it never computes.

pub mod diff;
pub mod doctor;
pub mod gc;
pub mod graph;
mod interrupt;
pub mod progress;
pub mod run;
pub mod show;
pub mod status;
mod timing;
pub mod verify;
pub mod why;
mod words;

use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::{Arc, Mutex, PoisonError};

use clap::{Args, Parser, Subcommand, ValueEnum};

use crate::engine::disk::System;
use crate::engine::error::{Error, Result};
use crate::engine::graph::Graph;
use crate::engine::index::Index;
use crate::engine::node::Node;
use crate::engine::params::ParamsFile;
use crate::engine::store::Store;
use crate::engine::target::Target;
use crate::numerics::lanes::Level;
use crate::numerics::self_test;
use crate::stages::PIPELINE;
use crate::stages::axes::SHIP;
use crate::text::escape;

/// Gong & Pan's ships encountering wave groups: the whole paper from seeds, through a cache.
#[derive(Debug, Parser)]
#[command(version, about, max_term_width = 100)]
struct Cli {
    #[command(subcommand)]
    verb: Verb,
}

#[derive(Debug, Subcommand)]
enum Verb {
    /// Make what is missing or outdated, then write figures and tables
    Run(run::RunArgs),
    /// Say what a run would do, and the state of each published file
    Status(status::StatusArgs),
    /// Say why a node would run: the root changes, old and new, and what the rerun costs
    Why(why::WhyArgs),
    /// Print the record and value of one node, piece or published file
    Show(show::ShowArgs),
    /// Compare parameters, contents and the numbers of Table 1 and Figure 3 with a git revision; nothing is run
    Diff(diff::DiffArgs),
    /// Draw the pipeline in paper order, each stage with its state
    Graph(graph::GraphArgs),
    /// Check the committed lock against the code, the store against its names, or both against a run from nothing
    Verify(verify::VerifyArgs),
    /// Make room in the store: what nothing reaches goes, then what can be made again
    Gc(gc::GcArgs),
    /// Say whether this machine can make the paper, how long that takes, and whether the store is whole
    Doctor(doctor::DoctorArgs),
}

/// Options of every verb.
#[derive(Debug, Args)]
pub struct Common {
    /// The scale: the paper's own, a minute's, or seconds'
    #[arg(long, value_enum, default_value = "paper")]
    profile: Profile,
    /// A parameter file laid over the profile; may be repeated
    #[arg(long, value_name = "FILE")]
    overlay: Vec<PathBuf>,
    /// One parameter, such as sea.S2.bandwidth=0.035; may be repeated
    #[arg(long, value_name = "KEY=VALUE")]
    set: Vec<String>,
    /// The folder of cached outputs [default: artifacts]
    #[arg(long, value_name = "DIR")]
    store: Option<PathBuf>,
    /// The folder of figures [default: figures for the paper profile, else within the store]
    #[arg(long, value_name = "DIR")]
    figures: Option<PathBuf>,
    /// Print one JSON object on standard output
    #[arg(long)]
    json: bool,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Profile {
    Paper,
    Quick,
    Tiny,
}

impl Profile {
    fn name(self) -> &'static str {
        match self {
            Self::Paper => "paper",
            Self::Quick => "quick",
            Self::Tiny => "tiny",
        }
    }
}

impl Common {
    /// The folder that holds `stages/paper.toml`: this one or the nearest above it.
    fn root() -> Result<PathBuf> {
        let mut folder = PathBuf::new();
        for _ in 0..16 {
            if folder.join("stages/paper.toml").is_file() {
                return Ok(folder);
            }
            folder.push("..");
        }
        Err(Error::Usage(
            "stages/paper.toml: expected in this folder or one above it, found in none; run encounter in its repository"
                .to_owned(),
        ))
    }

    fn params(&self) -> Result<ParamsFile> {
        let stages = Self::root()?.join("stages");
        let mut files = vec![stages.join("paper.toml")];
        if self.profile != Profile::Paper {
            files.push(stages.join(format!("{}.toml", self.profile.name())));
        }
        files.extend(self.overlay.iter().cloned());
        let files: Vec<&Path> = files.iter().map(PathBuf::as_path).collect();
        ParamsFile::read(&files, &self.set)
    }

    fn store_folder(&self) -> Result<PathBuf> {
        self.store
            .clone()
            .map_or_else(|| Ok(Self::root()?.join("artifacts")), Ok)
    }

    fn figures_folder(&self) -> Result<PathBuf> {
        if let Some(folder) = &self.figures {
            return Ok(folder.clone());
        }
        if self.is_custom() {
            return Ok(self.store_folder()?.join("figures/custom"));
        }
        match self.profile {
            Profile::Paper => Ok(Self::root()?.join("figures")),
            other => Ok(self.store_folder()?.join("figures").join(other.name())),
        }
    }

    /// The lock of a run of everything, or of the one output named that only runs on request.
    fn lock_file(&self, targets: &[String]) -> Result<PathBuf> {
        let profile = self.profile.name();
        let name = match on_request(targets) {
            Some(own) if self.profile == Profile::Paper => own.to_owned(),
            Some(own) => format!("{profile}.{own}"),
            None => profile.to_owned(),
        };
        Ok(self.store_folder()?.join(format!("{name}.lock")))
    }

    /// Whether parameters differ from those of the profile, so that nothing committed may be touched.
    fn is_custom(&self) -> bool {
        !self.overlay.is_empty() || !self.set.is_empty()
    }

    fn open(&self, targets: &[String]) -> Result<Session> {
        self.open_targets(&targets.iter().map(|text| target(text)).collect::<Result<Vec<_>>>()?)
    }

    /// The same for whole nodes, whatever pieces the targets name.
    fn open_nodes(&self, targets: &[String]) -> Result<Session> {
        let whole = |text: &String| target(text).map(|target| Target { piece: None, ..target });
        self.open_targets(&targets.iter().map(whole).collect::<Result<Vec<_>>>()?)
    }

    fn open_targets(&self, targets: &[Target]) -> Result<Session> {
        let params = self.params()?;
        let graph = Graph::new(&PIPELINE, &params, targets)?;
        let ships = params.list(SHIP)?;
        Ok(Session {
            graph,
            ships,
            store: self.store_folder()?,
            figures: self.figures_folder()?,
            profile: self.profile,
        })
    }
}

/// The one target, if it is published and only on request: it has a lock of its own.
fn on_request(targets: &[String]) -> Option<&str> {
    let [own] = targets else { return None };
    let is_it = |node: &&dyn Node| node.name() == own && node.is_published();
    let is_published = PIPELINE.contents.iter().any(is_it);
    (is_published && PIPELINE.on_request.contains(&own.as_str())).then_some(own.as_str())
}

/// Reads a target. All epsilon_1 of a ship lie in one node, so `nic/calibrated-S1-0.002` is `nic/calibrated-S1`.
fn target(text: &str) -> Result<Target> {
    let mut target = Target::parse(text)?;
    if let Some(case) = &mut target.case
        && let [ship, sea, epsilon_1] = case.split('-').collect::<Vec<_>>().as_slice()
        && epsilon_1.parse::<f64>().is_ok()
    {
        *case = format!("{ship}-{sea}");
    }
    Ok(target)
}

/// What a verb works on.
struct Session {
    graph: Graph,
    ships: Vec<String>,
    store: PathBuf,
    figures: PathBuf,
    profile: Profile,
}

impl Session {
    /// The index of its profile: no other profile's keys burden it.
    fn index(&self) -> Index {
        Index::read(&self.store, self.profile.name())
    }

    fn open_store(&self) -> Result<Store> {
        Store::open_on(&self.store, Arc::new(System), &wait_for_gc).map(told_of_locks)
    }

    /// The store, which need not be there, for reading.
    fn look_at_store(&self) -> Result<Store> {
        if self.store.exists() && !self.store.is_dir() {
            let why = io::ErrorKind::NotADirectory.into();
            return Err(Error::io("look into the store", &self.store)(why));
        }
        let store = Store::look_on(&self.store, Arc::new(System), &wait_for_gc);
        Ok(told_of_locks(store))
    }
}

/// Says so where the file system has no locks.
fn told_of_locks(store: Store) -> Store {
    if store.is_without_locks() {
        let folder = store.root().display();
        progress::tell(&format!(
            "{folder} has no file locks: runs at once may do the same work twice, nothing else"
        ));
    }
    store
}

fn wait_for_gc() {
    progress::tell("waiting for `encounter gc`, which has the store to itself");
}

/// Prints a line; a reader that has gone, such as `head`, is no error.
fn say(line: std::fmt::Arguments<'_>) {
    note(writeln!(std::io::stdout(), "{}", escape::terminal(&line.to_string())));
}

/// Why not all of the answer could be printed.
static UNSAID: Mutex<Option<io::Error>> = Mutex::new(None);

fn note(outcome: io::Result<()>) {
    if let Err(why) = outcome
        && why.kind() != io::ErrorKind::BrokenPipe
    {
        UNSAID.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert(why);
    }
}

/// An error if not all of the answer could be printed, as on a full disk.
fn all_said() -> Result<()> {
    note(io::stdout().flush());
    let why = UNSAID.lock().unwrap_or_else(PoisonError::into_inner).take();
    why.map_or(Ok(()), |why| {
        Err(Error::io("print the answer to", "standard output")(why))
    })
}

fn print_json(value: &serde_json::Value) {
    let text = format!("{value:#}");
    note(writeln!(std::io::stdout(), "{}", escape::json(&text)));
}

/// Parses the command line, runs the verb, prints the error; the exit code says which kind it was.
pub fn main() -> ExitCode {
    let done = match Cli::try_parse() {
        Ok(cli) => {
            interrupt::listen();
            forced_level().and_then(|()| act(&cli.verb))
        }
        Err(mistake) if mistake.use_stderr() => mistake.exit(),
        Err(help) => {
            note(help.print());
            Ok(())
        }
    };
    match done.and_then(|()| all_said()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(Error::Interrupted) => interrupt::leave(),
        Err(error) => {
            progress::tell(&format!("error: {error}"));
            ExitCode::from(error.exit_code())
        }
    }
}

fn act(verb: &Verb) -> Result<()> {
    match verb {
        Verb::Run(args) => run::run(args),
        Verb::Status(args) => status::status(args),
        Verb::Why(args) => why::why(args),
        Verb::Show(args) => show::show(args),
        Verb::Diff(args) => diff::diff(args),
        Verb::Graph(args) => graph::graph(args),
        Verb::Verify(args) => verify::verify(args),
        Verb::Gc(args) => gc::gc(args),
        Verb::Doctor(args) => doctor::doctor(args),
    }
}

/// Refuses a level, forced by the one environment variable there is, that is none or that this CPU lacks.
fn forced_level() -> Result<()> {
    let forced = std::env::var("ENCOUNTER_LEVEL").ok();
    Level::choose(forced.as_deref()).map(|_| ()).map_err(Error::Usage)
}

/// Refuses to compute on a build or a CPU whose bits are not those of the locks.
fn same_bits() -> Result<()> {
    self_test::check(Level::current()).map_err(Error::OtherBits)
}
