//! Draws the pictures of the evaluation thread. Evaluators are used again, and a held slider is drawn as a drag.

use crate::engine::{EngineError, Subject};
use crate::evaluate::review::{PictureFinding, PictureSummary, ReviewedPicture, review};
use crate::evaluate::{Drag, Evaluator, Framebuffer};
use crate::formula::Formula;
use crate::picture::Frame;
use crate::plan::Method;
use crate::preview::renderer::{Event, NanMask, Picture, RenderRequest};
use crate::preview::resampling::scale;
use crate::trace::Hits;
use rayon::prelude::*;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use std::time::Instant;

/// What a held slider may keep, in bytes.
const DRAG_BYTES: usize = 1 << 30;

/// A slider that is held.
struct Held {
    indices: Vec<usize>,
    drag: Readiness,
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
}

/// The linear colours of a picture, with NaN as 0.
struct LinearPicture {
    frame: Arc<Frame>,
    nan: NanMask,
    /// The summary of a picture with NaN. Only the evaluation sees them.
    summary: Option<PictureSummary>,
    hits: Arc<Hits>,
    numbers: Vec<f32>,
}

impl LinearPicture {
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
        let (Some(Held { indices, drag }), Some((_, ready))) = (&mut self.held, &self.ready) else { return };
        *drag = match std::mem::replace(drag, Readiness::Impossible) {
            Readiness::First(numbers) => {
                let (ready, indices) = (Arc::clone(ready), indices.clone());
                let is_done = Arc::new(AtomicBool::new(false));
                let told = Arc::clone(&is_done);
                let make = move || {
                    let made = ready.drag(&indices, &numbers, DRAG_BYTES).ok();
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
        let [width, height] = [hits.view.width(), hits.view.height()];
        let mut framebuffer = self.framebuffer_for(request, hits);
        let frame_start = Instant::now();
        if self.held.as_ref().map(|held| &held.indices) != held.as_ref() {
            self.held = held.map(|indices| Held { indices, drag: Readiness::First(numbers.to_vec()) });
        }
        let mut told = None;
        let (mut linear, mut nan) = (None, NanMask::default());
        match &mut self.held {
            Some(Held { drag: Readiness::Made(drag), .. }) => {
                drag.frame(numbers, &mut framebuffer);
                told = Some(Some(drag.method()));
            }
            Some(_) => {
                ready.draw(numbers, &mut framebuffer);
                told = Some(Some(Method::General));
            }
            None => {
                let (frame, mask, summary, undefined) = match self.linear.take().filter(|linear| linear.is_of(hits, numbers)) {
                    Some(linear) => (linear.frame, linear.nan, linear.summary, None),
                    None => {
                        told = Some(None);
                        let mut frame = ready.frame(numbers);
                        let is_undefined = |pixel: &[f32; 3]| pixel.iter().any(|component| component.is_nan());
                        let first = frame.linear.iter().position(is_undefined);
                        let summary = first.map(|_| PictureSummary::of(&frame));
                        // Most pictures have none, and are read once.
                        let mask = first.map(|_| NanMask::of(&frame)).unwrap_or_default();
                        let undefined = if first.is_some() { frame.clean() } else { 0 };
                        (Arc::new(frame), mask, summary, Some((undefined, first)))
                    }
                };
                framebuffer.set(&frame);
                nan = mask.clone();
                self.unreviewed = Some(summary.or_else(|| PictureSummary::if_remarkable(&frame, &request.transform)));
                let (frame_kept, hits, numbers) = (Arc::clone(&frame), Arc::clone(hits), numbers.to_vec());
                self.linear = Some(LinearPicture { frame: frame_kept, nan: mask, summary, hits, numbers });
                linear = Some(frame);
                if let Some((undefined, first)) = undefined {
                    let view = &request.subject.view;
                    // A pixel of a coarse picture stands for several.
                    let full = |at: usize, side: u32, full: u32| (at as u64 * u64::from(full) / u64::from(side)) as u32;
                    let place = |index: usize| {
                        let (x, y) = (index % width as usize, index / width as usize);
                        [full(x, width, view.width()), full(y, height, view.height())]
                    };
                    tell(Event::Undefined(undefined, first.map(place)));
                }
            }
        }
        let mut pixels = room();
        let full = [width, height];
        let is_held = matches!(told, Some(Some(_)));
        let smaller = self.shown.filter(|shown| is_held && (0..2).all(|axis| (1..full[axis]).contains(&shown[axis])));
        match smaller {
            Some(shown) => scale(&framebuffer.pixels, full, shown, &mut pixels),
            None => copy(&framebuffer.pixels, &mut pixels),
        }
        let [width, height] = smaller.unwrap_or(full);
        self.framebuffer = Some(framebuffer);
        if is_new {
            let bytes_per_pixel = ready.bytes() as f64 / f64::from(full[0] * full[1]);
            tell(Event::Ready { time: prepare_start.elapsed(), bytes_per_pixel });
        } else if let Some(method) = told {
            tell(Event::Frame { method, time: frame_start.elapsed() });
        }
        let view = &request.subject.view;
        let full_size = [view.width(), view.height()];
        Ok(Picture { width, height, pixels, version: 0, values: 0, full_size, linear, nan })
    }

    /// What is remarkable about the picture that was drawn last, if it was evaluated at rest in full size.
    pub(super) fn review(&mut self, request: &RenderRequest, hits: &Hits, numbers: &[f32]) -> Option<Option<PictureFinding>> {
        let summary = self.unreviewed.take()?;
        let Subject { formula, world, view } = &request.subject;
        let picture = ReviewedPicture { formula, world, view, passes: 1, numbers, transform: request.transform };
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
        RenderRequest { subject, engine, .. }: &RenderRequest,
        hits: &Arc<Hits>,
        numbers: &[f32],
    ) -> Result<(Arc<dyn Evaluator>, bool), EngineError> {
        if let Some((of, ready)) = &self.ready
            && Arc::ptr_eq(of, hits)
        {
            return Ok((Arc::clone(ready), false));
        }
        // Freed before another one is made.
        self.held = None;
        self.ready = None;
        self.linear = None;
        let made = engine.prepare(subject, hits, numbers)?;
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

/// Copies pixels, on all threads of the current pool. Copying a large picture can take longer than drawing a frame of
/// a drag.
fn copy(from: &[u32], to: &mut Vec<u32>) {
    const PART: usize = 1 << 16;
    to.resize(from.len(), 0);
    to.par_chunks_mut(PART).zip(from.par_chunks(PART)).for_each(|(to, from)| to.copy_from_slice(from));
}
