//! The peers as child processes: finds compilers, compiles, starts programs and talks to them. `README.md` has the
//! protocol.

use crate::stage::Model;
use illuminator::jit::Width;
use std::fmt::Display;
use std::io::{BufRead, BufReader, Write};
use std::path::{Path, PathBuf};
use std::process::{ChildStdin, ChildStdout, Command, Stdio};
use std::time::Duration;

/// A little longer than the threads of a C peer spin while they wait for the next frame. Nothing else is measured
/// meanwhile.
const C_SPINS: Duration = Duration::from_millis(5);
/// The same for Dr.Jit.
const DRJIT_SPINS: Duration = Duration::from_millis(30);

/// The flags that let a C compiler use vectors of a width. Nothing else is enabled, so that a narrow peer uses no
/// instruction that processors without wider vectors lack.
fn instruction_set(width: Width) -> &'static [&'static str] {
    match width {
        Width::Four => &["-msse4.1"],
        Width::Eight => &["-mavx2", "-mfma"],
        Width::Sixteen => &["-mavx512f", "-mavx512bw", "-mavx512dq", "-mfma"],
    }
}

/// The data that a peer has in memory when a frame begins.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Variant {
    /// Normals, directions to the viewer and to lights.
    Directions,
    /// Their dot products alone.
    Dots,
}

impl Variant {
    pub(crate) const ALL: [Variant; 2] = [Variant::Directions, Variant::Dots];

    /// Its name in the protocol.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Variant::Directions => "nlv",
            Variant::Dots => "dots",
        }
    }
}

/// How to start a peer.
pub(crate) struct Program {
    /// The compiler: `gcc 12.2.0`.
    pub(crate) name: String,
    /// Whether it was compiled from `peer.c`.
    pub(crate) is_c: bool,
    command: Vec<PathBuf>,
}

/// The peers that are available here with vectors of this width, and why others are not. The C peers are compiled
/// into `folder`.
pub(crate) fn programs(folder: &Path, width: Width) -> (Vec<Program>, Vec<String>) {
    let clangs = ["clang".to_owned()].into_iter().chain((15..=22).rev().map(|version| format!("clang-{version}")));
    let gcc = ["gcc".to_owned()].into_iter();
    let tried = [c_peer("clang", clangs, folder, width), c_peer("gcc", gcc, folder, width), drjit_peer(width)];
    let (mut programs, mut missing) = (Vec::new(), Vec::new());
    for tried in tried {
        match tried {
            Ok(program) => programs.push(program),
            Err(reason) => missing.push(reason),
        }
    }
    (programs, missing)
}

/// The peer in C, compiled by the newest of several compilers.
fn c_peer(family: &str, compilers: impl Iterator<Item = String>, folder: &Path, width: Width) -> Result<Program, String> {
    let versioned = compilers.filter_map(|compiler| Some((version(&compiler)?, compiler)));
    let (version, compiler) = versioned.max().ok_or_else(|| format!("{family}: not found"))?;
    let name = format!("{family} {}", version.iter().map(u32::to_string).collect::<Vec<_>>().join("."));
    let program = folder.join(format!("peer-{family}"));
    let output = Command::new(&compiler)
        .args(["-O3", "-mtune=native", "-ffast-math", "-std=gnu11"])
        .args(instruction_set(width))
        .arg(format!("-DLANES={}", width.lanes()))
        .arg(source("peer.c"))
        .arg("-o")
        .arg(&program)
        .args(["-lm", "-lpthread"])
        .output()
        .map_err(|error| format!("{name}: {error}"))?;
    if !output.status.success() {
        let text = String::from_utf8_lossy(&output.stderr).into_owned();
        let reason = text.lines().find(|line| line.contains("error")).unwrap_or("it failed").to_owned();
        return Err(format!("{name}: it cannot compile peer.c: {reason}"));
    }
    Ok(Program { name, is_c: true, command: vec![program] })
}

/// The version of the compiler with this name, if there is one.
fn version(compiler: &str) -> Option<Vec<u32>> {
    // `-dumpversion` alone gives only the first number of gcc's version.
    let output = Command::new(compiler).args(["-dumpfullversion", "-dumpversion"]).stderr(Stdio::null()).output().ok()?;
    let text = String::from_utf8(output.stdout).ok().filter(|_| output.status.success())?;
    text.trim().split('.').map(|number| number.parse().ok()).collect()
}

