//! `illuminator bench`: how fast each stage is, and each slider.

use crate::cli::engine;
use crate::cli::input::load;
use crate::cli::options::{InputOptions, PassOptions, whole};
use crate::cli::progress::Progress;
use crate::cli::report::{Failure, print, print_json};
use clap::Args;
use illuminator::backends::{DEFAULT, REFERENCE};
use illuminator::engine::{Engine, Subject, Task};
use illuminator::evaluate::{Drag, Evaluator, Framebuffer};
use illuminator::formula::ParameterId;
use illuminator::lang::diagnostic::Diagnostic;
use illuminator::lang::types::Type;
use illuminator::picture::Transfer;
use illuminator::trace::Hits;
use illuminator::workspace::project::Project;
use illuminator::workspace::{OwnerId, Values};
use serde::Serialize;
use std::fmt::Write;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// A measurement is not repeated after this total time.
const PATIENCE: Duration = Duration::from_secs(10);
/// Tracing is repeated at most this many times.
const MOST_TRACES: u32 = 3;
/// The memory that a drag may keep, in bytes.
const DRAG_BUDGET: usize = 1 << 30;

/// Options of `bench`.
#[derive(Args, Debug)]
pub(super) struct Options {
    #[command(flatten)]
    input: InputOptions,
    /// How often each stage is measured; medians are shown
    #[arg(long, value_name = "N", default_value_t = 15, value_parser = whole(1_u32..=1000), allow_negative_numbers = true)]
    runs: u32,
    /// A slider to be dragged, floor.kd, or floor.Cd.r for one component; may be repeated [default: all]
    #[arg(long, value_name = "OWNER.PARAM")]
    slider: Vec<String>,
    /// Also measure pictures of N passes, which are all kept, 2 to 4096
    #[arg(long, value_name = "N", value_parser = whole(2_u32..=4096), allow_negative_numbers = true)]
    samples: Option<u32>,
    /// Print JSON instead of a table
    #[arg(long)]
    json: bool,
}

/// What was measured; times are medians in milliseconds.
#[derive(Serialize)]
struct Report {
    /// Width and height in pixels.
    size: [u32; 2],
    depth: u32,
    threads: usize,
    hits: u64,
    /// Pairs of a hit and a light that it is evaluated for.
    records: u64,
    paths: u64,
    groups: u64,
    bytes_per_pixel: Backends,
    trace_ms: f64,
    compile_ms: f64,
    full_ms: Backends,
    drag: Vec<DragReport>,
    /// The same for pictures of several passes, if that was asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    passes: Option<PassesReport>,
}

/// What was measured of pictures of several passes, by compiled code.
#[derive(Serialize)]
struct PassesReport {
    passes: u32,
    /// All of them.
    trace_ms: f64,
    prepare_ms: f64,
    full_ms: f64,
    /// A picture of one pass, in turns with those of all.
    one_pass_ms: f64,
    bytes_per_pixel: f64,
    drag: Vec<DragReport>,
}

/// A figure for each backend.
#[derive(Serialize)]
struct Backends {
    interpreter: f64,
    jit: f64,
}

#[derive(Serialize)]
struct DragReport {
    parameter: String,
    method: &'static str,
    prepare_ms: f64,
    frame_ms: f64,
    /// A frame of one pass, in turns with those of all passes.
    #[serde(skip_serializing_if = "Option::is_none")]
    one_pass_ms: Option<f64>,
    #[serde(skip)]
    pixels: usize,
}

/// A slider: a value, or a component of it.
#[derive(Clone, Copy)]
struct Slider {
    owner: OwnerId,
    id: ParameterId,
    component: Option<usize>,
}

/// Measures and reports.
pub(super) fn run(options: &Options) -> Result<(), Failure> {
    let input = load(&options.input, &PassOptions::default())?;
    let all = sliders(&input.values);
    let wanted = options.slider.iter().map(|label| find(&input.values, &all, label)).collect::<Result<Vec<_>, _>>()?;
    let wanted = if wanted.is_empty() { all } else { wanted };
    let report = engine::on_threads(&options.input.machine, || measure(options, &input, &wanted))??;
    if options.json { print_json(&report) } else { print(&table(&report, options.runs)) }
}

