//! A fit in the background: what it is asked for, how far it is, and what came out.
//!
//! It runs on a thread with a pool of its own, which leaves a processor to the window. While a slider is held, it
//! waits.

use crate::backends::DEFAULT;
use crate::engine::{Engine, EngineError, Subject, Task};
use crate::fit::charts::{of_models, of_pictures};
use crate::fit::metric::Metric;
use crate::fit::request::{self, FittedOwners};
use crate::fit::samples::{FitSample, samples_of_material};
use crate::fit::solve::{FitOptions, FitProgress, Solution, solve};
use crate::fit::unknowns::{FreeParameter, Unknowns};
use crate::formula::Formula;
use crate::picture::{ReadPicture, ViewTransform};
use crate::plot::Chart;
use crate::preview::app::fitting::data::{FittingContents, FittingData};
use crate::preview::workshop::Workshop;
use crate::trace::View;
use crate::workspace::project::view;
use crate::workspace::session::PictureSettings;
use crate::workspace::{FileKind, Values};
use crate::world::World;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, TryRecvError, channel};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// How a fit is done.
#[derive(Clone, Copy)]
pub(super) struct FittingSettings {
    pub(super) metric: Metric,
    pub(super) starts: u32,
    /// At how many pairs of directions a measured material is compared.
    pub(super) directions: usize,
    /// Up to which angle from the normal, in degrees.
    pub(super) within: u32,
    /// How many passes a picture is the mean of.
    pub(super) passes: u32,
}

/// What a fit is asked for: all that it needs of the window.
pub(super) struct FittingTask {
    pub(super) formula: Arc<Formula>,
    pub(super) world: Arc<World>,
    pub(super) values: Values,
    pub(super) owners: FittedOwners,
    pub(super) unknowns: Unknowns,
    pub(super) data: Arc<FittingData>,
    pub(super) settings: FittingSettings,
    /// What is fitted to what, in words.
    pub(super) described: String,
    /// The view of a picture.
    view: Option<View>,
    transform: ViewTransform,
    memory: Option<u64>,
}

impl FittingTask {
    /// The task for the open formula and scene, or for the user, why there is none.
    pub(super) fn new(
        workshop: &Workshop,
        owners: FittedOwners,
        data: &Arc<FittingData>,
        free: &[FreeParameter],
        settings: FittingSettings,
        described: String,
    ) -> Result<Self, String> {
        let mends = |what: &str| format!("The {what} has mistakes, and a plain one stands in for it. Mend it first.");
        if workshop.stands_in(FileKind::Formula) {
            return Err(mends("formula"));
        }
        let picture = workshop.settings();
        let of_picture = match &data.contents {
            FittingContents::Picture(_) if workshop.stands_in(FileKind::Scene) => return Err(mends("scene")),
            FittingContents::Picture(ReadPicture { numbers, .. }) => {
                let size = [numbers.width, numbers.height];
                Some(view(&PictureSettings { size, ..picture }).map_err(|error| format!("The picture cannot be made: {error}"))?)
            }
            FittingContents::Material(_) | FittingContents::Samples(_) if owners.body.is_none() => {
                return Err("The scene has no body whose values could be fitted.".to_owned());
            }
            FittingContents::Material(_) | FittingContents::Samples(_) => None,
        };
        let unknowns = request::unknowns(free, workshop.formula(), workshop.values());
        let unknowns = unknowns.map_err(|error| format!("There is nothing to fit: {error}."))?;
        Ok(Self {
            formula: Arc::clone(workshop.formula()),
            world: Arc::clone(workshop.world()),
            values: workshop.values().clone(),
            owners,
            unknowns,
            data: Arc::clone(data),
            settings,
            described,
            view: of_picture,
            transform: picture.view,
            memory: workshop.memory(),
        })
    }

