//! Pictures made in the background. Callers say what they want, take the newest picture, and never wait.
//!
//! One thread traces, first at a low resolution and then in full; another evaluates. Both take the newest request:
//! outdated values are never drawn, and tracing that is no longer needed ends soon. While a scene is moved by hand, one
//! coarse picture follows the other, and the full one comes when the scene rests. Nothing here knows of widgets.

mod drawing;
mod nan_mask;
mod pace;
mod tracing;

use crate::engine::{Engine, Subject};
use crate::evaluate::review::PictureFinding;
use crate::picture::{Frame, ViewTransform};
use crate::plan::Method;
use crate::trace::{Counts, Hits};
use drawing::DrawingWorker;
pub use nan_mask::NanMask;
use pace::Pace;
use std::sync::atomic::{AtomicBool, AtomicU32, AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::Duration;
use tracing::trace_forever;

/// What is to be drawn, beside parameter numbers.
#[derive(Clone)]
pub struct RenderRequest {
    /// Formula, world and view.
    pub subject: Subject,
    /// The engine that makes the pictures.
    pub engine: Engine,
    /// How linear components become bytes.
    pub transform: ViewTransform,
    /// Whether the scene is being moved by hand, so other requests will follow soon. They have the same formula, and
    /// the same bodies and lights in other places.
    pub moves: bool,
    /// How many passes the picture is the mean of, at least 1. The first one is shown alone, then those so far.
    pub samples: u32,
}

/// A picture to be shown.
#[derive(Debug, Clone, Default)]
pub struct Picture {
    /// Pixels in a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Row by row from the top left, `0x00RRGGBB`.
    pub pixels: Vec<u32>,
    /// The number of the picture, counted from 1. 0 is no picture.
    pub version: u64,
    /// The stamp of its parameter numbers, from [`Renderer::show`] or [`Renderer::move_to`].
    pub values: u64,
    /// Width and height that were asked for. A picture of low resolution has fewer pixels.
    pub full_size: [u32; 2],
    /// The linear colours of the pixels, with NaN as 0. Pictures of a held slider have none.
    pub linear: Option<Arc<Frame>>,
    /// Which of them are NaN.
    pub nan: NanMask,
    /// How many passes are in it.
    pub passes: PassCount,
}

/// How many passes a picture has.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct PassCount {
    /// How many were evaluated for its numbers, at least 1.
    pub evaluated: usize,
    /// How many are in it: more, if only what the numbers changed was evaluated.
    pub shown: usize,
}

impl Picture {
    /// Whether it has all its pixels.
    pub fn is_full(&self) -> bool {
        self.full_size == [self.width, self.height]
    }
}

/// What happened in the background.
#[derive(Debug, Clone, PartialEq)]
pub enum Event {
    /// A formula was compiled, or found in the cache of compiled formulas.
    Compiled(Duration),
    /// Rays were traced.
    Traced {
        /// How long it took.
        time: Duration,
        /// What was found.
        counts: Counts,
        /// Pixels in a row, and rows.
        size: [u32; 2],
        /// Whether this is the size that was asked for.
        full: bool,
    },
    /// Static values of all hits were computed, and the first picture was drawn.
    Ready {
        /// How long that took.
        time: Duration,
        /// The memory that the evaluator keeps, in bytes for each pixel.
        bytes_per_pixel: f64,
    },
    /// A frame was drawn.
    Frame {
        /// The method of the drag; `None` if it was no drag.
        method: Option<Method>,
        /// How long it took.
        time: Duration,
        /// How many passes are in it.
        passes: PassCount,
    },
    /// All passes were traced, or as many as there is memory for.
    Passes {
        /// How many are kept.
        kept: usize,
        /// How many were wanted.
        wanted: usize,
        /// How long it took to trace those after the first.
        time: Duration,
        /// What all of them take, in bytes.
        bytes: u64,
    },
    /// A coarse picture of a scene that is being moved was traced and drawn.
    Moved {
        /// How long it took.
        time: Duration,
        /// Pixels in a row, and rows.
        size: [u32; 2],
    },
    /// The number of pixels with a component that is NaN, of a picture without a held slider, and the first of them in
    /// the picture in full size. The picture shows such components as 0.
    Undefined(usize, Option<[u32; 2]>),
    /// What is remarkable about a picture at rest that has all its pixels; `None` if nothing is.
    Reviewed(Option<PictureFinding>),
    /// There is no picture. The text says why.
    Failed(String),
}