/// Everything that a slider can move. The formula's own parameters with `slider` come first; colours count as a whole
/// and by component.
fn sliders(values: &Values) -> Vec<Slider> {
    let asks = |id: ParameterId| {
        let parameter = values.table().parameter(id);
        parameter.slider && parameter.predefined.is_none()
    };
    let movable: Vec<(OwnerId, ParameterId)> =
        values.iter().map(|(owner, id, _)| (owner, id)).filter(|(owner, id)| values.lock_of(*owner, *id).is_none()).collect();
    let (first, rest): (Vec<_>, Vec<_>) = movable.into_iter().partition(|(_, id)| asks(*id));
    let components = |id: ParameterId| match values.table().parameter(id).ty {
        Type::Vector => vec![None, Some(0), Some(1), Some(2)],
        Type::Scalar | Type::Truth | Type::Texture => vec![None],
    };
    let each = |(owner, id)| components(id).into_iter().map(move |component| Slider { owner, id, component });
    first.into_iter().chain(rest).flat_map(each).collect()
}

fn label(values: &Values, slider: &Slider) -> String {
    let label = values.table().label(slider.owner, slider.id);
    match slider.component {
        Some(component) => format!("{label}.{}", ["r", "g", "b"][component]),
        None => label,
    }
}

fn find(values: &Values, sliders: &[Slider], wanted: &str) -> Result<Slider, Failure> {
    if let Some(slider) = sliders.iter().find(|slider| label(values, slider) == wanted) {
        return Ok(*slider);
    }
    let locked = values.iter().find(|(owner, id, _)| values.table().label(*owner, *id) == wanted);
    Err(match locked.and_then(|(owner, id, _)| values.lock_of(owner, id)) {
        Some(reason) => Failure::command_line(format!("--slider {wanted}: it cannot be moved: {reason}")),
        None => Failure::command_line(format!("--slider {wanted}: there is no such value")),
    })
}

fn measure(options: &Options, input: &Project, sliders: &[Slider]) -> Result<Report, Failure> {
    let Project { subject, .. } = input;
    let view = &subject.view;
    let progress = Progress::new("measuring");
    let (compile_ms, engine) = time(options.runs, || {
        // A new backend each time, because a backend keeps what it compiled.
        let engine = engine::engine(&DEFAULT, &options.input.machine);
        engine.compile(subject).map_err(engine::failed)?;
        Ok(engine)
    })?;
    progress.tell(0.05);
    let traces = options.runs.min(MOST_TRACES);
    let (trace_ms, hits) = time(traces, || engine.trace(subject, &Task::UNWATCHED).map_err(engine::failed))?;
    progress.tell(0.2);
    let evaluator = engine.prepare(subject, &hits, input.values.numbers()).map_err(engine::failed)?;
    let mut framebuffer = Framebuffer::black(view.width(), view.height(), Transfer::Linear);
    let numbers = input.values.numbers();
    let jit_ms = median(options.runs, |_| {
        let start = Instant::now();
        evaluator.draw(numbers, &mut framebuffer);
        Ok(start.elapsed())
    })?;
    let drag = sliders
        .iter()
        .enumerate()
        .map(|(index, slider)| {
            progress.tell(0.25 + 0.5 * index as f64 / sliders.len() as f64);
            drag(options.runs, input, &evaluator, slider, &mut framebuffer)
        })
        .collect::<Result<Vec<_>, _>>()?;
    let jit_bytes = (evaluator.bytes() + size_of_val(&*framebuffer.pixels)) as f64;
    let passes = match options.samples {
        Some(passes) => Some(measure_passes(passes, options, input, (&engine, &hits, evaluator), sliders)?),
        None => None,
    };
    let (interpreter_ms, interpreter_bytes) = interpreted(options, subject, numbers, &mut framebuffer)?;
    let evaluated = hits.for_lights(subject.formula.evaluated_lights());
    let counts = evaluated.map_err(|error| Failure::input(error.to_string()))?.counts();
    let pixels = f64::from(view.pixels());
    Ok(Report {
        size: [view.width(), view.height()],
        depth: view.depth(),
        threads: rayon::current_num_threads(),
        hits: counts.hits,
        records: counts.records,
        paths: counts.paths,
        groups: counts.groups,
        bytes_per_pixel: Backends { interpreter: interpreter_bytes as f64 / pixels, jit: jit_bytes / pixels },
        trace_ms,
        compile_ms,
        full_ms: Backends { interpreter: interpreter_ms, jit: jit_ms },
        drag,
        passes,
    })
}

