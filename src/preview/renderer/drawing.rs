//! The drawing of one picture: what is ready is used again, a held slider is a drag.

use crate::evaluate::{Backend, Compiled, Drag, Framebuffer, Interpreted, Method};
use crate::formula::Formula;
use crate::jit::{CompiledFormula, KernelCache};
use crate::picture::{Transfer, quantise};
use crate::preview::renderer::{Event, Picture, Subject};
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
    places: Vec<usize>,
    drag: Readiness,
}

/// What pictures of a held slider are made with.
enum Readiness {
    /// Nothing yet. These are the numbers of its first picture.
    First(Vec<f32>),
    /// Kernels are compiled beside the pictures, which are drawn in full meanwhile; nothing comes of it where they cannot be. The flag is set when
    /// that is done, and the thread is about to end.
    Making(JoinHandle<Option<Drag>>, Arc<AtomicBool>),
    Made(Box<Drag>),
    /// There are no kernels for it, and every picture is drawn in full.
    Impossible,
}

/// Draws pictures.
#[derive(Default)]
pub(super) struct Artist {
    kernels: KernelCache,
    /// The formula that was compiled last.
    compiled: Option<(Arc<Formula>, Arc<CompiledFormula>)>,
    /// What is ready, and of which hits.
    ready: Option<(Arc<Hits>, Arc<Compiled>)>,
    interpreted: Option<(Arc<Formula>, Arc<Hits>, Interpreted)>,
    /// The slider that is held.
    held: Option<Held>,
    framebuffer: Option<Framebuffer>,
}

impl Artist {
    /// Whether a held slider needs more than there is.
    pub(super) fn has_more_to_prepare(&self) -> bool {
        match self.held.as_ref().map(|held| &held.drag) {
            Some(Readiness::First(_)) => self.ready.is_some(),
            Some(Readiness::Making(_, is_done)) => is_done.load(Ordering::Acquire),
            Some(Readiness::Made(drag)) => !drag.is_ready(),
            Some(Readiness::Impossible) | None => false,
        }
    }

    /// Makes some of it. What takes longer is made by another thread, which calls `done` at its end.
    pub(super) fn prepare(&mut self, done: impl FnOnce() + Send + 'static) {
        let (Some(Held { places, drag }), Some((_, ready))) = (&mut self.held, &self.ready) else { return };
        *drag = match std::mem::replace(drag, Readiness::Impossible) {
            Readiness::First(numbers) => {
                let (ready, places) = (Arc::clone(ready), places.clone());
                let is_done = Arc::new(AtomicBool::new(false));
                let told = Arc::clone(&is_done);
                let make = move || {
                    let made = Drag::new(&ready, &places, &numbers, DRAG_BYTES).ok();
                    told.store(true, Ordering::Release);
                    done();
                    made
                };
                let thread = std::thread::Builder::new().name("drag".into()).spawn(make);
                thread.map_or(Readiness::Impossible, |thread| Readiness::Making(thread, is_done))
            }
            Readiness::Making(thread, is_done) if is_done.load(Ordering::Acquire) => match thread.join() {
                Ok(Some(drag)) => Readiness::Made(Box::new(drag)),
                Ok(None) | Err(_) => Readiness::Impossible,
            },
            Readiness::Made(mut drag) => {
                drag.prepare();
                Readiness::Made(drag)
            }
            other @ (Readiness::Making(..) | Readiness::Impossible) => other,
        };
    }

    /// How many pixels of a picture that was drawn by compiled code hold what is no number: its words do not tell.
    pub(super) fn undefined(&self, hits: &Arc<Hits>, numbers: &[f32]) -> usize {
        match &self.ready {
            Some((of, ready)) if Arc::ptr_eq(of, hits) => ready.frame(numbers).clean(),
            Some(_) | None => 0,
        }
    }

    /// Draws a picture, into some room.
    ///
    /// # Errors
    /// The backend cannot take the formula.
    pub(super) fn draw(
        &mut self,
        subject: &Subject,
        hits: &Arc<Hits>,
        numbers: &[f32],
        held: Option<Vec<usize>>,
        tell: &dyn Fn(Event),
        room: impl FnOnce() -> Vec<u32>,
    ) -> Result<Picture, String> {
        let size = [hits.view.width(), hits.view.height()];
        let mut pixels = room();
        match subject.backend {
            Backend::Interpreter => {
                self.forget_compiled();
                self.interpret(subject, hits, numbers, held.is_some(), tell, &mut pixels)?;
            }
            Backend::Jit => {
                self.interpreted = None;
                self.evaluate(subject, hits, numbers, held, tell, &mut pixels)?;
            }
        }
        let full_size = [subject.view.width(), subject.view.height()];
        Ok(Picture { width: size[0], height: size[1], pixels, version: 0, values: 0, full_size })
    }

