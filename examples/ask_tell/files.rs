//! Files read and written whole: what is wrong with one is said by file, line, expected, found and what to do.

use std::fmt::Display;
use std::fs::{self, File};
use std::io::{ErrorKind, Write};
use std::path::Path;

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
    let (place, expected, found) = (place.to_string(), expected.to_string(), found.to_string());
    Refusal {
        place,
        expected,
        found,
        next,
    }
}

pub(crate) fn line(path: &Path, line: usize) -> String {
    format!("{}, line {line}", path.display())
}

/// The rows of a CSV file of numbers with exactly these columns, each with its line.
pub(crate) fn table<const N: usize>(path: &Path, columns: [&str; N]) -> Result<Vec<(usize, [f64; N])>, Refusal> {
    let next = "correct the file and call again: nothing of it was taken";
    let text = read(path)?;
    let mut lines = text.lines().enumerate();
    let head = lines.next().map_or("", |(_, head)| head.trim_end());
    if head != columns.join(",") {
        return Err(refusal(line(path, 1), columns.join(","), format!("`{head}`"), next));
    }
    if !text.ends_with('\n') {
        let last = text.lines().count();
        return Err(refusal(
            line(path, last),
            "a line end",
            "the end of a file perhaps cut short",
            next,
        ));
    }
    let mut rows = Vec::new();
    for (i, text) in lines {
        let cells: Vec<&str> = text.trim_end().split(',').collect();
        if cells.len() != N {
            let (expected, found) = (format!("{N} cells"), cells.len());
            return Err(refusal(line(path, i + 1), expected, found, next));
        }
        let mut row = [0.0; N];
        for ((value, cell), column) in row.iter_mut().zip(cells).zip(columns) {
            let number = cell.trim().parse().ok().filter(|v: &f64| v.is_finite());
            let place = || format!("{}, {column}", line(path, i + 1));
            *value = number.ok_or_else(|| refusal(place(), "a finite number", format!("`{cell}`"), next))?;
        }
        rows.push((i + 1, row));
    }
    Ok(rows)
}

pub(crate) fn read(path: &Path) -> Result<String, Refusal> {
    let readable = |why| refusal(path.display(), "a text file", why, "check its path and its rights");
    fs::read_to_string(path).map_err(readable)
}

/// Replaces a file in one step: after a crash it is the old one or the new one, whole.
pub(crate) fn write(path: &Path, text: &str) -> Result<(), Refusal> {
    let folder = path.parent().unwrap_or(Path::new("."));
    let written = || -> std::io::Result<()> {
        let mut file = tempfile::NamedTempFile::new_in(folder)?;
        file.write_all(text.as_bytes())?;
        file.as_file().sync_all()?;
        file.persist(path)?;
        File::open(folder)?.sync_all()
    };
    written().map_err(|why| {
        let next = match why.kind() {
            ErrorKind::StorageFull | ErrorKind::QuotaExceeded => "make room and call again",
            ErrorKind::PermissionDenied | ErrorKind::ReadOnlyFilesystem => "allow writing to its folder and call again",
            ErrorKind::NotFound | ErrorKind::NotADirectory => "make its folder and call again",
            _ => "mend that and call again",
        };
        refusal(path.display(), "to write it", why, next)
    })
}
