//! Compares compiled evaluation with hand-written programs for two models (`README.md`), with the interpreter and with
//! drags. Everything is measured in one run and in turns, so that other work on the machine affects all alike.
//!
//! `cargo bench --bench peer` prints a table. After `--`, `--rounds N` sets the number of rounds and `--json FILE` also
//! writes all numbers to a file. `ILLUMINATOR_LANES=8` or `4` limits the vectors of both sides. A compiler that is not
//! installed is reported and left out, and so is Dr.Jit. `PEER_PYTHON` chooses the Python that has Dr.Jit,
//! `DRJIT_LIBLLVM_PATH` the LLVM that it uses.
#![allow(clippy::expect_used, reason = "a benchmark that cannot go on has failed")]

mod child;
mod report;
mod rounds;
#[path = "../stage/mod.rs"]
mod stage;

use child::{Child, Program, Variant};
use illuminator::jit::Width;
use rayon::ThreadPool;
use report::{Agreement, Report, Times};
use rounds::{Contender, DISCARDED};
use stage::{Model, SESSION, Script, Stage};
use std::cell::RefCell;
use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};

const SIZE: [u32; 2] = [1280, 720];
/// The number of rounds without `--rounds`.
const ROUNDS: usize = 60;
/// Components agree if they differ by at most this, or by this part of a value above 1.
const TOLERANCE: f32 = 1e-4;
/// The part of the components that may differ by more, since models have steps.
const BEYOND: f64 = 1e-4;

/// The command line.
struct Options {
    /// Whether to measure: `cargo bench` asks for it, `cargo test` does not.
    measure: bool,
    rounds: usize,
    json: Option<PathBuf>,
}

fn main() -> ExitCode {
    let done = options().and_then(|options| if options.measure { run(&options) } else { Ok(()) });
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(message) => {
            eprintln!("peer: {message}");
            ExitCode::FAILURE
        }
    }
}

/// Reads the command line. Unknown options are cargo's and are ignored.
fn options() -> Result<Options, String> {
    let mut options = Options { measure: false, rounds: ROUNDS, json: None };
    let mut arguments = std::env::args_os().skip(1);
    while let Some(argument) = arguments.next() {
        match argument.to_str() {
            Some("--bench") => options.measure = true,
            Some("--rounds") => {
                let number = arguments.next().and_then(|number| number.to_str()?.parse().ok());
                let more = number.filter(|number| *number > DISCARDED);
                options.rounds = more.ok_or_else(|| format!("--rounds takes a number above {DISCARDED}"))?;
            }
            Some("--json") => options.json = Some(arguments.next().ok_or("--json takes a file")?.into()),
            Some(_) | None => {}
        }
    }
    Ok(options)
}

fn run(options: &Options) -> Result<(), String> {
    let width = Width::widest().map_err(|error| error.to_string())?;
    let folder = tempfile::tempdir().map_err(|error| format!("cannot make a folder: {error}"))?;
    let dump = folder.path().join("hits");
    let hits = Script::new(Model::Phong, SIZE).trace();
    let stages = Model::ALL.map(|model| (model, Stage::new(Script::new(model, SIZE), &hits)));
    export(&dump, &stages)?;
    let (programs, mut missing) = child::programs(folder.path(), width);
    let pools = stage::pools();
    let children = start(&programs, &dump, &pools, &mut missing);
    let counts = hits.counts();
    let own = [counts.hits, counts.records];
    for child in &children {
        if child.borrow().counts != own {
            return Err(format!("{} has {:?} hits and records, not {own:?}", child.borrow().name, child.borrow().counts));
        }
    }
    let agreement = agreement(&stages, &children, folder.path())?;
    let mut contenders = Vec::new();
    for (model, stage) in &stages {
        for pool in &pools {
            contenders.extend(rounds::enter(*model, stage, pool, &children)?);
        }
    }
    let others = rounds::measure(&mut contenders, options.rounds)?;
    let times: Vec<Times> = contenders.into_iter().filter_map(Contender::times).collect();
    let ratios = report::ratios(&times);
    let [hits, records] = own;
    let rounds = options.rounds - DISCARDED;
    let report = Report {
        session: SESSION,
        size: SIZE,
        lanes: width.lanes(),
        hits,
        records,
        rounds,
        others,
        missing,
        agreement,
        times,
        ratios,
    };
    print!("{report}");
    if let Some(file) = &options.json {
        let text = serde_json::to_string_pretty(&report).map_err(|error| error.to_string())?;
        std::fs::write(file, text + "\n").map_err(|error| format!("cannot write {}: {error}", file.display()))?;
    }
    Ok(())
}

