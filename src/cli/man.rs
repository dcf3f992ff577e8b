//! `illuminator man`: the manual page of the program, made of the same descriptions as `--help`.

use crate::cli::list;
use crate::cli::output::check_folder;
use crate::cli::report::{Failure, print_bytes};
use clap::{Args, Command};
use clap_mangen::Man;
use clap_mangen::roff::{Roff, roman};
use illuminator::files::{reason, replace_file};
use illuminator::lang::diagnostic::{Diagnostic, nearest};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// Options of `man`.
#[derive(Args, Debug)]
pub(super) struct Options {
    /// Print the page of this command alone, such as render
    #[arg(value_name = "COMMAND", conflicts_with = "output")]
    command: Option<String>,
    /// Write a file for the program and one for each command into this folder, such as illuminator-render.1
    #[arg(long, short, value_name = "DIR")]
    output: Option<PathBuf>,
}

/// Prints or writes the pages of a program and its commands.
pub(super) fn run(options: &Options, program: Command) -> Result<(), Failure> {
    let mut program = program.disable_help_subcommand(true);
    program.build();
    match (&options.command, &options.output) {
        (Some(name), _) => match program.find_subcommand(name) {
            Some(command) => print_bytes(&text(|page| page_of_command(command, page))?),
            None => Err(Failure::CommandLine(unknown(name, &program))),
        },
        (None, Some(folder)) => {
            check_folder(folder)?;
            write(folder, &program, &text(|page| page_of_program(&program, page))?)?;
            program
                .get_subcommands()
                .try_for_each(|command| write(folder, command, &text(|page| page_of_command(command, page))?))
        }
        (None, None) => print_bytes(&text(|page| whole_manual(&program, page))?),
    }
}

/// The error that there is no command of this name.
fn unknown(name: &str, program: &Command) -> Diagnostic {
    let names: Vec<&str> = program.get_subcommands().map(Command::get_name).collect();
    let error = Diagnostic::error(format!("there is no command `{name}`"));
    match nearest(name, names.iter().copied()) {
        Some(near) => error.help(format!("did you mean `{near}`?")),
        None => error.help(format!("the commands are {}", names.join(", "))),
    }
}

/// A page as text. Characters beyond ASCII are written as troff reads them in every locale.
fn text(write: impl Fn(&mut Vec<u8>) -> io::Result<()>) -> Result<Vec<u8>, Failure> {
    let mut page = Vec::new();
    write(&mut page).map_err(|error| Failure::input(format!("cannot make the page: {}", reason(&error))))?;
    let mut text = String::new();
    for character in String::from_utf8_lossy(&page).chars() {
        match character.is_ascii() {
            true => text.push(character),
            false => text.push_str(&format!("\\[u{:04X}]", u32::from(character))),
        }
    }
    Ok(text.into_bytes())
}

/// Writes the page of a command to a file of its name.
fn write(folder: &Path, command: &Command, text: &[u8]) -> Result<(), Failure> {
    let path = folder.join(man(command).get_filename());
    replace_file(&path, |writer| writer.write_all(text))
        .map_err(|error| Failure::input(format!("cannot write `{}`: {}", path.display(), reason(&error))))
}

/// The parts of the page of a command. Every page names the version of the program.
fn man(command: &Command) -> Man {
    Man::new(command.clone()).source(concat!("illuminator ", env!("CARGO_PKG_VERSION")))
}

/// The page of a command.
fn page_of_command(command: &Command, page: &mut Vec<u8>) -> io::Result<()> {
    let man = man(command);
    man.render_title(page)?;
    man.render_name_section(page)?;
    man.render_synopsis_section(page)?;
    man.render_description_section(page)?;
    man.render_options_section(page)
}

/// The page of the program. It names the commands.
fn page_of_program(program: &Command, page: &mut Vec<u8>) -> io::Result<()> {
    page_of_command(program, page)?;
    man(program).render_subcommands_section(page)?;
    sections_at_the_end(page)
}

/// One page with the options of every command.
fn whole_manual(program: &Command, page: &mut Vec<u8>) -> io::Result<()> {
    page_of_command(program, page)?;
    for command in program.get_subcommands() {
        let mut heading = Roff::new();
        heading.control("SH", [command.get_bin_name().unwrap_or(command.get_name()).to_uppercase().as_str()]);
        heading.to_writer(page)?;
        let man = man(command);
        let mut parts = Vec::new();
        man.render_description_section(&mut parts)?;
        man.render_synopsis_section(&mut parts)?;
        man.render_options_section(&mut parts)?;
        for line in String::from_utf8_lossy(&parts).lines().filter(|line| *line != ".SH DESCRIPTION") {
            // The sections of a command are below its heading.
            match line.strip_prefix(".SH ") {
                Some(title) => writeln!(page, ".SS {title}")?,
                None => writeln!(page, "{line}")?,
            }
        }
    }
    sections_at_the_end(page)
}

/// The exit status, and the built-in files.
fn sections_at_the_end(page: &mut Vec<u8>) -> io::Result<()> {
    let mut roff = Roff::new();
    roff.control("SH", ["EXIT STATUS"]);
    roff.text([roman("0 if the command did its work, 1 if the input was wrong, 2 if the command line was wrong.")]);
    roff.control("SH", ["BUILT-IN FILES"]);
    // Lines are kept as they are.
    roff.control("nf", []);
    for line in list::listed().lines() {
        roff.text([roman(line)]);
    }
    roff.control("fi", []);
    roff.to_writer(page)
}
