//! What can go wrong in the cache, each with what was expected, what was found and the next step.

use std::io::ErrorKind;
use std::path::PathBuf;

use crate::engine::difference::Difference;

/// A result whose error is [`Error`].
pub type Result<T> = std::result::Result<T, Error>;

/// An error of the engine or of a stage.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// A parameter, target or option that cannot be used.
    #[error("{0}")]
    Usage(String),
    /// A stage that could not make its output.
    #[error("{node} failed: {message}")]
    Stage {
        /// The node and piece.
        node: String,
        /// What the stage said.
        message: String,
    },
    /// A file operation that failed.
    #[error("cannot {action} {path}: {source}", path = path.display())]
    Io {
        /// What was tried, as a verb.
        action: &'static str,
        /// The file or folder.
        path: PathBuf,
        /// The operating system's answer.
        source: std::io::Error,
    },
    /// A disk without room.
    #[error("cannot write {path}: {source}{room}", path = path.display(), room = room(*needed, *freeable))]
    Full {
        /// The file.
        path: PathBuf,
        /// Its length, bytes.
        needed: u64,
        /// What `encounter gc` could free, if that is known, bytes.
        freeable: Option<u64>,
        /// The operating system's answer.
        source: std::io::Error,
    },
    /// A system that gives no thread.
    #[error("cannot start a thread: {0}; end other processes of this user, or allow it more (`ulimit -u`)")]
    NoThread(#[source] std::io::Error),
    /// Somebody asked the run to end.
    #[error("interrupted; what is finished is kept, the next run goes on from there")]
    Interrupted,
    /// Bytes that are not what their name says.
    #[error("{what} is damaged: {why}")]
    Damaged {
        /// The object, record or lock.
        what: String,
        /// How it differs from what was expected.
        why: String,
    },
    /// An output that is what its name says and yet none of its stage's. It was set aside with its record; a new walk makes it
    /// again.
    #[error(
        "{node}: expected an output that keeps the rules of its stage, found in the store: {why}; it was moved to quarantine/ \
             with its record; run the command again to make it"
    )]
    Distrusted {
        /// The node and piece.
        node: String,
        /// How it differs from an output of its stage.
        why: String,
    },
    /// A key made twice with two contents.
    #[error("{node} is not reproducible: recorded {recorded}, made again {made}{}", told(.difference.as_deref(), .note))]
    NotReproducible {
        /// The node and piece.
        node: String,
        /// The recorded id.
        recorded: String,
        /// The id of the new output.
        made: String,
        /// Where the two differ, where both are at hand.
        difference: Option<Box<Difference>>,
        /// What else is known, a sentence; may be empty.
        note: String,
    },
    /// This build on this CPU computes other bits than the locks hold.
    #[error("{0}")]
    OtherBits(String),
    /// The committed lock differs from what was computed.
    #[error("{0}")]
    Difference(String),
    /// Some nodes failed; the rest is done.
    #[error("{0}")]
    Failures(String),
}

/// Difference and note on lines of their own.
fn told(difference: Option<&Difference>, note: &str) -> String {
    let note = Some(note.to_owned()).filter(|note| !note.is_empty());
    let told: Vec<String> = difference.map(ToString::to_string).into_iter().chain(note).collect();
    if told.is_empty() {
        return String::new();
    }
    format!("\n  {}", told.join("\n  "))
}

/// What a full disk lacks, and what could be done.
fn room(needed: u64, freeable: Option<u64>) -> String {
    let needed = (needed > 0).then(|| format!("; {needed} bytes needed"));
    let freeable = freeable.map(|bytes| format!("; `encounter gc --max 0` could free {bytes} bytes"));
    [needed, freeable].into_iter().flatten().collect()
}

impl Error {
    /// A failure inside a stage, told in the stage's words; the engine adds the node.
    pub fn stage(message: impl Into<String>) -> Self {
        Self::Stage {
            node: String::new(),
            message: message.into(),
        }
    }

    /// Names the node of a stage's failure.
    pub(crate) fn at(self, node: &str) -> Self {
        match self {
            Self::Stage { message, .. } => Self::Stage {
                node: node.to_owned(),
                message,
            },
            other => other,
        }
    }

    /// Wraps an operating system's error with the path and the action.
    pub(crate) fn io(action: &'static str, path: impl Into<PathBuf>) -> impl FnOnce(std::io::Error) -> Self {
        let path = path.into();
        move |source| Self::Io { action, path, source }
    }

    /// The same for a file of `needed` bytes, whose disk may have no room for it.
    pub(crate) fn writing(
        action: &'static str,
        path: impl Into<PathBuf>,
        needed: u64,
    ) -> impl FnOnce(std::io::Error) -> Self {
        let path = path.into();
        move |source| match source.kind() {
            ErrorKind::StorageFull | ErrorKind::QuotaExceeded => Self::Full {
                path,
                needed,
                freeable: None,
                source,
            },
            _ => Self::Io { action, path, source },
        }
    }

    /// The exit code of the process.
    pub fn exit_code(&self) -> u8 {
        match self {
            Self::Stage { .. } | Self::Failures(_) => 1,
            Self::Usage(_) => 2,
            Self::Difference(_) => 3,
            Self::NotReproducible { .. } | Self::OtherBits(_) => 4,
            Self::Io { .. }
            | Self::Full { .. }
            | Self::NoThread(_)
            | Self::Damaged { .. }
            | Self::Distrusted { .. } => 5,
            Self::Interrupted => 130,
        }
    }
}