/// Pictures of several passes. The first one is prepared.
fn measure_passes(
    passes: u32,
    options: &Options,
    input: &Project,
    (engine, hits, first): (&Engine, &Arc<Hits>, Arc<dyn Evaluator>),
    sliders: &[Slider],
) -> Result<PassesReport, Failure> {
    check_memory(passes, engine, &input.subject, hits)?;
    let progress = Progress::new("measuring passes");
    let (mut evaluator, mut trace, mut prepare) = (Arc::clone(&first), Duration::ZERO, Duration::ZERO);
    for pass in 1..passes {
        let subject = Subject { view: input.subject.view.with_pass(pass), ..input.subject.clone() };
        let start = Instant::now();
        let hits = engine.trace(&subject, &Task::UNWATCHED).map_err(engine::failed)?;
        trace += start.elapsed();
        let start = Instant::now();
        evaluator = evaluator.with_pass(&hits).map_err(|error| Failure::input(error.to_string()))?;
        prepare += start.elapsed();
        progress.tell(0.6 * f64::from(pass) / f64::from(passes));
    }
    let view = &input.subject.view;
    let mut framebuffer = Framebuffer::black(view.width(), view.height(), Transfer::Linear);
    let [one_pass_ms, full_ms] = medians(options.runs, |which, _| {
        let start = Instant::now();
        [&first, &evaluator][which].draw(input.values.numbers(), &mut framebuffer);
        Ok(start.elapsed())
    })?;
    let drags = sliders.iter().enumerate().map(|(index, slider)| {
        progress.tell(0.65 + 0.35 * index as f64 / sliders.len() as f64);
        let mut held = [HeldSlider::new(input, &first, slider)?, HeldSlider::new(input, &evaluator, slider)?];
        let [one, all] = medians(options.runs, |which, run| held[which].frame(run, &mut framebuffer))?;
        let [_, held] = held;
        Ok(DragReport { one_pass_ms: Some(one), ..held.report(all) })
    });
    Ok(PassesReport {
        passes,
        trace_ms: milliseconds(trace),
        prepare_ms: milliseconds(prepare),
        full_ms,
        one_pass_ms,
        bytes_per_pixel: evaluator.bytes() as f64 / f64::from(view.pixels()),
        drag: drags.collect::<Result<_, Failure>>()?,
    })
}

/// Checks that there is memory for this many passes. Each takes about as much as the first, with these hits.
fn check_memory(passes: u32, engine: &Engine, subject: &Subject, hits: &Arc<Hits>) -> Result<(), Failure> {
    let bytes = engine.kept_bytes(subject, hits).map_err(engine::failed)?.saturating_mul(u64::from(passes));
    let (needed, limit) = (bytes.div_ceil(1 << 20), engine.memory() >> 20);
    if needed <= limit {
        return Ok(());
    }
    let error = Diagnostic::error(format!("{passes} passes take about {needed} MiB, and the limit is {limit} MiB"));
    Err(Failure::Input(error.help("measure fewer passes or a smaller picture; `--memory SIZE` allows more")))
}

