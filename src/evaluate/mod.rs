//! What a backend does: parameter numbers and the hits of a traced scene into pictures.
//!
//! A [`Backend`] makes an [`Evaluator`] of a formula on a traced scene; an evaluator makes pictures of parameter
//! numbers, and a [`Drag`] makes them while a slider is held. The backends themselves are in
//! [`backends`](crate::backends); what they share is here: [`Frame`] and [`Framebuffer`], and the weights of ray paths.
//! [`inspect`] explains one pixel.
//!
//! Parameter numbers are one array in the order of [`Layout`](crate::formula::layout::Layout). Each number lies within
//! the range of its parameter, where that has one, and none is NaN or infinite, as
//! [`Parameter::clamp`](crate::formula::Parameter::clamp) leaves them: compiled code relies on that, and outside the
//! ranges a picture may differ from the formula's.

mod drag;
mod framebuffer;
pub mod inspect;
pub mod weights;

pub use drag::{Drag, WholeFrames};
pub use framebuffer::Framebuffer;
pub(crate) use framebuffer::{Part, write, write_component};

use crate::formula::Formula;
use crate::picture::Frame;
use crate::trace::{Hits, Mismatch};
use std::sync::Arc;
use std::time::{Duration, Instant};
use thiserror::Error;

/// Why a formula cannot be evaluated on a scene.
#[derive(Debug, Error)]
pub enum EvaluateError {
    /// The backend cannot take the formula, or does not run on this machine; why, for people.
    #[error("{0}")]
    Backend(String),
    /// The hits belong to another scene or view; an error of the caller.
    #[error(transparent)]
    Hits(#[from] Mismatch),
}

/// The memory that an evaluator keeps for a formula, in bytes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Footprint {
    /// For each hit.
    pub per_hit: u64,
    /// For each lit record: a pair of a hit and a light that reaches it.
    pub per_record: u64,
    /// For each pair of a body and a light of the scene.
    pub per_pair: u64,
    /// For each step of work: a light of a chunk of a group of hits, or adding that to the pixels.
    pub per_step: u64,
}

/// A way to evaluate formulas.
pub trait Backend: Send + Sync {
    /// The name by which it is chosen.
    fn name(&self) -> &'static str;

    /// Whether evaluators read the stored hits. One that does not gets those of [`Hits::untraced`], and traces for
    /// itself.
    fn reads_hits(&self) -> bool {
        true
    }

    /// Does what depends on the formula alone, so that [`prepare`](Self::prepare) need not; what evaluators of it will
    /// keep.
    ///
    /// # Errors
    /// The backend cannot take the formula.
    fn compile(&self, formula: &Arc<Formula>) -> Result<Footprint, EvaluateError>;

    /// Makes a formula ready on a traced scene, on all threads of the current pool.
    ///
    /// # Errors
    /// The backend cannot take the formula, or `hits` are not those of the scene.
    fn prepare(&self, formula: &Arc<Formula>, hits: &Arc<Hits>) -> Result<Arc<dyn Evaluator>, EvaluateError>;
}

/// A formula on a traced scene, ready to make pictures of parameter numbers.
pub trait Evaluator: Send + Sync {
    /// The picture of these parameter numbers, unclamped and linear.
    ///
    /// # Panics
    /// Where there are fewer numbers than the [`Layout`](crate::formula::layout::Layout) of formula and scene has.
    fn frame(&self, parameters: &[f32]) -> Frame;

    /// Draws the same picture as a window shows it.
    ///
    /// # Panics
    /// Where the framebuffer has another size than the view, or there are too few parameter numbers.
    fn draw(&self, parameters: &[f32], framebuffer: &mut Framebuffer) -> Drawn;

    /// Takes hold of numbers of one owner: `moved` are their places among `parameters`, which holds the values before
    /// the drag. At most `budget` bytes are kept for it.
    ///
    /// # Errors
    /// The backend cannot take the formula apart; pictures can still be drawn one by one.
    ///
    /// # Panics
    /// Where there are too few parameter numbers.
    fn drag(self: Arc<Self>, moved: &[usize], parameters: &[f32], budget: usize) -> Result<Box<dyn Drag>, EvaluateError>;

    /// The memory at rest, in bytes: the stored hits, and what is kept of them.
    fn bytes(&self) -> usize;
}

/// What drawing a picture came to.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Drawn {
    /// How long evaluation took. An interpreter does not count the writing of its programs.
    pub time: Duration,
    /// The bytes of programs that were written for this picture alone.
    pub program_bytes: u64,
    /// How many pixels hold NaN, where that is known.
    pub undefined: Option<usize>,
}

impl Drawn {
    /// Draws, and measures how long that takes.
    pub fn timed(draw: impl FnOnce()) -> Self {
        let start = Instant::now();
        draw();
        Self { time: start.elapsed(), ..Self::default() }
    }
}
