//! Long work: without the lock of the interpreter, and ended by Ctrl+C.

use crate::diagnostics::failure;
use illuminator::engine::Task;
use pyo3::prelude::*;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::sync::{Mutex, MutexGuard, OnceLock, PoisonError};
use std::time::Duration;

/// How often Python is asked whether the user wants to end the work.
const PATIENCE: Duration = Duration::from_millis(50);

/// Does some work on another thread, without the lock of the interpreter. Meanwhile this thread handles signals. One
/// that raises an exception, such as Ctrl+C, cancels the work, and the exception is returned once the work has ended.
///
/// # Errors
/// An exception of a signal; or this process was made by `fork` after the threads had started, which do not exist here.
pub(crate) fn interruptible<T: Send>(py: Python<'_>, work: impl FnOnce(&Task) -> T + Send) -> PyResult<T> {
    check_process()?;
    let cancelled = AtomicBool::new(false);
    let outcome = py.detach(|| {
        std::thread::scope(|scope| {
            let (sender, done) = channel::<()>();
            let worker = scope.spawn(|| {
                // The channel closes when the work ends, also by a panic.
                let _open = sender;
                work(&Task { progress: &|_| (), cancelled: &cancelled })
            });
            let mut raised = None;
            while let Err(RecvTimeoutError::Timeout) = done.recv_timeout(PATIENCE) {
                if let Err(error) = Python::attach(|py| py.check_signals()) {
                    cancelled.store(true, Ordering::Relaxed);
                    raised.get_or_insert(error);
                }
            }
            (worker.join(), raised)
        })
    });
    match outcome {
        (_, Some(raised)) => Err(raised),
        (Ok(value), None) => Ok(value),
        (Err(panic), None) => std::panic::resume_unwind(panic),
    }
}

/// Refuses to work in a process that was made by `fork` after the first work: the threads that work are missing there,
/// and it would wait for them for ever.
fn check_process() -> PyResult<()> {
    static FIRST: OnceLock<u32> = OnceLock::new();
    if *FIRST.get_or_init(std::process::id) == std::process::id() {
        return Ok(());
    }
    let way = "multiprocessing.get_context(\"spawn\")";
    Err(failure(format!("this process was forked from one that had begun to work, and has none of its threads; use {way}")))
}

/// Locks what threads share. No holder of such a lock runs Python code, or waits for the lock of the interpreter.
pub(crate) fn lock<T>(shared: &Mutex<T>) -> MutexGuard<'_, T> {
    shared.lock().unwrap_or_else(PoisonError::into_inner)
}
