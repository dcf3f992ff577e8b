//! What a session keeps between pictures: traced hits and the evaluator of its formula.

use crate::diagnostics::failure;
use illuminator::backends;
use illuminator::engine::{Engine, EngineError, Subject, Task};
use illuminator::evaluate::{Backend, EvaluateError, Evaluator};
use illuminator::picture::Frame;
use illuminator::trace::{Hits, TraceError};
use pyo3::prelude::*;
use rayon::ThreadPool;
use std::sync::Arc;

/// As many threads as the command line allows.
const MOST_THREADS: usize = 1024;

/// Traced hits, and the evaluator of all passes. Whoever locks it does not hold the lock of the interpreter.
pub(crate) struct Tracing {
    subject: Subject,
    passes: u32,
    backend: Arc<dyn Backend>,
    engine: Engine,
    /// The memory that may be used, in bytes, if the caller limits it.
    memory: Option<u64>,
    /// The threads that work, if the caller says how many.
    pool: Option<Arc<ThreadPool>>,
    /// The hits of the first passes. Formulas on the same scene and view share them.
    hits: Vec<Arc<Hits>>,
    /// The evaluator of all passes, once a picture was made. None if they do not fit into the memory together.
    evaluator: Option<Arc<dyn Evaluator>>,
    /// Whether the passes do not fit into the memory together.
    is_large: bool,
}

/// What does the work of a session.
pub(super) struct Means<'m> {
    /// The name of the backend, by default that of the program.
    pub(super) backend: Option<&'m str>,
    /// How many threads work, by default as many as there are processors.
    pub(super) threads: Option<usize>,
    /// How many bytes of memory may be used, by default half of what is free.
    pub(super) memory: Option<u64>,
}

impl Tracing {
    /// Nothing is traced yet.
    pub(super) fn new(subject: Subject, passes: u32, means: Means) -> PyResult<Self> {
        let Means { backend, threads, memory } = means;
        let backend = backend.unwrap_or(backends::DEFAULT.name);
        let choice = backends::named(backend).ok_or_else(|| {
            if backends::lacking(backend).is_some() {
                return failure(format!("this package was built without the feature `{backend}`"));
            }
            let names = backends::CHOICES.iter().map(|choice| format!("\"{}\"", choice.name));
            failure(format!("there is no backend \"{backend}\"; there are {}", names.collect::<Vec<_>>().join(", ")))
        })?;
        if let Some(threads) = threads.filter(|threads| !(1..=MOST_THREADS).contains(threads)) {
            return Err(failure(format!("`threads` is {threads}; it can be 1 to {MOST_THREADS}")));
        }
        let pool = threads.map(|threads| rayon::ThreadPoolBuilder::new().num_threads(threads).build());
        let backend = choice.make();
        let engine = Engine::new(Arc::clone(&backend));
        Ok(Self {
            subject,
            passes,
            backend,
            engine: memory.map_or(engine.clone(), |bytes| engine.with_memory(bytes)),
            memory,
            pool: pool.transpose().map_err(failure)?.map(Arc::new),
            hits: Vec::new(),
            evaluator: None,
            is_large: false,
        })
    }

    /// The same for a subject of another formula on the same scene and view. Hits are shared.
    pub(super) fn with_subject(&self, subject: Subject) -> Self {
        Self {
            subject,
            passes: self.passes,
            backend: Arc::clone(&self.backend),
            engine: self.engine.clone(),
            memory: self.memory,
            pool: self.pool.clone(),
            hits: self.hits.clone(),
            evaluator: None,
            is_large: false,
        }
    }

    /// The threads of this session.
    pub(crate) fn pool(&self) -> Option<Arc<ThreadPool>> {
        self.pool.clone()
    }

    /// The memory that may be used now, in bytes.
    pub(crate) fn memory(&self) -> u64 {
        self.engine.memory()
    }

    /// The pictures of several sets of parameter numbers, in order.
    pub(crate) fn frames(
        &mut self,
        numbers: &[Vec<f32>],
        task: &Task,
        mut each: impl FnMut(Frame) + Send,
    ) -> Result<(), EngineError> {
        let pool = self.pool();
        on_threads(pool.as_deref(), || {
            let first = numbers.first().map(Vec::as_slice).unwrap_or_default();
            if let Some(evaluator) = self.evaluator(first, task)? {
                for numbers in numbers {
                    each(mean(&*evaluator, numbers, task)?);
                }
                return Ok(());
            }
            let sets: Vec<&[f32]> = numbers.iter().map(Vec::as_slice).collect();
            self.engine.pictures(&self.subject, &sets, self.passes, task, |_, frame, _| {
                each(frame);
                Ok(())
            })
        })
    }

