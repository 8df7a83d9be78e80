//! The committed lock beside a run: whether the run has one, how its lines stand, and the only place that writes it.

use std::path::PathBuf;

use serde_json::json;

use crate::cli::progress;
use crate::cli::run::RunArgs;
use crate::cli::session::on_request;
use crate::cli::verify::read_lock;
use crate::engine::error::{Error, Result};
use crate::engine::figures;
use crate::engine::lock::Lock;

/// The lock of a run that has one, compared with what the run made.
pub(super) struct Compared {
    path: PathBuf,
    /// Lines that the run made.
    lines: usize,
    /// Names of lines that differ; of all of them where there is no lock yet.
    differ: Vec<String>,
    state: LockState,
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum LockState {
    /// It is there and is no lock.
    Unreadable,
    /// There is none yet.
    None,
    /// It is as it was.
    Kept,
    /// This run was told to write it, and it differed.
    Written,
    /// This run was told to write it, and there was none that could be read.
    Made,
}

/// Whether the run has a lock: one of everything, or of an output that only runs on request, parameters as committed.
pub(super) fn keeps_lock(args: &RunArgs) -> bool {
    (args.target.is_empty() || on_request(&args.target).is_some()) && !args.common.is_custom()
}

/// Refuses options that need a lock where the run has none; with `--locked`, a lock that cannot be read.
///
/// # Errors
/// Such an option, or such a lock.
pub(super) fn check(args: &RunArgs) -> Result<()> {
    let given = [("--locked", args.locked), ("--update-lock", args.update_lock)];
    let given = given
        .into_iter()
        .find_map(|(option, is_given)| is_given.then_some(option));
    if let Some(option) = given.filter(|_| !keeps_lock(args)) {
        return Err(without_lock(args, option));
    }
    if args.locked {
        read_lock(&args.common.lock_file(&args.target)?)?;
    }
    Ok(())
}

/// Why a run has no lock.
fn without_lock(args: &RunArgs, option: &str) -> Error {
    let why = if args.common.is_custom() {
        "found --overlay or --set: a lock holds what the profile's own parameters make, and a what-if has none"
            .to_owned()
    } else {
        format!("found the target `{}`: a lock holds a whole run", args.target.join(" "))
    };
    Error::Usage(format!("{option}: expected a run of everything, {why}"))
}

/// Compares what a run made with the committed lock, and writes it if that was asked for.
pub(super) fn compare(args: &RunArgs, made: &Lock) -> Result<Compared> {
    let path = args.common.lock_file(&args.target)?;
    let is_there = path.symlink_metadata().is_ok();
    let committed = match read_lock(&path) {
        Ok(lock) => Some(lock),
        Err(_) if !is_there => None,
        Err(error) if args.locked => return Err(error),
        // It is written over when that is asked for; otherwise nothing can be compared, and git has the old one.
        Err(_) if args.update_lock => None,
        Err(error) => {
            progress::tell(&format!("{error}"));
            return Ok(Compared {
                path,
                lines: made.lines.len(),
                differ: Vec::new(),
                state: LockState::Unreadable,
            });
        }
    };
    let differ = match &committed {
        Some(committed) => committed.differing(made),
        None => made.lines.iter().map(|line| line.name.clone()).collect(),
    };
    let mut state = if is_there { LockState::Kept } else { LockState::None };
    if args.update_lock && !(committed.is_some() && differ.is_empty()) {
        figures::write(&path, &made.text())?;
        state = if committed.is_some() {
            LockState::Written
        } else {
            LockState::Made
        };
    }
    Ok(Compared {
        path,
        lines: made.lines.len(),
        differ,
        state,
    })
}

impl Compared {
    /// With `--locked`, a difference is an error.
    ///
    /// # Errors
    /// The difference, with the first line of it and how to accept it.
    pub(super) fn verdict(&self, args: &RunArgs) -> Result<()> {
        if args.locked && !self.differ.is_empty() {
            return Err(Error::Difference(self.sentence(args)));
        }
        Ok(())
    }

    /// How the lock stands, and what to do about it.
    pub(super) fn sentence(&self, args: &RunArgs) -> String {
        let Self {
            path,
            lines,
            differ,
            state,
        } = self;
        let path = path.display();
        let target = on_request(&args.target).map_or(String::new(), |target| format!("{target} "));
        let accept = format!(
            "encounter run {target}--profile {} --update-lock",
            args.common.profile.name()
        );
        let count = differ.len();
        match (state, differ.first()) {
            (LockState::None, _) => format!("no lock yet: `{accept}` writes the {lines} lines of this run to {path}"),
            (LockState::Unreadable, _) => {
                format!(
                    "{path}: expected a readable lock; nothing was compared: restore it with git, or write it anew with {accept}"
                )
            }
            (LockState::Made, _) => format!("{path}: written, {lines} lines"),
            (_, None) => format!("{path}: {lines} lines as committed"),
            (LockState::Written, Some(_)) => format!("{path}: written, {count} of {lines} lines changed"),
            (LockState::Kept, Some(first)) => {
                format!("{count} of {lines} lines differ from {path}: first {first}; accept them with: {accept}")
            }
        }
    }

    pub(super) fn json(&self) -> serde_json::Value {
        json!({
            "path": self.path.display().to_string(), "lines": self.lines,
            "equal": if self.state == LockState::Unreadable { 0 } else { self.lines.saturating_sub(self.differ.len()) },
            "differ": self.differ, "readable": self.state != LockState::Unreadable,
        })
    }
}
