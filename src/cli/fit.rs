//! `illuminator fit`: values of parameters with which a formula comes near to measured reflectance, or its picture to
//! another picture.

mod charts;
mod report;

use crate::cli::engine::{self, on_threads};
use crate::cli::input::load;
use crate::cli::model::{owned, owner_named};
use crate::cli::options::{InputOptions, PassOptions, read, whole};
use crate::cli::output::{check_distinct, check_file};
use crate::cli::progress::Progress;
use crate::cli::report::{Failure, print, print_json, warn};
use clap::Args;
use clap::builder::{PossibleValue, PossibleValuesParser};
use illuminator::backends::DEFAULT;
use illuminator::engine::Task;
use illuminator::files::Readable;
use illuminator::fit::directions::{LARGEST_ANGLE, PAIR_ANGLES, PAIR_COUNTS, USUAL_PAIRS};
use illuminator::fit::metric::{METRICS, Metric};
use illuminator::fit::request::{self, FittedOwners, FreeName, FreeNameError};
use illuminator::fit::samples::{FitSample, samples_of_material};
use illuminator::fit::solve::{FitOptions, FitProgress, Solution, solve};
use illuminator::fit::unknowns::Unknowns;
use illuminator::lang::diagnostic::Diagnostic;
use illuminator::lang::display_text::one_line;
use illuminator::lang::variables::Owner;
use illuminator::measured::{FORMATS, MeasuredMaterial, Measurement};
use illuminator::picture::{Format, Frame, read_picture};
use illuminator::workspace::assignment::Assignment;
use illuminator::workspace::project::Project;
use illuminator::workspace::session::Session;
use illuminator::workspace::{FileKind, Location, OwnerId, Values, kind_of_file};
use report::FitReport;
use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Instant;

/// Options of `fit`.
#[derive(Args, Debug, Clone)]
pub(super) struct Options {
    #[command(flatten)]
    input: InputOptions,
    #[command(flatten)]
    passes: PassOptions,
    /// What the formula is to come near to: a measured material (.binary of MERL, .bsdf of RGL), a list of samples
    /// (.csv), or a picture of the same scene (.exr, .png or .bmp)
    #[arg(long, value_name = "FILE")]
    to: PathBuf,
    /// Parameters that may move, as in kd,h or ball.kd=0..0.5 [default: the smooth ones of the body]
    #[arg(long, value_name = "NAMES", value_parser = read::<FreeName>, value_delimiter = ',')]
    free: Vec<FreeName>,
    /// The body whose values are fitted [default: the first one; of a formula alone, a ball]
    #[arg(long, value_name = "NAME")]
    body: Option<String>,
    /// The light whose values count [default: the first one]
    #[arg(long, value_name = "NAME")]
    light: Option<String>,
    /// What is compared [default: cosine; for pictures the colours themselves, or log(1 + colour)]
    #[arg(long, value_name = "NAME", value_parser = metrics())]
    metric: Option<String>,
    /// Starts: the values at hand, and others spread over the ranges, 1 to 1000
    #[arg(long, value_name = "N", value_parser = whole(1_u32..=1000), default_value = "8", allow_negative_numbers = true)]
    starts: u32,
    #[arg(long, value_name = "N", value_parser = whole(PAIR_COUNTS), allow_negative_numbers = true,
        help = format!("Pairs of directions at which a measured material is compared, {} to {} [default: {USUAL_PAIRS}]",
            PAIR_COUNTS.start(), PAIR_COUNTS.end()))]
    directions: Option<usize>,
    #[arg(long, value_name = "DEGREES", value_parser = whole(PAIR_ANGLES), allow_negative_numbers = true,
        help = format!("Compare a measured material up to this angle from the normal, in degrees, {} to {} \
            [default: {LARGEST_ANGLE}]", PAIR_ANGLES.start(), PAIR_ANGLES.end()))]
    within: Option<u32>,
    /// Write a session with the fitted values
    #[arg(long = "output", short, value_name = "SESSION.toml")]
    output: Option<PathBuf>,
    /// Draw the data, and the formula before and after (.png or .svg)
    #[arg(long, value_name = "CHART")]
    chart: Option<PathBuf>,
    /// Print the result as JSON
    #[arg(long)]
    json: bool,
}