    /// Does it.
    fn work(&self, watch: &FittingWatch) -> Result<Fitted, String> {
        let start = Instant::now();
        let mut fitted = match (&self.data.contents, self.view) {
            (FittingContents::Material(material), _) => {
                let FittingSettings { directions, within, .. } = self.settings;
                self.to_samples(&samples_of_material(material, directions, f64::from(within)), watch)
            }
            (FittingContents::Samples(list), _) => self.to_samples(&request::listed_samples(list), watch),
            (FittingContents::Picture(read), Some(view)) => self.to_picture(read, view, watch)?,
            (FittingContents::Picture(_), None) => return Err("The picture has no view.".to_owned()),
        };
        fitted.seconds = start.elapsed().as_secs_f64();
        // The page of the result says it, and the chart needs the room.
        std::mem::take(fitted.chart.heading_mut());
        Ok(fitted)
    }

    fn to_samples(&self, samples: &[FitSample], watch: &FittingWatch) -> Fitted {
        let FittingSettings { metric, starts, .. } = self.settings;
        let (formula, unknowns) = (&self.formula, &self.unknowns);
        let misfit = request::sample_misfit(formula, &self.values, self.owners, unknowns, samples, metric);
        let tell = |told: FitProgress| watch.tell(told.share, Some(told.residual));
        let solution = solve(&misfit, unknowns, FitOptions { starts }, &tell, &watch.cancelled);
        let undefined = Some([misfit.undefined(&solution.values), samples.len()]);
        let values = request::fitted(&self.values, unknowns, &solution);
        let measured = match &self.data.contents {
            FittingContents::Material(material) => Some(material),
            FittingContents::Samples(_) | FittingContents::Picture(_) => None,
        };
        let chart = of_models(formula, [&self.values, &values], self.owners, measured, &self.described);
        let asymmetry = measured.filter(|material| material.is_reciprocal());
        let asymmetry = asymmetry.map(|_| request::asymmetry(formula, &values, self.owners));
        Fitted { solution, values, undefined, asymmetry, chart, seconds: 0.0 }
    }

    fn to_picture(&self, read: &ReadPicture, view: View, watch: &FittingWatch) -> Result<Fitted, String> {
        let FittingSettings { metric, starts, passes, .. } = self.settings;
        let target = request::target(read.clone(), &self.transform)
            .map_err(|why| format!("The picture `{}` cannot be used: {why}.", self.data.name()))?;
        let failed = |error: EngineError| match error.is_cancelled() {
            true => "The fit was cancelled while rays were traced, so nothing was found.".to_owned(),
            false => format!("The picture cannot be made: {error}"),
        };
        let engine = Engine::new(DEFAULT.make());
        let engine = self.memory.map_or(engine.clone(), |bytes| engine.with_memory(bytes));
        let subject = Subject { formula: Arc::clone(&self.formula), world: Arc::clone(&self.world), view };
        let tell = |share: f64| watch.tell(share, None);
        let task = Task { progress: &tell, cancelled: &watch.cancelled };
        let hits = request::traced(&engine, &subject, passes, &task).map_err(failed)?;
        let wanted = target.frame.clone();
        let misfit = request::picture_misfit(&engine, &subject, &hits, &self.values, &self.unknowns, (target, metric));
        let misfit = misfit.map_err(failed)?;
        let tell = |told: FitProgress| watch.tell(told.share, Some(told.residual));
        let solution = solve(&misfit, &self.unknowns, FitOptions { starts }, &tell, &watch.cancelled);
        let [before, after] = [&self.unknowns.start(), &solution.values].map(|values| misfit.picture(values));
        let chart = of_pictures(&wanted, [&before, &after], &self.described);
        let values = request::fitted(&self.values, &self.unknowns, &solution);
        Ok(Fitted { solution, values, undefined: None, asymmetry: None, chart, seconds: 0.0 })
    }
}

/// What came out of a fit.
pub(super) struct Fitted {
    pub(super) solution: Solution,
    /// The values of all parameters.
    pub(super) values: Values,
    /// At how many samples the formula is no number, of how many.
    pub(super) undefined: Option<[usize; 2]>,
    /// How much the formula changes when light and view change places, if the data do not.
    pub(super) asymmetry: Option<f64>,
    /// The data, before and after.
    pub(super) chart: Chart,
    pub(super) seconds: f64,
}

