//! Draws the pictures of the evaluation thread. Evaluators are used again, and a held slider is drawn as a drag.

use crate::engine::{EngineError, Subject};
use crate::evaluate::review::{PictureFinding, PictureSummary, ReviewedPicture, review};
use crate::evaluate::{Drag, DragBeginning, Evaluator, Framebuffer, WholeFrames};
use crate::formula::Formula;
use crate::picture::Frame;
use crate::plan::Method;
use crate::preview::renderer::{Event, NanMask, PassCount, Picture, RenderRequest, TracedHits};
use crate::preview::resampling::scale;
use crate::trace::Hits;
use rayon::prelude::*;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// What a held slider may keep, in bytes.
const DRAG_BYTES: usize = 1 << 30;

/// A slider that is held.
struct Held {
    indices: Vec<usize>,
    drag: Readiness,
    /// What draws pictures of several passes until the drag is made.
    interim: Option<WholeFrames>,
}

/// What pictures of a held slider are made with.
enum Readiness {
    /// Nothing yet. These are the parameter numbers of its first picture.
    First(Vec<f32>),
    /// A thread compiles kernels, while pictures are drawn in full. Its result is `None` if they cannot be compiled.
    /// It sets the flag when it is about to end.
    Making(JoinHandle<Option<Box<dyn Drag>>>, Arc<AtomicBool>),
    Made(Box<dyn Drag>),
    /// There are no kernels for the slider. Every picture is drawn in full.
    Impossible,
}

/// What the evaluation thread keeps from one picture to the next.
#[derive(Default)]
pub(super) struct DrawingWorker {
    /// The formula that was compiled last, and the name of the backend.
    compiled: Option<(Arc<Formula>, &'static str)>,
    /// The evaluator of the hits that are drawn, of that formula.
    ready: Option<(Arc<Hits>, Arc<dyn Evaluator>)>,
    /// The slider that is held.
    held: Option<Held>,
    framebuffer: Option<Framebuffer>,
    /// The size in which pictures are shown on the screen. Pictures of a held slider are scaled to it while they are in
    /// the caches of the threads that drew them, if it is smaller than they are.
    pub(super) shown: Option<[u32; 2]>,
    /// The summary of the last picture, if it was evaluated at rest and has not been reviewed. `Some(None)` if nothing
    /// is remarkable about it.
    unreviewed: Option<Option<PictureSummary>>,
    /// The last picture of the evaluator without a held slider. Another view transform needs no evaluation.
    linear: Option<LinearPicture>,
    /// How long it takes to evaluate a pass.
    pass_time: Duration,
    /// Whether the last pass could not be added.
    cannot_refine: bool,
}

/// Pictures of a held slider take about this long at most, where passes are evaluated.
const FRAME_TIME: Duration = Duration::from_millis(14);

/// The linear colours of a picture, with NaN as 0.
struct LinearPicture {
    frame: Arc<Frame>,
    nan: NanMask,
    /// The summary of a picture with NaN. Only the evaluation sees them.
    summary: Option<PictureSummary>,
    hits: Arc<Hits>,
    numbers: Vec<f32>,
    passes: PassCount,
    /// The sum of the first passes with these numbers, with NaN, and how many there are.
    sum: Option<(Frame, usize)>,
    /// How many pixels are NaN, and the index of the first.
    undefined: usize,
    first_undefined: Option<usize>,
}

impl LinearPicture {
    /// A picture of these hits and parameter numbers, which may contain NaN.
    fn new(mut frame: Frame, hits: &Arc<Hits>, numbers: Vec<f32>, passes: PassCount, sum: Option<(Frame, usize)>) -> Self {
        let is_undefined = |pixel: &[f32; 3]| pixel.iter().any(|component| component.is_nan());
        let first = frame.linear.iter().position(is_undefined);
        // Most pictures have none, and are read once.
        let summary = first.map(|_| PictureSummary::of(&frame));
        let nan = first.map(|_| NanMask::of(&frame)).unwrap_or_default();
        let undefined = if first.is_some() { frame.clean() } else { 0 };
        let hits = Arc::clone(hits);
        Self { frame: Arc::new(frame), nan, summary, hits, numbers, passes, sum, undefined, first_undefined: first }
    }