fn metrics() -> PossibleValuesParser {
    PossibleValuesParser::new(METRICS.iter().map(|metric| PossibleValue::new(metric.name).help(metric.doc)))
}

/// What a formula is fitted to.
enum FitTarget {
    Material(Arc<MeasuredMaterial>, Vec<FitSample>),
    Samples(Vec<FitSample>),
    Picture(illuminator::fit::picture::TargetPicture),
}

/// What came out of a fit.
pub(super) struct FitOutcome {
    solution: Solution,
    unknowns: Unknowns,
    values: Values,
    /// At how many samples the formula is no number, of how many.
    undefined: Option<[usize; 2]>,
    /// How much the formula changes when light and view change places, if the data do not.
    asymmetry: Option<f64>,
    /// The pictures before and after, of a fit to a picture.
    pictures: Option<[Frame; 2]>,
    /// Whether it was a formula alone, so that its values count for every body.
    is_alone: bool,
    seconds: f64,
}

/// Fits.
pub(super) fn run(options: &Options) -> Result<(), Failure> {
    match options.with_formula_named() {
        Some(options) => run_named(&options),
        None => run_named(options),
    }
}

impl Options {
    /// The same options with the formula in its place, if a formula is named where a session can be.
    fn with_formula_named(&self) -> Option<Self> {
        let name = self.input.session.as_ref().filter(|_| self.input.formula.is_none())?;
        let location = Location::new(name);
        let path = location.file().filter(|path| path.is_file())?;
        let source = location.read(FileKind::Session, Readable::Regular).ok()?;
        let is_formula = kind_of_file(path, source.text()) == FileKind::Formula;
        let input = InputOptions { formula: Some(name.clone()), session: None, ..self.input.clone() };
        is_formula.then(|| Self { input, ..self.clone() })
    }
}

/// Fits, with the formula where it belongs.
fn run_named(options: &Options) -> Result<(), Failure> {
    if let Some(path) = options.output.as_deref().filter(|path| path.extension().is_none_or(|suffix| suffix != "toml")) {
        return Err(Failure::command_line(format!("`{}` is no name of a session: it ends in .toml", path.display())));
    }
    for path in options.output.iter().chain(&options.chart) {
        check_file(path)?;
    }
    let chart = options.chart.as_deref().map(charts::ChartFile::new).transpose()?;
    check_target(&options.to)?;
    check_input(options)?;
    let mut project = load(&input(options), &options.passes)?;
    project.files.push(options.to.clone());
    for path in options.output.iter().chain(&options.chart) {
        check_distinct(path, &project.files)?;
    }
    let owners = owners(options, &project)?;
    let target = target(options, &mut project)?;
    warn_of_unused(options, &target);
    let unknowns = unknowns(options, &project, owners)?;
    let cancelled = cancelled_by_signals();
    let outcome = on_threads(&options.input.machine, || fit(options, &project, owners, &target, unknowns, &cancelled))??;
    if outcome.solution.cancelled {
        warn("the fit was cancelled; these are the best values so far");
    }
    let described = described(&project, owners, &outcome);
    let report = FitReport::new(&described, &one_line(&options.to.to_string_lossy()), metric(options), &project, &outcome);
    if options.json {
        print_json(&report)?;
    } else {
        print(&report::table(&report))?;
    }
    if let Some(path) = &options.output {
        let session = Session {
            formula: project.formula_location.clone(),
            scene: project.scene_location.clone(),
            picture: project.picture,
            values: Session::name_values(&outcome.values),
        };
        let failed = |error: std::io::Error| Failure::input(format!("cannot write `{}`: {error}", path.display()));
        session.save(path).map_err(failed)?;
    }
    if let Some(chart) = chart {
        chart.write(&charts::chart(&project, owners, &target, &outcome, &described))?;
    }
    Ok(())
}

