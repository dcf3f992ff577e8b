//! The job of a command line: how many parts it has, and where it is written.

use crate::cli::farm::description::JobDescription;
use crate::cli::farm::{FarmOptions, openjd, slurm};
use crate::cli::output::{check_distinct, check_folder};
use crate::cli::report::{Failure, number, print, print_bytes};
use clap::ValueEnum;
use illuminator::files::{reason, replace_text};
use illuminator::lang::diagnostic::Diagnostic;
use illuminator::lang::display_text::one_line;
use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::time::Duration;

/// The kinds of jobs: a template of the Open Job Description, and an array script for Slurm.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(in crate::cli) enum JobKind {
    Openjd,
    Slurm,
}

impl JobKind {
    /// What the file's name ends with.
    fn suffix(self) -> &'static str {
        match self {
            JobKind::Openjd => "openjd.json",
            JobKind::Slurm => "slurm.sh",
        }
    }

    fn text(self, job: &JobDescription) -> Result<String, Failure> {
        match self {
            JobKind::Openjd => openjd::text(job),
            JobKind::Slurm => slurm::text(job),
        }
    }

    /// How the job is started.
    fn start(self, file: &str, job: &JobDescription) -> String {
        let file = plain_or_quoted(file);
        match self {
            JobKind::Openjd if job.is_beside => format!("openjd run {file}"),
            JobKind::Openjd => format!("openjd run {file} -p {}", plain_or_quoted(&format!("Folder={}", job.folder))),
            JobKind::Slurm => format!("bash {file}"),
        }
    }
}

/// The work that is done in parts.
pub(in crate::cli) struct JobPlan<'j> {
    /// What it makes, for instance `sheet.png`.
    pub(in crate::cli) output: &'j Path,
    /// How many things are shared out among the parts: pictures, or passes.
    pub(in crate::cli) count: u32,
    /// What one of them is called.
    pub(in crate::cli) noun: &'static str,
    /// How long they take here.
    pub(in crate::cli) measured: Measured,
}

/// How long work takes on this machine.
#[derive(Debug, Clone, Copy)]
pub(in crate::cli) struct Measured {
    /// What every part does again: reading, compiling, tracing.
    pub(in crate::cli) once: Duration,
    /// What one thing takes.
    pub(in crate::cli) each: Duration,
}

/// The work that is done again takes at most this share of a part, if the parts are not given.
const MOST_AGAIN: f64 = 0.1;

impl JobPlan<'_> {
    /// How many parts are best: as many as possible where the work that is done again is not more than its share.
    fn parts(&self) -> u32 {
        let Measured { once, each } = self.measured;
        let least = once.as_secs_f64() * (1.0 - MOST_AGAIN) / MOST_AGAIN / each.as_secs_f64().max(1e-6);
        // The cast saturates.
        (self.count / (least.ceil() as u32).max(1)).clamp(1, super::MOST_PARTS)
    }
}

/// Writes the job of a plan, and says how to start it.
///
/// # Errors
/// The job cannot say what the command line says, or it cannot be written.
pub(in crate::cli) fn write_job(options: &FarmOptions, kind: JobKind, plan: &JobPlan, inputs: &[PathBuf]) -> Result<(), Failure> {
    let failed = |what: &str, error: std::io::Error| Failure::input(format!("{what}: {}", reason(&error)));
    let here = std::env::current_dir().map_err(|error| failed("cannot find the current folder", error))?;
    let program = std::env::current_exe().map_err(|error| failed("cannot find this program", error))?;
    let file = options.job_file.clone().unwrap_or_else(|| default_file(plan.output, kind));
    check_distinct(&file, inputs)?;
    let parent = file.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let parts = options.parts.unwrap_or_else(|| plan.parts()).min(plan.count);
    let job = JobDescription {
        name: format!("illuminator {}", one_line(&plan.output.display().to_string())),
        parts,
        program: utf8(program.into_os_string())?,
        arguments: common_arguments(std::env::args_os().skip(1))?,
        is_beside: file == Path::new("-") || parent.canonicalize().is_ok_and(|parent| parent == here),
        folder: utf8(here.into_os_string())?,
    };
    let text = kind.text(&job)?;
    if file == Path::new("-") {
        return print_bytes(text.as_bytes());
    }
    check_folder(parent)?;
    replace_text(&file, &text).map_err(|error| failed(&format!("cannot write `{}`", file.display()), error))?;
    let JobPlan { count, noun, measured: Measured { once, each }, .. } = plan;
    let again = f64::from(parts) * once.as_secs_f64();
    let all = again + f64::from(*count) * each.as_secs_f64();
    print(&format!(
        "{}: {} in {}. On this machine a part begins with {:.2} s of reading and tracing, and a {noun} takes {:.3} s. \
         The parts take {all:.1} s in all, {:.0} % of it for tracing again.\nStart it with `{}`.\n",
        one_line(&file.display().to_string()),
        number(*count as usize, noun),
        number(parts as usize, "part"),
        once.as_secs_f64(),
        each.as_secs_f64(),
        100.0 * (again - once.as_secs_f64()) / all.max(1e-9),
        kind.start(&one_line(&file.display().to_string()), &job),
    ))
}