    /// Whether it is the picture of these hits and parameter numbers.
    fn is_of(&self, hits: &Arc<Hits>, numbers: &[f32]) -> bool {
        let same = |(one, other): (&f32, &f32)| one.to_bits() == other.to_bits();
        Arc::ptr_eq(&self.hits, hits) && self.numbers.len() == numbers.len() && self.numbers.iter().zip(numbers).all(same)
    }
}

impl DrawingWorker {
    /// Whether something is left to prepare for the held slider.
    pub(super) fn has_more_to_prepare(&self) -> bool {
        match self.held.as_ref().map(|held| &held.drag) {
            Some(Readiness::First(_)) => self.ready.is_some(),
            Some(Readiness::Making(_, is_done)) => is_done.load(Ordering::Acquire),
            Some(Readiness::Made(drag)) => !drag.is_ready(),
            Some(Readiness::Impossible) | None => false,
        }
    }

    /// Prepares a part of the drag. Another thread plans and compiles it, and calls `done` at its end.
    pub(super) fn prepare(&mut self, done: impl FnOnce() + Send + 'static) {
        let Some((hits, ready)) = self.ready.clone() else { return };
        let Some(Held { indices, drag, interim }) = self.held.take() else { return };
        let drag = match drag {
            Readiness::First(numbers) => {
                let beginning = self.beginning(&ready, &hits).map(|(beginning, before)| (beginning, before.to_vec()));
                let indices = indices.clone();
                let is_done = Arc::new(AtomicBool::new(false));
                let told = Arc::clone(&is_done);
                let make = move || {
                    let made = begin_drag(&ready, &indices, &numbers, beginning);
                    told.store(true, Ordering::Release);
                    done();
                    made
                };
                let thread = std::thread::Builder::new().name("drag".into()).spawn(make);
                thread.map_or(Readiness::Impossible, |thread| Readiness::Making(thread, is_done))
            }
            Readiness::Making(thread, is_done) if is_done.load(Ordering::Acquire) => match thread.join() {
                Ok(Some(drag)) => Readiness::Made(drag),
                Ok(None) | Err(_) => Readiness::Impossible,
            },
            Readiness::Made(mut drag) => {
                drag.prepare();
                Readiness::Made(drag)
            }
            other @ (Readiness::Making(..) | Readiness::Impossible) => other,
        };
        self.held = Some(Held { indices, drag, interim });
    }

    /// Draws a picture into a buffer from `room`.
    ///
    /// # Errors
    /// The backend cannot compile the formula or prepare it for the hits.
    pub(super) fn draw(
        &mut self,
        request: &RenderRequest,
        hits: &Arc<Hits>,
        numbers: &[f32],
        held: Option<Vec<usize>>,
        tell: &dyn Fn(Event),
        room: impl FnOnce() -> Vec<u32>,
    ) -> Result<Picture, EngineError> {
        self.compile(request, tell)?;
        let prepare_start = Instant::now();
        let (ready, is_new) = self.evaluator(request, hits, numbers)?;
        let mut framebuffer = self.framebuffer_for(request, hits);
        let frame_start = Instant::now();
        let before = match self.held.as_ref().map(|held| &held.indices) == held.as_ref() {
            true => None,
            false => {
                let taken = held.map(|indices| self.take_hold(&ready, hits, numbers, indices));
                std::mem::replace(&mut self.held, taken)
            }
        };
        let is_held = self.held.is_some();
        let (told, passes) = match self.draw_held(&ready, numbers, &mut framebuffer) {
            Some((method, passes)) => (Some(Some(method)), passes),
            None => {
                let is_known = self.linear.as_ref().is_some_and(|linear| linear.is_of(hits, numbers));
                if !is_known {
                    let made = self.linear_picture(&ready, hits, numbers, before.as_ref());
                    self.set_linear(request, made, tell);
                }
                (if is_known { None } else { Some(None) }, self.linear.as_ref().map_or_else(PassCount::default, |own| own.passes))
            }
        };
        let picture = self.present(request, hits, framebuffer, is_held, room);
        if is_new {
            let bytes_per_pixel = ready.bytes() as f64 / f64::from(hits.view.pixels());
            tell(Event::Ready { time: prepare_start.elapsed(), bytes_per_pixel });
        } else if let Some(method) = told {
            tell(Event::Frame { method, time: frame_start.elapsed(), passes });
        }
        Ok(Picture { passes, ..picture })
    }

