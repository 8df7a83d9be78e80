//! `encounter doctor`: whether this machine can make the paper, how long it will take, and whether the store is whole.

use std::fs;
use std::path::Path;
use std::thread;
use std::time::Instant;

use clap::Args;
use serde_json::json;

use crate::cli::session::{Common, Session};
use crate::cli::{print_json, say};
use crate::engine::audit::{Audit, audit};
use crate::engine::error::{Error, Result};
use crate::engine::figures;
use crate::engine::plan::Plan;
use crate::engine::publish;
use crate::engine::store::Store;
use crate::numerics::lanes::Level;
use crate::numerics::self_test;
use crate::stages::axes::SHIP;
use crate::text::count::counted;

/// Arguments of `encounter doctor`.
#[derive(Debug, Args)]
pub struct DoctorArgs {
    #[command(flatten)]
    common: Common,
}

/// What a run of a profile from nothing wants; times are of the reference machine, a 2-core Xeon with AVX-512.
struct Reference {
    /// Seconds of one core, as measured there.
    core_seconds: f64,
    /// Memory, bytes, above what was measured.
    memory: u64,
    /// Room for the store, bytes, above what was measured.
    disk: u64,
}

/// What the self-test took there, s.
const SELF_TEST: f64 = 0.0009;

const GIB: f64 = 1_073_741_824.0;

fn reference(profile: &str) -> Reference {
    let (core_seconds, memory, disk) = match profile {
        "paper" => (1055.0, 2 << 30, 1 << 30),
        "quick" => (68.0, 1 << 29, 1 << 27),
        _ => (1.4, 1 << 28, 1 << 25),
    };
    Reference {
        core_seconds,
        memory,
        disk,
    }
}

/// Runs the verb.
///
/// # Errors
/// A parameter or store that cannot be used; a store that is damaged.
pub fn doctor(args: &DoctorArgs) -> Result<()> {
    let session = args.common.open(&[])?;
    let level = Level::current();
    let cores = thread::available_parallelism().map_or(1, usize::from);
    let bits = self_test::check(level);
    let pace = pace(level);
    let wanted = reference(args.common.profile.name());
    let memory = memory();
    let disk = room(&session.store);
    let store = session.look_at_store()?;
    let plan = Plan::new(&session.graph, &store, &[]);
    let (pieces, left) = plan.nodes().iter().fold((0, 0), |(pieces, left), node| {
        (pieces + node.pieces, left + node.will_run + node.may_run)
    });
    let cost = plan.cost();
    // Recorded times where every piece has one, else the reference at this machine's pace.
    let guess = wanted.core_seconds * pace * left as f64 / pieces.max(1) as f64;
    let core_seconds = if cost.untimed == 0 { cost.at_most } else { guess };
    let minutes = core_seconds / cores as f64 / 60.0;
    let found = if session.store.is_dir() {
        Some(audit(&Store::look(&session.store), cores, &|_, _| {})?)
    } else {
        None
    };
    let mut problems = problems(&wanted, memory, disk, bits.as_ref().err(), found.as_ref());
    problems.extend(unwritable(&session));
    if args.common.json {
        print_json(&json!({
            "format": 1, "profile": args.common.profile.name(), "cores": cores, "level": level.name(),
            "same_bits": bits.is_ok(), "pace": pace, "memory": memory, "disk": disk, "pieces": pieces, "left": left,
            "minutes": minutes, "store": found, "problems": problems,
        }));
    } else {
        let seen = Seen {
            profile: args.common.profile.name(),
            cpu: format!("{cores} cores, {}", level.name()),
            same_bits: bits.is_ok(),
            pace,
            memory,
            disk,
            wanted: &wanted,
            whole: wanted.core_seconds * pace / cores as f64 / 60.0,
            pieces,
            left,
            minutes,
        };
        seen.tell();
        tell_store(&session.store, found.as_ref());
        tell_problems(&problems, args.common.profile.name());
    }
    if problems.is_empty() {
        Ok(())
    } else {
        Err(Error::Difference(problems.join("\n")))
    }
}

/// What was found, for a terminal.
struct Seen<'a> {
    profile: &'a str,
    cpu: String,
    same_bits: bool,
    pace: f64,
    memory: Option<u64>,
    disk: Option<u64>,
    wanted: &'a Reference,
    /// Minutes of a run from nothing.
    whole: f64,
    pieces: usize,
    left: usize,
    /// Minutes of what is left.
    minutes: f64,
}

impl Seen<'_> {
    fn tell(&self) {
        let bits = if self.same_bits {
            "the committed bits"
        } else {
            "OTHER BITS"
        };
        say(format_args!(
            "cpu      {}; the self-test gives {bits}, in {:.1} times the reference machine's time",
            self.cpu, self.pace
        ));
        let (memory, disk) = (gib(self.memory), gib(self.disk));
        let (needs, store) = (gib(Some(self.wanted.memory)), gib(Some(self.wanted.disk)));
        say(format_args!(
            "memory   {memory} free; profile {} needs {needs}",
            self.profile
        ));
        say(format_args!("disk     {disk} free; a whole store needs {store}"));
        say(format_args!(
            "time     about {} for all {} from nothing",
            span(self.whole),
            counted(self.pieces, "piece")
        ));
        if self.left == 0 {
            say(format_args!("left     nothing: every piece is in the store"));
        } else {
            say(format_args!(
                "left     {}, about {}",
                counted(self.left, "piece"),
                span(self.minutes)
            ));
        }
    }
}

