//! `encounter run --profile-time`: nodes, pieces, seconds, bytes and throughput of each stage, in paper order.

use serde_json::{Value, json};

use crate::cli::say;
use crate::cli::words::seconds;
use crate::engine::timing::StageTime;
use crate::text::count::counted;

/// What is told, and of what.
pub(super) enum Times {
    /// Of the pieces that this run made.
    Ran {
        stages: Vec<StageTime>,
        /// What the whole run took, seconds.
        elapsed: f64,
    },
    /// Of pieces made by earlier runs: nothing had to run.
    Recorded(Vec<StageTime>),
}

/// Stage and place, then what is aligned at its end.
const HEAD: [&str; 9] = [
    "paper", "stage", "nodes", "pieces", "seconds", "share", "MB", "pieces/s", "MB/s",
];

impl Times {
    fn stages(&self) -> &[StageTime] {
        match self {
            Self::Ran { stages, .. } | Self::Recorded(stages) => stages,
        }
    }

    /// Prints the table and, below it, what it is of.
    pub(super) fn print(&self) {
        let all = total(self.stages());
        let rows = self.stages().iter().chain([&all]).map(|of| row(of, all.seconds));
        print(&[HEAD.map(str::to_owned)].into_iter().chain(rows).collect::<Vec<_>>());
        let took = seconds(all.seconds);
        match self {
            Self::Ran { elapsed, .. } => say(format_args!(
                "{took} of one core in {}: {:.1} cores busy",
                seconds(*elapsed),
                per(all.seconds, *elapsed).unwrap_or(0.0)
            )),
            Self::Recorded(_) => say(format_args!(
                "nothing had to run: {took} of one core, as recorded when the {} were made",
                counted(all.pieces, "piece")
            )),
        }
    }

    /// The same as data; a rate over no time is null.
    pub(super) fn json(&self) -> Value {
        let all = total(self.stages());
        let one = |of: &StageTime| {
            json!({
                "stage": of.stage, "paper": of.paper, "nodes": of.nodes, "pieces": of.pieces, "seconds": of.seconds,
                "share": per(of.seconds, all.seconds), "bytes": of.bytes,
                "pieces_per_second": per(of.pieces as f64, of.seconds),
                "bytes_per_second": per(of.bytes as f64, of.seconds),
            })
        };
        let of = match self {
            Self::Ran { .. } => "run",
            Self::Recorded(_) => "records",
        };
        json!({
            "of": of, "stages": self.stages().iter().map(one).collect::<Vec<_>>(),
            "nodes": all.nodes, "pieces": all.pieces, "seconds": all.seconds, "bytes": all.bytes,
        })
    }
}

/// The sum of some stages, as a stage.
fn total(stages: &[StageTime]) -> StageTime {
    StageTime {
        stage: "all",
        paper: "",
        nodes: stages.iter().map(|of| of.nodes).sum(),
        pieces: stages.iter().map(|of| of.pieces).sum(),
        seconds: stages.iter().map(|of| of.seconds).sum(),
        bytes: stages.iter().fold(0, |sum, of| sum.saturating_add(of.bytes)),
    }
}

/// A rate or share; none of nothing.
fn per(amount: f64, of: f64) -> Option<f64> {
    (of > 0.0).then(|| amount / of)
}

fn row(of: &StageTime, all: f64) -> [String; 9] {
    let megabytes = of.bytes as f64 / 1e6;
    let share = per(of.seconds, all).map(|share| format!("{:.1} %", share * 100.0));
    let rate = |amount: f64| per(amount, of.seconds).map_or("-".to_owned(), |rate| format!("{rate:.2}"));
    [
        of.paper.to_owned(),
        of.stage.to_owned(),
        of.nodes.to_string(),
        of.pieces.to_string(),
        format!("{:.2}", of.seconds),
        share.unwrap_or("-".to_owned()),
        format!("{megabytes:.2}"),
        rate(of.pieces as f64),
        rate(megabytes),
    ]
}

/// Prints rows in columns: the first two begin together, the others end together.
fn print(rows: &[[String; 9]]) {
    let width = |column: usize| rows.iter().map(|row| row[column].chars().count()).max().unwrap_or(0);
    let widths: [usize; 9] = std::array::from_fn(width);
    for row in rows {
        let cells = row.iter().zip(widths).enumerate().map(|(column, (cell, width))| {
            if column < 2 {
                format!("{cell:<width$}")
            } else {
                format!("{cell:>width$}")
            }
        });
        say(format_args!("{}", cells.collect::<Vec<_>>().join("  ")));
    }
}