    /// Whether the last picture can be improved: passes were traced since, or not all of them were evaluated.
    pub(super) fn can_refine(&self, request: &RenderRequest, TracedHits { hits, more, .. }: &TracedHits) -> bool {
        let (Some((of, ready)), Some(linear)) = (&self.ready, &self.linear) else { return false };
        if self.cannot_refine || self.held.is_some() || !Arc::ptr_eq(of, hits) || hits.view != request.subject.view {
            return false;
        }
        let evaluated = linear.sum.as_ref().map_or(0, |(_, passes)| *passes);
        evaluated < ready.passes().max(wanted_passes(request, more))
    }

    /// Adds a pass that was traced to the picture that was drawn last, and evaluates what was not evaluated for it.
    /// `None` once `hurries` is set.
    ///
    /// # Errors
    /// The backend cannot prepare the formula for the hits.
    pub(super) fn refine(
        &mut self,
        request: &RenderRequest,
        (hits, more): (&Arc<Hits>, &[Arc<Hits>]),
        numbers: &[f32],
        hurries: &AtomicBool,
        (tell, room): (&dyn Fn(Event), impl FnOnce() -> Vec<u32>),
    ) -> Result<Option<Picture>, EngineError> {
        let Some((of, mut ready)) = self.ready.take() else { return Ok(None) };
        let start = Instant::now();
        let own = ready.passes();
        if own < wanted_passes(request, more)
            && let Some(next) = more.get(own - 1)
        {
            match ready.with_pass(next) {
                Ok(with_pass) => ready = with_pass,
                Err(error) => {
                    self.cannot_refine = true;
                    self.ready = Some((of, ready));
                    return Err(error.into());
                }
            }
        }
        self.ready = Some((of, Arc::clone(&ready)));
        let Some(linear) = self.linear.as_mut().filter(|linear| linear.is_of(hits, numbers)) else { return Ok(None) };
        let (mut sum, first) = linear.sum.take().map_or((None, 0), |(sum, passes)| (Some(sum), passes));
        let (all, mut evaluated) = (ready.passes(), first);
        let evaluation = Instant::now();
        while evaluated < all {
            // From nothing, all at once, else pass by pass: the order of additions is the same.
            let passes = if sum.is_some() { evaluated..evaluated + 1 } else { 0..all };
            let Some(more) = ready.sum(passes.clone(), numbers, hurries) else { break };
            evaluated = passes.end;
            match &mut sum {
                Some(sum) => sum.add(&more),
                None => sum = Some(more),
            }
        }
        let is_done = evaluated == all;
        if is_done {
            // Fewer than 2³² passes.
            self.pass_time = evaluation.elapsed() / (all - first) as u32;
        }
        let numbers = linear.numbers.clone();
        let mean = sum.as_ref().filter(|_| is_done).map(|sum| mean(sum, evaluated));
        linear.sum = sum.map(|sum| (sum, evaluated));
        let Some(frame) = mean else { return Ok(None) };
        let passes = PassCount { evaluated, shown: evaluated };
        let sum = linear.sum.take();
        self.set_linear(request, LinearPicture::new(frame, hits, numbers, passes, sum), tell);
        let framebuffer = self.framebuffer_for(request, hits);
        let picture = self.present(request, hits, framebuffer, false, room);
        tell(Event::Frame { method: None, time: start.elapsed(), passes });
        Ok(Some(Picture { passes, ..picture }))
    }

