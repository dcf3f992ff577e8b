//! A sweep in parts: the job, the pictures of a part, and the last step.

use crate::cli::engine;
use crate::cli::farm::{
    JobKind, JobPlan, Measured, PartsRecord, WorkPart, is_there, no_parts, not_to_standard_output, remove_unfinished, write_job,
};
use crate::cli::output::PictureTarget;
use crate::cli::report::{Failure, number, print, say};
use crate::cli::sweep::cells::Cells;
use crate::cli::sweep::findings::Findings;
use crate::cli::sweep::sheet::Sheet;
use crate::cli::sweep::target::{NamePattern, SweepTarget};
use crate::cli::sweep::{Options, SweepOutput, make, memory_beside};
use illuminator::engine::Task;
use illuminator::lang::diagnostic::Diagnostic;
use illuminator::picture::{Bitmap, Format, ReadPictureError, ViewTransform, file_bytes, is_complete, read_bitmap};
use illuminator::workspace::project::Project;
use rayon::prelude::*;
use std::path::Path;
use std::time::Instant;

/// How many missing pictures are named.
const MOST_NAMED: usize = 5;

/// A sweep that is made in parts.
pub(super) struct SweepInParts<'w> {
    pub(super) options: &'w Options,
    pub(super) project: &'w Project,
    pub(super) cells: &'w Cells,
    /// When the command began.
    pub(super) start: Instant,
}

