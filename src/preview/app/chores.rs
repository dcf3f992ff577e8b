//! Jobs that take time and write files. They run one after the other on a background thread, so the interface does not
//! wait for disks.

use crate::lang::diagnostic::Diagnostic;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::thread::JoinHandle;

/// A job.
type Chore = Box<dyn FnOnce() -> Option<Told> + Send>;

/// The result of a job.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Told {
    /// A line for the log.
    Said(String),
    /// A message for the user, with a title.
    Failed(String, String),
    /// Drafts were written, or could not be.
    Kept(Result<(), Diagnostic>),
}

/// Is called whenever a job is done.
type Wake = Arc<dyn Fn() + Send + Sync>;

/// The jobs. The thread starts with the first of them.
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
                // The receiver is only gone when the program ends.
                let _ = outgoing.send(chore());
                wake();
            }
        };
        Some(Self { chores, done, thread: thread.spawn(work).ok()? })
    }
}

impl Chores {
    /// `wake` is called, on the thread, whenever a job is done.
    pub(super) fn new(wake: impl Fn() + Send + Sync + 'static) -> Self {
        Self { worker: None, wake: Arc::new(wake) }
    }

    /// Runs a job after all earlier ones. If there is no thread, it runs at once, and its result is returned.
    pub(super) fn add(&mut self, chore: impl FnOnce() -> Option<Told> + Send + 'static) -> Option<Told> {
        if self.worker.is_none() {
            self.worker = Worker::new(Arc::clone(&self.wake));
        }
        let Some(worker) = &self.worker else { return chore() };
        match worker.chores.send(Box::new(chore)) {
            Ok(()) => None,
            // The thread is gone, and so are the results of its jobs.
            Err(refused) => refused.0(),
        }
    }

    /// The results since the last call.
    pub(super) fn told(&self) -> Vec<Told> {
        self.worker.iter().flat_map(|worker| worker.done.try_iter().flatten()).collect()
    }

    /// Waits until all current jobs are done.
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

    /// Waits until all jobs are done.
    pub(super) fn finish(&mut self) {
        if let Some(Worker { chores, thread, .. }) = self.worker.take() {
            drop(chores);
            // A thread that panicked has printed its message.
            let _ = thread.join();
        }
    }
}
