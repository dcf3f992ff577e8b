//! A picture of many passes in parts: each part is the mean of some passes, and the last step takes the mean of all.
//!
//! A part is an OpenEXR file of linear numbers, named by its first and last pass, which are counted from 1.

use crate::cli::engine;
use crate::cli::farm::{
    JobKind, JobPlan, Measured, PartsRecord, WorkPart, is_there, no_parts, not_to_standard_output, remove_unfinished, write_job,
};
use crate::cli::output::PictureTarget;
use crate::cli::progress::Progress;
use crate::cli::render::Options;
use crate::cli::report::{Failure, print};
use illuminator::engine::{Subject, Task};
use illuminator::files::reason;
use illuminator::lang::diagnostic::Diagnostic;
use illuminator::picture::{Frame, ViewTransform, read_linear, save};
use illuminator::workspace::project::Project;
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// A picture whose passes are shared out.
pub(super) struct PassesInParts<'p> {
    options: &'p Options,
    project: &'p Project,
    /// The folder of the parts.
    folder: PathBuf,
}

impl<'p> PassesInParts<'p> {
    /// The parts of a picture that is written to a file.
    ///
    /// # Errors
    /// It is written to standard output.
    pub(super) fn new(options: &'p Options, project: &'p Project, target: &PictureTarget) -> Result<Self, Failure> {
        let PictureTarget::File(path, _) = target else {
            return Err(not_to_standard_output());
        };
        let mut folder = path.file_stem().unwrap_or_default().to_owned();
        folder.push("-passes");
        Ok(Self { options, project, folder: path.with_file_name(folder) })
    }

    fn passes(&self) -> u32 {
        self.project.picture.passes()
    }

    fn record(&self) -> PartsRecord {
        // How linear colours become bytes does not matter for parts.
        PartsRecord::new(self.project, self.options.picture.backend().name, ViewTransform::default(), Vec::new())
    }

    fn record_path(&self) -> PathBuf {
        self.folder.join("parts.json")
    }

    /// The file of the mean of these passes, counted from 0.
    fn path(&self, passes: &Range<u32>) -> PathBuf {
        self.folder.join(format!("{:05}-{:05}.exr", passes.start + 1, passes.end))
    }

    /// The passes of a file, if it is a part.
    fn passes_of(path: &Path) -> Option<Range<u32>> {
        let (first, last) = path.file_name()?.to_str()?.strip_suffix(".exr")?.split_once('-')?;
        let (first, last) = (first.parse::<u32>().ok()?.checked_sub(1)?, last.parse().ok()?);
        (first < last).then_some(first..last)
    }

    /// The passes of all parts that are there.
    fn parts(&self) -> Result<Vec<Range<u32>>, Failure> {
        let failed = |error| Failure::input(format!("cannot read `{}`: {}", self.folder.display(), reason(&error)));
        let files = fs::read_dir(&self.folder).map_err(failed)?.flatten().map(|entry| entry.path());
        Ok(files.filter_map(|path| Self::passes_of(&path).filter(|passes| self.path(passes) == path)).collect())
    }

    /// Measures the work, and writes the job.
    pub(super) fn write_job(&self, kind: JobKind, start: Instant) -> Result<(), Failure> {
        if self.passes() == 1 {
            let error = Diagnostic::error("a picture of one pass has no parts");
            return Err(Failure::CommandLine(error.help("`--samples N` takes the mean of N passes")));
        }
        let machine = &self.options.input.machine;
        let once = start.elapsed();
        let pass = Instant::now();
        engine::on_threads(machine, || self.mean(0..1, &Progress::new("measuring")))??;
        let measured = Measured { once, each: pass.elapsed() };
        let plan = JobPlan { output: &self.options.output, count: self.passes(), noun: "pass", measured };
        write_job(&self.options.farm, kind, &plan, &self.project.files)
    }

    /// The mean of some passes.
    fn mean(&self, passes: Range<u32>, progress: &Progress) -> Result<Frame, Failure> {
        let engine = engine::engine(self.options.picture.backend(), &self.options.input.machine);
        let subject = &self.project.subject;
        let subject = Subject { view: subject.view.with_pass(passes.start), ..subject.clone() };
        let tell = |share: f64| progress.tell(share);
        let numbers = self.project.values.numbers();
        engine.picture(&subject, numbers, passes.len() as u32, &Task::watched(&tell)).map_err(engine::failed)
    }