/// Warns of options that change nothing for what is fitted to.
fn warn_of_unused(options: &Options, target: &FitTarget) {
    let (is_material, is_picture) = match target {
        FitTarget::Material(..) => (true, false),
        FitTarget::Samples(_) => (false, false),
        FitTarget::Picture(_) => (false, true),
    };
    let InputOptions { size, depth, .. } = &options.input;
    let of_pictures = [("--size", size.is_some()), ("--depth", depth.is_some()), ("--samples", options.passes.samples.is_some())];
    let of_materials = [("--directions", options.directions.is_some()), ("--within", options.within.is_some())];
    let unused = |is_used: bool| move |(_, is_given): &(&str, bool)| *is_given && !is_used;
    for (option, _) in of_materials.into_iter().filter(unused(is_material)) {
        warn(format!("`{option}` counts for measured materials only"));
    }
    for (option, _) in of_pictures.into_iter().filter(unused(is_picture)) {
        warn(format!("`{option}` counts for pictures only"));
    }
}

fn metric(options: &Options) -> Metric {
    options.metric.as_deref().and_then(Metric::named).unwrap_or(METRICS[0])
}

/// A flag that is set by signals that end the program. The fit ends then, and reports the best values so far.
fn cancelled_by_signals() -> Arc<AtomicBool> {
    let cancelled = Arc::new(AtomicBool::new(false));
    #[cfg(unix)]
    {
        use crate::cli::signals::{Closing, close_first};
        use std::sync::atomic::Ordering;
        struct EndingFit(Arc<AtomicBool>);
        impl Closing for EndingFit {
            fn close(&self) {
                self.0.store(true, Ordering::Relaxed);
            }

            fn last_resort(&self) {}
        }
        close_first(EndingFit(Arc::clone(&cancelled)));
    }
    cancelled
}

/// The body and the light that are fitted.
fn owners(options: &Options, project: &Project) -> Result<FittedOwners, Failure> {
    let all = project.values.table().owners();
    let plain = formula_alone(options).map(|_| PLAIN_BODY);
    let body = owner_named(all, Owner::Body, options.body.as_deref().or(plain))?;
    Ok(FittedOwners { body, light: owner_named(all, Owner::Light, options.light.as_deref())? })
}

/// Reads what is fitted to. The picture of the project gets the size of a picture that is to be reached.
fn target(options: &Options, project: &mut Project) -> Result<FitTarget, Failure> {
    let path = &options.to;
    if Format::of(path).is_some() {
        return picture_target(options, project, path);
    }
    let read = Measurement::read(path).map_err(|error| {
        let hint = error.hint.clone();
        Failure::Input(Diagnostic::error(error.to_string()).help_if(hint))
    })?;
    Ok(match read {
        Measurement::Material(material) => {
            let within = options.within.map_or(LARGEST_ANGLE, f64::from);
            let samples = samples_of_material(&material, options.directions.unwrap_or(USUAL_PAIRS), within);
            FitTarget::Material(material, samples)
        }
        Measurement::Samples(list) => {
            let steepest = list.samples.iter().map(|sample| sample.light.z.min(sample.view.z)).fold(1.0, f64::min);
            if list.samples.len() > 1 && steepest > 1.6_f64.to_radians().cos() {
                warn(
                    "all polar angles are below 1.6 degrees; if they are radians, a header must name them theta_i_rad and so on",
                );
            }
            let negative = list.samples.iter().filter(|sample| sample.value.min_element() < 0.0).count();
            if negative > 0 {
                warn(format!("{negative} of {} samples are negative somewhere; no surface reflects so", list.samples.len()));
            }
            FitTarget::Samples(request::listed_samples(&list))
        }
    })
}

