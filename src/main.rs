//! The process: everything it does is in `cli`.

use std::process::ExitCode;

fn main() -> ExitCode {
    encounter::cli::main()
}
