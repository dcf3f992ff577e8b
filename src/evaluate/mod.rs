//! What a backend does: it makes pictures of the hits of a traced scene and parameter numbers.
//!
//! A [`Backend`] makes an [`Evaluator`] of a formula for a scene and a view. The evaluator makes a picture for any
//! parameter numbers. A [`Drag`] makes the pictures while a slider is held. The backends are in
//! [`backends`](crate::backends). They share the [`Framebuffer`] and the weights of ray paths. [`inspect`] explains one
//! pixel, and [`review`] a picture that shows nothing. [`at_point`] has a formula without a scene.
//!
//! Parameter numbers are one array in the order of [`Layout`](crate::formula::layout::Layout). Each number is finite
//! and within the range of its parameter, as after [`Parameter::clamp`](crate::formula::Parameter::clamp). Compiled
//! code relies on that: outside the ranges a picture may be wrong.

pub mod at_point;
mod drag;
mod framebuffer;
pub mod inspect;
pub mod review;
pub mod weights;

pub use drag::{Drag, DragBeginning, WholeFrames};
pub use framebuffer::Framebuffer;
pub(crate) use framebuffer::{Part, write, write_component};

use crate::formula::Formula;
use crate::formula::equation::Equation;
use crate::picture::Frame;
use crate::trace::{Hits, Mismatch, View};
use crate::world::World;
use std::ops::Range;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::{Duration, Instant};
use thiserror::Error;

/// Why a formula cannot be evaluated on a scene.
#[derive(Debug, Error)]
pub enum EvaluateError {
    /// The backend does not support the formula, or does not run on this machine. The text is a message for the user.
    #[error("{0}")]
    Backend(String),
    /// The hits belong to another scene or view. This is an error of the caller.
    #[error(transparent)]
    Hits(#[from] Mismatch),
}

/// The memory that an evaluator keeps for a formula, in bytes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Footprint {
    /// For each hit.
    pub per_hit: u64,
    /// For each lit record: a pair of a hit and a light that it is evaluated for.
    pub per_record: u64,
    /// For each ray that leaves the scene.
    pub per_miss: u64,
    /// For each pair of a body and a light of the scene.
    pub per_pair: u64,
    /// For each call of compiled code: a kernel for one light of a chunk, or adding a chunk to the pixels.
    pub per_call: u64,
    /// For each pixel, beside the linear picture and the framebuffer.
    pub per_pixel: u64,
}

/// A way to evaluate formulas.
pub trait Backend: Send + Sync {
    /// The name by which it is chosen.
    fn name(&self) -> &'static str;

    /// Whether evaluators read the stored hits. An evaluator that does not gets [`Hits::untraced`] and traces the scene
    /// itself.
    fn reads_hits(&self) -> bool {
        true
    }

    /// Does the work that depends on the formula and on the kinds of lights of the world alone. Returns the memory that
    /// its evaluators will keep.
    ///
    /// # Errors
    /// The backend does not support the formula.
    fn compile(&self, formula: &Arc<Formula>, world: &World) -> Result<Footprint, EvaluateError>;

    /// The memory that each thread takes at most while it prepares and evaluates this formula, in bytes.
    ///
    /// # Errors
    /// The backend does not support the formula.
    fn thread_bytes(&self, formula: &Arc<Formula>, world: &World, view: &View) -> Result<u64, EvaluateError>;

    /// Prepares a formula for a traced scene, on all threads of the current pool. `parameters` are the numbers of the
    /// first picture: its textures are looked up now. Numbers that are missing count as 0. The first picture with other
    /// textures takes longer.
    ///
    /// # Errors
    /// The backend does not support the formula, or the hits do not belong to the scene.
    fn prepare(&self, formula: &Arc<Formula>, hits: &Arc<Hits>, parameters: &[f32]) -> Result<Arc<dyn Evaluator>, EvaluateError>;
}

