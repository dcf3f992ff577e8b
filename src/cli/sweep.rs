//! `illuminator sweep`: pictures that differ in one or two values, on a contact sheet or in numbered files.
//!
//! Rays are traced once in each pass, because only values change from picture to picture.

mod cells;
mod findings;
mod lettering;
mod parts;
mod sheet;
mod target;

use crate::cli::engine;
use crate::cli::farm::FarmOptions;
use crate::cli::input::load;
use crate::cli::options::{InputOptions, PictureOptions, read, whole};
use crate::cli::output::PictureTarget;
use crate::cli::progress::Progress;
use crate::cli::report::{Failure, print_bytes, print_json, say};
use cells::{Cell, Cells};
use clap::Args;
use findings::Findings;
use illuminator::engine::Task;
use illuminator::lang::diagnostic::Diagnostic;
use illuminator::lang::memory_size::MemorySize;
use illuminator::picture::{Bitmap, Format, Frame, ViewTransform, bitmap_file_bytes, save, save_bitmap};
use illuminator::workspace::project::Project;
use illuminator::workspace::{Location, Variation, VariedValues};
use serde::Serialize;
use sheet::Sheet;
use std::collections::BTreeMap;
use std::fs;
use std::path::PathBuf;
use std::time::{Duration, Instant};
use target::SweepTarget;

/// Bytes for each pixel of a sheet: the sheet, and its file.
const BYTES_PER_SHEET_PIXEL: u64 = 6;

/// Options of `sweep`.
#[derive(Args, Debug)]
pub(super) struct Options {
    /// Vary a value in N equal steps: ball.kd=0..1:5, ka=0..0.5:3, *.kd=0..1:5 for all, ball.Cd=#ff0000..#0000ff:5,
    /// ball.Cd.r=0..1:5 for a component. Or give a list: ball.kd=0.1,0.5, ball.model=GGX,Beckmann, ball.model=all for
    /// all choices. Given twice, the first one changes from row to row
    #[arg(long, value_name = "OWNER.PARAM=A..B:N", value_parser = read::<Variation>, required = true)]
    vary: Vec<Variation>,
    /// Contact sheet (.png or .bmp; - writes PNG to standard output), or with a place for a number, as in
    /// pictures/%04d.png, numbered pictures (.png, .bmp or .exr)
    #[arg(long = "output", short, value_name = "OUT")]
    output: PathBuf,
    /// Pictures in a row of a contact sheet of one value
    #[arg(long, value_name = "N", value_parser = whole(1_u32..=1000), allow_negative_numbers = true)]
    columns: Option<u32>,
    /// Print what was made as JSON: for each picture its file, values and seconds
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    farm: FarmOptions,
    #[command(flatten)]
    input: InputOptions,
    #[command(flatten)]
    picture: PictureOptions,
}

/// A picture that was made.
#[derive(Serialize)]
struct Made<'s> {
    file: String,
    /// The varied values as they are used, by name.
    values: BTreeMap<&'s str, Numbers<'s>>,
    /// The given values of those that are not used as given, because they are outside their range or break an
    /// invariant.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    clamped: BTreeMap<&'s str, Numbers<'s>>,
    /// Arguments of `--set` that give the same picture.
    set: &'s [String],
    /// The time to evaluate and write it.
    seconds: f64,
    /// Whether it was there already.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    kept: bool,
    /// Its place on a contact sheet: left, top, width and height in pixels.
    #[serde(skip_serializing_if = "Option::is_none")]
    place: Option<[u32; 4]>,
}

/// A value in JSON: a number, or several.
#[derive(Serialize)]
#[serde(untagged)]
enum Numbers<'n> {
    One(f32),
    Several(&'n [f32]),
}

impl<'n> Numbers<'n> {
    fn new(numbers: &'n [f32]) -> Self {
        match numbers {
            [number] => Numbers::One(*number),
            numbers => Numbers::Several(numbers),
        }
    }
}

fn by_name(values: &[(String, Vec<f32>)]) -> BTreeMap<&str, Numbers<'_>> {
    values.iter().map(|(name, numbers)| (name.as_str(), Numbers::new(numbers))).collect()
}

/// Makes the pictures.
pub(super) fn run(options: &Options) -> Result<(), Failure> {
    let start = Instant::now();
    let target = SweepTarget::new(&options.output)?;
    check_options(options, &target)?;
    let input = load(&options.input, &options.picture.passes)?;
    let varied = resolve(&options.vary, &input)?;
    let count = cells::count(&varied)?;
    target.check(count, &input.files)?;
    check_numbers(&input, count, options)?;
    let cells = Cells::new(&input, &varied)?;
    let sheet = match target {
        SweepTarget::Sheet(_) => Some(Sheet::new(&title(&input), &cells.parameters, input.picture.size, options.columns)?),
        SweepTarget::Numbered(_) => None,
    };
    cells.warn();
    let work = parts::SweepInParts { options, project: &input, cells: &cells, start };
    if let Some(kind) = options.farm.job {
        return work.write_job(kind, &target);
    }
    if options.farm.merge {
        return work.merge(target, sheet);
    }
    if let Some(part) = options.farm.part {
        return work.make_part(part, &target);
    }
    let mut output = SweepOutput {
        project: &input,
        cells: &cells.cells,
        target,
        bitmap: None,
        view: options.picture.view(input.picture.view),
        sheet,
        findings: Findings::default(),
        seconds: Vec::new(),
    };
    let all: Vec<usize> = (0..cells.cells.len()).collect();
    if let SweepTarget::Numbered(pattern) = &output.target {
        // It would say that these pictures are parts of something else. If there is none, there is nothing to remove.
        let _ = fs::remove_file(pattern.record());
    }
    engine::on_threads(&options.input.machine, || make(options, &mut output, &all))??;
    output.findings.say(&cells.cells);
    output.finish()?;
    output.list(options, &all, &[])
}

