//! `illuminator bench`: how fast each stage is.

use crate::cli::engine;
use crate::cli::input::{Input, load};
use crate::cli::options::InputOptions;
use crate::cli::progress::Progress;
use crate::cli::report::{Failure, print};
use clap::Args;
use illuminator::evaluate::{Compiled, Frame, Interpreted};
use illuminator::formula::ParameterId;
use illuminator::jit::CompiledFormula;
use illuminator::trace::{Counts, Hits};
use illuminator::workspace::{OwnerId, Values};
use serde::Serialize;
use std::fmt::Write;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// No measurement is repeated after it has taken so long altogether.
const PATIENCE: Duration = Duration::from_secs(10);

/// Options of `bench`.
#[derive(Args, Debug)]
pub(super) struct Options {
    #[command(flatten)]
    input: InputOptions,
    /// How often each stage is measured; medians are shown
    #[arg(long, value_name = "N", default_value_t = 7, value_parser = clap::value_parser!(u32).range(1..=1000))]
    runs: u32,
    /// The slider that is dragged [default: the first that can be]
    #[arg(long, value_name = "OWNER.PARAM")]
    slider: Option<String>,
    /// Print JSON instead of a table
    #[arg(long)]
    json: bool,
}

/// What was measured.
#[derive(Serialize)]
struct Report {
    width: u32,
    height: u32,
    depth: u32,
    threads: usize,
    runs: u32,
    hits: u64,
    lit_records: u64,
    slider: Option<String>,
    trace_ms: f64,
    jit: Stages,
    interpreter: Stages,
}

/// What was measured of one backend; times in milliseconds.
#[derive(Serialize)]
struct Stages {
    compile_ms: f64,
    static_values_ms: Option<f64>,
    evaluation_ms: f64,
    evaluation_fps: f64,
    drag_ms: Option<f64>,
    drag_fps: Option<f64>,
    bytes_per_pixel: f64,
}

/// Measures and tells.
pub(super) fn run(options: &Options) -> Result<(), Failure> {
    let input = load(&options.input)?;
    let slider = match &options.slider {
        Some(label) => Some(find_slider(&input.values, label)?),
        None => candidates(&input.values).next(),
    };
    let report = engine::on_threads(&options.input.machine, || measure(options, &input, slider))??;
    if options.json {
        let text = serde_json::to_string_pretty(&report).map_err(|error| Failure::input(error.to_string()))?;
        print(&format!("{text}\n"))
    } else {
        print(&table(&report))
    }
}

/// The values that a slider can move: first the formula's own that ask for a slider, then all others.
fn candidates(values: &Values) -> impl Iterator<Item = (OwnerId, ParameterId)> {
    let asks = |id: ParameterId| {
        let parameter = values.roster().parameter(id);
        parameter.slider && parameter.predefined.is_none()
    };
    let movable = move |asked: bool| {
        let all = values.iter().map(|(owner, id, _)| (owner, id));
        all.filter(move |(owner, id)| asks(*id) == asked && values.lock_of(*owner, *id).is_none())
    };
    movable(true).chain(movable(false))
}

fn find_slider(values: &Values, label: &str) -> Result<(OwnerId, ParameterId), Failure> {
    let named = |(owner, id): &(OwnerId, ParameterId)| values.roster().label(*owner, *id) == label;
    let Some((owner, id)) = values.iter().map(|(owner, id, _)| (owner, id)).find(named) else {
        return Err(Failure::command_line(format!("--slider {label}: there is no such value")));
    };
    match values.lock_of(owner, id) {
        Some(reason) => Err(Failure::command_line(format!("--slider {label}: it cannot be moved: {reason}"))),
        None => Ok((owner, id)),
    }
}

fn measure(options: &Options, input: &Input, slider: Option<(OwnerId, ParameterId)>) -> Result<Report, Failure> {
    let view = &input.view;
    let bytes = engine::memory_for(view, &options.input.machine)?;
    let progress = Progress::new("measuring");
    let clock = Clock { runs: options.runs, progress: &progress, stages: 8.0 };
    let (compile_ms, compiled) =
        clock.time(0, || CompiledFormula::new(&input.formula).map_err(|e| Failure::input(e.to_string())))?;
    let compiled = Arc::new(compiled);
    let (trace_ms, hits) = clock.time(1, || engine::trace_for(&compiled, input, view, bytes, &|_| ()))?;
    let (static_values_ms, evaluator) = clock.time(2, || engine::compiled_backend(&compiled, input, &hits))?;
    let evaluator = (evaluator, std::cell::RefCell::new(illuminator::evaluate::Framebuffer::black(view.width(), view.height())));
    let jit = Stages { static_values_ms: Some(static_values_ms), ..stages(&clock, 3, compile_ms, &evaluator, input, slider)? };
    drop(evaluator);
    let (compile_ms, evaluator) = clock.time(5, || engine::interpreter(input, *view))?;
    let interpreter = stages(&clock, 6, compile_ms, &evaluator, input, slider)?;
    let Counts { hits, records, .. } = Hits::counts(&hits);
    Ok(Report {
        width: view.width(),
        height: view.height(),
        depth: view.depth(),
        threads: rayon::current_num_threads(),
        runs: options.runs,
        hits,
        lit_records: records,
        slider: slider.map(|(owner, id)| input.values.roster().label(owner, id)),
        trace_ms,
        jit,
        interpreter,
    })
}

/// A backend ready to make frames.
trait Engine {
    /// A frame, and the time that evaluation alone took.
    fn timed_frame(&self, numbers: &[f32]) -> (Frame, Duration);
    /// The memory that all pixels take.
    fn bytes(&self, numbers: &[f32]) -> u64;
}

