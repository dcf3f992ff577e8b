//! Frames by the reference interpreter.

use crate::bytecode::program::Instantiation;
use crate::bytecode::{Code, CodeTooLarge, Programs};
use crate::evaluate::frame::Frame;
use crate::formula::Formula;
use crate::formula::layout::Layout;
use crate::lang::scalars::{Floats, Scalars};
use crate::scene::Scene;
use crate::trace::{Optics, View, ray_tree};
use rayon::prelude::*;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// How many pixels have their programs written at a time. Programs of all pixels would take gigabytes on deep scenes.
const PIXELS: usize = 512;

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
        Ok(Self { formula: Arc::clone(formula), scene: Arc::clone(scene), view, code, layout })
    }

    /// The programs of some pixels.
    pub fn programs(&self, pixels: std::ops::Range<u32>) -> Programs {
        let optics = Optics::new(&self.scene, &self.view);
        let instantiation = Instantiation { formula: &self.formula, code: &self.code, layout: self.layout, scene: &self.scene };
        let mut programs = Programs::new();
        for pixel in pixels {
            programs.add(&instantiation, &ray_tree(&optics, pixel));
        }
        programs
    }

    /// The picture that these parameter numbers give, see [`Evaluator::frame`](super::Evaluator::frame), and what it took.
    pub fn frame(&self, memory: &[f32]) -> (Frame, Timing) {
        self.frame_in(memory, || Floats)
    }

    /// The same with the operations taken in another sense, made anew for each part of the picture.
    pub fn frame_in<M: Scalars<Value = f32>>(&self, memory: &[f32], scalars: impl Fn() -> M + Sync) -> (Frame, Timing) {
        assert!(memory.len() >= self.layout.len(), "as many parameter numbers as the formula and the scene have");
        let mut frame = Frame::black(self.view.width(), self.view.height());
        let timing = frame
            .linear
            .par_chunks_mut(PIXELS)
            .enumerate()
            .map(|(chunk, pixels)| {
                let first = (chunk * PIXELS) as u32;
                let programs = self.programs(first..first + pixels.len() as u32);
                let mut stack = programs.stack();
                let mut scalars = scalars();
                let start = Instant::now();
                for (index, pixel) in pixels.iter_mut().enumerate() {
                    *pixel = programs.run(&mut scalars, index, memory, &mut stack);
                }
                Timing { evaluation: start.elapsed(), bytes: programs.bytes() as u64 }
            })
            .reduce(Timing::default, |one, other| Timing {
                evaluation: one.evaluation + other.evaluation,
                bytes: one.bytes + other.bytes,
            });
        (frame, timing)
    }
}
