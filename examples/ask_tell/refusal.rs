//! Why nothing was done: where, what was expected, what was found, and what to do next.

use std::fmt::Display;
use std::io::{Error, ErrorKind};
use std::path::Path;

/// Characters of one part of a refusal; a stranger's file may hold a key or a cell of any length.
const LONGEST_PART: usize = 300;

/// Why nothing was done.
#[derive(Debug, thiserror::Error)]
#[error("{place}: expected {expected}, found {found}; {next}")]
pub(crate) struct Refusal {
    place: String,
    expected: String,
    found: String,
    next: &'static str,
}

pub(crate) fn refusal(place: impl Display, expected: impl Display, found: impl Display, next: &'static str) -> Refusal {
    Refusal {
        place: plain(&place.to_string()),
        expected: plain(&expected.to_string()),
        found: plain(&found.to_string()),
        next,
    }
}

/// A refusal because the system refused; what to do next depends on the kind of its error.
pub(crate) fn failed(path: &Path, expected: impl Display, why: &Error) -> Refusal {
    refusal(path.display(), expected, why, next(why.kind()))
}

fn next(kind: ErrorKind) -> &'static str {
    match kind {
        ErrorKind::StorageFull | ErrorKind::QuotaExceeded | ErrorKind::FileTooLarge => "make room and call again",
        ErrorKind::PermissionDenied | ErrorKind::ReadOnlyFilesystem => {
            "give this user the right to read and write there, and call again"
        }
        ErrorKind::NotFound | ErrorKind::NotADirectory | ErrorKind::IsADirectory | ErrorKind::AlreadyExists => {
            "check the path and call again"
        }
        _ => "remove the cause and call again",
    }
}

/// The place of a line of a file.
pub(crate) fn line(path: &Path, line: u64) -> String {
    format!("{}, line {line}", path.display())
}

/// Text from a stranger's file in which nothing moves the reader's cursor: control characters are spelled out, as are
/// those that turn the direction of writing, and whatever is very long is cut.
fn plain(text: &str) -> String {
    let turns = |c: char| matches!(c, '\u{200e}' | '\u{200f}' | '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}');
    let mut spelled = String::new();
    for c in text.chars().take(LONGEST_PART) {
        if c.is_control() || turns(c) {
            spelled.extend(c.escape_default());
        } else {
            spelled.push(c);
        }
    }
    if text.chars().nth(LONGEST_PART).is_some() {
        spelled.push_str(" ..");
    }
    spelled
}
