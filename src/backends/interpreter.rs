//! Evaluation by the reference interpreter.

use crate::bytecode::program::{Instantiation, MAX_PROGRAM_BYTES, largest_tree};
use crate::bytecode::{CodeTooLarge, FormulaCode, Programs};
use crate::evaluate::{
    Backend, Drag, DragBeginning, Drawn, EvaluateError, Evaluator, Footprint, Framebuffer, WholeFrames, equation_in,
    evaluated_formula,
};
use crate::formula::Formula;
use crate::formula::equation::Equation;
use crate::lang::scalars::Floats;
use crate::lang::variables::EvaluatedLights;
use crate::picture::Frame;
use crate::trace::{Hits, Mismatch, NodeLight, RayNode, Tracer, View, ray_tree};
use crate::world::World;
use rayon::prelude::*;
use std::ops::Range;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// The name of the backend.
pub const NAME: &str = "interpreter";

/// A thread takes this many pixels at a time.
const PIXELS: usize = 512;
/// Programs are written in batches of about this many bytes and then run. The programs of all pixels would take
/// gigabytes in scenes with many reflections.
const BATCH_BYTES: usize = 1 << 20;

/// The backend.
pub struct Interpreter;

impl Backend for Interpreter {
    fn name(&self) -> &'static str {
        NAME
    }

    /// The interpreter traces each pixel itself.
    fn reads_hits(&self) -> bool {
        false
    }

    fn compile(&self, formula: &Arc<Formula>, world: &World) -> Result<Footprint, EvaluateError> {
        FormulaCode::new(&evaluated_formula(formula, world))?;
        Ok(Footprint::default())
    }

    /// Two programs: the interpreter writes others up to `BATCH_BYTES` before one of the largest size, and the memory
    /// of a growing list doubles. And the memory of the machine, and the tree of rays that a program is written from.
    fn thread_bytes(&self, formula: &Arc<Formula>, world: &World, view: &View) -> Result<u64, EvaluateError> {
        let code = FormulaCode::new(&evaluated_formula(formula, world))?;
        let equation = equation_in(formula, world);
        let instantiation = Instantiation { code: &code, equation, world };
        let (program, memory) = (instantiation.largest(view.depth()), instantiation.memory_bytes(view.depth()));
        if program > MAX_PROGRAM_BYTES {
            return Err(CodeTooLarge.into());
        }
        let node = size_of::<RayNode>() + world.emitter_ids().count() * size_of::<NodeLight>();
        Ok(2 * (BATCH_BYTES as u64 + program) + memory + largest_tree(world, view.depth()) * node as u64)
    }

    fn prepare(&self, formula: &Arc<Formula>, hits: &Arc<Hits>, _: &[f32]) -> Result<Arc<dyn Evaluator>, EvaluateError> {
        Ok(Arc::new(Interpreted::new(formula, &hits.world, hits.view)?))
    }
}

/// A formula's bytecode, and the world that it runs on.
pub struct Interpreted {
    world: Arc<World>,
    /// The view of each pass, at least one.
    passes: Vec<View>,
    code: FormulaCode,
    equation: Equation,
    lights: EvaluatedLights,
}

/// The cost of a frame by the interpreter.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Timing {
    /// The time to run the programs, without writing them, added up over threads.
    pub evaluation: Duration,
    /// The bytes of all programs.
    pub bytes: u64,
}

impl Timing {
    /// The cost of both.
    fn and(self, other: Timing) -> Timing {
        Timing { evaluation: self.evaluation + other.evaluation, bytes: self.bytes + other.bytes }
    }
}

impl Interpreted {
    /// Writes a formula's bytecode.
    ///
    /// # Errors
    /// The bytecode would be too large.
    pub fn new(formula: &Arc<Formula>, world: &Arc<World>, view: View) -> Result<Self, CodeTooLarge> {
        let code = FormulaCode::new(&evaluated_formula(formula, world))?;
        let equation = equation_in(formula, world);
        if (Instantiation { code: &code, equation, world }).largest(view.depth()) > MAX_PROGRAM_BYTES {
            return Err(CodeTooLarge);
        }
        Ok(Self { world: Arc::clone(world), passes: vec![view], code, equation, lights: formula.evaluated_lights() })
    }