/// A frame by the interpreter: the time to run the programs, and their size in bytes.
fn interpreted(
    options: &Options,
    subject: &Subject,
    numbers: &[f32],
    framebuffer: &mut Framebuffer,
) -> Result<(f64, u64), Failure> {
    let engine: Engine = engine::engine(&REFERENCE, &options.input.machine);
    let evaluator = engine.evaluator(subject, numbers, &Task::UNWATCHED).map_err(engine::failed)?;
    let mut bytes = 0;
    let ms = median(options.runs, |_| {
        let drawn = evaluator.draw(numbers, framebuffer);
        bytes = drawn.program_bytes;
        Ok(drawn.time)
    })?;
    Ok((ms, bytes))
}

/// A slider that is held and moved back and forth.
struct HeldSlider<'b> {
    slider: &'b Slider,
    values: Values,
    drag: Box<dyn Drag>,
    prepare_ms: f64,
}

impl<'b> HeldSlider<'b> {
    /// Makes the stored data of the drag.
    fn new(input: &Project, evaluator: &Arc<dyn Evaluator>, slider: &'b Slider) -> Result<Self, Failure> {
        let values = input.values.clone();
        let mut moved = values.moved_indices(slider.owner, slider.id);
        if let (Some(component), Some(first)) = (slider.component, moved.first()) {
            moved = vec![first + component];
        }
        let start = Instant::now();
        let drag = Arc::clone(evaluator).drag(&moved, values.numbers(), DRAG_BUDGET, None);
        let mut drag = drag.map_err(|error| Failure::input(error.to_string()))?;
        while !drag.prepare() {}
        Ok(Self { slider, values, drag, prepare_ms: milliseconds(start.elapsed()) })
    }

    /// Moves the slider and draws the frame. Returns the time of both.
    fn frame(&mut self, run: u32, framebuffer: &mut Framebuffer) -> Result<Duration, Failure> {
        let Slider { owner, id, component } = *self.slider;
        let [low, high] = self.values.range_of(owner, id).unwrap_or([0.0, 1.0]);
        let target = low + [0.25, 0.75][run as usize % 2] * (high - low);
        let mut value = [target; 3];
        if let Some(component) = component {
            value.copy_from_slice(self.values.get(owner, id));
            value[component] = target;
        }
        let start = Instant::now();
        self.values.move_to(owner, id, value);
        self.drag.frame(self.values.numbers(), framebuffer);
        Ok(start.elapsed())
    }

    fn report(self, frame_ms: f64) -> DragReport {
        let Self { slider, values, drag, prepare_ms } = self;
        let method = drag.method().name();
        DragReport { parameter: label(&values, slider), method, prepare_ms, frame_ms, one_pass_ms: None, pixels: drag.pixels() }
    }
}

/// Draws frames of a slider.
fn drag(
    runs: u32,
    input: &Project,
    evaluator: &Arc<dyn Evaluator>,
    slider: &Slider,
    framebuffer: &mut Framebuffer,
) -> Result<DragReport, Failure> {
    let mut held = HeldSlider::new(input, evaluator, slider)?;
    // The first frame is not measured.
    held.frame(1, framebuffer)?;
    let frame_ms = median(runs, |run| held.frame(run, framebuffer))?;
    Ok(held.report(frame_ms))
}

fn milliseconds(time: Duration) -> f64 {
    // A time that is too short for the clock is not 0.
    time.as_secs_f64().max(1e-9) * 1000.0
}

/// The median of what `once` returns, in milliseconds.
fn median(runs: u32, mut once: impl FnMut(u32) -> Result<Duration, Failure>) -> Result<f64, Failure> {
    let [median] = medians(runs, |_, run| once(run))?;
    Ok(median)
}

/// The medians of what `once` returns for each of several things, in milliseconds. They are measured in turns, so that
/// their ratio does not depend on what else the machine does. Each measurement follows one that does not count, so that
/// the caches hold what they hold while a slider is moved.
fn medians<const THINGS: usize>(
    runs: u32,
    mut once: impl FnMut(usize, u32) -> Result<Duration, Failure>,
) -> Result<[f64; THINGS], Failure> {
    let start = Instant::now();
    let mut times = [const { Vec::new() }; THINGS];
    for run in 0..runs {
        for (thing, times) in times.iter_mut().enumerate() {
            if THINGS > 1 {
                once(thing, run + 1)?;
            }
            times.push(once(thing, run)?);
        }
        if start.elapsed() > PATIENCE {
            break;
        }
    }
    Ok(times.map(|mut times| {
        times.sort();
        milliseconds(times.get(times.len() / 2).copied().unwrap_or_default())
    }))
}

