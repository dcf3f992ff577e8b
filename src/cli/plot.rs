//! `illuminator plot`: draws what a formula is.

use crate::cli::engine::on_threads;
use crate::cli::model::ModelOptions;
use crate::cli::options::size;
use crate::cli::output::{check_distinct, check_file};
use crate::cli::report::{Failure, print_bytes, prints_to_terminal, warn};
use clap::Args;
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use illuminator::files::{reason, replace_file};
use illuminator::instrument::direction::STEEPEST;
use illuminator::instrument::view::{Component, InstrumentView, MOST_LOBES, NamedModel, Shown, VIEWS, ViewChoice, ViewSettings};
use illuminator::lang::diagnostic::Diagnostic;
use illuminator::lang::memory_size::MemorySize;
use illuminator::plot::{Chart, ChartFormat, ChartTheme, Curve, MapPanel, MapValues, plain};
use illuminator::trace::usable_memory;
use std::ffi::OsString;
use std::io::Write;
use std::path::{Path, PathBuf};

/// The size of a chart in pixels.
const USUAL_SIZE: [u32; 2] = [800, 600];
/// The least and the greatest side of a chart in pixels.
const SIDES: [u32; 2] = [180, 8192];
/// The most models of a chart.
const MOST_MODELS: usize = 8;

/// Options of `plot`.
#[derive(Args, Debug)]
pub(super) struct Options {
    #[command(flatten)]
    model: ModelOptions,
    /// What is drawn
    #[arg(long, value_name = "VIEW", value_parser = views())]
    view: &'static InstrumentView,
    /// Another model in the same chart: a formula, a session or a measured material; may be repeated
    #[arg(long, value_name = "OTHER")]
    with: Vec<OsString>,
    /// Angles of the light from the normal in degrees, 0 to 89.99, as in 0,30,60
    #[arg(long, value_name = "DEGREES", value_parser = polar, value_delimiter = ',', allow_negative_numbers = true)]
    theta: Vec<f64>,
    /// Azimuth of the light from the tangent in degrees [default: 0]
    #[arg(long, value_name = "DEGREES", value_parser = turn, allow_negative_numbers = true)]
    phi: Option<f64>,
    /// Angle between the plane of incidence and the plane of the outgoing directions, in degrees [default: 0]
    #[arg(long, value_name = "DEGREES", value_parser = turn, allow_negative_numbers = true)]
    plane: Option<f64>,
    /// Logarithmic scale
    #[arg(long)]
    log: bool,
    /// Show numbers as false colours
    #[arg(long)]
    false_colours: bool,
    /// What is shown of colours
    #[arg(long, value_name = "NAME", value_parser = named(Component::ALL.map(|(name, _)| name)))]
    component: Option<String>,
    /// The BRDF, or the value of the formula for white light, which is π · BRDF · cos θ [default: brdf]
    #[arg(long, value_name = "NAME", value_parser = named(Shown::ALL.map(|(name, _)| name)))]
    quantity: Option<String>,
    /// From where a lobe is seen: azimuth from the light's, and elevation from 5 to 90, in degrees [default: 115,26]
    #[arg(long, value_name = "AZIMUTH,ELEVATION", value_parser = seen_from, allow_hyphen_values = true)]
    seen_from: Option<SeenFrom>,
    /// Size in pixels, each side 180 to 8192 [default: 800x600]
    #[arg(long, value_name = "WxH", value_parser = side)]
    size: Option<ChartSize>,
    /// Draw on dark paper
    #[arg(long)]
    dark: bool,
    /// File: .png, .svg, or .csv for the numbers; - writes PNG to standard output
    #[arg(long = "output", short, value_name = "OUT")]
    output: PathBuf,
}

/// From where a lobe is seen. It is a type of its own because the parser of arguments takes arrays for lists.
#[derive(Debug, Clone, Copy)]
struct SeenFrom([f64; 2]);

/// The size of a chart, likewise.
#[derive(Debug, Clone, Copy)]
struct ChartSize([u32; 2]);

fn views() -> impl TypedValueParser<Value = &'static InstrumentView> {
    let values = VIEWS.iter().map(|view| PossibleValue::new(view.name).help(view.doc));
    PossibleValuesParser::new(values).try_map(|name| InstrumentView::named(&name).ok_or("no such view"))
}

