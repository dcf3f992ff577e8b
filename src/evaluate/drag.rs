//! Pictures while a slider is held.

use crate::evaluate::{Evaluator, Framebuffer};
use crate::plan::Method;
use std::sync::Arc;

/// A slider that is held: pictures in which only some numbers of one owner move.
pub trait Drag: Send {
    /// How pictures are made once everything is prepared.
    fn method(&self) -> Method;

    /// Draws the picture of these parameter numbers, in the order of the [`Layout`](crate::formula::layout::Layout).
    /// After the first call, the framebuffer must hold the last picture of this drag, with the same transfer: pixels
    /// that cannot have changed are not written. If any other number has changed, the drag drops what it prepared and
    /// prepares it again.
    ///
    /// # Panics
    /// Where the framebuffer has another size than the view, or there are too few parameter numbers.
    fn frame(&mut self, parameters: &[f32], framebuffer: &mut Framebuffer);

    /// Does a part of the preparation, about as much work as one full evaluation. Returns whether everything is
    /// prepared.
    fn prepare(&mut self) -> bool;

    /// Whether everything is prepared.
    fn is_ready(&self) -> bool;

    /// The memory that the drag keeps, in bytes.
    fn bytes(&self) -> usize;

    /// How many pixels a picture writes once everything is prepared.
    fn pixels(&self) -> usize;
}

/// A drag that draws every picture in full.
pub struct WholeFrames {
    evaluator: Arc<dyn Evaluator>,
    pixels: usize,
}

impl WholeFrames {
    /// A drag with pictures by this evaluator, of this many pixels.
    pub fn new(evaluator: Arc<dyn Evaluator>, pixels: usize) -> Self {
        Self { evaluator, pixels }
    }
}

impl Drag for WholeFrames {
    fn method(&self) -> Method {
        Method::General
    }

    fn frame(&mut self, parameters: &[f32], framebuffer: &mut Framebuffer) {
        self.evaluator.draw(parameters, framebuffer);
    }

    fn prepare(&mut self) -> bool {
        true
    }

    fn is_ready(&self) -> bool {
        true
    }

    fn bytes(&self) -> usize {
        0
    }

    fn pixels(&self) -> usize {
        self.pixels
    }
}