/// How far a fit is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct FittingState {
    /// The share of the work that is done: of tracing, or of the fit itself.
    pub(super) share: f64,
    /// The least residual so far; none while rays are traced.
    pub(super) residual: Option<f64>,
}

/// What a fit and the window tell each other.
struct FittingWatch {
    cancelled: AtomicBool,
    /// Whether the fit must wait.
    waits: AtomicBool,
    state: Mutex<(FittingState, Instant)>,
    wake: Arc<dyn Fn() + Send + Sync>,
}

impl FittingWatch {
    fn state(&self) -> MutexGuard<'_, (FittingState, Instant)> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Tells the window how far the fit is, and waits if it must.
    fn tell(&self, share: f64, residual: Option<f64>) {
        /// The window shows progress at most this often.
        const LEAST_TIME: Duration = Duration::from_millis(80);
        const PAUSE: Duration = Duration::from_millis(4);
        let wakes = {
            let mut state = self.state();
            let is_due = state.1.elapsed() >= LEAST_TIME;
            *state = (FittingState { share, residual }, if is_due { Instant::now() } else { state.1 });
            is_due
        };
        if wakes {
            (self.wake)();
        }
        while self.waits.load(Ordering::Relaxed) && !self.cancelled.load(Ordering::Relaxed) {
            std::thread::sleep(PAUSE);
        }
    }
}

/// A fit that runs. It is cancelled when it is dropped.
pub(super) struct RunningFit {
    pub(super) task: Arc<FittingTask>,
    watch: Arc<FittingWatch>,
    answer: Receiver<Result<Fitted, String>>,
}

impl RunningFit {
    /// Starts a fit. `wake` is called, on any thread, when there is something new to see.
    ///
    /// # Errors
    /// No thread can be started.
    pub(super) fn start(task: FittingTask, wake: &Arc<dyn Fn() + Send + Sync>) -> Result<Self, String> {
        let unstarted = |error: &dyn std::fmt::Display| format!("The fit cannot start: {error}");
        let state = FittingState { share: 0.0, residual: None };
        let watch = Arc::new(FittingWatch {
            cancelled: AtomicBool::new(false),
            waits: AtomicBool::new(false),
            state: Mutex::new((state, Instant::now())),
            wake: Arc::clone(wake),
        });
        let processors = std::thread::available_parallelism().map_or(1, usize::from);
        let pool = rayon::ThreadPoolBuilder::new().num_threads(processors.saturating_sub(1).max(1));
        let pool = pool.thread_name(|index| format!("fitting {index}")).build().map_err(|error| unstarted(&error))?;
        let (sender, answer) = channel();
        let task = Arc::new(task);
        let (its_task, its_watch) = (Arc::clone(&task), Arc::clone(&watch));
        let work = move || {
            // Nobody waits for the answer of a fit that was dropped.
            let _ = sender.send(pool.install(|| its_task.work(&its_watch)));
            (its_watch.wake)();
        };
        let thread = std::thread::Builder::new().name("fitting".to_owned());
        thread.spawn(work).map_err(|error| unstarted(&error))?;
        Ok(Self { task, watch, answer })
    }

    /// Ends it soon, with the best values so far.
    pub(super) fn cancel(&self) {
        self.watch.cancelled.store(true, Ordering::Relaxed);
    }

    /// Whether it was cancelled.
    pub(super) fn is_cancelled(&self) -> bool {
        self.watch.cancelled.load(Ordering::Relaxed)
    }

    /// Lets it wait, or go on.
    pub(super) fn set_waiting(&self, waits: bool) {
        self.watch.waits.store(waits, Ordering::Relaxed);
    }

    /// How far it is.
    pub(super) fn state(&self) -> FittingState {
        self.watch.state().0
    }

    /// What came out, once.
    pub(super) fn take(&self) -> Option<Result<Fitted, String>> {
        match self.answer.try_recv() {
            Ok(answer) => Some(answer),
            Err(TryRecvError::Empty) => None,
            Err(TryRecvError::Disconnected) => Some(Err("The fit ended unexpectedly.".to_owned())),
        }
    }
}

impl Drop for RunningFit {
    fn drop(&mut self) {
        self.cancel();
    }
}
