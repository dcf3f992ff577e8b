//! Compiled evaluation against what a programmer would write by hand for two models and one kind of processor (`README.md`), against the
//! interpreter and against itself: everything in one run, in turns, so that whatever else the machine does hits all alike.
//!
//! `cargo bench --bench peer` prints a table; behind `--`, `--rounds N` sets how many rounds there are and `--json FILE` writes all
//! numbers to a file too. Compilers that are not there, and Dr.Jit, are said to be missing and left out; `PEER_PYTHON` names the Python
//! that has Dr.Jit, `DRJIT_LIBLLVM_PATH` the LLVM that it uses.
#![allow(clippy::expect_used, reason = "a benchmark that cannot go on has failed")]

mod child;
mod report;
mod rounds;
#[path = "../stage/mod.rs"]
mod stage;

use child::{Child, Program, Variant};
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
/// How many rounds there are, unless it is said.
const ROUNDS: usize = 60;
/// A component agrees that differs by at most so much, or so much of it.
const TOLERANCE: f32 = 1e-4;
/// So large a part of the components may differ by more: those at steps of a model.
const BEYOND: f64 = 1e-4;

/// What the command line says.
struct Options {
    /// Whether anything is measured: cargo says so when it benches, and not when it tests.
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

/// What is not known here is cargo's.
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
    let folder = tempfile::tempdir().map_err(|error| format!("cannot make a folder: {error}"))?;
    let dump = folder.path().join("hits");
    let hits = Script::new(Model::Phong, SIZE).trace();
    let stages = Model::ALL.map(|model| (model, Stage::new(Script::new(model, SIZE), &hits)));
    export(&dump, &stages)?;
    let (programs, mut missing) = child::programs(folder.path());
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
    let report = Report { session: SESSION, size: SIZE, hits, records, rounds, others, missing, agreement, times, ratios };
    print!("{report}");
    if let Some(file) = &options.json {
        let text = serde_json::to_string_pretty(&report).map_err(|error| error.to_string())?;
        std::fs::write(file, text + "\n").map_err(|error| format!("cannot write {}: {error}", file.display()))?;
    }
    Ok(())
}

/// Has the program itself write what the peers read, and the values beside it.
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

/// The values of all models, each once, as the peers read them.
fn values_of<'s>(scripts: impl Iterator<Item = &'s Script>) -> String {
    let mut lines = BTreeMap::new();
    for script in scripts {
        let roster = script.values.roster();
        for (owner, id, numbers) in script.values.iter() {
            let key = format!("{} {}", roster.owners().name(owner).unwrap_or("global"), roster.parameter(id).name);
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

/// Starts every peer for every number of threads; those that do not work are missing.
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

/// Holds the pictures of the peers against ours.
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
                // A difference that is NaN is beyond, too.
                let beyond = differences().filter(|difference| *difference > TOLERANCE || difference.is_nan()).count();
                if beyond as f64 > BEYOND * own.len() as f64 {
                    return Err(format!("{peer}: another picture: {beyond} components differ, the worst by {largest:e}"));
                }
                all.push(Agreement { model: model.name(), peer, largest, beyond });
            }
        }
    }
    Ok(all)
}
