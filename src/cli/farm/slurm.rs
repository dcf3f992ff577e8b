//! Jobs for Slurm: a script that submits itself as an array of parts, and once more for the last step.

use crate::cli::farm::description::JobDescription;
use crate::cli::report::Failure;
use illuminator::lang::diagnostic::Diagnostic;

/// The script of a job.
///
/// # Errors
/// An argument cannot be written.
pub(super) fn text(job: &JobDescription) -> Result<String, Failure> {
    let broken = |text: &&String| text.contains(['\n', '\r', '\0']);
    if let Some(argument) = job.arguments.iter().chain([&job.program, &job.folder]).find(broken) {
        let message = format!("{argument:?} has a line end, which the script cannot hold");
        return Err(Failure::CommandLine(Diagnostic::error(message)));
    }
    let arguments = job.arguments.iter().map(|argument| quoted(argument)).collect::<Vec<_>>().join(" ");
    let (parts, program, folder) = (job.parts, quoted(&job.program), quoted(&job.folder));
    Ok(format!(
        r#"#!/bin/bash
#SBATCH --job-name=illuminator
#SBATCH --output=illuminator-%A-%a.log
#SBATCH --requeue
# {parts} parts that run at the same time, and a last step that puts them together.
# `bash SCRIPT` submits both; options of sbatch go behind it: `bash SCRIPT --partition=cpu --time=10`.
# Parts that are complete are kept, so a job that failed is submitted again as it is.
# `bash SCRIPT --dry-run` does the same here, one part after the other, without Slurm.
set -euo pipefail

program=${{ILLUMINATOR:-{program}}}
folder={folder}
arguments=({arguments})

case "${{1:-}}" in
part) cd "$folder" && exec "$program" "${{arguments[@]}}" --part "$SLURM_ARRAY_TASK_ID/{parts}" ;;
merge) cd "$folder" && exec "$program" "${{arguments[@]}}" --merge ;;
--dry-run)
    cd "$folder"
    for part in $(seq {parts}); do
        "$program" "${{arguments[@]}}" --part "$part/{parts}"
    done
    exec "$program" "${{arguments[@]}}" --merge
    ;;
esac
# A worker runs a copy of this script, so the arguments are all that tells the steps apart.
job=$(sbatch --parsable --array=1-{parts} "$@" "$0" part)
wait_for=(--dependency="afterok:${{job%%;*}}" --kill-on-invalid-dep=yes --output=illuminator-%j.log)
last=$(sbatch --parsable "${{wait_for[@]}}" "$@" "$0" merge) || {{
    echo "the parts are job ${{job%%;*}}, but the last step was not submitted; when they have run: bash $0 merge" >&2
    exit 1
}}
echo "submitted: the parts are job ${{job%%;*}}, the last step is job ${{last%%;*}}"
"#
    ))
}

/// A word as the shell reads it.
pub(super) fn quoted(word: &str) -> String {
    format!("'{}'", word.replace('\'', r"'\''"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_are_quoted() {
        assert_eq!(quoted("ball.Cd=<1, 0, 0>"), "'ball.Cd=<1, 0, 0>'");
        assert_eq!(quoted("it's"), r"'it'\''s'");
    }
}
