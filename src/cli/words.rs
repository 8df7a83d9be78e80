//! Words: how costs and aligned lines are told by the verbs that plan.

use std::borrow::Cow;

use crate::cli::say;
use crate::engine::key_path::is_printable;
use crate::engine::plan::Cost;

/// A cost: certain, at most, or more than is known.
pub(super) fn cost(cost: &Cost, pieces: usize) -> String {
    if cost.untimed > 0 && cost.untimed >= pieces {
        return "time unknown".to_owned();
    }
    let more = if cost.untimed > 0 { "over " } else { "" };
    if cost.at_most > cost.certain {
        format!("at most {more}{}", seconds(cost.at_most))
    } else {
        format!("{more}{}", seconds(cost.certain))
    }
}

/// Seconds as a reader wants them: two digits of small ones, minutes of many.
pub(super) fn seconds(seconds: f64) -> String {
    if seconds < 0.1 {
        format!("{seconds:.2} s")
    } else if seconds < 600.0 {
        format!("{seconds:.1} s")
    } else {
        format!("{:.0} min", seconds / 60.0)
    }
}

/// Text in which no file name or lock can move the reader's cursor or turn a line round: all characters that do not show as
/// themselves, line ends excepted, are spelled out.
pub(super) fn plain(text: &str) -> Cow<'_, str> {
    let is_hidden = |c: char| !is_printable(c) && c != '\n' && c != '\t';
    if !text.contains(is_hidden) {
        return Cow::Borrowed(text);
    }
    let spelled = text.chars().map(|c| {
        if is_hidden(c) {
            c.escape_default().to_string()
        } else {
            c.to_string()
        }
    });
    Cow::Owned(spelled.collect())
}

/// "1 piece", "3 pieces".
pub(super) fn counted(count: usize, noun: &str) -> String {
    let plural = if count == 1 { "" } else { "s" };
    format!("{count} {noun}{plural}")
}

/// A line of three columns: the left one as it is, the right one ending where all of them end.
pub(super) struct Line {
    pub(super) left: String,
    pub(super) right: String,
    /// After all columns.
    pub(super) note: String,
}

/// Prints lines with their right columns aligned at their ends.
pub(super) fn print(lines: &[Line]) {
    let width = |of: fn(&Line) -> &str| lines.iter().map(|line| of(line).chars().count()).max().unwrap_or(0);
    let (left, right) = (width(|line| &line.left), width(|line| &line.right));
    for line in lines {
        let text = format!("{:<left$}  {:>right$}  {}", line.left, line.right, line.note);
        say(format_args!("{}", text.trim_end()));
    }
}
