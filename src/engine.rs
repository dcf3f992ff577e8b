//! The engine: the whole way from a formula and a scene to pictures.
//!
//! ```text
//! parse (texts) ─▶ compile (formula) ─▶ trace (world, view) ─▶ prepare ─▶ frames and drags
//! ```
//!
//! An [`Engine`] owns this sequence, its backend and its memory budget. Long work reports its progress to a [`Task`]
//! and can be cancelled through it. The engine does not know files, or where the values of parameters come from.

use crate::evaluate::{Backend, EvaluateError, Evaluator, Footprint};
use crate::formula::Formula;
use crate::lang::diagnostic::Diagnostics;
use crate::lang::source::Source;
use crate::picture::Frame;
use crate::scene::Scene;
use crate::trace::{Budget, Hits, TraceError, View, trace, usable_memory};
use crate::world::World;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use thiserror::Error;

/// The memory for each pixel, without hits, in bytes: two linear pictures, a framebuffer, and the data of a picture
/// file.
const BYTES_PER_PIXEL: u64 = 40;

/// What a picture shows, without the values of parameters.
#[derive(Debug, Clone)]
pub struct Subject {
    /// The model.
    pub formula: Arc<Formula>,
    /// The scene, ready for rays.
    pub world: Arc<World>,
    /// The view: size, depth and so on.
    pub view: View,
}

impl Subject {
    /// A formula, a scene and a view. This builds the world of the scene.
    pub fn new(formula: Formula, scene: Scene, view: View) -> Self {
        Self { formula: Arc::new(formula), world: Arc::new(World::new(scene)), view }
    }

    /// A subject from texts.
    ///
    /// # Errors
    /// All errors of both texts.
    pub fn parse(formula: &str, scene: &str, view: View) -> Result<Self, ParseError> {
        let (formula, scene) = (Source::new("formula", formula), Source::new("scene", scene));
        let failed = |errors: Diagnostics, source: &Source| ParseError(errors.located(source).to_string());
        match (Formula::parse(&formula), Scene::parse(&scene)) {
            (Ok((formula, _)), Ok((scene, _))) => Ok(Self::new(formula, scene, view)),
            (Err(errors), Ok(_)) => Err(failed(errors, &formula)),
            (Ok(_), Err(errors)) => Err(failed(errors, &scene)),
            (Err(first), Err(second)) => Err(ParseError(failed(first, &formula).0 + &failed(second, &scene).0)),
        }
    }

    /// Whether both subjects have the same hits.
    pub fn same_hits(&self, other: &Subject) -> bool {
        Arc::ptr_eq(&self.world, &other.world) && self.view == other.view
    }
}

/// The errors of a text: a line for each, with its place.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[error("{0}")]
pub struct ParseError(String);

/// The progress of long work, and its cancellation.
#[derive(Clone, Copy)]
pub struct Task<'t> {
    /// Is called with the share that is done, 0..=1, from time to time, from any thread.
    pub progress: &'t (dyn Fn(f64) + Sync),
    /// When it is set, the work ends soon.
    pub cancelled: &'t AtomicBool,
}

static NEVER: AtomicBool = AtomicBool::new(false);

impl Task<'static> {
    /// Work that nobody watches or cancels.
    pub const UNWATCHED: Task<'static> = Task { progress: &|_| (), cancelled: &NEVER };
}

impl<'t> Task<'t> {
    /// Work that is watched and is not cancelled.
    pub fn watched(progress: &'t (dyn Fn(f64) + Sync)) -> Self {
        Self { progress, cancelled: &NEVER }
    }
}

