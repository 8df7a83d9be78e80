//! VHGP-Seq for a simulator of your own, through files: it asks for wave trains, reads their maxima, estimates P(r > θ_t).
//!
//! ```text
//! cargo run --release --example ask_tell -- new DIR --groups groups.csv --t-p 15 --h-s 12 --theta-t 0.9
//! cargo run --release --example ask_tell -- ask DIR               # writes DIR/batch.csv and DIR/waves.csv
//! (simulate every wave train; write sample,r into maxima.csv)
//! cargo run --release --example ask_tell -- tell DIR maxima.csv   # writes DIR/estimate.csv; then ask again
//! ```
//! | file | columns | meaning |
//! |---|---|---|
//! | groups.csv | `field,t_c,l,a` | yours: the sea's groups by (2); field number, centre in s, length in s, amplitude in m |
//! | batch.csv | `sample,group,l,a,from,to` | the samples to simulate; look for the maximum from..to, s, on the clock of waves.csv |
//! | waves.csv | `sample,t,eta` | their wave trains: the group behind the two ahead of it, by (5), with a common carrier; s, m |
//! | maxima.csv | `sample,r` | yours: the maximum of each, in the unit of θ_t; some samples now, others later will do |
//! | estimate.csv | `n_samples,probability,std,at_least,at_most` | the estimate after each fit, see below |
//!
//! **sample** is a whole number, and not 0, 1, 2: its last four digits belong to this sequence alone. So a file `sample,r`
//! needs no further column, and answers meant for another sequence are refused, those for the same sea and another ship
//! too. **group** is the row of groups.csv, from 0.
//!
//! **A run that failed** is told as `failed` in place of r. The next `ask` then asks for another group near the same
//! place; the failed one is not drawn again. Do this only where the failure has nothing to do with the ship's motion:
//! a run that ends in a capsize is no failure but a maximum, any number above θ_t.
//!
//! **Your CSV files** may have further columns, another order of columns, a byte order mark, quotes, spaces, blank lines
//! and any line end, and numbers such as `1.0E+00`. Each row ends with a line end: a file without its last one may have
//! been cut short. A file that is malformed or contradicts what is known is refused whole: file, line, expected, found,
//! what to do.
//!
//! **estimate.csv** has the estimate and its standard deviation of first order, a guess from below; empty is unknown. As
//! long as no sample has exceeded θ_t there is no estimate but `at_most`, a bound with 95 % confidence by the first n
//! samples alone, which represent the sea: 1 - 0.05^(1/n), about 3/n. Where every sample exceeds, `at_least` alike.
//!
//! `state.toml` holds what has been told, nothing else: each call replays it, so a call that dies changes nothing. It is
//! replaced in one step, under a lock on the folder, and begins with its own checksum; `state.before.toml` is the one
//! before. The folder holds all that a sequence needs, its own copy of groups.csv too: move or rename it as you like.
//! Tested in `tests/ask_tell`, as a process.

#[path = "ask_tell/check.rs"]
mod check;
#[path = "ask_tell/folder.rs"]
mod folder;
#[path = "ask_tell/refusal.rs"]
mod refusal;
#[path = "ask_tell/replay.rs"]
mod replay;
#[path = "ask_tell/state.rs"]
mod state;
#[path = "ask_tell/table.rs"]
mod table;
#[path = "ask_tell/verbs.rs"]
mod verbs;
#[path = "ask_tell/waves.rs"]
mod waves;

use clap::{Parser, Subcommand};
use refusal::Refusal;
use state::Wanted;
use std::io::{self, Write};
use std::path::PathBuf;
use std::process::ExitCode;

#[derive(Parser)]
#[command(about = "Sequential design for a simulator of your own")]
struct Arguments {
    #[command(subcommand)]
    verb: Verb,
}

#[derive(Subcommand)]
enum Verb {
    /// Begins a sequence in a folder.
    New {
        folder: PathBuf,
        /// The sea's groups: field,t_c,l,a.
        #[arg(long)]
        groups: PathBuf,
        /// Peak period, s.
        #[arg(long)]
        t_p: f64,
        /// Significant wave height, m.
        #[arg(long)]
        h_s: f64,
        /// Threshold, in the unit of the maxima.
        #[arg(long)]
        theta_t: f64,
        /// Largest maximum that enters the model, so that none far above the threshold, like a capsize, bends it; a little
        /// above the threshold by default. Where most exceedances lie far above, give more: the samples correct but a part
        /// of what the law misses.
        #[arg(long)]
        cap: Option<f64>,
        /// Samples in all.
        #[arg(long)]
        total: Option<u32>,
        /// Root of the random stream.
        #[arg(long, default_value_t = 2022)]
        seed: u64,
    },
    /// Writes the samples to simulate next; the same ones until they are told.
    Ask { folder: PathBuf },
    /// Takes maxima and writes the estimate.
    Tell { folder: PathBuf, maxima: PathBuf },
}

fn run(verb: Verb) -> Result<String, Refusal> {
    match verb {
        Verb::New {
            folder,
            groups,
            t_p,
            h_s,
            theta_t,
            cap,
            total,
            seed,
        } => {
            let wanted = Wanted {
                seed,
                t_p,
                h_s,
                theta_t,
                cap,
                total,
            };
            verbs::new(&folder, &groups, &wanted)
        }
        Verb::Ask { folder } => verbs::ask(&folder),
        Verb::Tell { folder, maxima } => verbs::tell(&folder, &maxima),
    }
}

fn main() -> ExitCode {
    match run(Arguments::parse().verb) {
        Ok(said) => {
            // All is done: a reader who has gone away is no failure.
            let _ = writeln!(io::stdout(), "{said}");
            ExitCode::SUCCESS
        }
        Err(refusal) => {
            let _ = writeln!(io::stderr(), "refused: {refusal}");
            ExitCode::from(2)
        }
    }
}
