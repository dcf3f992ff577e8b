//! The peers as child processes: finding compilers, compiling, starting, asking. `README.md` has the protocol.

use crate::stage::Model;
use std::fmt::Display;
use std::io::{BufRead, BufReader, Write};
use std::path::{Path, PathBuf};
use std::process::{ChildStdin, ChildStdout, Command, Stdio};
use std::time::Duration;

/// Threads of the peer in C wait awake for a little less than this for the next frame; nothing else is measured meanwhile.
const AWAKE: Duration = Duration::from_millis(5);
/// Those of Dr.Jit wait longer.
const DRJIT_AWAKE: Duration = Duration::from_millis(30);

/// What a peer has in memory when a frame begins.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Variant {
    /// Normals, directions to the viewer and to lights.
    Directions,
    /// Their dot products.
    Dots,
}

impl Variant {
    pub(crate) const ALL: [Variant; 2] = [Variant::Directions, Variant::Dots];

    /// As the protocol calls it.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Variant::Directions => "nlv",
            Variant::Dots => "dots",
        }
    }
}

/// How to start a peer.
pub(crate) struct Program {
    /// Who made it: `gcc 12.2.0`.
    pub(crate) name: String,
    /// Whether it is what a C compiler made of `peer.c`.
    pub(crate) is_c: bool,
    command: Vec<PathBuf>,
}

/// All peers that can be had here, and why others cannot.
pub(crate) fn programs(folder: &Path) -> (Vec<Program>, Vec<String>) {
    let clangs = ["clang".to_owned()].into_iter().chain((15..=22).rev().map(|version| format!("clang-{version}")));
    let tried = [c_peer("clang", clangs, folder), c_peer("gcc", ["gcc".to_owned()].into_iter(), folder), drjit_peer()];
    let (mut programs, mut missing) = (Vec::new(), Vec::new());
    for tried in tried {
        match tried {
            Ok(program) => programs.push(program),
            Err(reason) => missing.push(reason),
        }
    }
    (programs, missing)
}

/// The peer in C, by the newest of some compilers.
fn c_peer(family: &str, compilers: impl Iterator<Item = String>, folder: &Path) -> Result<Program, String> {
    let versioned = compilers.filter_map(|compiler| Some((version(&compiler)?, compiler)));
    let (version, compiler) = versioned.max().ok_or_else(|| format!("{family}: it was not there"))?;
    let name = format!("{family} {}", version.iter().map(u32::to_string).collect::<Vec<_>>().join("."));
    let program = folder.join(format!("peer-{family}"));
    let output = Command::new(&compiler)
        .args(["-O3", "-march=native", "-ffast-math", "-std=gnu11"])
        .arg(source("peer.c"))
        .arg("-o")
        .arg(&program)
        .args(["-lm", "-lpthread"])
        .output()
        .map_err(|error| format!("{name}: {error}"))?;
    if !output.status.success() {
        // The likeliest reason is a processor without AVX-512.
        let text = String::from_utf8_lossy(&output.stderr).into_owned();
        let reason = text.lines().find(|line| line.contains("error")).unwrap_or("it failed").to_owned();
        return Err(format!("{name}: it cannot compile peer.c for this processor: {reason}"));
    }
    Ok(Program { name, is_c: true, command: vec![program] })
}

/// The version of a compiler, if there is one of this name.
fn version(compiler: &str) -> Option<Vec<u32>> {
    // Of gcc, `-dumpversion` alone has the first number only.
    let output = Command::new(compiler).args(["-dumpfullversion", "-dumpversion"]).stderr(Stdio::null()).output().ok()?;
    let text = String::from_utf8(output.stdout).ok().filter(|_| output.status.success())?;
    text.trim().split('.').map(|number| number.parse().ok()).collect()
}

/// The peer in Dr.Jit, where Python has it.
fn drjit_peer() -> Result<Program, String> {
    let python = std::env::var_os("PEER_PYTHON").unwrap_or_else(|| "python3".into());
    let missing = || format!("Dr.Jit: `{}` has none (PEER_PYTHON names another)", python.display());
    let script = "import drjit, numpy; print(drjit.__version__)";
    let output = Command::new(&python).args(["-c", script]).stderr(Stdio::null()).output().map_err(|_| missing())?;
    let version = String::from_utf8(output.stdout).ok().filter(|_| output.status.success()).ok_or_else(missing)?;
    let command = vec![python.into(), source("peer_drjit.py")];
    Ok(Program { name: format!("Dr.Jit {}", version.trim()), is_c: false, command })
}

fn source(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("benches/peer").join(name)
}

/// A peer that runs.
pub(crate) struct Child {
    pub(crate) name: String,
    pub(crate) is_c: bool,
    pub(crate) threads: usize,
    /// Hits and lit records, as it read them.
    pub(crate) counts: [u64; 2],
    process: std::process::Child,
    input: ChildStdin,
    output: BufReader<ChildStdout>,
}

impl Child {
    /// Starts a peer on exported hits, and has it make a frame of each kind: what it compiles on the way is compiled then.
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

    /// Makes a frame; milliseconds.
    pub(crate) fn frame(&mut self, model: Model, variant: Variant) -> Result<f64, String> {
        self.milliseconds(&format!("frame {} {}", model.name(), variant.name()))
    }

    /// Streams through three arrays of so many bytes together; milliseconds.
    pub(crate) fn triad(&mut self, bytes: usize) -> Result<f64, String> {
        self.milliseconds(&format!("triad {}", bytes / 3 / 4 * 4))
    }

    /// Writes a picture, as linear numbers.
    pub(crate) fn write(&mut self, model: Model, variant: Variant, file: &Path) -> Result<(), String> {
        let answer = self.ask(&format!("write {} {} {}", model.name(), variant.name(), file.display()))?;
        if answer == "ok" { Ok(()) } else { Err(self.failed(&format!("it answers `{answer}`"))) }
    }

    /// Waits until its threads sleep.
    pub(crate) fn rest(&self) {
        if self.threads > 1 {
            std::thread::sleep(if self.is_c { AWAKE } else { DRJIT_AWAKE });
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
        // Whether it has ended by itself makes no difference.
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}
