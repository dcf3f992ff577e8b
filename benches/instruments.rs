//! Times the charts of the instruments as the window makes them: at rest, and as drafts while a slider is held.
//!
//! `cargo bench --bench instruments` takes each view of three built-in formulas, moves all values before each chart,
//! and prints the medians of the times in milliseconds: the numbers, and the numbers with the drawing. `-- marble`
//! takes another formula. A display shows a frame each 16.7 ms.
#![allow(clippy::expect_used, reason = "a benchmark that cannot go on has failed")]

use illuminator::formula::Formula;
use illuminator::instrument::held::{CompiledModel, HeldFormula};
use illuminator::instrument::model::{Place, default_numbers};
use illuminator::instrument::view::{LightUse, NamedModel, VIEWS, ViewSettings};
use illuminator::lang::source::Source;
use illuminator::plot::{Chart, ChartTheme, painted};
use illuminator::workspace::{FileKind, presets};
use std::sync::Arc;
use std::time::{Duration, Instant};

/// The formulas that are measured.
const FORMULAS: [&str; 3] = ["lambert", "ggx", "disney"];
/// The size of a chart in the window, in pixels.
const SIZE: [u32; 2] = [380, 280];
/// How often each chart is made.
const ROUNDS: usize = 15;

fn main() {
    // `cargo test --benches` only builds it.
    if !std::env::args().any(|argument| argument == "--bench") {
        return;
    }
    let arguments: Vec<String> = std::env::args().skip(1).filter(|argument| !argument.starts_with("--")).collect();
    let formulas: Vec<&str> =
        if arguments.is_empty() { FORMULAS.to_vec() } else { arguments.iter().map(String::as_str).collect() };
    println!("{:<14}{:<13}{:>22}{:>22}", "", "", "at rest, ms", "while held, ms");
    println!("{:<14}{:<13}{:>11}{:>11}{:>11}{:>11}", "formula", "view", "numbers", "drawn", "numbers", "drawn");
    for name in formulas {
        measure(name);
    }
}

/// Measures all views of a built-in formula.
fn measure(name: &str) {
    let text = presets::text(FileKind::Formula, name).expect("a built-in formula");
    let (formula, _) = Formula::parse(&Source::new(name, text)).expect("a sound formula");
    let numbers = default_numbers(&formula);
    let compiled = Arc::new(CompiledModel::new(Arc::new(formula)));
    for view in &VIEWS {
        let mut columns = Vec::new();
        for is_draft in [false, true] {
            let settings = ViewSettings { is_draft, ..ViewSettings::default() };
            let mut times: [Vec<Duration>; 2] = Default::default();
            for round in 0..=ROUNDS {
                // All values change a little.
                let moved = numbers.iter().map(|number| number.map(|number| number * (1.0 - 1e-3 * round as f32))).collect();
                // As in the window: integrals at rest ask for other pairs each time.
                let keeps_pairs = view.lights != LightUse::Integrated || is_draft;
                let held = HeldFormula { compiled: Arc::clone(&compiled), numbers: moved, place: Place::default(), keeps_pairs };
                let models = [NamedModel { name: name.to_owned(), model: Arc::new(held) }];
                let start = Instant::now();
                let chart = view.chart(&models, &settings);
                let of_numbers = start.elapsed();
                if matches!(chart, Chart::Map(_) | Chart::Lobe(_)) {
                    painted(&chart.figure(SIZE, ChartTheme::Dark)).expect("a picture");
                }
                // The first chart also compiles the formula, and prepares what is kept.
                if round > 0 {
                    times[0].push(of_numbers);
                    times[1].push(start.elapsed());
                }
            }
            columns.extend(times.map(|times| format!("{:>11.2}", 1e3 * median(times).as_secs_f64())));
        }
        println!("{name:<14}{:<13}{}", view.name, columns.concat());
    }
}

fn median(mut times: Vec<Duration>) -> Duration {
    times.sort_unstable();
    times[times.len() / 2]
}