/// What is wanted.
#[derive(Default)]
struct WantedPicture {
    request: Option<RenderRequest>,
    numbers: Vec<f32>,
    /// Increases by 1 when numbers or request change.
    stamp: u64,
    /// The stamp of the request.
    requested: u64,
    /// The indices of the numbers of a slider that is held.
    held: Option<Vec<usize>>,
    /// The size of pictures on the screen.
    shown: Option<[u32; 2]>,
    /// The hits that were traced last for the wanted subject, or for the one before it while the scene moves.
    hits: Option<TracedHits>,
    /// Whether a picture of a moving scene is being traced. The next movement does not end that: otherwise no picture
    /// would ever be complete.
    moving: bool,
    /// Whether a pass after the first is being traced.
    traces_more: bool,
    quit: bool,
}

/// Hits with what they were traced for.
#[derive(Clone)]
struct TracedHits {
    hits: Arc<Hits>,
    /// Those of the passes after the first.
    more: Vec<Arc<Hits>>,
    /// The stamp of the request.
    requested: u64,
    /// How long tracing took, if they are coarse hits of a moving scene.
    moving: Option<Duration>,
}

/// What the threads share.
struct RendererState {
    wanted: Mutex<WantedPicture>,
    changed: Condvar,
    /// The newest picture, if nobody has taken it yet.
    newest: Mutex<Option<Picture>>,
    arrived: Condvar,
    /// Buffers of old pictures, to be used again.
    spare: Mutex<Vec<Vec<u32>>>,
    /// Ends tracing.
    cancelled: AtomicBool,
    /// Ends the refinement of a picture: another one is wanted.
    hurries: AtomicBool,
    /// How much is traced, in thousandths. 1000 if nothing is being traced.
    progress: AtomicU32,
    /// How many passes are traced, and how many are wanted.
    passes: [AtomicU32; 2],
    pace: Mutex<Pace>,
    versions: AtomicU64,
    wake: Box<dyn Fn() + Send + Sync>,
}

impl RendererState {
    fn wanted(&self) -> MutexGuard<'_, WantedPicture> {
        self.wanted.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn pace(&self) -> MutexGuard<'_, Pace> {
        self.pace.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Notes how long evaluating new hits took, if the event says so. Returns the event to pass on. `moving` is how
    /// long tracing took for a scene that moves.
    fn noting_pace(&self, event: Event, hits: &Hits, moving: Option<Duration>) -> Option<Event> {
        if let Event::Ready { time, .. } = event {
            self.pace().note_evaluated(hits.view.pixels(), time);
        }
        match (event, moving) {
            (Event::Ready { time, .. }, Some(tracing)) => {
                Some(Event::Moved { time: tracing + time, size: [hits.view.width(), hits.view.height()] })
            }
            // The picture of the scene at rest will say it.
            (Event::Undefined(..) | Event::Reviewed(_), Some(_)) => None,
            (event, _) => Some(event),
        }
    }

    fn wait<'w>(&self, wanted: MutexGuard<'w, WantedPicture>) -> MutexGuard<'w, WantedPicture> {
        self.changed.wait(wanted).unwrap_or_else(PoisonError::into_inner)
    }
}

/// Makes pictures on threads of its own.
pub struct Renderer {
    shared: Arc<RendererState>,
    events: Receiver<Event>,
    threads: Vec<JoinHandle<()>>,
}

impl Renderer {
    /// Starts the threads. They call `wake` when there is something new to see.
    ///
    /// # Errors
    /// No thread can be started.
    pub fn new(wake: impl Fn() + Send + Sync + 'static) -> std::io::Result<Self> {
        let shared = Arc::new(RendererState {
            wanted: Mutex::default(),
            changed: Condvar::new(),
            newest: Mutex::default(),
            arrived: Condvar::new(),
            spare: Mutex::default(),
            cancelled: AtomicBool::new(false),
            hurries: AtomicBool::new(false),
            progress: AtomicU32::new(1000),
            passes: [AtomicU32::new(1), AtomicU32::new(1)],
            pace: Mutex::default(),
            versions: AtomicU64::new(0),
            wake: Box::new(wake),
        });
        let (sender, events) = channel();
        let mut renderer = Self { shared: Arc::clone(&shared), events, threads: Vec::new() };
        // Each works on threads of its own: a frame does not wait for tiles that are being traced.
        for (name, work) in [("tracing", trace_forever as fn(&Arc<RendererState>, &Sender<Event>)), ("evaluation", draw_forever)]
        {
            let pool = rayon::ThreadPoolBuilder::new().thread_name(move |index| format!("{name} {index}")).build();
            let pool = pool.map_err(std::io::Error::other)?;
            let (shared, sender) = (Arc::clone(&shared), sender.clone());
            let thread = std::thread::Builder::new().name(name.to_owned());
            renderer.threads.push(thread.spawn(move || pool.install(|| work(&shared, &sender)))?);
        }
        Ok(renderer)
    }

