//! `encounter run`: make what is missing, then write figures, tables and the lock.

use std::sync::Mutex;
use std::time::Instant;

use clap::Args;
use serde_json::json;

use crate::cli::interrupt::STOP;
use crate::cli::locked::Compared;
use crate::cli::progress::{Progress, tell};
use crate::cli::session::{Common, Session};
use crate::cli::{gc, locked, print_json, same_bits, say, status, timing};
use crate::engine::code;
use crate::engine::error::{Error, Result};
use crate::engine::event::{Event, Fate};
use crate::engine::lock::Lock;
use crate::engine::plan::decide_all;
use crate::engine::publish;
use crate::engine::run::Run;
use crate::engine::schedule;
use crate::engine::store::Store;
use crate::engine::timing::{StageTime, by_stage, recorded};
use crate::stages::axes::SHIP;
use crate::text::count::counted;

/// Arguments of `encounter run`.
#[derive(Debug, Args)]
#[expect(clippy::struct_excessive_bools, reason = "each is an option of the command line")]
pub struct RunArgs {
    /// Stages, nodes (STAGE/CASE/PIECE) or outputs (table1); all of them by default
    pub(super) target: Vec<String>,
    #[command(flatten)]
    pub(super) common: Common,
    /// Worker threads [default: one per core]
    #[arg(short, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    j: Option<u16>,
    /// Only say what would run
    #[arg(long)]
    dry_run: bool,
    /// Exit with 3 if a line of the committed lock differs from what this run made; nothing is accepted
    #[arg(long, conflicts_with_all = ["dry_run", "update_lock"])]
    pub(super) locked: bool,
    /// Write what this run made into the lock, which nothing else changes
    #[arg(long, conflicts_with = "dry_run")]
    pub(super) update_lock: bool,
    /// Let the figures of this what-if take the place of those that its --name already has
    #[arg(long, requires = "name")]
    replace: bool,
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
    /// What the store held and no stage can have made.
    replaced: Vec<String>,
    failed: Vec<String>,
    files: Vec<(String, String, bool)>,
    /// Published files of earlier runs that this one did not make.
    old: Vec<(String, Fate)>,
}

/// Runs the verb.
///
/// # Errors
/// A parameter, store or stage that fails.
pub fn run(args: &RunArgs) -> Result<()> {
    locked::check(args)?;
    let mut session = args.common.open(&args.target)?;
    if args.replace {
        session.replace();
    }
    if args.dry_run {
        return status::print(&args.common, &session);
    }
    session.warn();
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
    for (path, kept) in store.put_aside() {
        tell(&format!(
            "store: something that is not the store's stood at {path}; moved to {}, where it stays",
            kept.display()
        ));
    }
    let ledger = ledger.into_inner().expect("a listener does not panic");
    let seconds = start.elapsed().as_secs_f64();
    let times = args.profile_time.then(|| ledger.times(&session, &store, seconds));
    drop(store);
    let compared = outcome.as_ref().ok().and_then(Option::as_ref);
    if args.common.json {
        print_json(&ledger.json(&session, seconds, times.as_ref(), compared));
    } else if outcome.is_ok() {
        ledger.print(&session, seconds, times.as_ref());
    }
    if outcome.is_ok() && !ledger.ran.is_empty() {
        gc::after_run(&session.store);
    }
    outcome.and_then(|compared| conclude(args, compared.as_ref()))
}

/// Says how the lock stands, as the last word of a run that has one.
fn conclude(args: &RunArgs, compared: Option<&Compared>) -> Result<()> {
    let Some(compared) = compared else { return Ok(()) };
    compared.verdict(args)?;
    if !args.common.json {
        say(format_args!("{}", compared.sentence(args)));
    }
    Ok(())
}

/// The number of worker threads in force.
pub(super) fn workers(j: Option<u16>) -> usize {
    j.map_or_else(
        || std::thread::available_parallelism().map_or(1, usize::from),
        usize::from,
    )
}

/// Walks until nothing in the store is left that no stage has made: each walk sets aside what it comes upon.
fn execute(
    args: &RunArgs,
    session: &Session,
    store: &Store,
    listener: &(dyn Fn(&Event) + Sync),
) -> Result<Option<Compared>> {
    loop {
        match walk(args, session, store, listener) {
            Err(Error::Distrusted { .. }) => {}
            done => return done,
        }
    }
}

fn walk(
    args: &RunArgs,
    session: &Session,
    store: &Store,
    listener: &(dyn Fn(&Event) + Sync),
) -> Result<Option<Compared>> {
    let set = session.set();
    let run = Run::new(&session.graph, store, listener).in_checkout(session.checkout.root());
    let run = run.until(&STOP);
    if decide_all(&run) {
        set.check()?;
    } else {
        same_bits()?;
        publish::check_folder(&session.graph, SHIP, &session.ships, &set)?;
    }
    let outcome = schedule::execute(&run, workers(args.j));
    if !matches!(outcome, Ok(()) | Err(Error::Failures(_))) {
        return outcome.map(|()| None);
    }
    let texts = publish::texts(&run, SHIP, &session.ships)?;
    let layout = publish::layout(&session.graph, SHIP, &session.ships);
    let due = session.due().exactly(&run, &layout, &texts, |_| true);
    publish::publish(&run, &texts, &due, &set)?;
    outcome?;
    if !locked::keeps_lock(args) {
        return Ok(None);
    }
    let made = Lock::of(&run, args.common.profile.name(), code::RUSTC, &texts)?;
    locked::compare(args, &made).map(Some)
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
            // A walk that begins anew meets every piece again.
            Event::DidPlan { .. } => self.reused = 0,
            Event::DidReuse { .. } => self.reused += 1,
            Event::DidHeal { node, piece, why } => self.healed.push(format!("{node}/{piece}: {why}")),
            Event::DidFail { node, piece, message } => self.failed.push(format!("{node}/{piece}: {message}")),
            Event::DidPublish { path, id, written } => self.files.push((path.clone(), id.clone(), *written)),
            Event::DidFindOld { path, fate } => self.old.push((path.clone(), *fate)),
            Event::DidDistrust { node, why } => self.replaced.push(format!("{node}: {why}")),
            Event::WillRun { .. } | Event::DidWait { .. } | Event::DidSetAside { .. } => {}
        }
    }

    /// The published files of earlier runs that met some fate.
    fn old_paths(&self, is_met: impl Fn(Fate) -> bool) -> Vec<&str> {
        let old = self.old.iter().filter(|(_, fate)| is_met(*fate));
        old.map(|(path, _)| path.as_str()).collect()
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

    fn json(
        &self,
        session: &Session,
        seconds: f64,
        times: Option<&timing::Times>,
        compared: Option<&Compared>,
    ) -> serde_json::Value {
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
            "format": 1, "ran": ran, "reused": self.reused, "healed": self.healed,
            "replaced": self.replaced, "failed": self.failed,
            "seconds": seconds, "files": files, "warnings": session.graph.warnings, "folder": session.figures.display().to_string(),
            "stale": self.old_paths(|fate| fate != Fate::Removed), "removed": self.old_paths(|fate| fate == Fate::Removed),
            "lock": compared.map(Compared::json),
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
        for replaced in &self.replaced {
            say(format_args!(
                "replaced  {replaced}; moved to quarantine/ and made again; --locked compares all outputs with the lock"
            ));
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
