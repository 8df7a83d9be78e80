//! Parse, run, print the error, exit code.

use std::process::ExitCode;

use clap::Parser;
use encounter::cli::{self, Cli};

fn main() -> ExitCode {
    match cli::main(&Cli::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::from(error.exit_code())
        }
    }
}
