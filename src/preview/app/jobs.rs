//! Slow jobs that write files, read images or make thumbnails. They run one after the other on a background thread, so
//! the interface does not wait for them.

use crate::lang::diagnostic::Diagnostic;
use crate::measured::MeasuredMaterial;
use crate::preview::app::thumbnail_key::ThumbnailKey;
use crate::workspace::OwnerId;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::thread::JoinHandle;

/// A job.
type Job = Box<dyn FnOnce() -> Option<JobResult> + Send>;

/// The result of a job.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum JobResult {
    /// Something was done, as the text says.
    Done(String),
    /// The picture was not saved, and why.
    PictureNotSaved(String),
    /// The chart of the instruments was not saved, and why.
    ChartNotSaved(String),
    /// A measured material was read for the instruments, or could not be.
    MeasuredRead(PathBuf, Result<Arc<MeasuredMaterial>, Diagnostic>),
    /// A thumbnail was made; without an image if there is none.
    ThumbnailMade(Box<ThumbnailKey>, Option<egui::ColorImage>),
    /// An image was read for a texture, or could not be.
    ImageRead(Box<ImageRead>),
    /// Drafts were written, or could not be.
    DraftsWritten(Result<(), Diagnostic>),
}

/// An image that was read for a texture of an owner.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct ImageRead {
    pub(super) owner: OwnerId,
    /// The name of the parameter.
    pub(super) parameter: String,
    /// The number of the texture, or why there is none.
    pub(super) outcome: Result<f32, Diagnostic>,
}

/// Is called whenever a job is done.
type Wake = Arc<dyn Fn() + Send + Sync>;

/// The jobs. The thread starts with the first of them.
pub(super) struct Jobs {
    worker: Option<Worker>,
    wake: Wake,
}

struct Worker {
    jobs: Sender<Job>,
    done: Receiver<Option<JobResult>>,
    thread: JoinHandle<()>,
}

impl Worker {
    fn new(wake: Wake) -> Option<Self> {
        let (jobs, incoming) = channel::<Job>();
        let (outgoing, done) = channel();
        let thread = std::thread::Builder::new().name("jobs".to_owned());
        let work = move || {
            for job in incoming {
                // The receiver is only gone when the program ends.
                let _ = outgoing.send(job());
                wake();
            }
        };
        Some(Self { jobs, done, thread: thread.spawn(work).ok()? })
    }
}

impl Jobs {
    /// `wake` is called, on the thread, whenever a job is done.
    pub(super) fn new(wake: impl Fn() + Send + Sync + 'static) -> Self {
        Self { worker: None, wake: Arc::new(wake) }
    }

    /// Runs a job after all earlier ones. If there is no thread, it runs at once, and its result is returned.
    pub(super) fn run(&mut self, job: impl FnOnce() -> Option<JobResult> + Send + 'static) -> Option<JobResult> {
        if self.worker.is_none() {
            self.worker = Worker::new(Arc::clone(&self.wake));
        }
        let Some(worker) = &self.worker else { return job() };
        match worker.jobs.send(Box::new(job)) {
            Ok(()) => None,
            // The thread is gone, and so are the results of its jobs.
            Err(refused) => refused.0(),
        }
    }

    /// The results since the last call.
    pub(super) fn results(&self) -> Vec<JobResult> {
        self.worker.iter().flat_map(|worker| worker.done.try_iter().flatten()).collect()
    }

    /// Waits until all current jobs are done.
    #[cfg(test)]
    pub(super) fn wait(&self) {
        let Some(worker) = &self.worker else { return };
        let (done, result) = channel();
        let last = move || {
            let _ = done.send(());
            None
        };
        if worker.jobs.send(Box::new(last)).is_ok() {
            let _ = result.recv();
        }
    }

    /// Waits until all jobs are done.
    pub(super) fn finish(&mut self) {
        if let Some(Worker { jobs, thread, .. }) = self.worker.take() {
            drop(jobs);
            // A thread that panicked has printed its message.
            let _ = thread.join();
        }
    }
}