fn tell_store(store: &Path, found: Option<&Audit>) {
    match found {
        Some(found) => say(format_args!(
            "store    {}: {}, {:.1} MB, {} damaged, {} missing",
            store.display(),
            counted(found.objects, "object"),
            found.bytes as f64 / 1e6,
            found.damaged.len(),
            found.missing.len()
        )),
        None => say(format_args!("store    none yet at {}", store.display())),
    }
}

fn tell_problems(problems: &[String], profile: &str) {
    for problem in problems {
        say(format_args!("problem  {problem}"));
    }
    if problems.is_empty() {
        say(format_args!(
            "all is well: `encounter run --profile {profile}` makes everything, `encounter verify --lock --profile {profile}` compares it"
        ));
    }
}

/// How many times longer than on the reference machine the self-test takes, the best of five.
fn pace(level: Level) -> f64 {
    let mut least = f64::INFINITY;
    for _ in 0..5 {
        let start = Instant::now();
        // What it says is asked for elsewhere.
        let _ = self_test::check(level);
        let seconds = start.elapsed().as_secs_f64();
        least = if seconds < least { seconds } else { least };
    }
    least / SELF_TEST
}

/// The memory that is free, bytes, where Linux tells.
fn memory() -> Option<u64> {
    let text = fs::read_to_string("/proc/meminfo").ok()?;
    let line = text.lines().find_map(|line| line.strip_prefix("MemAvailable:"))?;
    let kibibytes: u64 = line.split_whitespace().next()?.parse().ok()?;
    Some(1024 * kibibytes)
}

/// The room where the store lies or will lie, bytes, where the system tells.
#[cfg(not(unix))]
fn room(_: &Path) -> Option<u64> {
    None
}

/// The room where the store lies or will lie, bytes.
#[cfg(unix)]
fn room(store: &Path) -> Option<u64> {
    let there = store
        .ancestors()
        .find(|folder| folder.is_dir())
        .unwrap_or(Path::new("."));
    let there = if there.as_os_str().is_empty() {
        Path::new(".")
    } else {
        there
    };
    let known = rustix::fs::statvfs(there).ok()?;
    Some(known.f_bavail * known.f_frsize)
}

fn gib(bytes: Option<u64>) -> String {
    bytes.map_or("unknown".to_owned(), |bytes| format!("{:.2} GiB", bytes as f64 / GIB))
}

fn span(minutes: f64) -> String {
    if minutes < 1.0 {
        format!("{:.0} s", 60.0 * minutes)
    } else {
        format!("{minutes:.1} min")
    }
}

/// Folders of the store and of the figures in which no file can be made, which only making one shows.
fn unwritable(session: &Session) -> Vec<String> {
    let folders = [
        "objects",
        "records",
        "parts",
        "manifests",
        "locks",
        "tmp",
        "runs",
        "quarantine",
    ];
    let store = std::iter::once("").chain(folders).map(|name| session.store.join(name));
    let in_store = store
        .map(|folder| figures::probe("write to", &folder))
        .find_map(Result::err);
    let figures = publish::check_folder(&session.graph, SHIP, &session.ships, &session.set()).err();
    let artifacts = figures::probe("write to", &session.checkout.artifacts()).err();
    let told = |what: &str, option: &str, error: Option<Error>| {
        error.map(|error| format!("{what}: {error}; make it writable, or choose another folder with {option}"))
    };
    let found = [
        told("store", "--store", in_store),
        told("figures", "--figures", figures),
        artifacts.map(|error| format!("checkout: {error}; locks and the list of published files lie there")),
    ];
    found.into_iter().flatten().collect()
}

/// What stands in the way.
fn problems(
    wanted: &Reference,
    memory: Option<u64>,
    disk: Option<u64>,
    bits: Option<&String>,
    found: Option<&Audit>,
) -> Vec<String> {
    let mut all = Vec::new();
    if let Some(why) = bits {
        all.push(why.clone());
    }
    if memory.is_some_and(|free| free < wanted.memory) {
        all.push(format!(
            "memory: expected {} free, found {}",
            gib(Some(wanted.memory)),
            gib(memory)
        ));
    }
    let held = found.map_or(0, |found| found.bytes);
    if disk.is_some_and(|free| free + held < wanted.disk) {
        all.push(format!(
            "disk: expected {} free, found {}",
            gib(Some(wanted.disk)),
            gib(disk)
        ));
    }
    if let Some(found) = found.filter(|found| !found.damaged.is_empty()) {
        all.push(format!(
            "store: {} damaged files; `encounter verify --store` names them",
            found.damaged.len()
        ));
    }
    all
}