/// Refuses options that do not go together, and warns of those without an effect.
fn check_options(options: &Options, target: &SweepTarget) -> Result<(), Failure> {
    let refuse = |message: &str, help: &str| Err(Failure::CommandLine(Diagnostic::error(message).help(help)));
    if options.vary.len() > 2 {
        return refuse("at most two values can be varied", "`--set` sets the others");
    }
    match target {
        SweepTarget::Sheet(PictureTarget::StandardOutput) if options.json => {
            return refuse("standard output cannot take both the sheet and the list", "give `-o` a file, or leave out `--json`");
        }
        SweepTarget::Sheet(_) if options.vary.len() == 1 || options.columns.is_none() => {}
        SweepTarget::Sheet(_) => {
            return refuse("the columns of a table are those of the second `--vary`", "leave out `--columns`");
        }
        SweepTarget::Numbered(_) if options.columns.is_some() => {
            return refuse("numbered pictures have no columns", "leave out `--columns`, or the `%` in the name");
        }
        SweepTarget::Numbered(pattern) => {
            if Format::of(&pattern.path(0)) == Some(Format::Exr) {
                options.picture.warn_of_linear_files();
            }
        }
    }
    Ok(())
}

/// The varied values on the formula and the scene. All mistakes are reported.
fn resolve(given: &[Variation], project: &Project) -> Result<Vec<VariedValues>, Failure> {
    let (mut varied, mut errors) = (Vec::<VariedValues>::new(), Vec::new());
    for variation in given {
        match variation.resolve(&project.values) {
            Ok(values) => match varied.iter().find(|before| values.covers(before)) {
                Some(before) if before.covers(&values) => errors.push(format!("`{}` is varied twice", values.label())),
                Some(before) => {
                    let (label, before) = (values.label(), before.label());
                    errors.push(format!("--vary {variation}: `{label}` includes `{before}`, which would have no effect"));
                }
                None => varied.push(values),
            },
            Err(error) => errors.push(format!("--vary {variation}: {error}")),
        }
    }
    let mut errors = errors.into_iter().map(Diagnostic::error);
    let Some(last) = errors.next_back() else { return Ok(varied) };
    errors.for_each(|error| say(&error));
    Err(Failure::CommandLine(last))
}

/// Checks that the values of all pictures fit into the memory.
fn check_numbers(project: &Project, count: u32, options: &Options) -> Result<(), Failure> {
    let machine = &options.input.machine;
    let needed = u64::from(count) * size_of_val(project.values.numbers()) as u64;
    let allowed = engine::engine(options.picture.backend(), machine).memory();
    if needed <= allowed {
        return Ok(());
    }
    let (needed, allowed) = (MemorySize(needed), MemorySize(allowed));
    let message = format!("the values of {count} pictures take {needed} of memory, and {allowed} may be used");
    Err(Failure::Input(Diagnostic::error(message).help("`--memory SIZE` allows more")))
}

/// The title of a sheet.
fn title(project: &Project) -> String {
    let name = |location: &Location| match location {
        Location::Preset(name) => name.clone(),
        Location::File(path) => path.file_name().unwrap_or_default().display().to_string(),
    };
    let text = format!("{} on {}", name(&project.formula_location), name(&project.scene_location));
    illuminator::lang::display_text::one_line(&text)
}

/// The memory that is left beside a contact sheet, in bytes.
fn memory_beside(sheet: &Sheet, allowed: u64) -> Result<u64, Failure> {
    let [width, height] = sheet.size().map(u64::from);
    let needed = width * height * BYTES_PER_SHEET_PIXEL;
    allowed.checked_sub(needed).ok_or_else(|| {
        let (needed, allowed) = (MemorySize(needed), MemorySize(allowed));
        let message = format!("the contact sheet takes {needed} of memory, and {allowed} may be used");
        Failure::Input(Diagnostic::error(message).help("`--memory SIZE` allows more"))
    })
}