    /// How many passes are evaluated for a picture that must come soon: a power of two.
    fn soon(&self, ready: &Arc<dyn Evaluator>) -> usize {
        let all = ready.passes();
        let fitting = FRAME_TIME.as_secs_f64() / self.pass_time.as_secs_f64().max(1e-6);
        let fitting = (fitting as usize).clamp(1, all);
        if fitting == all { all } else { 1 << fitting.ilog2() }
    }

    /// What a drag of several passes begins with, and the numbers of that picture.
    fn beginning(&self, ready: &Arc<dyn Evaluator>, hits: &Arc<Hits>) -> Option<(DragBeginning, &[f32])> {
        let linear = self.linear.as_ref().filter(|linear| Arc::ptr_eq(&linear.hits, hits) && ready.passes() > 1)?;
        Some((DragBeginning { picture: Arc::clone(&linear.frame), passes: self.soon(ready) }, &linear.numbers))
    }

    /// Takes a slider. Where there are several passes, few of them are evaluated until the drag is made.
    fn take_hold(&self, ready: &Arc<dyn Evaluator>, hits: &Arc<Hits>, numbers: &[f32], indices: Vec<usize>) -> Held {
        let interim = (ready.passes() > 1).then(|| {
            let (beginning, before) = self.beginning(ready, hits).unzip();
            let (pixels, before) = (hits.view.pixels() as usize, before.unwrap_or(numbers));
            WholeFrames::new(Arc::clone(ready), pixels, before, beginning.as_ref())
        });
        Held { indices, drag: Readiness::First(numbers.to_vec()), interim }
    }

    /// Draws a picture of a held slider. `None` if none is held.
    fn draw_held(
        &mut self,
        ready: &Arc<dyn Evaluator>,
        numbers: &[f32],
        framebuffer: &mut Framebuffer,
    ) -> Option<(Method, PassCount)> {
        let all = ready.passes();
        let soon = self.soon(ready);
        let some = |evaluated: usize| PassCount { evaluated, shown: all };
        Some(match self.held.as_mut()? {
            Held { drag: Readiness::Made(drag), .. } => {
                drag.frame(numbers, framebuffer);
                (drag.method(), some(if drag.is_of_all_passes() { all } else { soon }))
            }
            Held { interim: Some(interim), .. } => {
                interim.frame(numbers, framebuffer);
                (Method::General, some(soon))
            }
            Held { interim: None, .. } => {
                ready.draw(numbers, framebuffer);
                (Method::General, some(all))
            }
        })
    }

    /// The linear picture of these numbers, quickly. `before` is the slider that was held until now.
    fn linear_picture(
        &mut self,
        ready: &Arc<dyn Evaluator>,
        hits: &Arc<Hits>,
        numbers: &[f32],
        before: Option<&Held>,
    ) -> LinearPicture {
        let all = ready.passes();
        let last = self.linear.take().filter(|linear| Arc::ptr_eq(&linear.hits, hits));
        let soon = self.soon(ready);
        let part = |numbers: &[f32]| {
            let sum = ready.sum(0..soon, numbers, &AtomicBool::new(false));
            sum.unwrap_or_else(|| Frame::black(hits.view.width(), hits.view.height()))
        };
        if let Some(Held { drag: Readiness::Made(drag), .. }) = before
            && all > 1
            && let Some(frame) = drag.linear(numbers)
        {
            return LinearPicture::new(frame, hits, numbers.to_vec(), PassCount { evaluated: all, shown: all }, None);
        }
        match last {
            // What the numbers change in few passes changes the picture of all passes.
            Some(last) if soon < all => {
                let mut frame = mean(&part(numbers), soon);
                frame.add(&last.frame.rest_beside(&mean(&part(&last.numbers), soon)));
                let passes = PassCount { evaluated: soon, shown: last.passes.shown };
                LinearPicture::new(frame, hits, numbers.to_vec(), passes, None)
            }
            Some(_) | None => {
                let start = Instant::now();
                let sum = part(numbers);
                // Fewer than 2³² passes.
                self.pass_time = start.elapsed() / soon as u32;
                let (frame, passes) = (mean(&sum, soon), PassCount { evaluated: soon, shown: soon });
                LinearPicture::new(frame, hits, numbers.to_vec(), passes, Some((sum, soon)))
            }
        }
    }

