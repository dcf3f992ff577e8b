//! The engine's work as commands ask for it: on so many threads, within so much memory, with progress.

use crate::cli::input::Input;
use crate::cli::options::MachineOptions;
use crate::cli::progress::Progress;
use crate::cli::report::Failure;
use illuminator::evaluate::{self, Backend, Compiled, Frame, Interpreted};
use illuminator::jit::CompiledFormula;
use illuminator::trace::{self, Budget, Hits, TraceError, View};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// Bytes of a pixel beside those of hits: two frames, and what a picture file is made from.
const BYTES_PER_PIXEL: u64 = 40;

/// Does some work on as many threads as the options say.
pub(super) fn on_threads<T: Send>(options: &MachineOptions, work: impl FnOnce() -> T + Send) -> Result<T, Failure> {
    // 0 stands for one thread a core.
    let threads = usize::from(options.threads.unwrap_or(0));
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
    let pool = pool.map_err(|error| Failure::input(format!("cannot start {threads} threads: {error}")))?;
    Ok(pool.install(work))
}

/// Traces the scene for a compiled formula.
pub(super) fn trace_for(
    formula: &CompiledFormula,
    input: &Input,
    view: &View,
    bytes: u64,
    progress: &(dyn Fn(f64) + Sync),
) -> Result<Arc<Hits>, Failure> {
    let budget = Budget { bytes_per_pixel: BYTES_PER_PIXEL, ..evaluate::budget(bytes, &formula.bindings) };
    trace::trace(&input.scene, view, &budget, progress, &AtomicBool::new(false)).map(Arc::new).map_err(failed)
}

/// What may be used, after checking that the picture itself fits in.
pub(super) fn memory_for(view: &View, options: &MachineOptions) -> Result<u64, Failure> {
    let budget = options.memory.unwrap_or_else(trace::usable_memory);
    let needed = u64::from(view.pixels()) * BYTES_PER_PIXEL;
    if needed > budget { Err(failed(TraceError::Memory { needed, budget, pixels: view.pixels() })) } else { Ok(budget) }
}

fn failed(error: TraceError) -> Failure {
    let message = error.to_string();
    match error {
        TraceError::Memory { .. } => {
            Failure::Input(illuminator::lang::diagnostic::Diagnostic::error(message).help("`--memory SIZE` allows more"))
        }
        TraceError::Cancelled => Failure::input(message),
    }
}

/// The picture, `samples` × `samples` rays a pixel averaged, NaN not yet cleaned out.
pub(super) fn picture(input: &Input, samples: u32, backend: Backend, options: &MachineOptions) -> Result<Frame, Failure> {
    let bytes = memory_for(&input.view, options)?;
    let compiled = match backend {
        Backend::Jit => Some(Arc::new(CompiledFormula::new(&input.formula).map_err(|error| Failure::input(error.to_string()))?)),
        Backend::Interpreter => None,
    };
    let progress = Progress::new("tracing");
    let mut sum: Option<Frame> = None;
    let count = samples * samples;
    for sample in 0..count {
        let tell = |share: f64| progress.tell((f64::from(sample) + share) / f64::from(count));
        let place = |step: u32| (f64::from(step) + 0.5) / f64::from(samples);
        let view = input.view.with_offset([place(sample % samples), place(sample / samples)]);
        let frame = match &compiled {
            Some(compiled) => {
                let hits = trace_for(compiled, input, &view, bytes, &tell)?;
                compiled_backend(compiled, input, &hits)?.frame(input.values.numbers())
            }
            None => {
                tell(0.0);
                interpreter(input, view)?.frame(input.values.numbers()).0
            }
        };
        sum = Some(match sum {
            None if count == 1 => frame,
            so_far => {
                let mut so_far = so_far.unwrap_or_else(|| Frame::black(view.width(), view.height()));
                so_far.add(&frame, 1.0 / count as f32);
                so_far
            }
        });
    }
    sum.ok_or_else(|| Failure::command_line("a picture needs at least one sample"))
}

/// A compiled formula on traced hits.
pub(super) fn compiled_backend(compiled: &Arc<CompiledFormula>, input: &Input, hits: &Arc<Hits>) -> Result<Compiled, Failure> {
    Compiled::new(Arc::clone(compiled), &input.formula, &input.scene, hits).map_err(|error| Failure::input(error.to_string()))
}

/// The reference interpreter on a view of the scene.
pub(super) fn interpreter(input: &Input, view: View) -> Result<Interpreted, Failure> {
    Interpreted::new(&input.formula, &input.scene, view).map_err(|error| Failure::input(error.to_string()))
}
