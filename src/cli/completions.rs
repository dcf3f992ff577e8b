//! `illuminator completions`: a script that lets a shell complete commands and options.

use crate::cli::report::{Failure, print_bytes};
use clap::{Args, Command};
use clap_complete::{Shell, generate};

/// Options of `completions`.
#[derive(Args, Debug)]
pub(super) struct Options {
    /// The shell
    shell: Shell,
}

/// Prints the script for a program.
pub(super) fn run(options: &Options, mut program: Command) -> Result<(), Failure> {
    let name = program.get_name().to_owned();
    let mut script = Vec::new();
    generate(options.shell, &mut program, name, &mut script);
    print_bytes(&script)
}
