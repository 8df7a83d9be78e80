//! Threads: how workers and helpers are started, and what is said where the system has no thread left to give.
//!
//! Which worker runs what never shows in a result, so a system that gives fewer workers than wanted only makes a run slower.
//! Tested in `tests/cli/threads.rs`.

use std::io;
use std::thread::{Builder, Scope, ScopedJoinHandle};

use rayon::{ThreadPool, ThreadPoolBuilder};

use crate::engine::error::{Error, Result};

/// A pool of so many workers, or of as many as the system gives.
///
/// # Errors
/// Not even one thread can be started.
pub(crate) fn pool(wanted: usize) -> Result<ThreadPool> {
    let mut workers = wanted.max(1);
    loop {
        match ThreadPoolBuilder::new().num_threads(workers).build() {
            Ok(pool) => return Ok(pool),
            Err(_) if workers > 1 => workers /= 2,
            Err(why) => return Err(Error::NoThread(io::Error::other(why))),
        }
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