/// The median time of `make` in milliseconds, and the last result.
fn time<T>(runs: u32, mut make: impl FnMut() -> Result<T, Failure>) -> Result<(f64, T), Failure> {
    let mut made = None;
    let median = median(runs, |_| {
        // Freed before the clock starts, because there may not be memory for two.
        made = None;
        let start = Instant::now();
        made = Some(make()?);
        Ok(start.elapsed())
    })?;
    made.map(|made| (median, made)).ok_or_else(|| Failure::command_line("at least one run is needed"))
}

fn table(report: &Report, runs: u32) -> String {
    let Report { size: [width, height], depth, threads, hits, records, paths, groups, .. } = report;
    let mut text = format!(
        "{width}x{height} pixels, depth {depth}, {hits} hits, {records} lit records, {paths} paths, {groups} groups\n\
         {threads} threads, medians of {runs} {}\n\n",
        if runs == 1 { "run" } else { "runs" }
    );
    let mut line = |cells: [String; 4]| {
        let [name, one, two, three] = cells;
        // Writing to a string does not fail.
        let _ = writeln!(text, "{}", format!("{name:<22}{one:>16}{two:>16}{three:>16}").trim_end());
    };
    let ms = |value: f64| format!("{value:.3} ms");
    let fps = |value: f64| format!("{:.1} fps", 1000.0 / value);
    let bytes = |value: f64| format!("{value:.1} B");
    let none = String::new;
    line([none(), "jit".into(), "interpreter".into(), none()]);
    line(["trace".into(), ms(report.trace_ms), "-".into(), none()]);
    line(["compile".into(), ms(report.compile_ms), "-".into(), none()]);
    line(["full evaluation".into(), ms(report.full_ms.jit), ms(report.full_ms.interpreter), none()]);
    line([none(), fps(report.full_ms.jit), fps(report.full_ms.interpreter), none()]);
    line(["memory a pixel".into(), bytes(report.bytes_per_pixel.jit), bytes(report.bytes_per_pixel.interpreter), none()]);
    line([none(), none(), none(), none()]);
    line(["slider".into(), "method".into(), "frame".into(), "prepared in".into()]);
    let drag_line = |DragReport { parameter, method, prepare_ms, frame_ms, pixels, .. }: &DragReport| {
        let frame = if *pixels == 0 { "unseen".into() } else { ms(*frame_ms) };
        [parameter.clone(), (*method).into(), frame, ms(*prepare_ms)]
    };
    report.drag.iter().for_each(|drag| line(drag_line(drag)));
    if let Some(passes) = &report.passes {
        line([none(), none(), none(), none()]);
        line([format!("{} passes", passes.passes), "jit".into(), "of one pass".into(), none()]);
        let times = |value: f64, one: f64| format!("x {:.2}", value / one);
        line(["trace".into(), ms(passes.trace_ms), none(), none()]);
        line(["prepare".into(), ms(passes.prepare_ms), none(), none()]);
        line(["full evaluation".into(), ms(passes.full_ms), times(passes.full_ms, passes.one_pass_ms), none()]);
        line(["memory a pixel".into(), bytes(passes.bytes_per_pixel), none(), none()]);
        line(["slider".into(), "method".into(), "frame".into(), "prepared in".into()]);
        for drag in &passes.drag {
            let [parameter, method, frame, prepared] = drag_line(drag);
            let ratio = drag.one_pass_ms.map(|one| times(drag.frame_ms, one)).unwrap_or_default();
            line([parameter, method, format!("{frame} {ratio}"), prepared]);
        }
    }
    text
}
