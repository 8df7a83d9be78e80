//! `encounter verify`: the committed lock against the code, or against a run from nothing.

use std::fs;
use std::path::Path;

use clap::Args;
use serde_json::json;

use crate::cli::progress::Progress;
use crate::cli::run::workers;
use crate::cli::{Common, Session, print_json, say};
use crate::engine::code;
use crate::engine::error::{Error, Result};
use crate::engine::event::Event;
use crate::engine::lock::Lock;
use crate::engine::publish;
use crate::engine::run::Run;
use crate::engine::schedule;
use crate::engine::store::Store;
use crate::engine::verify::{against_lock, between};
use crate::stages::axes::SHIP;

/// Arguments of `encounter verify`.
#[derive(Debug, Args)]
#[group(id = "what", required = true, multiple = false, args = ["lock", "rebuild"])]
pub struct VerifyArgs {
    /// Compare the lock with code, parameters and published files; nothing is run
    #[arg(long)]
    lock: bool,
    /// Run everything in an empty temporary store and compare the contents with the lock
    #[arg(long)]
    rebuild: bool,
    #[command(flatten)]
    common: Common,
    /// Worker threads of the rebuild [default: one per core]
    #[arg(short, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    j: Option<u16>,
}

/// Runs the verb.
///
/// # Errors
/// A lock that cannot be read, or a difference.
pub fn verify(args: &VerifyArgs) -> Result<()> {
    let session = args.common.open(&[])?;
    let path = args.common.lock_file()?;
    let text = fs::read_to_string(&path).map_err(|source| Error::Io {
        action: "read",
        path: path.clone(),
        source,
    })?;
    let lock = Lock::parse(&text)?;
    let differences = if args.rebuild {
        rebuild(args, &session, &lock)?
    } else {
        compare(args, &session, &lock)
    };
    if args.common.json {
        let lines = lock.lines.len();
        print_json(
            &json!({"format": 1, "lock": path.display().to_string(), "lines": lines, "differences": differences}),
        );
    } else if differences.is_empty() {
        say(format_args!(
            "{}: {} lines, all equal",
            path.display(),
            lock.lines.len()
        ));
    }
    match differences.as_slice() {
        [] => Ok(()),
        [first, rest @ ..] => {
            let others = if rest.is_empty() {
                String::new()
            } else {
                format!("\nand {} more:\n{}", rest.len(), rest.join("\n"))
            };
            Err(Error::Difference(format!(
                "{} differs: {first}{others}",
                path.display()
            )))
        }
    }
}

fn compare(args: &VerifyArgs, session: &Session, lock: &Lock) -> Vec<String> {
    // Published files of a small profile live in its store, which may not be there; only the paper's are committed.
    let mut lock = lock.clone();
    if !session.figures.is_dir() && args.common.profile.name() != "paper" {
        lock.lines.retain(|line| line.pieces.is_some());
    }
    let store = session.look_at_store();
    let silent = |_: &_| {};
    let run = Run::new(&session.graph, &store, &silent);
    against_lock(&run, &session.graph, &lock, &session.figures)
}

fn rebuild(args: &VerifyArgs, session: &Session, lock: &Lock) -> Result<Vec<String>> {
    let folder = tempfile::tempdir().map_err(Error::io("make a temporary folder", std::env::temp_dir()))?;
    let made = rebuild_in(args, session, folder.path())?;
    Ok(between(lock, &made))
}

fn rebuild_in(args: &VerifyArgs, session: &Session, folder: &Path) -> Result<Lock> {
    let store = Store::open(folder)?;
    let progress = Progress::new();
    let listener = |event: &Event| progress.hear(event);
    let run = Run::new(&session.graph, &store, &listener);
    let outcome = schedule::execute(&run, workers(args.j));
    progress.finish();
    outcome?;
    let texts = publish::texts(&run, SHIP, &session.ships)?;
    Lock::of(&run, args.common.profile.name(), code::RUSTC, &texts)
}
