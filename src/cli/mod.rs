//! The command line: its options, and the commands.
//!
//! A command loads its input ([`input`]), runs the engine on it ([`engine`]) and reports the result ([`report`]).
//! Nothing about pictures, formulas or scenes is decided here.

mod bench;
mod check;
mod completions;
mod draw;
mod dump;
mod engine;
mod export;
mod farm;
mod fit;
mod fmt;
mod hits;
mod import;
mod input;
mod list;
mod lsp;
mod man;
mod measure;
mod model;
mod options;
mod output;
mod plot;
#[cfg(feature = "window")]
mod preview;
mod progress;
mod protocol;
mod render;
mod report;
#[cfg(unix)]
mod signals;
mod sweep;
mod verify;

use clap::{CommandFactory, Parser, Subcommand};
use report::{Status, print, say_arguments};
use std::process::ExitCode;

/// A lighting workshop: type an illumination model and see its ray-traced picture.
///
/// In place of any input file, `preset:NAME` names a built-in one.
#[derive(Parser)]
#[command(name = "illuminator", bin_name = "illuminator", version, max_term_width = 100, after_long_help = list::listed())]
#[cfg_attr(not(feature = "window"), command(arg_required_else_help = true))]
struct Arguments {
    /// Without one, the window opens.
    #[command(subcommand)]
    command: Option<Command>,
}

#[derive(Subcommand)]
enum Command {
    /// Open the workshop window
    #[cfg(feature = "window")]
    Preview(preview::Options),
    /// Make a picture file
    Render(render::Options),
    /// Make pictures that differ in one or two values: a contact sheet, or numbered files
    Sweep(sweep::Options),
    /// Make a scene and a session, or a formula, of a model from another program
    Import(import::Options),
    /// Write a formula in another language: C, shading languages, MaterialX
    Export(export::Options),
    /// Draw what a formula or a material is: lobes, curves, slices, albedo
    Plot(plot::Options),
    /// Tell whether a formula or a material conserves energy, and more
    Measure(measure::Options),
    /// Find values with which a formula comes near to measured data or a picture
    Fit(fit::Options),
    /// Check formulas, scenes, sessions and material libraries for mistakes
    Check(check::Options),
    /// Give formulas and scenes a regular layout: lines, spaces, columns
    Fmt(fmt::Options),
    /// Answer an editor as a language server, on standard input and output
    Lsp,
    /// Compare the compiled code with the reference interpreter
    Verify(verify::Options),
    /// Measure how fast tracing, compiling and evaluating are
    Bench(bench::Options),
    /// Show the stages of a formula or a picture
    Dump(dump::Options),
    /// List the built-in sessions, formulas, scenes, materials, environments and meshes
    List,
    /// Print the reference of the formula language
    HelpLanguage,
    /// Print the manual page of the program, or write one for each command
    Man(man::Options),
    /// Print a script that lets a shell complete commands and options
    Completions(completions::Options),
}

impl Command {
    /// The command that runs if the command line names none.
    fn unnamed() -> Self {
        #[cfg(feature = "window")]
        return Command::Preview(preview::Options::default());
        // Without a window the argument parser requires a command.
        #[cfg(not(feature = "window"))]
        Command::HelpLanguage
    }
}

/// Runs the command that the command line names.
pub(crate) fn run() -> ExitCode {
    #[cfg(unix)]
    signals::handle();
    let arguments = match Arguments::try_parse() {
        Ok(arguments) => arguments,
        Err(error) => return ExitCode::from(say_arguments(error) as u8),
    };
    let outcome = match arguments.command.unwrap_or_else(Command::unnamed) {
        #[cfg(feature = "window")]
        Command::Preview(options) => preview::run(&options),
        Command::Render(options) => render::run(&options),
        Command::Sweep(options) => sweep::run(&options),
        Command::Import(options) => import::run(&options),
        Command::Export(options) => export::run(&options),
        Command::Plot(options) => plot::run(&options),
        Command::Measure(options) => measure::run(&options),
        Command::Fit(options) => fit::run(&options),
        Command::Check(options) => check::run(&options),
        Command::Fmt(options) => fmt::run(&options),
        Command::Lsp => lsp::run(),
        Command::Verify(options) => verify::run(&options),
        Command::Bench(options) => bench::run(&options),
        Command::Dump(options) => dump::run(&options),
        Command::List => list::run(),
        Command::HelpLanguage => print(&illuminator::lang::reference::reference()),
        Command::Man(options) => man::run(&options, Arguments::command()),
        Command::Completions(options) => completions::run(&options, Arguments::command()),
    };
    #[cfg(unix)]
    signals::end_if_received();
    let status = match outcome {
        Ok(()) => Status::Success,
        Err(failure) => {
            failure.report();
            failure.status()
        }
    };
    ExitCode::from(status as u8)
}
