//! Stat: what the file system says of a file; with luck it is to be believed instead of the bytes.
//!
//! An equal stat proves equal bytes only if nothing can have changed under it after the bytes were verified: nobody can set
//! ctime, but two writes within one tick of the clock have the same. So what changed less than 2 s before the verifying
//! [`Began`] is not believed (racy). Tested in `tests/cache/index.rs`.

use std::path::Path;
use std::time::{SystemTime, UNIX_EPOCH};

use serde::{Deserialize, Serialize};

/// A file that changed so shortly before it was verified, seconds, may have changed after it under the same time.
const GRAIN: i64 = 2;

/// Seconds and nanoseconds since 1970.
pub(crate) type Time = (i64, i64);

/// The file system's words on a file.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct Stat {
    pub(crate) size: u64,
    pub(crate) mtime: Time,
    pub(crate) ctime: Time,
    pub(crate) inode: u64,
}

impl Stat {
    #[cfg(unix)]
    pub(crate) fn of(path: &Path) -> Option<Self> {
        use std::os::unix::fs::MetadataExt;
        let found = std::fs::metadata(path).ok()?;
        Some(Self {
            size: found.len(),
            mtime: (found.mtime(), found.mtime_nsec()),
            ctime: (found.ctime(), found.ctime_nsec()),
            inode: found.ino(),
        })
    }

    /// Without the time of a file's last change, which nobody can set, a stat proves nothing.
    #[cfg(not(unix))]
    pub(crate) fn of(_: &Path) -> Option<Self> {
        None
    }
}

/// When a run began to verify what it noted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct Began(pub(crate) Time);

impl Began {
    pub(crate) fn now() -> Self {
        let now = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
        Self((now.as_secs() as i64, i64::from(now.subsec_nanos())))
    }

    /// Whether nothing can have changed under a noted stat after it was verified.
    pub(crate) fn is_calm(self, noted: &Stat) -> bool {
        let (seconds, nanoseconds) = self.0;
        let since = (seconds.saturating_sub(GRAIN), nanoseconds);
        noted.ctime < since && noted.mtime < since
    }

    /// Whether a file is as it was noted, and was calm then.
    pub(crate) fn vouches_for(self, noted: &Stat, path: &Path) -> bool {
        self.is_calm(noted) && Stat::of(path).as_ref() == Some(noted)
    }
}