    /// Shows another scene or formula, with these parameter numbers in the order of their layout. Returns their stamp,
    /// which increases by 1 with each call.
    pub fn show(&self, request: RenderRequest, numbers: &[f32]) -> u64 {
        let mut wanted = self.shared.wanted();
        let same_hits = wanted.request.as_ref().is_some_and(|before| before.subject.same_hits(&request.subject));
        wanted.requested = wanted.stamp + 1;
        if same_hits {
            let requested = wanted.requested;
            wanted.hits.iter_mut().for_each(|traced| traced.requested = requested);
        } else {
            let moves_on = request.moves && wanted.request.as_ref().is_some_and(|before| before.moves);
            // The evaluation may not have come to the picture before the movement yet.
            wanted.hits = wanted.hits.take().filter(|traced| moves_on && traced.moving.is_some());
            if !(request.moves && wanted.moving) {
                self.shared.cancelled.store(true, Ordering::Relaxed);
            }
        }
        wanted.request = Some(request);
        wanted.held = None;
        self.set(wanted, numbers)
    }

    /// The hits of the first pass of the picture that was requested last, once they are traced in full.
    pub fn first_hits(&self) -> Option<Arc<Hits>> {
        let wanted = self.shared.wanted();
        let view = wanted.request.as_ref()?.subject.view;
        let traced = wanted.hits.as_ref().filter(|traced| traced.hits.view == view && traced.requested == wanted.requested);
        traced.map(|traced| Arc::clone(&traced.hits))
    }

    /// Shows other parameter numbers. `held` are the indices of those that a held slider moves. Returns their stamp.
    pub fn move_to(&self, numbers: &[f32], held: Option<Vec<usize>>) -> u64 {
        let mut wanted = self.shared.wanted();
        if held.is_some() && wanted.traces_more {
            // The slider gets all processors. The pass is traced when it is let go.
            self.shared.cancelled.store(true, Ordering::Relaxed);
        }
        wanted.held = held;
        self.set(wanted, numbers)
    }

    /// Says how large pictures are on the screen, in pixels. Pictures of a held slider are scaled to that size, if it
    /// is smaller than their own: then fewer pixels go from thread to thread.
    pub fn show_scaled(&self, size: Option<[u32; 2]>) {
        self.shared.wanted().shown = size;
    }

    fn set(&self, mut wanted: MutexGuard<'_, WantedPicture>, numbers: &[f32]) -> u64 {
        numbers.clone_into(&mut wanted.numbers);
        wanted.stamp += 1;
        self.shared.hurries.store(true, Ordering::Relaxed);
        let stamp = wanted.stamp;
        drop(wanted);
        self.shared.changed.notify_all();
        stamp
    }

    /// Waits until the picture of the numbers with this stamp, or of later ones, has arrived, but at most `longest`.
    pub fn wait_for(&self, values: u64, longest: Duration) {
        let newest = self.shared.newest.lock().unwrap_or_else(PoisonError::into_inner);
        let is_missing = |newest: &mut Option<Picture>| newest.as_ref().is_none_or(|picture| picture.values < values);
        // The caller takes what has arrived.
        drop(self.shared.arrived.wait_timeout_while(newest, longest, is_missing));
    }

    /// Replaces `before` by the newest picture if that was not taken yet, and recycles the memory of `before`. Returns
    /// whether it did.
    pub fn take(&self, before: &mut Picture) -> bool {
        let newest = self.shared.newest.lock().unwrap_or_else(PoisonError::into_inner).take();
        let Some(newest) = newest else { return false };
        let old = std::mem::replace(before, newest);
        self.shared.spare.lock().unwrap_or_else(PoisonError::into_inner).push(old.pixels);
        true
    }

    /// What happened since the last call.
    pub fn events(&self) -> impl Iterator<Item = Event> {
        self.events.try_iter()
    }