/// Writes the files that the peers read: the hits by the program itself, the values beside them.
fn export(dump: &Path, stages: &[(Model, Stage)]) -> Result<(), String> {
    let [width, height] = SIZE;
    let output = Command::new(env!("CARGO_BIN_EXE_illuminator"))
        .args(["dump", SESSION, "--formula", &Model::Phong.location().to_string(), "--stage", "hits"])
        .args(["--size", &format!("{width}x{height}")])
        .arg("-o")
        .arg(dump)
        .output()
        .map_err(|error| format!("the program does not run: {error}"))?;
    if !output.status.success() {
        return Err(format!("the program fails: {}", String::from_utf8_lossy(&output.stderr)));
    }
    let scripts = stages.iter().map(|(_, stage)| &stage.script);
    std::fs::write(dump.join("values.txt"), values_of(scripts)).map_err(|error| format!("cannot write values.txt: {error}"))
}

/// The values of all models, each once, in the format that the peers read.
fn values_of<'s>(scripts: impl Iterator<Item = &'s Script>) -> String {
    let mut lines = BTreeMap::new();
    for script in scripts {
        let table = script.values.table();
        for (owner, id, numbers) in script.values.iter() {
            let key = format!("{} {}", table.owners().name(owner).unwrap_or("global"), table.parameter(id).name);
            let line = numbers.iter().fold(key.clone(), |line, number| format!("{line} {number}"));
            lines.insert(key, line);
        }
    }
    lines.values().fold(String::new(), |mut text, line| {
        // Writing to a string does not fail.
        let _ = writeln!(text, "{line}");
        text
    })
}

/// Starts every peer for every number of threads. Peers that do not work are added to `missing`.
fn start(programs: &[Program], dump: &Path, pools: &[ThreadPool], missing: &mut Vec<String>) -> Vec<RefCell<Child>> {
    let mut children = Vec::new();
    for program in programs {
        let of_program = pools.iter().map(|pool| Child::start(program, dump, pool.current_num_threads()));
        match of_program.collect::<Result<Vec<_>, _>>() {
            Ok(of_program) => children.extend(of_program.into_iter().map(RefCell::new)),
            Err(reason) => missing.push(reason),
        }
    }
    children
}

/// Compares the pictures of the peers with ours.
fn agreement(stages: &[(Model, Stage)], children: &[RefCell<Child>], folder: &Path) -> Result<Vec<Agreement>, String> {
    let mut all = Vec::new();
    for (model, stage) in stages {
        let own = stage.compiled.frame(stage.script.values.numbers());
        let own: Vec<f32> = own.linear.iter().flatten().copied().collect();
        for child in children.iter().filter(|child| child.borrow().threads == 1) {
            for variant in Variant::ALL {
                let mut child = child.borrow_mut();
                let file = folder.join("picture.f32");
                child.write(*model, variant, &file)?;
                let bytes = std::fs::read(&file).map_err(|error| format!("cannot read a peer's picture: {error}"))?;
                let theirs: Vec<f32> = bytes.chunks_exact(4).map(|b| f32::from_le_bytes([b[0], b[1], b[2], b[3]])).collect();
                let peer = format!("{} {}", child.name, variant.name());
                if theirs.len() != own.len() {
                    return Err(format!("{peer}: a picture of {} components, not {}", theirs.len(), own.len()));
                }
                let differences = || own.iter().zip(&theirs).map(|(own, their)| (own - their).abs() / own.abs().max(1.0));
                let largest = differences().max_by(f32::total_cmp).unwrap_or_default();
                // NaN counts as beyond the tolerance.
                let beyond = differences().filter(|difference| *difference > TOLERANCE || difference.is_nan()).count();
                if beyond as f64 > BEYOND * own.len() as f64 {
                    return Err(format!("{peer}: its picture differs in {beyond} components, by at most {largest:e}"));
                }
                all.push(Agreement { model: model.name(), peer, largest, beyond });
            }
        }
    }
    Ok(all)
}
