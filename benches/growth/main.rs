//! Measures how the cost of each stage grows with the picture, the scene and the formula. One of them grows at a time.
//!
//! `cargo bench --bench growth` prints a table in about two minutes. After `--`, `--plot FILE.svg` also draws it.
//! Scenes and formulas are generated, everything runs on one thread and in turns, and the best time counts.
#![allow(clippy::expect_used, reason = "a benchmark that cannot go on has failed")]

mod plot;
mod workload;

use illuminator::trace::Counts;
use rayon::ThreadPoolBuilder;
use std::path::PathBuf;
use std::process::ExitCode;
use workload::{Cost, Stage, Workload};

/// The size of the picture while sines grow in number: each of them takes a column.
pub(crate) const SMALL: [u32; 2] = [64, 36];

/// The number of rounds.
const ROUNDS: usize = 8;

/// The measurements while one thing grows.
pub(crate) struct Sweep {
    /// What grows.
    pub(crate) name: &'static str,
    /// The title of its panel.
    pub(crate) label: &'static str,
    /// Positions and labels on its axis.
    pub(crate) ticks: Vec<(f64, String)>,
    /// Amounts in ascending order, with the costs.
    pub(crate) points: Vec<(f64, Cost)>,
}

/// One line of the plot.
pub(crate) struct Series {
    pub(crate) name: &'static str,
    /// Its milliseconds.
    pub(crate) of: fn(&Cost) -> f64,
}

pub(crate) const SERIES: [Series; 4] = [
    Series { name: "full evaluation", of: |cost| cost.full },
    Series { name: "tracing", of: |cost| cost.trace },
    Series { name: "compiling", of: |cost| cost.compile },
    Series { name: "frame of an image drag", of: |cost| cost.drag },
];

/// The command line.
struct Options {
    /// Whether to measure: `cargo bench` asks for it, `cargo test` does not.
    measure: bool,
    plot: Option<PathBuf>,
}

fn main() -> ExitCode {
    let done = options().and_then(|options| if options.measure { run(&options) } else { Ok(()) });
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(message) => {
            eprintln!("growth: {message}");
            ExitCode::FAILURE
        }
    }
}

/// Reads the command line. Unknown options are cargo's and are ignored.
fn options() -> Result<Options, String> {
    let mut options = Options { measure: false, plot: None };
    let mut arguments = std::env::args_os().skip(1);
    while let Some(argument) = arguments.next() {
        match argument.to_str() {
            Some("--bench") => options.measure = true,
            Some("--plot") => options.plot = Some(arguments.next().ok_or("--plot takes a file")?.into()),
            Some(_) | None => {}
        }
    }
    Ok(options)
}

fn run(options: &Options) -> Result<(), String> {
    let pool = ThreadPoolBuilder::new().num_threads(1).build().map_err(|error| error.to_string())?;
    let sweeps = pool.install(|| measured(plans()));
    tell(&sweeps);
    if let Some(file) = &options.plot {
        std::fs::write(file, plot::svg(&sweeps)).map_err(|error| format!("cannot write {}: {error}", file.display()))?;
    }
    Ok(())
}

/// What to measure while one thing grows.
struct Plan {
    name: &'static str,
    label: &'static str,
    ticks: Vec<(f64, String)>,
    workloads: Vec<(f64, Workload)>,
}