    fn forget_compiled(&mut self) {
        self.held = None;
        self.ready = None;
    }

    fn interpret(
        &mut self,
        subject: &Subject,
        hits: &Arc<Hits>,
        numbers: &[f32],
        is_held: bool,
        tell: &dyn Fn(Event),
        pixels: &mut Vec<u32>,
    ) -> Result<(), String> {
        let known = self.interpreted.as_ref();
        if !known.is_some_and(|(formula, of, _)| Arc::ptr_eq(formula, &subject.formula) && Arc::ptr_eq(of, hits)) {
            let made = Interpreted::new(&subject.formula, &subject.scene, hits.view).map_err(|error| error.to_string())?;
            self.interpreted = Some((Arc::clone(&subject.formula), Arc::clone(hits), made));
        }
        if let Some((.., interpreted)) = &self.interpreted {
            let start = Instant::now();
            let (mut frame, _) = interpreted.frame(numbers);
            words(&frame.linear, subject.transfer, pixels);
            tell(Event::Frame { method: None, time: start.elapsed() });
            if !is_held {
                tell(Event::Undefined(frame.clean()));
            }
        }
        Ok(())
    }

    fn evaluate(
        &mut self,
        subject: &Subject,
        hits: &Arc<Hits>,
        numbers: &[f32],
        held: Option<Vec<usize>>,
        tell: &dyn Fn(Event),
        pixels: &mut Vec<u32>,
    ) -> Result<(), String> {
        let start = Instant::now();
        let formula = match &self.compiled {
            Some((formula, compiled)) if Arc::ptr_eq(formula, &subject.formula) => Arc::clone(compiled),
            Some(_) | None => {
                let compiled = self.kernels.compiled(&subject.formula).map_err(|error| error.to_string())?;
                tell(Event::Compiled(start.elapsed()));
                self.compiled = Some((Arc::clone(&subject.formula), Arc::clone(&compiled)));
                self.forget_compiled();
                compiled
            }
        };
        let start = Instant::now();
        let (ready, is_new) = match &self.ready {
            Some((of, ready)) if Arc::ptr_eq(of, hits) => (Arc::clone(ready), false),
            Some(_) | None => {
                self.forget_compiled();
                let made = Compiled::new(formula, &subject.formula, &subject.scene, hits).map_err(|error| error.to_string())?;
                let made = Arc::new(made);
                self.ready = Some((Arc::clone(hits), Arc::clone(&made)));
                (made, true)
            }
        };
        let [width, height] = [hits.view.width(), hits.view.height()];
        let fits = |framebuffer: &Framebuffer| {
            (framebuffer.width, framebuffer.height, framebuffer.transfer) == (width, height, subject.transfer)
        };
        let mut framebuffer = match self.framebuffer.take() {
            Some(framebuffer) if fits(&framebuffer) => framebuffer,
            Some(_) | None => {
                // A drag goes on in its own framebuffer alone.
                self.held = None;
                Framebuffer::black(width, height, subject.transfer)
            }
        };
        let frame_start = Instant::now();
        if self.held.as_ref().map(|held| &held.places) != held.as_ref() {
            self.held = held.map(|places| Held { places, drag: Readiness::First(numbers.to_vec()) });
        }
        let method = match &mut self.held {
            Some(Held { drag: Readiness::Made(drag), .. }) => {
                drag.frame(numbers, &mut framebuffer);
                Some(drag.method())
            }
            other => {
                ready.draw(numbers, &mut framebuffer);
                other.is_some().then_some(Method::General)
            }
        };
        copy(&framebuffer.pixels, pixels);
        self.framebuffer = Some(framebuffer);
        if is_new {
            let bytes_per_pixel = ready.bytes() as f64 / f64::from(width * height);
            tell(Event::Ready { time: start.elapsed(), bytes_per_pixel });
        } else {
            tell(Event::Frame { method, time: frame_start.elapsed() });
        }
        Ok(())
    }
}

/// Copies pixels, on all threads of the current pool: of a large picture that takes longer than drawing what a slider changes.
fn copy(from: &[u32], to: &mut Vec<u32>) {
    const PART: usize = 1 << 16;
    to.resize(from.len(), 0);
    to.par_chunks_mut(PART).zip(from.par_chunks(PART)).for_each(|(to, from)| to.copy_from_slice(from));
}

/// Linear colours as words `0x00RRGGBB`.
fn words(linear: &[[f32; 3]], transfer: Transfer, pixels: &mut Vec<u32>) {
    let bytes = quantise(linear, transfer);
    let word = |[red, green, blue]: &[u8; 3]| u32::from_be_bytes([0, *red, *green, *blue]);
    pixels.clear();
    pixels.extend(bytes.as_chunks::<3>().0.iter().map(word));
}
