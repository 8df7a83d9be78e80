//! Words: how costs and aligned lines are told by the verbs that plan.

use crate::cli::say;
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