impl SweepInParts<'_> {
    fn view(&self) -> ViewTransform {
        self.options.picture.view(self.project.picture.view)
    }

    fn count(&self) -> u32 {
        // A sweep has a limited number of pictures.
        self.cells.cells.len() as u32
    }

    /// Where the pictures of parts are.
    fn pattern(&self, target: &SweepTarget) -> Result<NamePattern, Failure> {
        match target {
            SweepTarget::Numbered(pattern) => Ok(pattern.clone()),
            SweepTarget::Sheet(PictureTarget::File(path, _)) => Ok(NamePattern::of_parts(path)),
            SweepTarget::Sheet(PictureTarget::StandardOutput) => Err(not_to_standard_output()),
        }
    }

    fn record(&self) -> PartsRecord {
        let parts = self.cells.cells.iter().map(|cell| cell.set.clone()).collect();
        PartsRecord::new(self.project, self.options.picture.backend().name, self.view(), parts)
    }

    /// Measures the work, and writes the job.
    pub(super) fn write_job(&self, kind: JobKind, target: &SweepTarget) -> Result<(), Failure> {
        if self.options.json {
            return Err(Failure::command_line("`--json` lists pictures, and `--job` makes none"));
        }
        let pattern = self.pattern(target)?;
        let measured = engine::on_threads(&self.options.input.machine, || self.measure(&pattern))??;
        let plan = JobPlan { output: &self.options.output, count: self.count(), noun: "picture", measured };
        write_job(&self.options.farm, kind, &plan, &self.project.files)
    }

    /// How long the work takes here: one pass is traced, and one picture is made of it.
    fn measure(&self, pattern: &NamePattern) -> Result<Measured, Failure> {
        let passes = self.project.picture.passes();
        let engine = engine::engine(self.options.picture.backend(), &self.options.input.machine);
        let numbers = self.project.values.numbers();
        let read = self.start.elapsed();
        let tracing = Instant::now();
        let evaluator = engine.evaluator(&self.project.subject, numbers, &Task::UNWATCHED).map_err(engine::failed)?;
        let once = read + tracing.elapsed() * passes;
        let making = Instant::now();
        let mut frame = evaluator.frame(numbers);
        let frames = making.elapsed() * passes;
        let writing = Instant::now();
        frame.clean();
        let format = Format::of(&pattern.path(0)).unwrap_or(Format::Png);
        file_bytes(&frame, format, self.view()).map_err(|error| Failure::input(error.to_string()))?;
        Ok(Measured { once, each: frames + writing.elapsed() })
    }

    /// Makes the pictures of a part that are not there yet.
    pub(super) fn make_part(&self, part: WorkPart, target: &SweepTarget) -> Result<(), Failure> {
        let pattern = self.pattern(target)?;
        let first = || (0..self.count()).map(|index| pattern.path(index)).find(|path| path.exists());
        self.record().claim(&pattern.record(), first)?;
        let share: Vec<usize> = part.share(self.count()).map(|index| index as usize).collect();
        let is_there = |index: &usize| is_there(&pattern.path(*index as u32), self.project.picture.size);
        let there: Vec<bool> =
            engine::on_threads(&self.options.input.machine, || share.par_iter().map(is_there).collect::<Vec<_>>())?;
        let of = |wanted: bool| share.iter().zip(&there).filter(move |(_, there)| **there == wanted).map(|(index, _)| *index);
        let (kept, missing): (Vec<usize>, Vec<usize>) = (of(true).collect(), of(false).collect());
        let mut output = SweepOutput {
            project: self.project,
            cells: &self.cells.cells,
            target: SweepTarget::Numbered(pattern),
            bitmap: None,
            view: self.view(),
            sheet: None,
            findings: Findings::default(),
            seconds: Vec::new(),
        };
        if !missing.is_empty() {
            engine::on_threads(&self.options.input.machine, || make(self.options, &mut output, &missing))??;
        }
        output.findings.say_of_pictures(&self.cells.cells);
        if !self.options.json {
            print(&format!("part {part}: {} made, {} kept\n", number(missing.len(), "picture"), kept.len()))?;
        }
        output.list(self.options, &missing, &kept)
    }

    /// A picture that must be there, if its pixels are wanted.
    fn read(&self, path: &Path, is_wanted: bool) -> Result<Option<Bitmap>, ReadPictureError> {
        let size = self.project.picture.size;
        match is_wanted {
            true => read_bitmap(path, size).map(Some),
            false if is_complete(path, size)? => Ok(None),
            false => Err(ReadPictureError::Missing),
        }
    }

    /// Checks that all pictures are there, and puts them onto the sheet, if there is one.
    pub(super) fn merge(&self, target: SweepTarget, sheet: Option<Sheet>) -> Result<(), Failure> {
        let pattern = self.pattern(&target)?;
        if !self.record().check(&pattern.record())? {
            return Err(no_parts(pattern.folder()));
        }
        let mut bitmap = match &sheet {
            Some(sheet) => {
                let engine = engine::engine(self.options.picture.backend(), &self.options.input.machine);
                memory_beside(sheet, engine.memory())?;
                Some(sheet.draw())
            }
            None => None,
        };
        let mut missing = Vec::new();
        let indices: Vec<u32> = (0..self.count()).collect();
        for some in indices.chunks(AT_ONCE) {
            let read = |index: &u32| self.read(&pattern.path(*index), sheet.is_some());
            let pictures: Vec<_> =
                engine::on_threads(&self.options.input.machine, || some.par_iter().map(read).collect::<Vec<_>>())?;
            for (index, picture) in some.iter().zip(pictures) {
                match (picture, &sheet, &mut bitmap) {
                    (Ok(Some(picture)), Some(sheet), Some(bitmap)) => bitmap.copy(&picture, sheet.corner(*index as usize)),
                    (Ok(_), ..) => {}
                    (Err(error), ..) => missing.push(format!("`{}`: {error}", pattern.path(*index).display())),
                }
            }
        }
        if !missing.is_empty() {
            return Err(incomplete(&missing, self.count()));
        }
        let is_own = matches!(target, SweepTarget::Sheet(_));
        let output = SweepOutput {
            project: self.project,
            cells: &self.cells.cells,
            target,
            bitmap,
            view: self.view(),
            sheet,
            findings: Findings::default(),
            seconds: Vec::new(),
        };
        output.finish()?;
        if is_own {
            remove_unfinished(pattern.folder());
        }
        let all: Vec<usize> = (0..self.cells.cells.len()).collect();
        if !self.options.json {
            print(&format!("{}: {}\n", self.options.output.display(), number(self.cells.cells.len(), "picture")))?;
        }
        output.list(self.options, &[], &all)
    }
}

/// How many pictures are read at the same time.
const AT_ONCE: usize = 64;

/// The error that pictures are missing.
fn incomplete(missing: &[String], count: u32) -> Failure {
    missing.iter().take(MOST_NAMED).for_each(|picture| say(&Diagnostic::error(picture)));
    let message = format!("{} of {count} pictures are missing or damaged", missing.len());
    Failure::Input(Diagnostic::error(message).help("run the parts again: they keep what is complete"))
}