    /// Keeps a linear picture as the last one, and tells how many pixels of it are undefined.
    fn set_linear(&mut self, request: &RenderRequest, made: LinearPicture, tell: &dyn Fn(Event)) {
        let undefined = made.undefined;
        let is_news =
            self.linear.as_ref().is_none_or(|last| last.undefined != undefined || !last.is_of(&made.hits, &made.numbers));
        if is_news {
            let [width, height] = [made.frame.width, made.frame.height];
            let view = &request.subject.view;
            // A pixel of a coarse picture stands for several.
            let full = |at: usize, side: u32, full: u32| (at as u64 * u64::from(full) / u64::from(side)) as u32;
            let place = |index: usize| {
                let (x, y) = (index % width as usize, index / width as usize);
                [full(x, width, view.width()), full(y, height, view.height())]
            };
            tell(Event::Undefined(undefined, made.first_undefined.map(place)));
        }
        self.linear = Some(made);
    }

    /// The picture in a framebuffer, in a buffer from `room`. That of a slider that is not held is the last linear
    /// picture.
    fn present(
        &mut self,
        request: &RenderRequest,
        hits: &Hits,
        mut framebuffer: Framebuffer,
        is_held: bool,
        room: impl FnOnce() -> Vec<u32>,
    ) -> Picture {
        let full = [hits.view.width(), hits.view.height()];
        let (mut linear, mut nan) = (None, NanMask::default());
        if let Some(last) = self.linear.as_ref().filter(|_| !is_held) {
            framebuffer.set(&last.frame);
            nan = last.nan.clone();
            let summary = last.summary;
            self.unreviewed = Some(summary.or_else(|| PictureSummary::if_remarkable(&last.frame, &request.transform)));
            linear = Some(Arc::clone(&last.frame));
        }
        let mut pixels = room();
        let smaller = self.shown.filter(|shown| is_held && (0..2).all(|axis| (1..full[axis]).contains(&shown[axis])));
        match smaller {
            Some(shown) => scale(&framebuffer.pixels, full, shown, &mut pixels),
            None => copy(&framebuffer.pixels, &mut pixels),
        }
        let [width, height] = smaller.unwrap_or(full);
        self.framebuffer = Some(framebuffer);
        let view = &request.subject.view;
        let full_size = [view.width(), view.height()];
        Picture { width, height, pixels, full_size, linear, nan, ..Picture::default() }
    }

    /// What is remarkable about the picture that was drawn last, if it was evaluated at rest in full size.
    pub(super) fn review(&mut self, request: &RenderRequest, hits: &Hits, numbers: &[f32]) -> Option<Option<PictureFinding>> {
        let summary = self.unreviewed.take()?;
        let Subject { formula, world, view } = &request.subject;
        // Fewer than 2³² passes.
        let passes = self.linear.as_ref().map_or(1, |last| last.passes.shown as u32);
        let picture = ReviewedPicture { formula, world, view, passes, numbers, transform: request.transform };
        Some(summary.filter(|_| hits.view == *view).and_then(|summary| review(&picture, &summary)))
    }

