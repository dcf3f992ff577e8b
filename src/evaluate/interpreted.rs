//! Frames by the reference interpreter.

use crate::bytecode::program::{Instantiation, MAX_PROGRAM_BYTES};
use crate::bytecode::{Code, CodeTooLarge, Programs};
use crate::evaluate::frame::Frame;
use crate::formula::Formula;
use crate::formula::layout::Layout;
use crate::lang::scalars::Floats;
use crate::scene::Scene;
use crate::trace::{Optics, View, ray_tree};
use rayon::prelude::*;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// How many pixels a thread takes at a time.
const PIXELS: usize = 512;
/// How many bytes of programs are written before they are run. Programs of all pixels would take gigabytes on deep scenes.
const BATCH_BYTES: usize = 1 << 20;

/// A formula's bytecode on a scene.
pub struct Interpreted {
    formula: Arc<Formula>,
    scene: Arc<Scene>,
    view: View,
    code: Code,
    layout: Layout,
}

/// What a frame by the interpreter took.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Timing {
    /// Running the programs, not writing them, added up over threads.
    pub evaluation: Duration,
    /// The bytes of all programs.
    pub bytes: u64,
}

impl Interpreted {
    /// Writes a formula's bytecode.
    ///
    /// # Errors
    /// It would be too large.
    pub fn new(formula: &Arc<Formula>, scene: &Arc<Scene>, view: View) -> Result<Self, CodeTooLarge> {
        let code = Code::new(formula)?;
        let layout = Layout::new(formula, scene.bodies.len(), scene.lights.len());
        if (Instantiation { formula, code: &code, layout, scene }).largest(view.depth()) > MAX_PROGRAM_BYTES {
            return Err(CodeTooLarge);
        }
        Ok(Self { formula: Arc::clone(formula), scene: Arc::clone(scene), view, code, layout })
    }

    fn instantiation(&self) -> Instantiation<'_> {
        Instantiation { formula: &self.formula, code: &self.code, layout: self.layout, scene: &self.scene }
    }

    /// The program of a pixel, counted row by row from the top left.
    pub fn program(&self, pixel: u32) -> Programs {
        let mut programs = Programs::new();
        programs.add(&self.instantiation(), &ray_tree(&Optics::new(&self.scene, &self.view), pixel));
        programs
    }

    /// The picture that these parameter numbers give, see [`Evaluator::frame`](super::Evaluator::frame), and what it took.
    pub fn frame(&self, memory: &[f32]) -> (Frame, Timing) {
        assert!(memory.len() >= self.layout.len(), "as many parameter numbers as the formula and the scene have");
        let mut frame = Frame::black(self.view.width(), self.view.height());
        let chunks = frame.linear.par_chunks_mut(PIXELS).enumerate();
        let timings = chunks.map(|(chunk, pixels)| self.chunk((chunk * PIXELS) as u32, pixels, memory));
        let timing = timings.reduce(Timing::default, |one, other| Timing {
            evaluation: one.evaluation + other.evaluation,
            bytes: one.bytes + other.bytes,
        });
        (frame, timing)
    }

    /// Writes and runs the programs of consecutive pixels, some at a time.
    fn chunk(&self, first: u32, pixels: &mut [[f32; 3]], memory: &[f32]) -> Timing {
        let optics = Optics::new(&self.scene, &self.view);
        let instantiation = self.instantiation();
        let mut programs = Programs::new();
        let mut timing = Timing::default();
        let mut done = 0;
        while done < pixels.len() {
            programs.clear();
            while done + programs.len() < pixels.len() && programs.bytes() < BATCH_BYTES {
                let pixel = first + (done + programs.len()) as u32;
                programs.add(&instantiation, &ray_tree(&optics, pixel));
            }
            let mut stack = programs.stack();
            let start = Instant::now();
            for (index, pixel) in pixels[done..done + programs.len()].iter_mut().enumerate() {
                *pixel = programs.run(&mut Floats, index, memory, &mut stack);
            }
            timing.evaluation += start.elapsed();
            timing.bytes += programs.bytes() as u64;
            done += programs.len();
        }
        timing
    }
}
