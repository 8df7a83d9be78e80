//! `encounter run`: make what is missing, then write figures, tables and the lock.

use std::sync::Mutex;
use std::time::Instant;

use clap::Args;
use serde_json::json;

use crate::cli::interrupt::STOP;
use crate::cli::progress::Progress;
use crate::cli::{Common, Session, gc, on_request, print_json, same_bits, say, status, timing};
use crate::engine::code;
use crate::engine::disk::read_text;
use crate::engine::error::{Error, Result};
use crate::engine::event::Event;
use crate::engine::idle::{self, Traces};
use crate::engine::index::Index;
use crate::engine::lock::Lock;
use crate::engine::publish;
use crate::engine::run::Run;
use crate::engine::schedule;
use crate::engine::store::Store;
use crate::engine::timing::{StageTime, by_stage, recorded};
use crate::stages::axes::SHIP;
use crate::text::count::counted;

/// Arguments of `encounter run`.
#[derive(Debug, Args)]
pub struct RunArgs {
    /// Stages, nodes (STAGE/CASE/PIECE) or outputs (table1); all of them by default
    target: Vec<String>,
    #[command(flatten)]
    common: Common,
    /// Worker threads [default: one per core]
    #[arg(short, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    j: Option<u16>,
    /// Only say what would run
    #[arg(long)]
    dry_run: bool,
    /// Print nodes, pieces, seconds of one core, bytes and throughput of each stage: of what ran, or, if nothing had to,
    /// of when each piece was made
    #[arg(long, conflicts_with = "dry_run")]
    profile_time: bool,
}

/// What a run did, gathered from its events.
#[derive(Default)]
struct Ledger {
    ran: Vec<(String, usize, f64, u64)>,
    reused: usize,
    healed: Vec<String>,
    failed: Vec<String>,
    files: Vec<(String, String, bool)>,
}

/// Runs the verb.
///
/// # Errors
/// A parameter, store or stage that fails.
pub fn run(args: &RunArgs) -> Result<()> {
    let session = args.common.open(&args.target)?;
    if args.dry_run {
        return status::print(&args.common, &session);
    }
    let store = session.open_store()?;
    let start = Instant::now();
    let ledger = Mutex::new(Ledger::default());
    let progress = Progress::new();
    let listener = |event: &Event| {
        progress.hear(event);
        ledger.lock().expect("a listener does not panic").hear(event);
    };
    let outcome = execute(args, &session, &store, &listener).map_err(|error| gc::hint(error, &session.store));
    progress.finish();
    let ledger = ledger.into_inner().expect("a listener does not panic");
    let seconds = start.elapsed().as_secs_f64();
    let times = args.profile_time.then(|| ledger.times(&session, &store, seconds));
    drop(store);
    if args.common.json {
        print_json(&ledger.json(seconds, times.as_ref()));
    } else if outcome.is_ok() {
        ledger.print(&session, seconds, times.as_ref());
    }
    if outcome.is_ok() && !ledger.ran.is_empty() {
        gc::after_run(&session.store);
    }
    outcome
}

/// The number of worker threads in force.
pub(super) fn workers(j: Option<u16>) -> usize {
    j.map_or_else(
        || std::thread::available_parallelism().map_or(1, usize::from),
        usize::from,
    )
}

fn execute(args: &RunArgs, session: &Session, store: &Store, listener: &(dyn Fn(&Event) + Sync)) -> Result<()> {
    publish::clear(&session.graph, SHIP, &session.ships, &session.figures, store.root());
    let index = session.index();
    if is_idle(args, session, store, listener, &index)? {
        return Ok(());
    }
    same_bits()?;
    publish::check_folder(&session.graph, SHIP, &session.ships, &session.figures)?;
    let run = Run::new(&session.graph, store, listener).until(&STOP);
    let outcome = schedule::execute(&run, workers(args.j));
    if !matches!(outcome, Ok(()) | Err(Error::Failures(_))) {
        return outcome;
    }
    let texts = publish::texts(&run, SHIP, &session.ships)?;
    publish::publish(&run, &texts, &session.figures)?;
    outcome?;
    if keeps_lock(args) {
        let lock = Lock::of(&run, args.common.profile.name(), code::RUSTC, &texts)?;
        write_lock(args, &lock)?;
    }
    index.renew(&run)
}