/// Makes some of the pictures, by index, and passes them on.
fn make(options: &Options, output: &mut SweepOutput, which: &[usize]) -> Result<(), Failure> {
    let (project, cells) = (output.project, output.cells);
    let (machine, picture) = (&options.input.machine, &options.picture);
    let mut engine = engine::engine(picture.backend(), machine);
    if let Some(sheet) = &output.sheet {
        let memory = memory_beside(sheet, engine.memory())?;
        engine = engine.with_memory(memory);
        output.bitmap = Some(sheet.draw());
    }
    let passes = project.picture.passes();
    let what = match which.len() {
        1 => "1 picture".to_owned(),
        count => format!("{count} pictures"),
    };
    let progress = Progress::of_passes(what, passes);
    let tell = |share: f64| progress.tell(share);
    let numbers: Vec<&[f32]> = which.iter().map(|index| cells[*index].numbers.as_slice()).collect();
    engine
        .pictures(&project.subject, &numbers, passes, &Task::watched(&tell), |position, frame, time| {
            Ok(output.take(which[position], frame, time)?)
        })
        .map_err(|problem: Problem| problem.0)
}

/// A failure of the engine or of writing a picture.
struct Problem(Failure);

impl From<illuminator::engine::EngineError> for Problem {
    fn from(error: illuminator::engine::EngineError) -> Self {
        Problem(engine::failed(error))
    }
}

impl From<Failure> for Problem {
    fn from(failure: Failure) -> Self {
        Problem(failure)
    }
}

/// Takes the pictures as they are made.
struct SweepOutput<'o> {
    project: &'o Project,
    cells: &'o [Cell],
    target: SweepTarget<'o>,
    /// The places on the contact sheet, if there is one.
    sheet: Option<Sheet>,
    /// The contact sheet with the pictures so far.
    bitmap: Option<Bitmap>,
    view: ViewTransform,
    findings: Findings,
    /// How long each picture took, in the order in which they were made.
    seconds: Vec<f64>,
}

impl SweepOutput<'_> {
    /// Puts a picture onto the sheet, or writes it.
    fn take(&mut self, index: usize, mut frame: Frame, time: Duration) -> Result<(), Failure> {
        let start = Instant::now();
        self.findings.look(self.project, &self.cells[index], index, &frame, self.view);
        frame.clean();
        match (&self.target, &self.sheet, &mut self.bitmap) {
            (SweepTarget::Numbered(pattern), ..) => {
                save(&pattern.path(index as u32), &frame, self.view).map_err(|message| {
                    let error = Diagnostic::error(message);
                    Failure::Input(match self.seconds.len() {
                        0 => error,
                        1 => error.help("the picture before it is complete"),
                        made => error.help(format!("the {made} pictures before it are complete")),
                    })
                })?;
            }
            (SweepTarget::Sheet(_), Some(sheet), Some(bitmap)) => {
                bitmap.copy(&Bitmap::new(&frame, self.view), sheet.corner(index));
            }
            (SweepTarget::Sheet(_), ..) => {}
        }
        self.findings.compare(frame);
        self.seconds.push((time + start.elapsed()).as_secs_f64());
        Ok(())
    }

    /// Writes the sheet, if there is one.
    fn finish(&self) -> Result<(), Failure> {
        match (&self.target, &self.bitmap) {
            (SweepTarget::Sheet(PictureTarget::File(path, _)), Some(bitmap)) => save_bitmap(path, bitmap).map_err(Failure::input),
            (SweepTarget::Sheet(PictureTarget::StandardOutput), Some(bitmap)) => {
                let bytes = bitmap_file_bytes(bitmap, Format::Png);
                print_bytes(&bytes.map_err(|error| Failure::input(format!("cannot write the sheet: {error}")))?)
            }
            (SweepTarget::Numbered(_) | SweepTarget::Sheet(_), _) => Ok(()),
        }
    }

    /// Prints the list of pictures, if it is wanted: those that were made, in this order, among others that were there.
    fn list(&self, options: &Options, made: &[usize], kept: &[usize]) -> Result<(), Failure> {
        if !options.json {
            return Ok(());
        }
        let new = made.iter().zip(&self.seconds).map(|(index, seconds)| self.made(*index, *seconds, false));
        let mut all: Vec<_> = new.chain(kept.iter().map(|index| self.made(*index, 0.0, true))).collect();
        all.sort_by_key(|(index, _)| *index);
        print_json(&all.into_iter().map(|(_, made)| made).collect::<Vec<_>>())
    }

    /// What the list says about a picture, behind its index.
    fn made(&self, index: usize, seconds: f64, kept: bool) -> (usize, Made<'_>) {
        let [width, height] = self.project.picture.size;
        let cell = &self.cells[index];
        let file = match &self.target {
            SweepTarget::Numbered(pattern) => pattern.path(index as u32).display().to_string(),
            SweepTarget::Sheet(PictureTarget::File(path, _)) => path.display().to_string(),
            SweepTarget::Sheet(PictureTarget::StandardOutput) => "-".to_owned(),
        };
        let place = self.sheet.as_ref().map(|sheet| {
            let [x, y] = sheet.corner(index);
            [x, y, width, height]
        });
        let (values, clamped) = (by_name(&cell.used), by_name(&cell.clamped));
        (index, Made { file, values, clamped, set: &cell.set, seconds, kept, place })
    }
}