/// The plans: in each, one thing grows.
fn plans() -> Vec<Plan> {
    let growing = |name, label, amounts: &[u32], ticks: &[u32], with: fn(u32) -> Workload| Plan {
        name,
        label,
        ticks: ticks.iter().map(|tick| (f64::from(*tick), tick.to_string())).collect(),
        workloads: amounts.iter().map(|amount| (f64::from(*amount), with(*amount))).collect(),
    };
    let typical = Workload::TYPICAL;
    let sizes = [[160, 90], [320, 180], [640, 360], [960, 540], [1280, 720], [1920, 1080]];
    let pixels = |size: [u32; 2]| f64::from(size[0] * size[1]);
    let pixels = Plan {
        name: "pixels",
        label: "pixels (16:9, by height)",
        // The labels of 540 and 720 would touch.
        ticks: sizes.iter().filter(|size| size[1] != 540).map(|size| (pixels(*size), size[1].to_string())).collect(),
        workloads: sizes.map(|size| (pixels(size), Workload { size, ..typical })).to_vec(),
    };
    vec![
        pixels,
        growing("lights", "lights", &[1, 2, 4, 8, 16, 32, 64], &[1, 2, 4, 8, 16, 32, 64], |lights| Workload {
            lights,
            ..Workload::TYPICAL
        }),
        growing("spheres", "spheres", &[1, 4, 9, 16, 36, 64], &[1, 4, 9, 16, 36, 64], |amount| Workload {
            spheres_a_side: amount.isqrt(),
            ..Workload::TYPICAL
        }),
        growing("depth", "depth of rays", &[1, 2, 3, 4, 5, 6, 7, 8, 9], &[1, 2, 3, 4, 5, 7, 9], |depth| Workload {
            depth,
            ..Workload::TYPICAL
        }),
        growing("terms", "highlights in the formula", &[1, 2, 4, 8, 16, 32, 64], &[1, 2, 4, 8, 16, 32, 64], |terms| Workload {
            terms,
            ..Workload::TYPICAL
        }),
        growing("sines", "static sines in the formula", &[125, 250, 500, 1000, 2000], &[125, 250, 500, 1000, 2000], |sines| {
            Workload { sines, size: SMALL, ..Workload::TYPICAL }
        }),
    ]
}

/// Measures everything in turns, so that other work on the machine affects all alike.
fn measured(plans: Vec<Plan>) -> Vec<Sweep> {
    let ready = |plan: Plan| {
        let stages: Vec<(f64, Stage)> = plan.workloads.into_iter().map(|(amount, workload)| (amount, workload.stage())).collect();
        (Sweep { name: plan.name, label: plan.label, ticks: plan.ticks, points: Vec::new() }, stages)
    };
    let mut all: Vec<_> = plans.into_iter().map(ready).collect();
    for _ in 0..ROUNDS {
        all.iter_mut().flat_map(|(_, stages)| stages).for_each(|(_, stage)| stage.measure());
    }
    let costs = |stages: Vec<(f64, Stage)>| stages.into_iter().map(|(amount, stage)| (amount, stage.cost)).collect();
    all.into_iter().map(|(sweep, stages)| Sweep { points: costs(stages), ..sweep }).collect()
}

/// Prints the table, and below each part the slopes on logarithmic axes, where 1 is linear.
fn tell(sweeps: &[Sweep]) {
    println!(
        "grows,    amount,     hits,  records, groups,  spans,  paths,filled,bytes/px,  full ms, trace ms,compile ms, drag ms,drag by"
    );
    for Sweep { name, points, .. } in sweeps {
        for (amount, cost) in points {
            let Cost { counts, spans, filled, bytes_per_pixel, full, trace, compile, drag, method } = cost;
            let Counts { hits, records, groups, paths, .. } = counts;
            let counts = format!("{hits:>9},{records:>9},{groups:>7},{spans:>7},{paths:>7},{filled:>6.2},{bytes_per_pixel:>8.1}");
            println!("{name:<7},{amount:>8},{counts},{full:>9.3},{trace:>9.2},{compile:>10.2},{drag:>8.3},{}", method.name());
        }
        if let [first, .., before, last] = &points[..] {
            for (what, from) in [("all in all", first), ("at the end", before)] {
                let slopes = SERIES.iter().map(|Series { name, of }| {
                    let slope = (of(&last.1) / of(&from.1)).ln() / (last.0 / from.0).ln();
                    format!("{name} {slope:.2}")
                });
                println!("# {name}, exponent {what}: {}", slopes.collect::<Vec<_>>().join(", "));
            }
        }
    }
}