/// The file of a job for this output: its name without the place for a number.
fn default_file(output: &Path, kind: JobKind) -> PathBuf {
    let stem = output.file_stem().unwrap_or_default().to_string_lossy();
    let plain: String = match stem.split_once('%') {
        Some((before, behind)) => {
            before.to_owned() + behind.trim_start_matches(|c: char| c.is_ascii_digit()).trim_start_matches('d')
        }
        None => stem.into_owned(),
    };
    let name = plain.trim_end_matches(['-', '_', '.']);
    PathBuf::from(format!("{}.{}", if name.is_empty() { "pictures" } else { name }, kind.suffix()))
}

/// A word as a shell reads it, in quotation marks if it needs them.
fn plain_or_quoted(word: &str) -> String {
    let is_plain = word.chars().all(|c| c.is_ascii_alphanumeric() || "._-/=+:,".contains(c));
    if is_plain { word.to_owned() } else { slurm::quoted(word) }
}

/// Text of the system as UTF-8, which jobs are written in.
fn utf8(text: OsString) -> Result<String, Failure> {
    let message = |text: OsString| Failure::input(format!("`{}` is not UTF-8, so no job can name it", text.display()));
    text.into_string().map_err(message)
}

/// The options of a command that are only for writing the job, and take a value.
const OF_JOB: [&str; 3] = ["--job", "--job-file", "--parts"];

/// The arguments of the command line without those that are only for writing the job.
fn common_arguments(all: impl Iterator<Item = OsString>) -> Result<Vec<String>, Failure> {
    let mut common = Vec::new();
    let mut all = all.map(utf8);
    while let Some(argument) = all.next() {
        let argument = argument?;
        if OF_JOB.contains(&argument.as_str()) {
            all.next().transpose()?;
        } else if !OF_JOB.iter().any(|option| argument.strip_prefix(option).is_some_and(|rest| rest.starts_with('='))) {
            common.push(argument);
        }
    }
    if common.iter().any(|argument| argument == "--") {
        let error = Diagnostic::error("a job cannot be written for a command line with `--`");
        return Err(Failure::CommandLine(error.help("write `./` in front of a name that begins with `-`")));
    }
    Ok(common)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_cost_at_most_a_tenth_for_tracing_again() {
        let plan = |count, once, each| {
            let measured = Measured { once: Duration::from_millis(once), each: Duration::from_millis(each) };
            JobPlan { output: Path::new("o.png"), count, noun: "picture", measured }.parts()
        };
        // Ninety pictures take nine times as long as tracing.
        assert_eq!([plan(900, 1000, 100), plan(899, 1000, 100), plan(10, 1000, 100)], [10, 9, 1]);
        assert_eq!([plan(10_000, 0, 100), plan(5, 1, 1000), plan(100, 1000, 0)], [10_000, 5, 1]);
    }

    #[test]
    fn files_of_jobs_are_named_after_the_output() {
        let name = |output: &str| default_file(Path::new(output), JobKind::Openjd).display().to_string();
        assert_eq!([name("a/sheet.png"), name("a/frame-%04d.exr")], ["sheet.openjd.json", "frame.openjd.json"]);
        assert_eq!([name("%d.png"), name("x%%.png")], ["pictures.openjd.json", "x%.openjd.json"]);
        assert_eq!([plain_or_quoted("a.json"), plain_or_quoted("a b")], ["a.json", "'a b'"]);
    }

    #[test]
    fn options_for_writing_the_job_are_left_out() {
        let all = "sweep s.toml --job openjd --set ball.kd=1 --job-file=j.json -o out.png --parts 3 --vary ka=0..1:3";
        let common = common_arguments(all.split(' ').map(OsString::from)).unwrap();
        assert_eq!(common.join(" "), "sweep s.toml --set ball.kd=1 -o out.png --vary ka=0..1:3");
        assert!(common_arguments(["sweep", "--", "-s"].into_iter().map(OsString::from)).is_err());
    }
}
