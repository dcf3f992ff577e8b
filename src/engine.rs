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
use crate::world::{Assets, MissingAsset, World};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};
use thiserror::Error;

/// The memory for each pixel, without hits, in bytes: two linear pictures, a framebuffer, and the data of a picture
/// file.
const BYTES_PER_PIXEL: u64 = 40;
/// The memory for each pixel of a linear picture, in bytes.
const BYTES_PER_LINEAR_PIXEL: u64 = size_of::<[f32; 3]>() as u64;
/// Tracing takes about as long as this many pictures. Progress is told by it.
const TRACING: f64 = 20.0;

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
    /// A formula, a scene and a view. This builds the world of the scene. What the scene names must be among
    /// the `assets`.
    ///
    /// # Errors
    /// The scene names something that is not among them.
    pub fn new(formula: Formula, scene: Scene, assets: &Assets, view: View) -> Result<Self, MissingAsset> {
        Ok(Self { formula: Arc::new(formula), world: Arc::new(World::new(scene, assets)?), view })
    }

    /// A subject from texts. The scene names no files; [`AssetStore`](crate::workspace::AssetStore) reads those of
    /// others.
    ///
    /// # Errors
    /// All errors of both texts, and that the scene names a file.
    pub fn parse(formula: &str, scene: &str, view: View) -> Result<Self, ParseError> {
        let (formula, scene) = (Source::new("formula", formula), Source::new("scene", scene));
        let failed = |errors: Diagnostics, source: &Source| ParseError(errors.located(source).to_string());
        match (Formula::parse(&formula), Scene::parse(&scene)) {
            (Ok((formula, _)), Ok((scene, _))) => {
                Self::new(formula, scene, &Assets::NONE, view).map_err(|missing| ParseError(missing.to_string()))
            }
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

    /// Does the work that depends on the formula and the kinds of lights alone. The backend keeps formulas that it has
    /// compiled.
    ///
    /// # Errors
    /// The backend does not support the formula.
    pub fn compile(&self, subject: &Subject) -> Result<(), EngineError> {
        self.backend.compile(&subject.formula, &subject.world)?;
        Ok(())
    }

    /// Traces the scene, on all threads of the current pool. Hits and the evaluation of the formula share the memory
    /// budget.
    ///
    /// # Errors
    /// The picture needs more memory than the budget, the task was cancelled, or the backend does not support the
    /// formula.
    pub fn trace(&self, subject: &Subject, task: &Task) -> Result<Arc<Hits>, EngineError> {
        self.trace_beside(subject, 0, task)
    }

    /// Traces the scene. There is memory for this many linear pictures besides.
    fn trace_beside(&self, subject: &Subject, pictures: u64, task: &Task) -> Result<Arc<Hits>, EngineError> {
        let budget = self.budget(subject, pictures)?;
        let lights = subject.formula.evaluated_lights();
        Ok(Arc::new(trace(&subject.world, &subject.view, lights, &budget, task.progress, task.cancelled)?))
    }

    /// What a pass of a picture with these hits takes once the formula is prepared for it, in bytes.
    ///
    /// # Errors
    /// The backend does not support the formula.
    pub fn kept_bytes(&self, subject: &Subject, hits: &Arc<Hits>) -> Result<u64, EngineError> {
        let budget = self.budget(subject, 0)?;
        Ok(budget.kept_bytes(hits, subject.formula.evaluated_lights()))
    }

    /// Prepares a formula for hits. They may have been traced for another formula. If the formula is the first one to
    /// read `visible`, the shadow rays that it needs are traced now. `parameters` are the numbers of the first picture,
    /// or none: see [`Backend::prepare`].
    ///
    /// # Errors
    /// The backend does not support the formula, the hits belong to another scene or view, or what the formula needs
    /// beyond the hits takes more memory than the budget.
    pub fn prepare(&self, subject: &Subject, hits: &Arc<Hits>, parameters: &[f32]) -> Result<Arc<dyn Evaluator>, EngineError> {
        let lights = subject.formula.evaluated_lights();
        if self.backend.reads_hits() && !hits.serves(lights) {
            self.budget(subject, 0)?.check_hits(hits, lights)?;
        }
        Ok(self.backend.prepare(&subject.formula, hits, parameters)?)
    }

    /// Compiles, traces and prepares. `parameters` are the numbers of the first picture, or none.
    ///
    /// # Errors
    /// One of these steps failed.
    pub fn evaluator(&self, subject: &Subject, parameters: &[f32], task: &Task) -> Result<Arc<dyn Evaluator>, EngineError> {
        self.evaluator_beside(subject, parameters, 0, task)
    }

    /// Compiles, traces and prepares. There is memory for this many linear pictures besides.
    fn evaluator_beside(
        &self,
        subject: &Subject,
        parameters: &[f32],
        pictures: u64,
        task: &Task,
    ) -> Result<Arc<dyn Evaluator>, EngineError> {
        let hits = match self.backend.reads_hits() {
            true => self.trace_beside(subject, pictures, task)?,
            false => {
                self.budget(subject, pictures)?.check(&subject.view)?;
                Arc::new(Hits::untraced(&subject.world, subject.view))
            }
        };
        self.prepare(subject, &hits, parameters)
    }

    /// The picture of these parameter numbers, in the order of the [`Layout`](crate::formula::layout::Layout): the
    /// mean of this many passes (0 counts as 1) from that of the view on, in linear RGB, not clamped. It may contain
    /// NaN. Each pass is traced, see [`View::with_pass`].
    ///
    /// # Errors
    /// One of the stages failed.
    ///
    /// # Panics
    /// Where there are fewer parameter numbers than the layout has.
    pub fn picture(&self, subject: &Subject, parameters: &[f32], passes: u32, task: &Task) -> Result<Frame, EngineError> {
        let mut picture = None;
        self.pictures(subject, &[parameters], passes, task, |_, frame, _| {
            picture = Some(frame);
            Ok::<_, EngineError>(())
        })?;
        Ok(picture.unwrap_or_else(|| Frame::black(subject.view.width(), subject.view.height())))
    }

    /// The pictures of several sets of parameter numbers, each as [`picture`](Self::picture) makes it. `each` gets
    /// their indices, the pictures, and how long they were evaluated, in order. Rays are traced once for all of them:
    /// once for each pass. With more than one pass, all pictures are kept until the last pass is traced.
    ///
    /// # Errors
    /// One of the stages failed, the task was cancelled between two pictures, or `each` failed.
    ///
    /// # Panics
    /// Where a set has fewer parameter numbers than the layout has.
    pub fn pictures<E: From<EngineError>>(
        &self,
        subject: &Subject,
        parameters: &[&[f32]],
        passes: u32,
        task: &Task,
        mut each: impl FnMut(usize, Frame, Duration) -> Result<(), E>,
    ) -> Result<(), E> {
        let count = passes.max(1);
        // One of them is in the memory of any picture.
        let kept = if count == 1 { 0 } else { (parameters.len() as u64).saturating_sub(1) };
        let mut sums: Vec<(Frame, Duration)> = Vec::new();
        for pass in 0..count {
            let view = subject.view.with_pass(subject.view.pass() + pass);
            let subject = Subject { view, ..subject.clone() };
            let tell = |share: f64| (task.progress)((f64::from(pass) + share) / f64::from(count));
            let frames = parameters.len() as f64;
            let traced = |share: f64| tell(share * TRACING / (TRACING + frames));
            let first = parameters.first().copied().unwrap_or_default();
            let evaluator = self.evaluator_beside(&subject, first, kept, &Task { progress: &traced, ..*task })?;
            for (index, parameters) in parameters.iter().enumerate() {
                if task.cancelled.load(Ordering::Relaxed) {
                    return Err(EngineError::from(TraceError::Cancelled).into());
                }
                let start = Instant::now();
                let frame = evaluator.frame(parameters);
                if let Some(failure) = evaluator.failure() {
                    return Err(EngineError::from(EvaluateError::Backend(failure)).into());
                }
                if count == 1 {
                    each(index, frame, start.elapsed())?;
                } else {
                    let time = start.elapsed();
                    match sums.get_mut(index) {
                        Some((sum, times)) => {
                            sum.add(&frame);
                            *times += time;
                        }
                        None => sums.push((frame, time)),
                    }
                }
                tell((TRACING + index as f64 + 1.0) / (TRACING + frames));
            }
        }
        sums.into_iter().enumerate().try_for_each(|(index, (mut sum, time))| {
            sum.scale(1.0 / count as f32);
            each(index, sum, time)
        })
    }

    /// The memory budget, and what parts of the picture take of it. This many linear pictures are kept besides.
    fn budget(&self, subject: &Subject, pictures: u64) -> Result<Budget, EngineError> {
        let Footprint { per_hit, per_record, per_miss, per_pair, per_call, per_pixel } =
            self.backend.compile(&subject.formula, &subject.world)?;
        let scene = subject.world.scene();
        let pairs = scene.bodies.len() as u64 * scene.lights.len() as u64;
        Ok(Budget {
            bytes: self.memory(),
            fixed_bytes: pairs.saturating_mul(per_pair),
            asset_bytes: subject.world.assets().memory(),
            threads: rayon::current_num_threads() as u64,
            bytes_per_thread: self.backend.thread_bytes(&subject.formula, &subject.world, &subject.view)?,
            bytes_per_hit: per_hit,
            bytes_per_record: per_record,
            bytes_per_miss: per_miss,
            bytes_per_pixel: (BYTES_PER_PIXEL + per_pixel).saturating_add(pictures.saturating_mul(BYTES_PER_LINEAR_PIXEL)),
            bytes_per_call: per_call,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::workspace::Values;
    use std::sync::Mutex;

    /// The default backend. It keeps the hits that it prepares formulas for.
    struct Recording {
        backend: Arc<dyn Backend>,
        prepared: Mutex<Vec<Arc<Hits>>>,
    }

    impl Backend for Recording {
        fn name(&self) -> &'static str {
            "recording"
        }

        fn compile(&self, formula: &Arc<Formula>, world: &World) -> Result<Footprint, EvaluateError> {
            self.backend.compile(formula, world)
        }

        fn thread_bytes(&self, formula: &Arc<Formula>, world: &World, view: &View) -> Result<u64, EvaluateError> {
            self.backend.thread_bytes(formula, world, view)
        }

        fn prepare(
            &self,
            formula: &Arc<Formula>,
            hits: &Arc<Hits>,
            parameters: &[f32],
        ) -> Result<Arc<dyn Evaluator>, EvaluateError> {
            self.prepared.lock().unwrap().push(Arc::clone(hits));
            self.backend.prepare(formula, hits, parameters)
        }
    }

    fn subject() -> Subject {
        let formula = "body_specific; kd: scalar, constraint 0..1, default 0.5; formula; = kd*IL*Cd*max(0, N.L);";
        let scene = "bodies; ball: sphere, center <0,0,0>, radius 1; lights; key: point, <4,6,5>;
            camera; position <0,1,6>; gaze <0,-0.15,-1>; up <0,1,0>; fov 40;";
        Subject::parse(formula, scene, View::new(24, 16).unwrap()).unwrap()
    }

    /// Three sets of parameter numbers: `kd` is 0, 0.5 and 1.
    fn numbers(subject: &Subject) -> Vec<Vec<f32>> {
        let mut values = Values::defaults(&subject.formula, subject.world.scene());
        let set = |text: &str, values: &mut Values| {
            let given = text.parse::<crate::workspace::NamedAssignment>().unwrap().resolve(values.table()).unwrap();
            values.assign(&given);
            values.numbers().to_vec()
        };
        ["ball.kd=0", "ball.kd=0.5", "ball.kd=1"].map(|text| set(text, &mut values)).to_vec()
    }

    #[test]
    fn several_pictures_are_those_of_one_each_and_traced_once_for_each_pass() {
        let subject = subject();
        let numbers = numbers(&subject);
        for passes in [1, 3] {
            let backend = Arc::new(Recording { backend: crate::backends::DEFAULT.make(), prepared: Mutex::default() });
            let engine = Engine::new(Arc::clone(&backend) as Arc<dyn Backend>);
            let told = Mutex::new(Vec::new());
            let tell = |share: f64| told.lock().unwrap().push(share);
            let mut pictures = Vec::new();
            let sets: Vec<&[f32]> = numbers.iter().map(Vec::as_slice).collect();
            let done = engine.pictures(&subject, &sets, passes, &Task::watched(&tell), |index, frame, _| {
                pictures.push((index, frame));
                Ok::<_, EngineError>(())
            });
            done.unwrap();
            let prepared = std::mem::take(&mut *backend.prepared.lock().unwrap());
            assert_eq!(prepared.iter().map(|hits| hits.view.pass()).collect::<Vec<_>>(), Vec::from_iter(0..passes));
            let shares = told.into_inner().unwrap();
            assert!(shares.is_sorted() && shares.last() == Some(&1.0), "{shares:?}");
            let one = |numbers: &Vec<f32>| Engine::default().picture(&subject, numbers, passes, &Task::UNWATCHED).unwrap();
            assert_eq!(pictures, numbers.iter().map(one).enumerate().collect::<Vec<_>>());
            assert!(pictures[0].1 != pictures[1].1 && pictures[1].1 != pictures[2].1);
        }
    }

    #[test]
    fn several_pictures_end_at_a_failure_or_when_they_are_cancelled() {
        let subject = subject();
        let numbers = numbers(&subject);
        let sets: Vec<&[f32]> = numbers.iter().map(Vec::as_slice).collect();
        let cancelled = AtomicBool::new(false);
        let task = Task { progress: &|_| (), cancelled: &cancelled };
        let mut count = 0;
        let outcome = Engine::default().pictures(&subject, &sets, 1, &task, |_, _, _| {
            count += 1;
            cancelled.store(true, Ordering::Relaxed);
            Ok::<_, EngineError>(())
        });
        assert!(outcome.unwrap_err().is_cancelled());
        assert_eq!(count, 1);
        let failed = || EngineError::from(EvaluateError::Backend("full".to_owned()));
        let outcome = Engine::default().pictures(&subject, &sets, 1, &Task::UNWATCHED, |_, _, _| Err(failed()));
        assert_eq!(outcome.unwrap_err().to_string(), "full");
    }

    #[test]
    fn files_count_in_the_memory_of_a_picture() {
        let text = "bodies; stone: mesh, \"preset:gem\"; lights; key: point, <4,6,5>;
            camera; position <0,1,6>; gaze <0,-0.15,-1>; up <0,1,0>; fov 40;";
        let (scene, _) = Scene::parse(&Source::new("scene", text)).unwrap();
        let (formula, _) = Formula::parse(&Source::new("formula", "formula; = IL*Cd;")).unwrap();
        let reading = crate::mesh::Reading::unwatched(1 << 20);
        let place = crate::workspace::Location::new("");
        let (assets, _) = crate::workspace::AssetStore::default().load(&scene, &place, &reading).unwrap();
        let subject = Subject::new(formula, scene, &assets, View::new(24, 16).unwrap()).unwrap();
        let trace = |bytes: u64| Engine::default().with_memory(bytes).trace(&subject, &Task::UNWATCHED);
        let error = trace(assets.memory() - 1).unwrap_err();
        assert!(error.is_memory() && error.to_string().starts_with("the files of the scene take"), "{error}");
        assert!(trace(1 << 30).is_ok());
    }
}
