//! The command line: verbs, options, and what every verb needs. It speaks; it never computes.

pub mod diff;
pub mod doctor;
pub mod gc;
pub mod graph;
mod interrupt;
mod locked;
pub mod progress;
pub mod run;
mod session;
pub mod show;
mod stale;
pub mod status;
mod timing;
pub mod verify;
pub mod why;
mod words;

use std::io::{self, Write};
use std::process::ExitCode;
use std::sync::{Mutex, PoisonError};

use clap::{Parser, Subcommand};

use crate::engine::error::{Error, Result};
use crate::engine::target::Target;
use crate::numerics::lanes::Level;
use crate::numerics::self_test;
use crate::text::escape;

/// Gong & Pan's ships encountering wave groups: the whole paper from seeds, through a cache.
#[derive(Debug, Parser)]
#[command(version, about, max_term_width = 100)]
struct Cli {
    #[command(subcommand)]
    verb: Verb,
}

#[derive(Debug, Subcommand)]
enum Verb {
    /// Make what is missing or outdated, then write figures and tables
    Run(run::RunArgs),
    /// Say what a run would do, and the state of each published file
    Status(status::StatusArgs),
    /// Say why a node would run: the root changes, old and new, and what the rerun costs
    Why(why::WhyArgs),
    /// Print the record and value of one node, piece or published file
    Show(show::ShowArgs),
    /// Compare parameters, contents and the numbers of Table 1 and Figure 3 with a git revision; nothing is run
    Diff(diff::DiffArgs),
    /// Draw the pipeline in paper order, each stage with its state
    Graph(graph::GraphArgs),
    /// Check the committed lock against the code, the store against its names, or both against a run from nothing
    Verify(verify::VerifyArgs),
    /// Make room in the store: what nothing reaches goes, then what can be made again
    Gc(gc::GcArgs),
    /// Say whether this machine can make the paper, how long that takes, and whether the store is whole
    Doctor(doctor::DoctorArgs),
}

/// Reads a target. All epsilon_1 of a ship lie in one node, so `nic/calibrated-S1-0.002` is `nic/calibrated-S1`.
fn target(text: &str) -> Result<Target> {
    let mut target = Target::parse(text)?;
    if let Some(case) = &mut target.case
        && let [ship, sea, epsilon_1] = case.split('-').collect::<Vec<_>>().as_slice()
        && epsilon_1.parse::<f64>().is_ok()
    {
        *case = format!("{ship}-{sea}");
    }
    Ok(target)
}

/// Prints a line; a reader that has gone, such as `head`, is no error.
fn say(line: std::fmt::Arguments<'_>) {
    note(writeln!(std::io::stdout(), "{}", escape::terminal(&line.to_string())));
}

/// Why not all of the answer could be printed.
static UNSAID: Mutex<Option<io::Error>> = Mutex::new(None);

fn note(outcome: io::Result<()>) {
    if let Err(why) = outcome
        && why.kind() != io::ErrorKind::BrokenPipe
    {
        UNSAID.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert(why);
    }
}

/// An error if not all of the answer could be printed, as on a full disk.
fn all_said() -> Result<()> {
    note(io::stdout().flush());
    let why = UNSAID.lock().unwrap_or_else(PoisonError::into_inner).take();
    why.map_or(Ok(()), |why| {
        Err(Error::io("print the answer to", "standard output")(why))
    })
}

fn print_json(value: &serde_json::Value) {
    let text = format!("{value:#}");
    note(writeln!(std::io::stdout(), "{}", escape::json(&text)));
}

/// Parses the command line, runs the verb, prints the error; the exit code says which kind it was.
pub fn main() -> ExitCode {
    let done = match Cli::try_parse() {
        Ok(cli) => {
            interrupt::listen();
            forced_level().and_then(|()| act(&cli.verb))
        }
        Err(mistake) if mistake.use_stderr() => mistake.exit(),
        Err(help) => {
            note(help.print());
            Ok(())
        }
    };
    match done.and_then(|()| all_said()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(Error::Interrupted) => interrupt::leave(),
        Err(error) => {
            progress::tell(&format!("error: {error}"));
            ExitCode::from(error.exit_code())
        }
    }
}

fn act(verb: &Verb) -> Result<()> {
    match verb {
        Verb::Run(args) => run::run(args),
        Verb::Status(args) => status::status(args),
        Verb::Why(args) => why::why(args),
        Verb::Show(args) => show::show(args),
        Verb::Diff(args) => diff::diff(args),
        Verb::Graph(args) => graph::graph(args),
        Verb::Verify(args) => verify::verify(args),
        Verb::Gc(args) => gc::gc(args),
        Verb::Doctor(args) => doctor::doctor(args),
    }
}

/// Refuses a level, forced by the one environment variable there is, that is none or that this CPU lacks.
fn forced_level() -> Result<()> {
    let forced = std::env::var("ENCOUNTER_LEVEL").ok();
    Level::choose(forced.as_deref()).map(|_| ()).map_err(Error::Usage)
}

/// Refuses to compute on a build or a CPU whose bits are not those of the locks.
fn same_bits() -> Result<()> {
    self_test::check(Level::current()).map_err(Error::OtherBits)
}
