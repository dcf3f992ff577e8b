//! The program `illuminator`: arguments into calls of the library, results into files, text and an exit status.

mod cli;

use std::process::ExitCode;

fn main() -> ExitCode {
    cli::run()
}
