//! The engine for commands: with a number of threads, a memory limit, and progress.

use crate::cli::options::MachineOptions;
use crate::cli::progress::Progress;
use crate::cli::report::Failure;
use illuminator::backends::BackendChoice;
use illuminator::backends::interpreter::Interpreted;
use illuminator::engine::{Engine, EngineError, Subject, Task};
use illuminator::lang::diagnostic::Diagnostic;
use illuminator::picture::Frame;
use illuminator::workspace::project::Project;

/// Does some work on the number of threads that the options give.
pub(super) fn on_threads<T: Send>(options: &MachineOptions, work: impl FnOnce() -> T + Send) -> Result<T, Failure> {
    // 0 stands for one thread for each core.
    let threads = usize::from(options.threads.unwrap_or(0));
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
    let pool = pool.map_err(|error| Failure::input(format!("cannot start {threads} threads: {error}")))?;
    Ok(pool.install(work))
}

/// An engine with this backend and the memory that the options give.
pub(super) fn engine(backend: &BackendChoice, options: &MachineOptions) -> Engine {
    let engine = Engine::new(backend.make());
    match options.memory {
        Some(bytes) => engine.with_memory(bytes),
        None => engine,
    }
}

/// The failure for an error of the engine.
pub(super) fn failed(error: EngineError) -> Failure {
    let diagnostic = Diagnostic::error(error.to_string());
    Failure::Input(if error.is_memory() { diagnostic.help("`--memory SIZE` allows more") } else { diagnostic })
}

/// The picture, the mean of its passes. It may contain NaN.
pub(super) fn picture(project: &Project, backend: &BackendChoice, options: &MachineOptions) -> Result<Frame, Failure> {
    let passes = project.picture.passes();
    let progress = Progress::of_passes("tracing", passes);
    let tell = |share: f64| progress.tell(share);
    let picture = engine(backend, options).picture(&project.subject, project.values.numbers(), passes, &Task::watched(&tell));
    picture.map_err(failed)
}

/// The reference interpreter.
pub(super) fn interpreter(Subject { formula, world, view }: &Subject) -> Result<Interpreted, Failure> {
    Interpreted::new(formula, world, *view).map_err(|error| Failure::input(error.to_string()))
}