    /// Makes a part, if it is not there yet.
    pub(super) fn make_part(&self, part: WorkPart) -> Result<(), Failure> {
        self.record().claim(&self.record_path(), || self.parts().ok()?.first().map(|passes| self.path(passes)))?;
        let passes = part.share(self.passes());
        if passes.is_empty() {
            return print(&format!("part {part}: nothing to do, because there are more parts than passes\n"));
        }
        let path = self.path(&passes);
        let there = is_there(&path, self.project.picture.size);
        if !there {
            let progress = Progress::of_passes(format!("part {part}"), passes.len() as u32);
            let frame = engine::on_threads(&self.options.input.machine, || self.mean(passes.clone(), &progress))??;
            save(&path, &frame, ViewTransform::default()).map_err(Failure::input)?;
        }
        let done = if there { "kept" } else { "made" };
        let which = match passes.len() {
            1 => format!("pass {}", passes.end),
            _ => format!("passes {} to {}", passes.start + 1, passes.end),
        };
        print(&format!("part {part}: {which}, {done}\n"))
    }

    /// The mean of all parts.
    pub(super) fn merge(&self) -> Result<Frame, Failure> {
        if !self.record().check(&self.record_path())? {
            return Err(no_parts(&self.folder));
        }
        let known = self.parts()?;
        let [width, height] = self.project.picture.size;
        let mut sum = vec![[0.0_f64; 3]; width as usize * height as usize];
        for passes in self.chain(&known).map_err(|done| self.missing(done, "is missing"))? {
            let unusable = |error| self.missing(passes.start, &format!("is unusable: {error}"));
            let part = read_linear(&self.path(passes), [width, height]).map_err(unusable)?;
            let share = f64::from(passes.len() as u32) / f64::from(self.passes());
            for (sum, colour) in sum.iter_mut().zip(&part.linear) {
                sum.iter_mut().zip(colour).for_each(|(sum, number)| *sum += share * f64::from(*number));
            }
        }
        remove_unfinished(&self.folder);
        Ok(Frame { width, height, linear: sum.into_iter().map(|colour| colour.map(|number| number as f32)).collect() })
    }

    /// Parts that are all passes together, in order. Parts of jobs with other numbers of parts may be among those that
    /// are known.
    ///
    /// # Errors
    /// There are none. The error is a pass, counted from 0, at which no part that is needed begins.
    fn chain<'k>(&self, known: &'k [Range<u32>]) -> Result<Vec<&'k Range<u32>>, u32> {
        let mut last_first: Vec<&Range<u32>> = known.iter().filter(|passes| passes.end <= self.passes()).collect();
        last_first.sort_by_key(|passes| std::cmp::Reverse((passes.start, passes.end)));
        // By its first pass, a part behind which parts go on to the last pass.
        let mut complete: BTreeMap<u32, &Range<u32>> = BTreeMap::new();
        for passes in &last_first {
            if passes.end == self.passes() || complete.contains_key(&passes.end) {
                complete.entry(passes.start).or_insert(passes);
            }
        }
        let mut chain = Vec::new();
        let mut done = 0;
        while let Some(passes) = complete.get(&done) {
            chain.push(*passes);
            done = passes.end;
        }
        if done == self.passes() {
            return Ok(chain);
        }
        // The last pass up to which parts lead from the first one.
        let mut reached = BTreeSet::from([0]);
        for passes in last_first.iter().rev().filter(|passes| passes.end < self.passes()) {
            if reached.contains(&passes.start) {
                reached.insert(passes.end);
            }
        }
        Err(reached.last().copied().unwrap_or_default())
    }

    fn missing(&self, pass: u32, why: &str) -> Failure {
        let error = Diagnostic::error(format!("the part that begins with pass {} {why}", pass + 1));
        Failure::Input(error.help("run the parts again: they keep what is complete"))
    }
}
