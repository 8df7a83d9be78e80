//! Threads: how workers and helpers are started, and what is said where the system has no thread left to give.
//!
//! Which worker runs what never shows in a result, so a system that gives fewer workers than wanted only makes a run slower.
//! Tested in `tests/cli/threads.rs`.

use std::io;
use std::thread::{Builder, Scope, ScopedJoinHandle};
use std::time::Duration;

use rayon::{ThreadPool, ThreadPoolBuilder};

use crate::engine::error::{Error, Result};

/// How often one worker is asked for again.
const PATIENCE: u32 = 20;
/// The wait between two attempts.
const PAUSE: Duration = Duration::from_millis(10);

/// A pool of so many workers, or of as many as the system gives.
///
/// # Errors
/// Not even one thread can be started.
pub(crate) fn pool(wanted: usize) -> Result<ThreadPool> {
    let (mut workers, mut patience) = (wanted.max(1), PATIENCE);
    loop {
        match ThreadPoolBuilder::new().num_threads(workers).build() {
            Ok(pool) => return Ok(pool),
            Err(_) if workers > 1 => workers /= 2,
            Err(why) if patience == 0 => return Err(Error::NoThread(io::Error::other(why))),
            Err(_) => patience -= 1,
        }
        // The workers of the pool that came to nothing are still ending, and count until they have.
        std::thread::sleep(PAUSE);
    }
}

/// Starts a helper that ends before the scope does.
///
/// # Errors
/// No thread can be started.
pub(crate) fn helper<'scope, 'env, T: Send + 'scope>(
    scope: &'scope Scope<'scope, 'env>,
    work: impl FnOnce() -> T + Send + 'scope,
) -> Result<ScopedJoinHandle<'scope, T>> {
    Builder::new().spawn_scoped(scope, work).map_err(Error::NoThread)
}
