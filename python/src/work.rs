//! Long work: without the lock of the interpreter, and ended by Ctrl+C.

use illuminator::engine::Task;
use pyo3::prelude::*;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::Duration;

/// How often Python is asked whether the user wants to end the work.
const PATIENCE: Duration = Duration::from_millis(50);

/// Does some work on another thread, without the lock of the interpreter. Meanwhile this thread handles signals. One
/// that raises an exception, such as Ctrl+C, cancels the work, and the exception is returned once the work has ended.
pub(crate) fn interruptible<T: Send>(py: Python<'_>, work: impl FnOnce(&Task) -> T + Send) -> PyResult<T> {
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

/// Locks what threads share. A panic of another thread does not matter: what is kept is replaced as a whole.
pub(crate) fn lock<T>(shared: &Mutex<T>) -> MutexGuard<'_, T> {
    shared.lock().unwrap_or_else(PoisonError::into_inner)
}