    /// Compiles the formula, unless it was the last one.
    fn compile(
        &mut self,
        RenderRequest { subject, engine, .. }: &RenderRequest,
        tell: &dyn Fn(Event),
    ) -> Result<(), EngineError> {
        let backend = engine.backend().name();
        if !self.compiled.as_ref().is_some_and(|(formula, of)| Arc::ptr_eq(formula, &subject.formula) && *of == backend) {
            let start = Instant::now();
            engine.compile(subject)?;
            tell(Event::Compiled(start.elapsed()));
            self.compiled = Some((Arc::clone(&subject.formula), backend));
            self.held = None;
            self.ready = None;
            self.linear = None;
        }
        Ok(())
    }

    /// The evaluator of these hits, and whether it is new. The next picture is that of these numbers.
    fn evaluator(
        &mut self,
        request: &RenderRequest,
        hits: &Arc<Hits>,
        numbers: &[f32],
    ) -> Result<(Arc<dyn Evaluator>, bool), EngineError> {
        // Of fewer passes than before there is another evaluator.
        if let Some((of, ready)) = &self.ready
            && Arc::ptr_eq(of, hits)
            && ready.passes() <= request.samples as usize
        {
            return Ok((Arc::clone(ready), false));
        }
        // Freed before another one is made.
        self.held = None;
        self.ready = None;
        self.linear = None;
        self.cannot_refine = false;
        let made = request.engine.prepare(&request.subject, hits, numbers)?;
        self.ready = Some((Arc::clone(hits), Arc::clone(&made)));
        Ok((made, true))
    }

    /// The framebuffer for pictures of these hits. A drag goes on only in its own framebuffer.
    fn framebuffer_for(&mut self, request: &RenderRequest, hits: &Arc<Hits>) -> Framebuffer {
        let (width, height, transform) = (hits.view.width(), hits.view.height(), request.transform);
        match self.framebuffer.take() {
            Some(kept) if (kept.width, kept.height, kept.view()) == (width, height, transform) => kept,
            Some(_) | None => {
                self.held = None;
                Framebuffer::black(width, height, transform)
            }
        }
    }
}

/// Plans and compiles a drag. With several passes, it begins with a picture of these numbers. `None` if that is not
/// possible: other numbers have changed too, or the backend has no drags.
fn begin_drag(
    ready: &Arc<dyn Evaluator>,
    indices: &[usize],
    numbers: &[f32],
    beginning: Option<(DragBeginning, Vec<f32>)>,
) -> Option<Box<dyn Drag>> {
    let Some((beginning, before)) = beginning else {
        return if ready.passes() > 1 { None } else { Arc::clone(ready).drag(indices, numbers, DRAG_BYTES, None).ok() };
    };
    let changed = |(index, (one, other)): (usize, (&f32, &f32))| one.to_bits() != other.to_bits() && !indices.contains(&index);
    if before.len() != numbers.len() || before.iter().zip(numbers).enumerate().any(changed) {
        return None;
    }
    Arc::clone(ready).drag(indices, &before, DRAG_BYTES, Some(&beginning)).ok()
}

/// How many passes there will be of those that were traced, the first one included.
fn wanted_passes(request: &RenderRequest, more: &[Arc<Hits>]) -> usize {
    (more.len() + 1).min(request.samples as usize)
}

/// The mean of a sum of passes.
fn mean(sum: &Frame, passes: usize) -> Frame {
    let mut frame = sum.clone();
    if passes > 1 {
        frame.scale(1.0 / passes as f32);
    }
    frame
}

/// Copies pixels, on all threads of the current pool. Copying a large picture can take longer than drawing a frame of
/// a drag.
fn copy(from: &[u32], to: &mut Vec<u32>) {
    const PART: usize = 1 << 16;
    to.resize(from.len(), 0);
    to.par_chunks_mut(PART).zip(from.par_chunks(PART)).for_each(|(to, from)| to.copy_from_slice(from));
}
