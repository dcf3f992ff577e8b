//! What takes its time and leads to files: done one after the other on a thread of its own, so that the interface does not wait for disks.

use crate::lang::diagnostic::Diagnostic;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::thread::JoinHandle;

/// Something to be done.
type Chore = Box<dyn FnOnce() -> Option<Told> + Send>;

/// What there is to say of something that was done.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Told {
    /// For the log.
    Said(String),
    /// What must not be missed: a title, and a text.
    Failed(String, String),
    /// Unsaved work was kept, or could not be.
    Kept(Result<(), Diagnostic>),
}

/// Called whenever something is done.
type Wake = Arc<dyn Fn() + Send + Sync>;

/// The thread, which begins with the first thing to do.
pub(super) struct Chores {
    worker: Option<Worker>,
    wake: Wake,
}

struct Worker {
    chores: Sender<Chore>,
    done: Receiver<Option<Told>>,
    thread: JoinHandle<()>,
}

impl Worker {
    fn new(wake: Wake) -> Option<Self> {
        let (chores, incoming) = channel::<Chore>();
        let (outgoing, done) = channel();
        let thread = std::thread::Builder::new().name("chores".to_owned());
        let work = move || {
            for chore in incoming {
                // Whoever listens is gone only when all ends.
                let _ = outgoing.send(chore());
                wake();
            }
        };
        Some(Self { chores, done, thread: thread.spawn(work).ok()? })
    }
}

impl Chores {
    /// `wake` is called, on the thread, whenever something is done.
    pub(super) fn new(wake: impl Fn() + Send + Sync + 'static) -> Self {
        Self { worker: None, wake: Arc::new(wake) }
    }

    /// Does something when all before it is done. Where there is no thread it is done at once, and there is this to say of it.
    pub(super) fn add(&mut self, chore: impl FnOnce() -> Option<Told> + Send + 'static) -> Option<Told> {
        if self.worker.is_none() {
            self.worker = Worker::new(Arc::clone(&self.wake));
        }
        let Some(worker) = &self.worker else { return chore() };
        match worker.chores.send(Box::new(chore)) {
            Ok(()) => None,
            // The thread is gone: so is what it would have said.
            Err(refused) => refused.0(),
        }
    }

    /// What there is to say of what was done since it was asked last.
    pub(super) fn told(&self) -> Vec<Told> {
        self.worker.iter().flat_map(|worker| worker.done.try_iter().flatten()).collect()
    }

    /// Waits until all that there is now is done.
    #[cfg(test)]
    pub(super) fn wait(&self) {
        let Some(worker) = &self.worker else { return };
        let (done, told) = channel();
        let last = move || {
            let _ = done.send(());
            None
        };
        if worker.chores.send(Box::new(last)).is_ok() {
            let _ = told.recv();
        }
    }

    /// Waits until all is done.
    pub(super) fn finish(&mut self) {
        if let Some(Worker { chores, thread, .. }) = self.worker.take() {
            drop(chores);
            // One that panicked has said so.
            let _ = thread.join();
        }
    }
}
