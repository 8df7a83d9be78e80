//! Stop: the wish to end a run early. Whoever hears it starts nothing new; what is finished is kept.

use std::sync::atomic::{AtomicBool, Ordering};

/// A wish that can be made from any thread, once.
#[derive(Debug, Default)]
pub struct Stop(AtomicBool);

impl Stop {
    /// No wish yet.
    pub const fn new() -> Self {
        Self(AtomicBool::new(false))
    }

    /// Asks every run that listens to end.
    pub fn ask(&self) {
        self.0.store(true, Ordering::Relaxed);
    }

    /// Whether somebody asked.
    pub fn is_asked(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }
}