/// A formula for a scene and a view, ready to make pictures of parameter numbers.
pub trait Evaluator: Send + Sync {
    /// How many passes its pictures are the mean of, at least 1.
    fn passes(&self) -> usize;

    /// The same with one more pass, whose hits are given. What is known of the passes so far is shared.
    ///
    /// # Errors
    /// The hits belong to another scene, or their view differs in more than the pass.
    fn with_pass(&self, hits: &Arc<Hits>) -> Result<Arc<dyn Evaluator>, EvaluateError>;

    /// The sum of some passes of the picture of these parameter numbers: linear RGB, not clamped, one colour for each
    /// pixel of the view. A colour may be infinite or NaN if the formula is. `None` once `cancelled` is set.
    ///
    /// # Panics
    /// Where there are fewer numbers than the [`Layout`](crate::formula::layout::Layout) of formula and scene has, or
    /// fewer passes.
    fn sum(&self, passes: Range<usize>, parameters: &[f32], cancelled: &AtomicBool) -> Option<Frame>;

    /// The picture of these parameter numbers: the mean of all passes, see [`sum`](Self::sum).
    ///
    /// # Panics
    /// Where there are fewer numbers than the [`Layout`](crate::formula::layout::Layout) of formula and scene has.
    fn frame(&self, parameters: &[f32]) -> Frame {
        let passes = self.passes();
        let mut frame = self.sum(0..passes, parameters, &AtomicBool::new(false)).unwrap_or_else(|| Frame::black(0, 0));
        if passes > 1 {
            frame.scale(1.0 / passes as f32);
        }
        frame
    }

    /// Why the last picture is no picture, if the means of evaluation failed: a message for the user. Its colours are
    /// NaN.
    fn failure(&self) -> Option<String> {
        None
    }

    /// Draws the same picture as a window shows it.
    ///
    /// # Panics
    /// Where the framebuffer has another size than the view, or there are too few parameter numbers.
    fn draw(&self, parameters: &[f32], framebuffer: &mut Framebuffer) -> Drawn;

    /// Starts a drag of numbers of one owner. `moved` are their indices in `parameters`, which holds the values before
    /// the drag. The drag keeps at most `budget` bytes. It may begin with a picture.
    ///
    /// # Errors
    /// The backend does not support drags of this formula. Pictures can still be drawn in full.
    ///
    /// # Panics
    /// Where there are too few parameter numbers.
    fn drag(
        self: Arc<Self>,
        moved: &[usize],
        parameters: &[f32],
        budget: usize,
        beginning: Option<&DragBeginning>,
    ) -> Result<Box<dyn Drag>, EvaluateError>;

    /// The memory that is kept between frames, in bytes: stored hits and columns.
    fn bytes(&self) -> usize;
}

/// The formula that is evaluated in a world: that of the user, or the same [for weighted
/// samples](Formula::for_weighted_samples).
pub fn evaluated_formula(formula: &Arc<Formula>, world: &World) -> Arc<Formula> {
    if world.has_whole_samples() { Arc::clone(formula) } else { formula.for_weighted_samples() }
}

/// Equation (2) for a formula in a world.
pub fn equation_in(formula: &Formula, world: &World) -> Equation {
    let scene = world.scene();
    let environment = world.environment().map(|environment| environment.light().index());
    Equation::new(formula, scene.bodies.len(), scene.lights.len()).with_environment(environment)
}

/// Statistics of drawing a picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Drawn {
    /// How long evaluation took. The interpreter does not count the time to write its programs.
    pub time: Duration,
    /// The size of the programs that were written for this picture, in bytes.
    pub program_bytes: u64,
    /// How many pixels hold NaN, where that is known.
    pub undefined: Option<usize>,
}

impl Drawn {
    /// Draws and measures the time.
    pub fn timed(draw: impl FnOnce()) -> Self {
        let start = Instant::now();
        draw();
        Self { time: start.elapsed(), ..Self::default() }
    }
}