impl Engine for (Compiled, std::cell::RefCell<illuminator::evaluate::Framebuffer>) {
    fn timed_frame(&self, numbers: &[f32]) -> (Frame, Duration) {
        let start = Instant::now();
        self.0.draw(numbers, &mut self.1.borrow_mut());
        (Frame::black(1, 1), start.elapsed())
    }

    fn bytes(&self, _: &[f32]) -> u64 {
        Compiled::bytes(&self.0) as u64
    }
}

impl Engine for Interpreted {
    fn timed_frame(&self, numbers: &[f32]) -> (Frame, Duration) {
        let (frame, timing) = self.frame(numbers);
        // Programs are written in between; what running them took is added up over threads.
        (frame, timing.evaluation / rayon::current_num_threads() as u32)
    }

    fn bytes(&self, numbers: &[f32]) -> u64 {
        self.frame(numbers).1.bytes
    }
}

/// Measures frames with the values at hand, and with one slider moved to and fro.
fn stages(
    clock: &Clock,
    first: u32,
    compile_ms: f64,
    engine: &impl Engine,
    input: &Input,
    slider: Option<(OwnerId, ParameterId)>,
) -> Result<Stages, Failure> {
    let evaluation_ms = clock.median(first, || Ok(engine.timed_frame(input.values.numbers()).1))?;
    let mut values = input.values.clone();
    let mut towards = 0;
    let drag_ms = slider.map(|(owner, id)| {
        clock.median(first + 1, || {
            let [low, high] = values.range_of(owner, id).unwrap_or([0.0, 1.0]);
            let share = [0.25, 0.75][towards];
            towards = 1 - towards;
            let start = Instant::now();
            values.move_to(owner, id, [low + share * (high - low); 3]);
            let moved = start.elapsed();
            Ok(moved + engine.timed_frame(values.numbers()).1)
        })
    });
    let drag_ms = drag_ms.transpose()?;
    Ok(Stages {
        compile_ms,
        static_values_ms: None,
        evaluation_ms,
        evaluation_fps: 1000.0 / evaluation_ms,
        drag_ms,
        drag_fps: drag_ms.map(|ms| 1000.0 / ms),
        bytes_per_pixel: engine.bytes(input.values.numbers()) as f64 / f64::from(input.view.pixels()),
    })
}

/// Repeats measurements.
struct Clock<'p> {
    runs: u32,
    progress: &'p Progress,
    stages: f64,
}

impl Clock<'_> {
    /// The median of what `once` returns, in milliseconds.
    fn median(&self, stage: u32, mut once: impl FnMut() -> Result<Duration, Failure>) -> Result<f64, Failure> {
        let start = Instant::now();
        let mut times = Vec::new();
        for run in 0..self.runs {
            self.progress.tell((f64::from(stage) + f64::from(run) / f64::from(self.runs)) / self.stages);
            times.push(once()?);
            if start.elapsed() > PATIENCE {
                break;
            }
        }
        times.sort();
        let middle = times.get(times.len() / 2).copied().unwrap_or_default();
        // What is too short for the clock still took some time.
        Ok(middle.as_secs_f64().max(1e-9) * 1000.0)
    }

    /// The median time of making something, in milliseconds, and what the last run made.
    fn time<T>(&self, stage: u32, mut make: impl FnMut() -> Result<T, Failure>) -> Result<(f64, T), Failure> {
        let mut made = None;
        let median = self.median(stage, || {
            // Freed before the clock starts: memory for two may not be there.
            made = None;
            let start = Instant::now();
            made = Some(make()?);
            Ok(start.elapsed())
        })?;
        made.map(|made| (median, made)).ok_or_else(|| Failure::command_line("at least one run is needed"))
    }
}

fn table(report: &Report) -> String {
    let mut text = String::new();
    let mut line = |name: &str, jit: String, interpreter: String| {
        // Writing to a string does not fail.
        let _ = writeln!(text, "{}", format!("{name:<22}{jit:>16}{interpreter:>16}").trim_end());
    };
    let ms = |value: f64| format!("{value:.3} ms");
    let maybe = |value: Option<f64>, show: fn(f64) -> String| value.map_or("-".to_owned(), show);
    let fps = |value: f64| format!("{value:.1} fps");
    let (jit, interpreter) = (&report.jit, &report.interpreter);
    line("", "jit".to_owned(), "interpreter".to_owned());
    line("trace", ms(report.trace_ms), "-".to_owned());
    line("compile", ms(jit.compile_ms), ms(interpreter.compile_ms));
    line("static values", maybe(jit.static_values_ms, |v| format!("{v:.3} ms")), "-".to_owned());
    line("full evaluation", ms(jit.evaluation_ms), ms(interpreter.evaluation_ms));
    line("", fps(jit.evaluation_fps), fps(interpreter.evaluation_fps));
    line("slider drag", maybe(jit.drag_ms, |v| format!("{v:.3} ms")), maybe(interpreter.drag_ms, |v| format!("{v:.3} ms")));
    line("", maybe(jit.drag_fps, |v| format!("{v:.1} fps")), maybe(interpreter.drag_fps, |v| format!("{v:.1} fps")));
    let bytes = |value: f64| format!("{value:.1} B");
    line("memory a pixel", bytes(jit.bytes_per_pixel), bytes(interpreter.bytes_per_pixel));
    let Report { width, height, depth, threads, runs, hits, lit_records, slider, .. } = report;
    let slider = slider.as_deref().unwrap_or("none");
    format!(
        "{width}x{height} pixels, depth {depth}, {hits} hits, {lit_records} lit records\n\
         {threads} threads, medians of {runs} runs, slider: {slider}\n\n{text}"
    )
}