fn picture_target(options: &Options, project: &mut Project, path: &Path) -> Result<FitTarget, Failure> {
    let unreadable = |why: String| Failure::input(format!("cannot read the picture `{}`: {why}", path.display()));
    let read = read_picture(path).map_err(|error| unreadable(error.to_string()))?;
    let size = [read.numbers.width, read.numbers.height];
    if options.input.size.is_some_and(|wanted| wanted != size) {
        return Err(unreadable(format!("it has {}×{} pixels, and `--size` says otherwise", size[0], size[1])));
    }
    project.picture.size = size;
    project.subject.view =
        illuminator::workspace::project::view(&project.picture).map_err(|error| unreadable(error.to_string()))?;
    let target = request::target(read, &project.picture.view).map_err(unreadable)?;
    Ok(FitTarget::Picture(target))
}

/// The numbers that may move.
fn unknowns(options: &Options, project: &Project, owners: FittedOwners) -> Result<Unknowns, Failure> {
    let (formula, table) = (&project.subject.formula, project.values.table());
    let wrong = |error: FreeNameError| Failure::CommandLine(Diagnostic::error(error.to_string()).help_if(error.hint()));
    let free = match options.free.is_empty() {
        true => request::usual(table, formula, owners),
        false => {
            let found = options.free.iter().map(|name| request::named(name, table, formula, owners));
            found.collect::<Result<Vec<_>, _>>().map_err(wrong)?
        }
    };
    request::unknowns(&free, formula, &project.values).map_err(|error| Failure::command_line(error.to_string()))
}

fn fit(
    options: &Options,
    project: &Project,
    owners: FittedOwners,
    target: &FitTarget,
    unknowns: Unknowns,
    cancelled: &AtomicBool,
) -> Result<FitOutcome, Failure> {
    let (formula, metric) = (&project.subject.formula, metric(options));
    let fit_options = FitOptions { starts: options.starts };
    let start = Instant::now();
    let progress = Progress::new("fitting");
    let tell = |told: FitProgress| progress.tell(told.share);
    let (solution, undefined, pictures) = match target {
        FitTarget::Material(_, samples) | FitTarget::Samples(samples) => {
            let misfit = request::sample_misfit(formula, &project.values, owners, &unknowns, samples, metric);
            let solution = solve(&misfit, &unknowns, fit_options, &tell, cancelled);
            let undefined = [misfit.undefined(&solution.values), samples.len()];
            (solution, Some(undefined), None)
        }
        FitTarget::Picture(target) => {
            let engine = engine::engine(&DEFAULT, &options.input.machine);
            let subject = &project.subject;
            let hits = {
                let tracing = Progress::of_passes("tracing", project.picture.passes());
                let tell = |share: f64| tracing.tell(share);
                request::traced(&engine, subject, project.picture.passes(), &Task { progress: &tell, cancelled })
            };
            let hits = hits.map_err(engine::failed)?;
            let target = (target.clone(), metric);
            let misfit = request::picture_misfit(&engine, subject, &hits, &project.values, &unknowns, target);
            let misfit = misfit.map_err(engine::failed)?;
            let solution = solve(&misfit, &unknowns, fit_options, &tell, cancelled);
            let pictures = [unknowns.start(), solution.values.clone()].map(|values| misfit.picture(&values));
            (solution, None, Some(pictures))
        }
    };
    let seconds = start.elapsed().as_secs_f64();
    let mut values = request::fitted(&project.values, &unknowns, &solution);
    let is_alone = formula_alone(options).is_some();
    if let (true, Some(body)) = (is_alone, owners.body) {
        set_all_bodies(&mut values, body);
    }
    let asymmetry = match target {
        FitTarget::Material(material, _) if material.is_reciprocal() => Some(request::asymmetry(formula, &values, owners)),
        FitTarget::Material(..) | FitTarget::Samples(_) | FitTarget::Picture(_) => None,
    };
    Ok(FitOutcome { solution, unknowns, values, undefined, asymmetry, pictures, is_alone, seconds })
}