    /// The evaluator of all passes, which traces what is not traced yet; `None` if they do not fit into the memory
    /// together. It is called on the threads of the session, with the numbers of the first picture.
    pub(crate) fn evaluator(&mut self, numbers: &[f32], task: &Task) -> Result<Option<Arc<dyn Evaluator>>, EngineError> {
        if self.evaluator.is_none() && !self.is_large {
            match self.prepared(numbers, task) {
                Ok(evaluator) => self.evaluator = Some(evaluator),
                // One pass after the other fits, maybe.
                Err(error) if error.is_memory() && self.passes > 1 => {
                    self.is_large = true;
                    self.hits.clear();
                }
                Err(error) => return Err(error),
            }
        }
        Ok(self.evaluator.clone())
    }

    fn prepared(&mut self, numbers: &[f32], task: &Task) -> Result<Arc<dyn Evaluator>, EngineError> {
        let mut evaluator: Option<Arc<dyn Evaluator>> = None;
        for pass in 0..self.passes {
            let hits = self.pass_hits(pass, evaluator.as_ref().map_or(0, |evaluator| evaluator.bytes() as u64), task)?;
            evaluator = Some(match evaluator {
                None => self.engine.prepare(&self.subject, &hits, numbers)?,
                Some(evaluator) => evaluator.with_pass(&hits)?,
            });
        }
        evaluator.ok_or_else(|| TraceError::Cancelled.into())
    }

    /// The subject in a pass.
    fn in_pass(&self, pass: u32) -> Subject {
        Subject { view: self.subject.view.with_pass(pass), ..self.subject.clone() }
    }

    /// The hits of a pass. `used` bytes of the memory are taken.
    fn pass_hits(&mut self, pass: u32, used: u64, task: &Task) -> Result<Arc<Hits>, EngineError> {
        if let Some(hits) = self.hits.get(pass as usize) {
            return Ok(Arc::clone(hits));
        }
        let subject = self.in_pass(pass);
        let hits = match self.backend.reads_hits() {
            true => {
                let engine = self.engine.clone();
                // Without a limit, the engine asks what is free now.
                let engine = self.memory.map_or(engine.clone(), |bytes| engine.with_memory(bytes.saturating_sub(used)));
                engine.trace(&subject, task)?
            }
            false => Arc::new(Hits::untraced(&subject.world, subject.view)),
        };
        if pass as usize == self.hits.len() {
            self.hits.push(Arc::clone(&hits));
        }
        Ok(hits)
    }

    /// The hits of a pass with the lights that the formula is evaluated for, also if the backend traces by itself. They
    /// are not kept if the passes do not fit into the memory together.
    pub(crate) fn traced(&mut self, pass: u32, task: &Task) -> Result<Arc<Hits>, EngineError> {
        let pool = self.pool();
        let hits = on_threads(pool.as_deref(), || match self.backend.reads_hits() && !self.is_large {
            true => self.pass_hits(pass, 0, task),
            false => self.engine.trace(&self.in_pass(pass), task),
        })?;
        let lights = self.subject.formula.evaluated_lights();
        hits.for_lights(lights).map_err(|error| EngineError::Evaluate(error.into()))
    }
}

/// Does some work on the threads of a session.
pub(crate) fn on_threads<T: Send>(pool: Option<&ThreadPool>, work: impl FnOnce() -> T + Send) -> T {
    match pool {
        Some(pool) => pool.install(work),
        None => work(),
    }
}

/// The mean of all passes of an evaluator.
pub(crate) fn mean(evaluator: &dyn Evaluator, numbers: &[f32], task: &Task) -> Result<Frame, EngineError> {
    let passes = evaluator.passes();
    let mut frame = evaluator.sum(0..passes, numbers, task.cancelled).ok_or(TraceError::Cancelled)?;
    if let Some(failure) = evaluator.failure() {
        return Err(EvaluateError::Backend(failure).into());
    }
    if passes > 1 {
        frame.scale(1.0 / passes as f32);
    }
    Ok(frame)
}
