//! The program `illuminator`: it calls the library by its arguments, and writes files, text and an exit status.

mod cli;

use std::process::ExitCode;

fn main() -> ExitCode {
    cli::run()
}