    /// How many passes of the picture are traced, and how many there will be.
    pub fn passes(&self) -> [u32; 2] {
        self.shared.passes.each_ref().map(|count| count.load(Ordering::Relaxed))
    }

    /// How much of a picture is traced, 0..1. `None` if nothing is being traced.
    pub fn progress(&self) -> Option<f32> {
        let thousandths = self.shared.progress.load(Ordering::Relaxed);
        (thousandths < 1000).then_some(thousandths as f32 / 1000.0)
    }
}

impl Drop for Renderer {
    fn drop(&mut self) {
        self.shared.wanted().quit = true;
        self.shared.hurries.store(true, Ordering::Relaxed);
        self.shared.cancelled.store(true, Ordering::Relaxed);
        self.shared.changed.notify_all();
        for thread in self.threads.drain(..) {
            // A thread that panicked has reported it already.
            let _ = thread.join();
        }
    }
}

/// Draws what is wanted, whenever that changes, and prepares what a held slider will need meanwhile.
fn draw_forever(shared: &Arc<RendererState>, events: &Sender<Event>) {
    // It takes the lock, so that the notification cannot come between a check and the wait that follows.
    let again = || {
        let shared = Arc::clone(shared);
        move || {
            drop(shared.wanted());
            shared.changed.notify_all();
        }
    };
    let mut worker = DrawingWorker::default();
    let mut drawn: Option<(u64, Arc<Hits>)> = None;
    loop {
        let (request, traced, numbers, held, stamp, values, is_drawn) = {
            let mut wanted = shared.wanted();
            loop {
                if wanted.quit {
                    return;
                }
                if let (Some(request), Some(traced)) = (&wanted.request, &wanted.hits) {
                    let is_older = traced.requested != wanted.requested;
                    let done =
                        |(stamp, of): &(u64, Arc<Hits>)| (*stamp == wanted.stamp || is_older) && Arc::ptr_eq(of, &traced.hits);
                    let is_drawn = drawn.as_ref().is_some_and(done);
                    if !is_drawn || wanted.held.is_none() && worker.can_refine(request, traced) {
                        worker.shown = wanted.shown;
                        // A picture of the scene before the last movement is not that of the wanted values.
                        let values = if is_older { traced.requested } else { wanted.stamp };
                        let (numbers, held) = (wanted.numbers.clone(), wanted.held.clone());
                        shared.hurries.store(false, Ordering::Relaxed);
                        break (request.clone(), traced.clone(), numbers, held, wanted.stamp, values, is_drawn);
                    }
                }
                if worker.has_more_to_prepare() {
                    drop(wanted);
                    worker.prepare(again());
                    wanted = shared.wanted();
                } else {
                    wanted = shared.wait(wanted);
                }
            }
        };
        let TracedHits { hits, more, moving, .. } = traced;
        let tell = |event: Event| {
            // The receiver is dropped only at the end of the program.
            shared.noting_pace(event, &hits, moving).into_iter().for_each(|event| drop(events.send(event)));
        };
        let room = || shared.spare.lock().unwrap_or_else(PoisonError::into_inner).pop().unwrap_or_default();
        // Passes are refined while nothing else is wanted.
        let picture = match is_drawn {
            false => worker.draw(&request, &hits, &numbers, held, &tell, room).map(Some),
            true => worker.refine(&request, (&hits, &more), &numbers, &shared.hurries, (&tell, room)),
        };
        match picture {
            Ok(None) => continue,
            Ok(Some(mut picture)) => {
                picture.version = shared.versions.fetch_add(1, Ordering::Relaxed) + 1;
                picture.values = values;
                let overtaken = shared.newest.lock().unwrap_or_else(PoisonError::into_inner).replace(picture);
                shared.arrived.notify_all();
                if let Some(overtaken) = overtaken {
                    shared.spare.lock().unwrap_or_else(PoisonError::into_inner).push(overtaken.pixels);
                }
            }
            Err(error) => tell(Event::Failed(error.to_string())),
        }
        // After the picture, because this may take longer than a frame.
        if let Some(finding) = worker.review(&request, &hits, &numbers) {
            tell(Event::Reviewed(finding));
        }
        drawn = Some((stamp, hits));
        (shared.wake)();
        // Also if a new picture is wanted already: otherwise a quick drag would never be prepared.
        worker.prepare(again());
    }
}

#[cfg(test)]
mod tests;