/// Gives all bodies the values of one.
fn set_all_bodies(values: &mut Values, body: OwnerId) {
    let table = values.table();
    let ids: Vec<_> = table.parameters_of(Owner::Body).collect();
    let all = table.owners().of_kind(Owner::Body).filter(|owner| *owner != body);
    let assignments = all.flat_map(|owner| ids.iter().map(move |id| (owner, *id))).map(|(owner, parameter)| {
        let numbers = values.get(body, parameter);
        let value = std::array::from_fn(|component| numbers[component % numbers.len()]);
        Assignment { owner, parameter, value }
    });
    let assignments: Vec<Assignment> = assignments.collect();
    values.assign(&assignments);
}

/// What is fitted, in words.
fn described(project: &Project, owners: FittedOwners, outcome: &FitOutcome) -> String {
    if outcome.pictures.is_some() {
        return one_line(&format!("{} on {}", project.formula_location, project.scene_location));
    }
    let all = project.values.table().owners();
    let names = [owners.body, owners.light].into_iter().flatten().filter_map(|owner| all.name(owner));
    let names: Vec<&str> = names.collect();
    one_line(&format!("{} with {}", project.formula_location, names.join(" under ")))
}

/// The scene for a formula alone, and the body of it that is fitted.
const PLAIN_SCENE: &str = "preset:studio";
const PLAIN_BODY: &str = "ball";

/// The formula, if it alone is fitted to measurements. It has its defaults then, as in `measure`.
fn formula_alone(options: &Options) -> Option<&OsStr> {
    let input = &options.input;
    let is_alone = input.session.is_none() && input.scene.is_none() && Format::of(&options.to).is_none();
    input.formula.as_deref().filter(|_| is_alone)
}

/// What is opened.
fn input(options: &Options) -> InputOptions {
    let mut input = options.input.clone();
    if let Some(formula) = formula_alone(options) {
        input.scene = Some(PLAIN_SCENE.into());
        if let Ok(source) = Location::new(formula).read(FileKind::Formula, Readable::Regular) {
            input.settings = input.settings.into_iter().map(|given| owned(given, &source)).collect();
        }
    }
    input
}

/// Tells a measured material where the session belongs.
fn check_input(options: &Options) -> Result<(), Failure> {
    let Some(session) = &options.input.session else { return Ok(()) };
    let suffix = Path::new(session).extension().map(|suffix| suffix.to_string_lossy().to_lowercase());
    let is_measured = |suffix: &str| FORMATS.iter().any(|format| format.has_all_directions && format.suffixes.contains(&suffix));
    if !suffix.as_deref().is_some_and(is_measured) {
        return Ok(());
    }
    let error = Diagnostic::error(format!("`{}` is a measured material, not a session", session.to_string_lossy()));
    let help = "`--to` gives the material, and `--formula` the formula that is to come near to it";
    Err(Failure::CommandLine(error.help(help)))
}

/// Tells apart what `--to` cannot be by its name.
fn check_target(path: &Path) -> Result<(), Failure> {
    let suffix = path.extension().map(|suffix| suffix.to_string_lossy().to_lowercase());
    let (what, help) = match suffix.as_deref() {
        Some("jpg" | "jpeg" | "hdr" | "tif" | "tiff" | "webp" | "gif") => {
            ("a picture of another kind", "pictures to fit to are .exr, .png and .bmp")
        }
        Some("formula" | "scene" | "toml" | "brdf" | "obj" | "ply" | "gltf" | "glb") => (
            "no measurement and no picture",
            "`--to` takes a measured material (.binary, .bsdf), a list of samples (.csv), or a picture (.exr, .png, .bmp)",
        ),
        Some(_) | None => return Ok(()),
    };
    let error = Diagnostic::error(format!("`{}` is {what}", path.display()));
    Err(Failure::CommandLine(error.help(help)))
}