/// Why there is no picture.
#[derive(Debug, Error)]
pub enum EngineError {
    /// The scene was not traced.
    #[error(transparent)]
    Trace(#[from] TraceError),
    /// The formula cannot be evaluated.
    #[error(transparent)]
    Evaluate(#[from] EvaluateError),
}

impl EngineError {
    /// Whether more memory would help.
    pub fn is_memory(&self) -> bool {
        matches!(self, EngineError::Trace(TraceError::Memory(_)))
    }

    /// Whether the caller cancelled the work.
    pub fn is_cancelled(&self) -> bool {
        matches!(self, EngineError::Trace(TraceError::Cancelled))
    }
}

/// Makes pictures of formulas on scenes, with one backend, within a memory budget.
#[derive(Clone)]
pub struct Engine {
    backend: Arc<dyn Backend>,
    memory: Option<u64>,
}

impl Default for Engine {
    /// An engine with the default backend and the memory that is free.
    fn default() -> Self {
        Self::new(crate::backends::DEFAULT.make())
    }
}

impl Engine {
    /// An engine with this backend and the memory that is free.
    pub fn new(backend: Arc<dyn Backend>) -> Self {
        Self { backend, memory: None }
    }

    /// The same engine with a memory budget of this many bytes.
    #[must_use]
    pub fn with_memory(self, bytes: u64) -> Self {
        Self { memory: Some(bytes), ..self }
    }

    /// The backend.
    pub fn backend(&self) -> &dyn Backend {
        &*self.backend
    }

    /// The memory budget for a picture, in bytes: the given one, or half of the memory that is free now.
    pub fn memory(&self) -> u64 {
        self.memory.unwrap_or_else(usable_memory)
    }

    /// Does the work that depends on the formula alone. The backend keeps formulas that it has compiled.
    ///
    /// # Errors
    /// The backend does not support the formula.
    pub fn compile(&self, formula: &Arc<Formula>) -> Result<(), EngineError> {
        self.backend.compile(formula)?;
        Ok(())
    }

    /// Traces the scene, on all threads of the current pool. Hits and the evaluation of the formula share the memory
    /// budget.
    ///
    /// # Errors
    /// The picture needs more memory than the budget, the task was cancelled, or the backend does not support the
    /// formula.
    pub fn trace(&self, subject: &Subject, task: &Task) -> Result<Arc<Hits>, EngineError> {
        let budget = self.budget(subject)?;
        let lights = subject.formula.evaluated_lights();
        Ok(Arc::new(trace(&subject.world, &subject.view, lights, &budget, task.progress, task.cancelled)?))
    }

    /// Prepares a formula for hits. They may have been traced for another formula. If the formula is the first one to
    /// read `visible`, the shadow rays that it needs are traced now.
    ///
    /// # Errors
    /// The backend does not support the formula, the hits belong to another scene or view, or what the formula needs
    /// beyond the hits takes more memory than the budget.
    pub fn prepare(&self, subject: &Subject, hits: &Arc<Hits>) -> Result<Arc<dyn Evaluator>, EngineError> {
        let lights = subject.formula.evaluated_lights();
        if self.backend.reads_hits() && !hits.serves(lights) {
            self.budget(subject)?.check_hits(hits, lights)?;
        }
        Ok(self.backend.prepare(&subject.formula, hits)?)
    }

    /// Compiles, traces and prepares.
    ///
    /// # Errors
    /// One of these steps failed.
    pub fn evaluator(&self, subject: &Subject, task: &Task) -> Result<Arc<dyn Evaluator>, EngineError> {
        let hits = match self.backend.reads_hits() {
            true => self.trace(subject, task)?,
            false => {
                self.budget(subject)?.check(&subject.view)?;
                Arc::new(Hits::untraced(&subject.world, subject.view))
            }
        };
        self.prepare(subject, &hits)
    }

    /// The picture of these parameter numbers, in the order of the [`Layout`](crate::formula::layout::Layout): the
    /// mean of `samples` × `samples` rays for each pixel (0 counts as 1), in linear RGB, not clamped. It may
    /// contain NaN. Each of the samples² pictures is traced.
    ///
    /// # Errors
    /// One of the stages failed.
    ///
    /// # Panics
    /// Where there are fewer parameter numbers than the layout has.
    pub fn picture(&self, subject: &Subject, parameters: &[f32], samples: u32, task: &Task) -> Result<Frame, EngineError> {
        let count = samples.max(1).pow(2);
        let mut mean: Option<Frame> = None;
        for sample in 0..count {
            let centre = |step: u32| (f64::from(step) + 0.5) / f64::from(samples.max(1));
            let offset = [centre(sample % samples.max(1)), centre(sample / samples.max(1))];
            let subject = Subject { view: subject.view.with_offset(offset), ..subject.clone() };
            let progress = |share: f64| (task.progress)((f64::from(sample) + share) / f64::from(count));
            let frame = self.evaluator(&subject, &Task { progress: &progress, ..*task })?.frame(parameters);
            if count == 1 {
                return Ok(frame);
            }
            let mean = mean.get_or_insert_with(|| Frame::black(frame.width, frame.height));
            mean.add(&frame, 1.0 / count as f32);
        }
        Ok(mean.unwrap_or_else(|| Frame::black(subject.view.width(), subject.view.height())))
    }

    /// The memory budget, and what parts of the picture take of it.
    fn budget(&self, subject: &Subject) -> Result<Budget, EngineError> {
        let Footprint { per_hit, per_record, per_pair, per_call } = self.backend.compile(&subject.formula)?;
        let scene = subject.world.scene();
        let pairs = scene.bodies.len() as u64 * scene.lights.len() as u64;
        Ok(Budget {
            bytes: self.memory(),
            fixed_bytes: pairs.saturating_mul(per_pair),
            threads: rayon::current_num_threads() as u64,
            bytes_per_thread: self.backend.thread_bytes(&subject.formula, &subject.world, &subject.view)?,
            bytes_per_hit: per_hit,
            bytes_per_record: per_record,
            bytes_per_pixel: BYTES_PER_PIXEL,
            bytes_per_call: per_call,
        })
    }
}
