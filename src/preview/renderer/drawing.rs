//! Draws the pictures of the evaluation thread. Evaluators are used again, and a held slider is drawn as a drag.

use crate::engine::EngineError;
use crate::evaluate::{Drag, Evaluator, Framebuffer};
use crate::formula::Formula;
use crate::plan::Method;
use crate::preview::renderer::{Event, Picture, RenderRequest};
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

    /// How many pixels of a picture are NaN. Bytes do not show that.
    pub(super) fn undefined(&self, hits: &Arc<Hits>, numbers: &[f32]) -> usize {
        match &self.ready {
            Some((of, ready)) if Arc::ptr_eq(of, hits) => ready.frame(numbers).clean(),
            Some(_) | None => 0,
        }
    }

    /// Draws a picture into a buffer from `room`. Returns it with the number of its pixels that hold NaN, if that is
    /// known.
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
    ) -> Result<(Picture, Option<usize>), EngineError> {
        self.compile(request, tell)?;
        let prepare_start = Instant::now();
        let (ready, is_new) = self.evaluator(request, hits)?;
        let [width, height] = [hits.view.width(), hits.view.height()];
        let mut framebuffer = self.framebuffer_for(request, hits);
        let frame_start = Instant::now();
        if self.held.as_ref().map(|held| &held.indices) != held.as_ref() {
            self.held = held.map(|indices| Held { indices, drag: Readiness::First(numbers.to_vec()) });
        }
        let (method, undefined) = match &mut self.held {
            Some(Held { drag: Readiness::Made(drag), .. }) => {
                drag.frame(numbers, &mut framebuffer);
                (Some(drag.method()), None)
            }
            other => (other.is_some().then_some(Method::General), ready.draw(numbers, &mut framebuffer).undefined),
        };
        let mut pixels = room();
        copy(&framebuffer.pixels, &mut pixels);
        self.framebuffer = Some(framebuffer);
        if is_new {
            let bytes_per_pixel = ready.bytes() as f64 / f64::from(width * height);
            tell(Event::Ready { time: prepare_start.elapsed(), bytes_per_pixel });
        } else {
            tell(Event::Frame { method, time: frame_start.elapsed() });
        }
        let view = &request.subject.view;
        let picture = Picture { width, height, pixels, version: 0, values: 0, full_size: [view.width(), view.height()] };
        Ok((picture, undefined))
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
            engine.compile(&subject.formula)?;
            tell(Event::Compiled(start.elapsed()));
            self.compiled = Some((Arc::clone(&subject.formula), backend));
            self.held = None;
            self.ready = None;
        }
        Ok(())
    }

    /// The evaluator of these hits, and whether it is new.
    fn evaluator(
        &mut self,
        RenderRequest { subject, engine, .. }: &RenderRequest,
        hits: &Arc<Hits>,
    ) -> Result<(Arc<dyn Evaluator>, bool), EngineError> {
        if let Some((of, ready)) = &self.ready
            && Arc::ptr_eq(of, hits)
        {
            return Ok((Arc::clone(ready), false));
        }
        // Freed before another one is made.
        self.held = None;
        self.ready = None;
        let made = engine.prepare(subject, hits)?;
        self.ready = Some((Arc::clone(hits), Arc::clone(&made)));
        Ok((made, true))
    }

    /// The framebuffer for pictures of these hits. A drag goes on only in its own framebuffer.
    fn framebuffer_for(&mut self, request: &RenderRequest, hits: &Arc<Hits>) -> Framebuffer {
        let (width, height, transfer) = (hits.view.width(), hits.view.height(), request.transfer);
        match self.framebuffer.take() {
            Some(kept) if (kept.width, kept.height, kept.transfer) == (width, height, transfer) => kept,
            Some(_) | None => {
                self.held = None;
                Framebuffer::black(width, height, transfer)
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