    fn instantiation(&self) -> Instantiation<'_> {
        Instantiation { code: &self.code, equation: self.equation, world: &self.world }
    }

    /// The same for this many passes from the first one on, at least 1.
    #[must_use]
    pub fn with_passes(self, passes: u32) -> Self {
        let view = self.passes[0];
        Self { passes: (0..passes.max(1)).map(|pass| view.with_pass(pass)).collect(), ..self }
    }

    /// The program of a pixel in the first pass, counted row by row from the top left.
    pub fn program(&self, pixel: u32) -> Programs {
        let mut programs = Programs::new();
        self.add_program(pixel, 0, &mut programs);
        programs
    }

    /// Appends the program of a pixel in the pass of this index, which is less than [`passes`](Evaluator::passes).
    pub fn add_program(&self, pixel: u32, pass: usize, programs: &mut Programs) {
        let tracer = Tracer::new(&self.world, &self.passes[pass]);
        programs.add(&self.instantiation(), &ray_tree(&tracer, pixel, self.lights));
    }

    /// The picture of these parameter numbers, see [`Evaluator::frame`], and its cost.
    pub fn timed_frame(&self, parameters: &[f32]) -> (Frame, Timing) {
        let passes = self.passes.len();
        let (mut frame, timing) = self.timed_sum(0..passes, parameters, &AtomicBool::new(false));
        if passes > 1 {
            frame.scale(1.0 / passes as f32);
        }
        (frame, timing)
    }

    /// The sum of some passes, and its cost. It is not complete once `cancelled` is set.
    fn timed_sum(&self, passes: Range<usize>, parameters: &[f32], cancelled: &AtomicBool) -> (Frame, Timing) {
        assert!(parameters.len() >= self.equation.layout.len(), "as many parameter numbers as the formula and the scene have");
        let mut sum: Option<Frame> = None;
        let mut total = Timing::default();
        for view in &self.passes[passes] {
            let mut frame = Frame::black(view.width(), view.height());
            let chunks = frame.linear.par_chunks_mut(PIXELS).enumerate();
            let timings = chunks.map(|(chunk, pixels)| match cancelled.load(Ordering::Relaxed) {
                true => Timing::default(),
                false => self.chunk(view, (chunk * PIXELS) as u32, pixels, parameters),
            });
            total = total.and(timings.reduce(Timing::default, Timing::and));
            match &mut sum {
                Some(sum) => sum.add(&frame),
                None => sum = Some(frame),
            }
        }
        (sum.unwrap_or_else(|| Frame::black(0, 0)), total)
    }

    /// Writes and runs the programs of consecutive pixels in batches.
    fn chunk(&self, view: &View, first: u32, pixels: &mut [[f32; 3]], parameters: &[f32]) -> Timing {
        let tracer = Tracer::new(&self.world, view);
        let instantiation = self.instantiation();
        let mut programs = Programs::new();
        let mut timing = Timing::default();
        let mut done = 0;
        while done < pixels.len() {
            programs.clear();
            while done + programs.len() < pixels.len() && programs.bytes() < BATCH_BYTES {
                let pixel = first + (done + programs.len()) as u32;
                programs.add(&instantiation, &ray_tree(&tracer, pixel, self.lights));
            }
            let mut memory = programs.memory(0.0);
            let start = Instant::now();
            for (index, pixel) in pixels[done..done + programs.len()].iter_mut().enumerate() {
                *pixel = programs.run(&mut Floats, index, parameters, &mut memory);
            }
            timing.evaluation += start.elapsed();
            timing.bytes += programs.bytes() as u64;
            done += programs.len();
        }
        timing
    }
}

impl Evaluator for Interpreted {
    fn passes(&self) -> usize {
        self.passes.len()
    }

    fn with_pass(&self, hits: &Arc<Hits>) -> Result<Arc<dyn Evaluator>, EvaluateError> {
        let (own, view) = (self.passes[0], hits.view);
        if !Arc::ptr_eq(&self.world, &hits.world) || own != view.with_pass(own.pass()) {
            return Err(Mismatch.into());
        }
        let passes = self.passes.iter().copied().chain([view]).collect();
        Ok(Arc::new(Self { passes, world: Arc::clone(&self.world), code: self.code.clone(), ..*self }))
    }

    fn sum(&self, passes: Range<usize>, parameters: &[f32], cancelled: &AtomicBool) -> Option<Frame> {
        let (frame, _) = self.timed_sum(passes, parameters, cancelled);
        (!cancelled.load(Ordering::Relaxed)).then_some(frame)
    }

    fn draw(&self, parameters: &[f32], framebuffer: &mut Framebuffer) -> Drawn {
        let (mut frame, timing) = self.timed_frame(parameters);
        framebuffer.set(&frame);
        // The time is added up over threads.
        let time = timing.evaluation / rayon::current_num_threads() as u32;
        Drawn { time, program_bytes: timing.bytes, undefined: Some(frame.clean()) }
    }

    fn drag(
        self: Arc<Self>,
        _: &[usize],
        parameters: &[f32],
        _: usize,
        beginning: Option<&DragBeginning>,
    ) -> Result<Box<dyn Drag>, EvaluateError> {
        let pixels = self.passes[0].pixels() as usize;
        Ok(Box::new(WholeFrames::new(self, pixels, parameters, beginning)))
    }

    fn bytes(&self) -> usize {
        self.code.bytes()
    }
}
