//! Work for many machines: jobs for render farms, the parts that their workers make, and the last step.
//!
//! The same command line does all three. With `--job` it writes a job instead of pictures, with `--part I/N` it makes
//! one part, and with `--merge` it puts the parts together. No scheduler is here: that is the farm's.

mod description;
mod job;
mod openjd;
mod part;
mod record;
mod slurm;

use crate::cli::options::{read, whole};
use crate::cli::report::{Failure, warn};
use clap::Args;
use illuminator::files::UNFINISHED_PREFIX;
use illuminator::lang::diagnostic::Diagnostic;
use illuminator::picture::is_complete;
pub(super) use job::{JobKind, JobPlan, Measured, write_job};
pub(super) use part::{MOST_PARTS, WorkPart};
pub(super) use record::PartsRecord;
use std::fs;
use std::path::{Path, PathBuf};

/// The heading of these options in help texts.
const FARMS: &str = "Render farms";

/// What a farm does with a command.
#[derive(Args, Debug, Default)]
pub(super) struct FarmOptions {
    /// Write a job for a render farm instead of making pictures: openjd is an Open Job Description template, slurm a
    /// script for Slurm. Its workers make parts, and its last step merges them
    #[arg(long, help_heading = FARMS, value_enum, value_name = "KIND", conflicts_with_all = ["part", "merge"])]
    pub(super) job: Option<JobKind>,
    /// File of the job; - is standard output [default: the name of the output with .openjd.json or .slurm.sh, here]
    #[arg(long, help_heading = FARMS, value_name = "FILE", requires = "job")]
    pub(super) job_file: Option<PathBuf>,
    /// Number of parts of the job [default: as many as cost at most a tenth of the work for tracing again]
    #[arg(long, help_heading = FARMS, value_name = "N", value_parser = whole(1..=MOST_PARTS), requires = "job")]
    pub(super) parts: Option<u32>,
    /// Make part I of N, as a worker does; what is there and complete is kept
    #[arg(long, help_heading = FARMS, value_name = "I/N", value_parser = read::<WorkPart>, conflicts_with = "merge")]
    pub(super) part: Option<WorkPart>,
    /// Put the parts together, as the last step of a job does
    #[arg(long, help_heading = FARMS)]
    pub(super) merge: bool,
}

/// Removes what workers that were killed left in the folder of the parts.
pub(super) fn remove_unfinished(folder: &Path) {
    let Ok(entries) = fs::read_dir(folder) else { return };
    let left = entries.flatten().filter(|entry| entry.file_name().to_string_lossy().starts_with(UNFINISHED_PREFIX));
    // What cannot be removed does no harm.
    left.for_each(|entry| drop(fs::remove_file(entry.path())));
}

/// Whether a picture of this size is there, and complete. A damaged one is made again.
pub(super) fn is_there(path: &Path, size: [u32; 2]) -> bool {
    is_complete(path, size).unwrap_or_else(|error| {
        warn(format!("`{}` is made again: {error}", path.display()));
        false
    })
}

/// The error that nothing was made that could be merged.
pub(super) fn no_parts(folder: &Path) -> Failure {
    let shown = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    let error = Diagnostic::error(format!("there are no parts in `{}`", shown.display()));
    Failure::Input(error.help("`--part I/N` makes part I of N, with the same command line otherwise"))
}

/// The error that parts have no names.
pub(super) fn not_to_standard_output() -> Failure {
    let error = Diagnostic::error("parts are written to files, not to standard output");
    Failure::CommandLine(error.help("give `-o` the name of a file"))
}