fn named<const COUNT: usize>(names: [&'static str; COUNT]) -> PossibleValuesParser {
    PossibleValuesParser::new(names)
}

fn polar(text: &str) -> Result<f64, String> {
    let angle = text.trim().parse().ok().filter(|angle| (0.0..=STEEPEST).contains(angle));
    angle.ok_or_else(|| format!("expected an angle from 0 to {STEEPEST} degrees"))
}

fn turn(text: &str) -> Result<f64, String> {
    let angle = text.trim().parse().ok().filter(|angle| (-360.0..=360.0).contains(angle));
    angle.ok_or_else(|| "expected an angle from -360 to 360 degrees".to_owned())
}

fn seen_from(text: &str) -> Result<SeenFrom, String> {
    let form = || "expected two angles such as 115,26, the second one from 5 to 90 degrees".to_owned();
    let (azimuth, elevation) = text.split_once(',').ok_or_else(form)?;
    let elevation = elevation.trim().parse().ok().filter(|angle| (5.0..=90.0).contains(angle)).ok_or_else(form)?;
    Ok(SeenFrom([turn(azimuth)?, elevation]))
}

fn side(text: &str) -> Result<ChartSize, String> {
    let [least, greatest] = SIDES;
    let sides = size(text).ok().filter(|sides| sides.iter().all(|side| (least..=greatest).contains(side)));
    sides.map(ChartSize).ok_or_else(|| format!("expected a size such as 800x600, each side {least} to {greatest}"))
}

/// The format that a path asks for.
fn format_of(path: &Path) -> Result<ChartFormat, Failure> {
    if path == Path::new("-") {
        if prints_to_terminal() {
            let error = Diagnostic::error("a picture cannot be shown in a terminal");
            return Err(Failure::CommandLine(error.help("send it on, as in `-o - > chart.png` or `-o - | viewer`")));
        }
        return Ok(ChartFormat::Png);
    }
    let format = ChartFormat::of(path).ok_or_else(|| {
        let message = match path.extension() {
            Some(suffix) => format!("charts of the kind `.{}` cannot be written", suffix.display()),
            None => format!("`{}` does not say by a suffix what kind of chart it is to be", path.display()),
        };
        Failure::CommandLine(Diagnostic::error(message).help(format!("the kinds are {}", ChartFormat::suffixes())))
    })?;
    check_file(path)?;
    Ok(format)
}

/// Draws.
pub(super) fn run(options: &Options) -> Result<(), Failure> {
    let format = format_of(&options.output)?;
    if options.with.len() >= MOST_MODELS {
        return Err(Failure::command_line(format!("a chart shows at most {MOST_MODELS} models")));
    }
    warn_of_unused(options);
    let first = options.model.open()?;
    let mut files = first.files;
    let mut models = vec![first.named];
    for name in &options.with {
        let other = options.model.beside(name)?;
        files.extend(other.files);
        models.push(other.named);
    }
    if options.output != Path::new("-") {
        check_distinct(&options.output, &files)?;
    }
    let subtitle = if models.len() == 1 { first.described } else { String::new() };
    let lobes = models.len() * options.theta.len().max(1);
    if options.view.name == "lobe" && lobes > MOST_LOBES {
        let message = format!("a chart has at most {MOST_LOBES} lobes, and these models and angles make {lobes}");
        return Err(Failure::command_line(message));
    }
    let settings = settings(options, subtitle);
    let chart = on_threads(&options.model.machine, || options.view.chart(&models, &settings))?;
    warn_of_nothing(&chart, &models, options.log);
    warn_of_equal_curves(&chart);
    write(options, format, &chart)
}

/// What is shown, and how.
fn settings(options: &Options, subtitle: String) -> ViewSettings {
    let usual = ViewSettings::default();
    let chosen = |name: &str| Component::ALL.iter().find(|(known, _)| *known == name).map(|(_, component)| *component);
    let quantity = |name: &str| Shown::ALL.iter().find(|(known, _)| *known == name).map(|(_, shown)| *shown);
    ViewSettings {
        subtitle,
        light_polar: options.theta.clone(),
        light_azimuth: options.phi.unwrap_or(usual.light_azimuth),
        plane: options.plane.unwrap_or(usual.plane),
        is_log: options.log,
        false_colours: options.false_colours,
        component: options.component.as_deref().and_then(chosen),
        shown: options.quantity.as_deref().and_then(quantity).unwrap_or(usual.shown),
        seen_from: options.seen_from.map_or(usual.seen_from, |SeenFrom(angles)| angles),
        ..usual
    }
}

/// Warns of options that change nothing in the view.
fn warn_of_unused(options: &Options) {
    let given = [
        ("--theta", ViewChoice::LightPolar, !options.theta.is_empty()),
        ("--phi", ViewChoice::LightAzimuth, options.phi.is_some()),
        ("--plane", ViewChoice::Plane, options.plane.is_some()),
        ("--log", ViewChoice::Log, options.log),
        ("--false-colours", ViewChoice::FalseColours, options.false_colours),
        ("--component", ViewChoice::Component, options.component.is_some()),
        ("--quantity", ViewChoice::Shown, options.quantity.is_some()),
        ("--seen-from", ViewChoice::SeenFrom, options.seen_from.is_some()),
    ];
    for (option, choice, _) in given.into_iter().filter(|(_, _, is_given)| *is_given) {
        if !options.view.choices.contains(&choice) {
            warn(format!("`{option}` changes nothing in the view `{}`", options.view.name));
        }
    }
}

/// Warns of a chart in which there is nothing to be seen, and of numbers that are not seen as what they are.
fn warn_of_nothing(chart: &Chart, models: &[NamedModel], is_log: bool) {
    let numbers = numbers_of(chart);
    let is_curves = matches!(chart, Chart::Cartesian(_) | Chart::Polar(_));
    let which = if models.len() == 1 { "the model" } else { "every model" };
    let is_unknown = numbers.iter().all(|number| !number.is_finite());
    if is_curves && is_unknown {
        warn(format!("{which} has no finite value for these directions"));
    } else if is_curves && numbers.iter().all(|number| *number == 0.0 || !number.is_finite()) {
        warn(format!("{which} is 0 for all of these directions"));
    } else if is_log && numbers.iter().all(|number| number.is_nan() || *number <= 0.0) {
        warn("no value is above 0, so a logarithmic scale shows nothing");
    } else if let Some(least) = numbers.iter().copied().filter(|number| *number < LEAST_TOLD).reduce(f64::min) {
        warn(format!("some values are negative, down to {least:.3}"));
    }
    if !is_unknown && numbers.iter().any(|number| number.is_nan()) {
        let shown = if is_curves { "curves have gaps there" } else { "they are magenta in pictures" };
        warn(format!("some values are not numbers; {shown}"));
    }
}

/// Rounding makes numbers this small of either sign.
const LEAST_TOLD: f64 = -1e-6;

/// All numbers that a chart shows.
fn numbers_of(chart: &Chart) -> Vec<f64> {
    let of_curves = |curves: &[Curve]| curves.iter().flat_map(|curve| &curve.points).map(|point| point[1]).collect();
    match chart {
        Chart::Cartesian(chart) => of_curves(&chart.curves),
        Chart::Polar(chart) => of_curves(&chart.curves),
        Chart::Lobe(chart) => chart.lobes.iter().flat_map(|lobe| &lobe.values).copied().collect(),
        Chart::Map(chart) => {
            let numbers = |panel: &MapPanel| match &panel.values {
                MapValues::Numbers(numbers) => numbers.clone(),
                MapValues::Colours(colours) => colours.as_flattened().iter().copied().map(f64::from).collect(),
            };
            chart.panels.iter().flat_map(numbers).collect()
        }
    }
}

/// Warns of curves that look the same.
fn warn_of_equal_curves(chart: &Chart) {
    let curves = match chart {
        Chart::Cartesian(chart) => &chart.curves,
        Chart::Polar(chart) => &chart.curves,
        Chart::Map(_) | Chart::Lobe(_) => return,
    };
    let look = |curve: &Curve| (curve.colour, curve.dashes);
    let equal = curves.iter().enumerate().find_map(|(index, curve)| {
        let earlier = curves[..index].iter().find(|earlier| look(earlier) == look(curve))?;
        Some([earlier, curve].map(|curve| plain(&curve.name)))
    });
    if let Some([one, other]) = equal {
        warn(format!("there are more curves than looks: `{one}` and `{other}` look the same"));
    }
}

/// Writes the chart.
fn write(options: &Options, format: ChartFormat, chart: &Chart) -> Result<(), Failure> {
    let ChartSize(size) = options.size.unwrap_or(ChartSize(USUAL_SIZE));
    let theme = if options.dark { ChartTheme::Dark } else { ChartTheme::Light };
    let path = &options.output;
    let needed = format.memory(chart, size);
    let allowed = options.model.machine.memory.unwrap_or_else(usable_memory);
    if needed > allowed {
        let ([width, height], needed, allowed) = (size, MemorySize(needed), MemorySize(allowed));
        let message = format!("a chart of {width}×{height} pixels takes {needed} of memory, and {allowed} may be used");
        let help = "`--memory SIZE` allows more, and `--size WxH` makes the chart smaller";
        return Err(Failure::Input(Diagnostic::error(message).help(help)));
    }
    let bytes = format.bytes(chart, size, theme).map_err(Failure::input)?;
    if path == Path::new("-") {
        return print_bytes(&bytes);
    }
    replace_file(path, |writer| writer.write_all(&bytes))
        .map_err(|error| Failure::input(format!("cannot write `{}`: {}", path.display(), reason(&error))))
}
