//! Ctrl-C and its like: the run is asked to end, has most of a second to publish what is finished, then the process ends.
//!
//! A piece that takes longer is given up. Its temporary file belongs to whoever makes the piece next, and its lock to the
//! kernel, so nothing is to be cleaned up. Tested in `tests/reliability/kill.rs`.

use std::sync::Mutex;
use std::time::Duration;

use crate::cli::progress::tell;
use crate::engine::error::Error;
use crate::engine::stop::Stop;

/// Asked when the process should end.
pub(super) static STOP: Stop = Stop::new();

/// What finished pieces have to be published in.
const GRACE: Duration = Duration::from_millis(700);

/// Listens to Ctrl-C, SIGTERM and SIGHUP; where that cannot be done, they end the process as they always do.
pub(super) fn listen() {
    let _ = ctrlc::set_handler(|| {
        STOP.ask();
        std::thread::sleep(GRACE);
        leave()
    });
}

/// Says so, once, and ends the process.
pub(super) fn leave() -> ! {
    static LEAVING: Mutex<()> = Mutex::new(());
    let _only_one = LEAVING.lock();
    tell(&Error::Interrupted.to_string());
    std::process::exit(i32::from(Error::Interrupted.exit_code()))
}
