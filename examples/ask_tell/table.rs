//! CSV files of strangers, as spreadsheets and scripts write them.
//!
//! Columns are found by their names. What changes no number is let pass: a byte order mark, quotes, spaces, capitals in a
//! header, `#` before it, columns in another order and columns of other names, blank lines, and any line end. A last line
//! without its end is refused: a file that was cut short may end inside a number.

use crate::refusal::{Refusal, line, refusal};
use csv::{ReaderBuilder, StringRecord, Trim};
use std::path::Path;

const NEXT: &str = "correct the file and call again: nothing of it was taken";

/// Calls `take` with the line number and the cells of these columns, row by row.
pub(crate) fn rows<const N: usize>(
    path: &Path,
    bytes: &[u8],
    columns: [&str; N],
    mut take: impl FnMut(u64, [&str; N]) -> Result<(), Refusal>,
) -> Result<(), Refusal> {
    if bytes.starts_with(&[0xff, 0xfe]) || bytes.starts_with(&[0xfe, 0xff]) {
        let next = "save it as `CSV UTF-8`, or as plain text, and call again";
        return Err(refusal(path.display(), "a text file in UTF-8", "UTF-16", next));
    }
    // Whatever is no text becomes a sign that no number holds; in columns that are not read it does no harm.
    let text = String::from_utf8_lossy(bytes);
    let text = text.trim_start_matches('\u{feff}');
    if !text.is_empty() && !text.ends_with(['\n', '\r']) {
        let last = text.lines().count() as u64;
        let found = "the end of a file that may have been cut short";
        return Err(refusal(line(path, last), "a line end", found, NEXT));
    }
    let mut reader = ReaderBuilder::new()
        .has_headers(false)
        .flexible(true)
        .trim(Trim::All)
        .from_reader(text.as_bytes());
    let mut head: Option<([usize; N], usize)> = None;
    let mut record = StringRecord::new();
    while reader
        .read_record(&mut record)
        .map_err(|why| refusal(path.display(), "rows of cells", why, NEXT))?
    {
        let at = record.position().map_or(0, csv::Position::line);
        if record.iter().all(str::is_empty) {
            continue;
        }
        match &head {
            None => head = Some((named(path, at, &record, columns)?, record.len())),
            Some((places, width)) => take(at, cells(path, at, &record, places, *width)?)?,
        }
    }
    if head.is_none() {
        return Err(refusal(line(path, 1), columns.join(","), "no header", NEXT));
    }
    Ok(())
}

/// Where the columns stand in a header.
fn named<const N: usize>(path: &Path, at: u64, head: &StringRecord, columns: [&str; N]) -> Result<[usize; N], Refusal> {
    let names: Vec<&str> = head.iter().map(|name| name.trim_start_matches('#').trim()).collect();
    let mut places = [0; N];
    for (place, column) in places.iter_mut().zip(columns) {
        let mut found = (0..names.len()).filter(|i| names[*i].eq_ignore_ascii_case(column));
        *place = match (found.next(), found.next()) {
            (Some(i), None) => i,
            (Some(_), Some(_)) => return Err(refusal(line(path, at), format!("one column {column}"), "two", NEXT)),
            (None, _) => {
                let expected = format!("the columns {}", columns.join(","));
                return Err(refusal(
                    line(path, at),
                    expected,
                    format!("`{}`", names.join(",")),
                    NEXT,
                ));
            }
        };
    }
    Ok(places)
}

/// The cells of one row; more or fewer of them than the header names say that a comma is one too many or too few.
fn cells<'a, const N: usize>(
    path: &Path,
    at: u64,
    record: &'a StringRecord,
    places: &[usize; N],
    width: usize,
) -> Result<[&'a str; N], Refusal> {
    let beyond = record.iter().skip(width).any(|cell| !cell.is_empty());
    if record.len() < width || beyond {
        let (expected, found) = (format!("{width} cells"), record.len());
        return Err(refusal(line(path, at), expected, found, NEXT));
    }
    Ok(places.map(|i| &record[i]))
}

/// The finite number in a cell.
pub(crate) fn number(path: &Path, at: u64, column: &str, cell: &str) -> Result<f64, Refusal> {
    let parsed = cell.parse().ok().filter(|v: &f64| v.is_finite());
    let place = || format!("{}, {column}", line(path, at));
    parsed.ok_or_else(|| refusal(place(), "a finite number", format!("`{cell}`"), NEXT))
}