/// Whether there is nothing to do, which the index tells quickly.
fn is_idle(
    args: &RunArgs,
    session: &Session,
    store: &Store,
    listener: &(dyn Fn(&Event) + Sync),
    index: &Index,
) -> Result<bool> {
    let path = args.common.lock_file(&args.target)?;
    let traces = Traces {
        axis: SHIP,
        values: &session.ships,
        figures: &session.figures,
        lock: keeps_lock(args).then(|| (&*path, args.common.profile.name())),
    };
    Ok(idle::is_idle(
        &Run::new(&session.graph, store, listener),
        index,
        &traces,
    ))
}

/// Whether the run has a lock: one of everything, or of an output that only runs on request, parameters as committed.
fn keeps_lock(args: &RunArgs) -> bool {
    (args.target.is_empty() || on_request(&args.target).is_some()) && !args.common.is_custom()
}

/// Writes the lock, unless only the compiler's name would change.
fn write_lock(args: &RunArgs, lock: &Lock) -> Result<()> {
    let path = args.common.lock_file(&args.target)?;
    let old = read_text(&path).ok().and_then(|text| Lock::parse(&text).ok());
    if old.is_some_and(|old| old.says_the_same_as(lock)) {
        return Ok(());
    }
    publish::write(&path, &lock.text())
}

impl Ledger {
    fn hear(&mut self, event: &Event) {
        match event {
            Event::DidRun {
                node,
                piece,
                seconds,
                bytes,
            } => {
                self.ran.push((node.clone(), *piece, *seconds, *bytes));
            }
            Event::DidReuse { .. } => self.reused += 1,
            Event::DidHeal { node, piece, why } => self.healed.push(format!("{node}/{piece}: {why}")),
            Event::DidFail { node, piece, message } => self.failed.push(format!("{node}/{piece}: {message}")),
            Event::DidPublish { path, id, written } => self.files.push((path.clone(), id.clone(), *written)),
            Event::DidPlan { .. } | Event::WillRun { .. } | Event::DidWait { .. } | Event::DidSetAside { .. } => {}
        }
    }

    /// What its pieces took, by stage.
    fn by_stage(&self, session: &Session) -> Vec<StageTime> {
        let ran = self.ran.iter();
        by_stage(
            &session.graph,
            ran.map(|(node, _, seconds, bytes)| (&**node, *seconds, *bytes)),
        )
    }

    /// The same to be told at length; of the records if nothing ran.
    fn times(&self, session: &Session, store: &Store, elapsed: f64) -> timing::Times {
        if self.ran.is_empty() && self.failed.is_empty() {
            timing::Times::Recorded(recorded(&session.graph, store))
        } else {
            let stages = self.by_stage(session);
            timing::Times::Ran { stages, elapsed }
        }
    }

    fn json(&self, seconds: f64, times: Option<&timing::Times>) -> serde_json::Value {
        let ran: Vec<_> = self
            .ran
            .iter()
            .map(|(node, piece, seconds, _)| json!({"node": node, "piece": piece, "seconds": seconds}))
            .collect();
        let files: Vec<_> = self
            .files
            .iter()
            .map(|(path, id, written)| json!({"path": path, "id": id, "written": written}))
            .collect();
        let mut told = json!({
            "format": 1, "ran": ran, "reused": self.reused, "healed": self.healed, "failed": self.failed,
            "seconds": seconds, "files": files,
        });
        if let Some(times) = times {
            told["profile_time"] = times.json();
        }
        told
    }

    fn print(&self, session: &Session, seconds: f64, times: Option<&timing::Times>) {
        match times {
            Some(times) => times.print(),
            None => self.print_stages(session),
        }
        for healed in &self.healed {
            say(format_args!("healed  {healed}; made again, equal to its record"));
        }
        let written = self.files.iter().filter(|(_, _, written)| *written).count();
        say(format_args!(
            "ran {}, reused {}, in {seconds:.2} s; {} in {}, {written} written",
            counted(self.ran.len(), "piece"),
            self.reused,
            counted(self.files.len(), "file"),
            session.figures.display()
        ));
    }

    /// Time, pieces and bytes of each stage that ran, in paper order.
    fn print_stages(&self, session: &Session) {
        for of in self.by_stage(session) {
            say(format_args!(
                "{:<14} {:<22} {:>6} {:<6} {:>9.2} s {:>10.2} MB",
                of.paper,
                of.stage,
                of.pieces,
                if of.pieces == 1 { "piece" } else { "pieces" },
                of.seconds,
                of.bytes as f64 / 1e6
            ));
        }
    }
}