/// The peer in Dr.Jit, if Python has it.
fn drjit_peer(width: Width) -> Result<Program, String> {
    if Width::supported().any(|wider| wider > width) {
        return Err("Dr.Jit: it always uses the widest vectors of the processor".to_owned());
    }
    let python = std::env::var_os("PEER_PYTHON").unwrap_or_else(|| "python3".into());
    let missing = || format!("Dr.Jit: `{}` has no such package (PEER_PYTHON chooses another Python)", python.display());
    let script = "import drjit, numpy; print(drjit.__version__)";
    let output = Command::new(&python).args(["-c", script]).stderr(Stdio::null()).output().map_err(|_| missing())?;
    let version = String::from_utf8(output.stdout).ok().filter(|_| output.status.success()).ok_or_else(missing)?;
    let command = vec![python.into(), source("peer_drjit.py")];
    Ok(Program { name: format!("Dr.Jit {}", version.trim()), is_c: false, command })
}

fn source(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("benches/peer").join(name)
}

/// A running peer.
pub(crate) struct Child {
    pub(crate) name: String,
    pub(crate) is_c: bool,
    pub(crate) threads: usize,
    /// The hits and lit records that it read.
    pub(crate) counts: [u64; 2],
    process: std::process::Child,
    input: ChildStdin,
    output: BufReader<ChildStdout>,
}

impl Child {
    /// Starts a peer on exported hits and makes a frame of each kind, so that whatever it compiles is compiled now.
    pub(crate) fn start(program: &Program, dump: &Path, threads: usize) -> Result<Self, String> {
        let failed = |error: &dyn Display| format!("{}: {error}", program.name);
        let mut process = Command::new(&program.command[0])
            .args(&program.command[1..])
            .arg(dump)
            .arg(threads.to_string())
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .map_err(|error| failed(&error))?;
        let pipes = process.stdin.take().zip(process.stdout.take());
        let (input, output) = pipes.ok_or_else(|| failed(&"no pipes"))?;
        let output = BufReader::new(output);
        let mut child = Self { name: program.name.clone(), is_c: program.is_c, threads, counts: [0; 2], process, input, output };
        let ready = child.answer()?;
        let mut counts = ready.strip_prefix("ready ").into_iter().flat_map(|counts| counts.split(' ')).map(str::parse);
        match (counts.next(), counts.next()) {
            (Some(Ok(hits)), Some(Ok(records))) => child.counts = [hits, records],
            _ => return Err(failed(&format!("it answers `{ready}`, not `ready`"))),
        }
        for model in Model::ALL {
            for variant in Variant::ALL {
                child.frame(model, variant)?;
            }
        }
        child.rest();
        Ok(child)
    }

    /// Makes a frame and returns its milliseconds.
    pub(crate) fn frame(&mut self, model: Model, variant: Variant) -> Result<f64, String> {
        self.milliseconds(&format!("frame {} {}", model.name(), variant.name()))
    }

    /// Streams through three arrays that have this many bytes together, and returns the milliseconds.
    pub(crate) fn triad(&mut self, bytes: usize) -> Result<f64, String> {
        self.milliseconds(&format!("triad {}", bytes / 3 / 4 * 4))
    }

    /// Writes a picture to a file, as linear numbers.
    pub(crate) fn write(&mut self, model: Model, variant: Variant, file: &Path) -> Result<(), String> {
        let answer = self.ask(&format!("write {} {} {}", model.name(), variant.name(), file.display()))?;
        if answer == "ok" { Ok(()) } else { Err(self.failed(&format!("it answers `{answer}`"))) }
    }

    /// Waits until its threads sleep.
    pub(crate) fn rest(&self) {
        if self.threads > 1 {
            std::thread::sleep(if self.is_c { C_SPINS } else { DRJIT_SPINS });
        }
    }

    fn milliseconds(&mut self, line: &str) -> Result<f64, String> {
        let answer = self.ask(line)?;
        answer.parse().map_err(|_| self.failed(&format!("it answers `{answer}`, not milliseconds")))
    }

    fn ask(&mut self, line: &str) -> Result<String, String> {
        writeln!(self.input, "{line}").map_err(|error| self.failed(&error))?;
        self.answer()
    }

    fn answer(&mut self) -> Result<String, String> {
        let mut line = String::new();
        match self.output.read_line(&mut line) {
            Ok(0) => Err(self.failed(&"it ended")),
            Ok(_) => Ok(line.trim().to_owned()),
            Err(error) => Err(self.failed(&error)),
        }
    }

    fn failed(&self, error: &dyn Display) -> String {
        format!("{}: {error}", self.name)
    }
}

impl Drop for Child {
    fn drop(&mut self) {
        // It does not matter whether the process has ended by itself.
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}
