//! Ctrl-C and its like: the run is asked to end, has most of a second to publish what is finished, then the process ends.
//!
//! A piece that takes longer is given up. Its temporary file goes with the next `gc`, and its lock belongs to the kernel, so
//! nobody has to clean up. Tested in `tests/reliability/kill.rs`.

use std::path::{Path, PathBuf};
#[cfg(unix)]
use std::sync::Arc;
#[cfg(unix)]
use std::sync::mpsc::channel;
use std::sync::{Mutex, MutexGuard, PoisonError};
#[cfg(unix)]
use std::thread;
use std::time::Duration;

#[cfg(unix)]
use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};
#[cfg(unix)]
use signal_hook::flag;
#[cfg(unix)]
use signal_hook::iterator::Signals;
use tempfile::{Builder, TempDir};

use crate::cli::progress::tell;
use crate::engine::error::{Error, Result};
use crate::engine::gc::Alone;
use crate::engine::stop::Stop;
use crate::engine::store::Store;

/// Asked when the process should end.
pub(super) static STOP: Stop = Stop::new();

/// What finished pieces have to be published in.
const GRACE: Duration = Duration::from_millis(700);

/// How the folders of temporary stores begin.
const TEMPORARY_STORE: &str = "encounter-rebuild-";

/// The signal of a file that would grow beyond `ulimit -f`.
#[cfg(unix)]
const SIGXFSZ: i32 = 25;

/// A folder that goes with the process.
static TEMPORARY: Mutex<Option<PathBuf>> = Mutex::new(None);

/// Listens to Ctrl-C, SIGTERM and SIGHUP; where that cannot be done, also for want of a thread, they end the process as they
/// always do. A SIGHUP that was ignored when the process began, as by `nohup`, stays so.
#[cfg(unix)]
pub(super) fn listen() {
    // Heard, it kills nobody: the write fails instead, and its error says which file it was.
    let _ = flag::register(SIGXFSZ, Arc::default());
    let hangup = (!ignores_hangup()).then_some(SIGHUP);
    let (listening, is_listening) = channel();
    let listener = thread::Builder::new().spawn(move || {
        // Only the thread that will answer takes the signals from the system: without it they would be lost.
        let signals = Signals::new([SIGINT, SIGTERM].into_iter().chain(hangup));
        let _ = listening.send(());
        if let Ok(mut signals) = signals
            && signals.forever().next().is_some()
        {
            end();
        }
    });
    if listener.is_ok() {
        let _ = is_listening.recv();
    }
}

/// Listens to Ctrl-C.
#[cfg(not(unix))]
pub(super) fn listen() {
    let _ = ctrlc::set_handler(|| end());
}

/// Whether the process began with SIGHUP ignored; where the system does not tell, it did not.
#[cfg(unix)]
fn ignores_hangup() -> bool {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    let mask = mask.and_then(|hex| u64::from_str_radix(hex.trim(), 16).ok());
    mask.is_some_and(|mask| mask & (1 << (SIGHUP - 1)) != 0)
}

fn end() -> ! {
    STOP.ask();
    std::thread::sleep(GRACE);
    leave()
}

/// Makes a temporary folder for a store, which is gone after its last use, also if the process is interrupted meanwhile.
/// Those that killed processes left are removed.
pub(super) fn temporary_folder() -> Result<TempDir> {
    let folder = Builder::new().prefix(TEMPORARY_STORE).tempdir();
    let folder = folder.map_err(Error::io("make a temporary folder", std::env::temp_dir()))?;
    *temporary() = Some(folder.path().to_owned());
    remove_abandoned(folder.path());
    Ok(folder)
}

/// Removes the temporary stores beside a folder that nobody works in any more: of our name and of the same owner, with the
/// marker of a store, and with nobody holding its lock.
fn remove_abandoned(own: &Path) {
    let Some(beside) = own.parent() else { return };
    for entry in std::fs::read_dir(beside).into_iter().flatten().flatten() {
        let is_named_so = entry.file_name().to_string_lossy().starts_with(TEMPORARY_STORE);
        let path = entry.path();
        if !is_named_so || path == own || !is_folder_of_the_same_owner(&path, own) {
            continue;
        }
        if let Some(alone) = Store::look_at(&path).ok().and_then(Alone::now) {
            // It is in nobody's way.
            let _ = std::fs::remove_dir_all(&path);
            drop(alone);
        }
    }
}

#[cfg(unix)]
fn is_folder_of_the_same_owner(path: &Path, own: &Path) -> bool {
    use std::os::unix::fs::MetadataExt;
    let found = (path.symlink_metadata(), own.symlink_metadata());
    matches!(found, (Ok(path), Ok(own)) if path.is_dir() && path.uid() == own.uid())
}

#[cfg(not(unix))]
fn is_folder_of_the_same_owner(path: &Path, _: &Path) -> bool {
    path.symlink_metadata().is_ok_and(|found| found.is_dir())
}

fn temporary() -> MutexGuard<'static, Option<PathBuf>> {
    TEMPORARY.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Says so, once, and ends the process.
pub(super) fn leave() -> ! {
    static LEAVING: Mutex<()> = Mutex::new(());
    let _only_one = LEAVING.lock();
    if let Some(folder) = temporary().take() {
        // Workers may still be writing into it: what is new since the first look goes with a second one.
        for _ in 0..3 {
            let _ = std::fs::remove_dir_all(&folder);
        }
        tell("interrupted; the temporary store of the rebuild was removed, the next one begins anew");
    } else {
        tell(&Error::Interrupted.to_string());
    }
    std::process::exit(i32::from(Error::Interrupted.exit_code()))
}
