//! What a session keeps between pictures: traced hits and the evaluator of its formula.

use crate::diagnostics::failure;
use crate::formula::Formula;
use illuminator::backends::{self, BackendChoice};
use illuminator::engine::{Engine, EngineError, Subject, Task};
use illuminator::evaluate::{Backend, Evaluator};
use illuminator::lang::source::Source;
use illuminator::picture::Frame;
use illuminator::trace::{Hits, MAX_PASSES, TraceError};
use illuminator::workspace::project::Project;
use illuminator::workspace::session::PictureSettings;
use illuminator::workspace::{Location, Values};
use pyo3::prelude::*;
use rayon::ThreadPool;
use std::sync::Arc;

/// As many threads as the command line allows.
const MOST_THREADS: usize = 1024;

/// A session's formula, scene, view and values, and what is kept between its pictures.
pub(crate) struct State {
    pub(crate) subject: Subject,
    pub(crate) values: Values,
    pub(crate) picture: PictureSettings,
    pub(crate) formula: (Location, Source),
    pub(crate) scene: Location,
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

impl State {
    /// The state of an open session. `threads` is how many threads work; by default as many as there are processors.
    pub(super) fn new(project: Project, backend: Option<&str>, threads: Option<usize>, memory: Option<u64>) -> PyResult<Self> {
        let Project { subject, values, picture, formula_location, formula_text, scene_location, .. } = project;
        if !(1..=MAX_PASSES).contains(&picture.passes()) {
            return Err(failure(format!("`samples` is {}; it can be 1 to {MAX_PASSES}", picture.passes())));
        }
        let backend = backend.unwrap_or(backends::DEFAULT.name);
        let choice = backends::named(backend).ok_or_else(|| {
            let names = backends::CHOICES.iter().map(|choice: &BackendChoice| format!("\"{}\"", choice.name));
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
            values,
            picture,
            formula: (formula_location, formula_text),
            scene: scene_location,
            backend,
            engine: memory.map_or(engine.clone(), |bytes| engine.with_memory(bytes)),
            memory,
            pool: pool.transpose().map_err(failure)?.map(Arc::new),
            hits: Vec::new(),
            evaluator: None,
            is_large: false,
        })
    }

    /// The same with another formula. The values that both have are kept. Returns warnings about values.
    pub(super) fn with_formula(&self, formula: Formula) -> (Self, Vec<String>) {
        let Formula { location, source, formula } = formula;
        let (values, warnings) = self.values.carry_over(&formula, self.subject.world.scene());
        let state = Self {
            subject: Subject { formula: Arc::new(formula), ..self.subject.clone() },
            values,
            picture: self.picture,
            formula: (location, source),
            scene: self.scene.clone(),
            backend: Arc::clone(&self.backend),
            engine: self.engine.clone(),
            memory: self.memory,
            pool: self.pool.clone(),
            hits: self.hits.clone(),
            evaluator: None,
            is_large: false,
        };
        (state, warnings.iter().map(ToString::to_string).collect())
    }

    /// Does some work on the threads of this session.
    pub(crate) fn on_threads<T: Send>(pool: Option<&ThreadPool>, work: impl FnOnce() -> T + Send) -> T {
        match pool {
            Some(pool) => pool.install(work),
            None => work(),
        }
    }

    /// The threads of this session.
    pub(crate) fn pool(&self) -> Option<Arc<ThreadPool>> {
        self.pool.clone()
    }

    /// The picture of the values now.
    pub(super) fn frame(&mut self, task: &Task) -> Result<Frame, EngineError> {
        let numbers = self.values.numbers().to_vec();
        self.frame_of(&numbers, task)
    }

    /// The picture of these parameter numbers.
    fn frame_of(&mut self, numbers: &[f32], task: &Task) -> Result<Frame, EngineError> {
        let pool = self.pool();
        Self::on_threads(pool.as_deref(), || match self.evaluator(task)? {
            Some(evaluator) => mean(&*evaluator, numbers, task),
            None => self.engine.picture(&self.subject, numbers, self.picture.passes(), task),
        })
    }

    /// The pictures of several sets of parameter numbers, in order.
    pub(crate) fn frames_of(
        &mut self,
        numbers: &[Vec<f32>],
        task: &Task,
        mut each: impl FnMut(&Frame) + Send,
    ) -> Result<(), EngineError> {
        let pool = self.pool();
        Self::on_threads(pool.as_deref(), || {
            if let Some(evaluator) = self.evaluator(task)? {
                return numbers.iter().try_for_each(|numbers| {
                    each(&mean(&*evaluator, numbers, task)?);
                    Ok(())
                });
            }
            let sets: Vec<&[f32]> = numbers.iter().map(Vec::as_slice).collect();
            self.engine.pictures(&self.subject, &sets, self.picture.passes(), task, |_, frame, _| {
                each(&frame);
                Ok(())
            })
        })
    }

    /// The memory that may be used now, in bytes.
    pub(crate) fn memory(&self) -> u64 {
        self.engine.memory()
    }

    /// The evaluator of all passes, which traces what is not traced yet; `None` if they do not fit into the memory
    /// together. It is called on the threads of the session.
    pub(crate) fn evaluator(&mut self, task: &Task) -> Result<Option<Arc<dyn Evaluator>>, EngineError> {
        if self.evaluator.is_none() && !self.is_large {
            match self.prepared(task) {
                Ok(evaluator) => self.evaluator = Some(evaluator),
                // One pass after the other fits, maybe.
                Err(error) if error.is_memory() && self.picture.passes() > 1 => {
                    self.is_large = true;
                    self.hits.clear();
                }
                Err(error) => return Err(error),
            }
        }
        Ok(self.evaluator.clone())
    }

    fn prepared(&mut self, task: &Task) -> Result<Arc<dyn Evaluator>, EngineError> {
        let mut evaluator: Option<Arc<dyn Evaluator>> = None;
        for pass in 0..self.picture.passes() {
            let hits = self.pass_hits(pass, evaluator.as_ref().map_or(0, |evaluator| evaluator.bytes() as u64), task)?;
            evaluator = Some(match evaluator {
                None => self.engine.prepare(&self.subject, &hits, self.values.numbers())?,
                Some(evaluator) => evaluator.with_pass(&hits)?,
            });
        }
        evaluator.ok_or_else(|| TraceError::Cancelled.into())
    }

    /// The hits of a pass. `used` bytes of the memory are taken.
    pub(crate) fn pass_hits(&mut self, pass: u32, used: u64, task: &Task) -> Result<Arc<Hits>, EngineError> {
        if let Some(hits) = self.hits.get(pass as usize) {
            return Ok(Arc::clone(hits));
        }
        let subject = Subject { view: self.subject.view.with_pass(pass), ..self.subject.clone() };
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
        let hits = match self.backend.reads_hits() && !self.is_large {
            true => self.pass_hits(pass, 0, task)?,
            false => {
                let subject = Subject { view: self.subject.view.with_pass(pass), ..self.subject.clone() };
                self.engine.trace(&subject, task)?
            }
        };
        let lights = self.subject.formula.evaluated_lights();
        hits.for_lights(lights).map_err(|error| EngineError::Evaluate(error.into()))
    }
}

/// The mean of all passes of an evaluator.
pub(crate) fn mean(evaluator: &dyn Evaluator, numbers: &[f32], task: &Task) -> Result<Frame, EngineError> {
    let passes = evaluator.passes();
    let mut frame = evaluator.sum(0..passes, numbers, task.cancelled).ok_or(TraceError::Cancelled)?;
    if passes > 1 {
        frame.scale(1.0 / passes as f32);
    }
    Ok(frame)
}
