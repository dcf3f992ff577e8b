//! Pictures while a slider is held.

use crate::evaluate::{Evaluator, Framebuffer};
use crate::picture::Frame;
use crate::plan::Method;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// What a drag of a picture of several passes begins with. Frames that evaluate passes evaluate only some of them, and
/// show what these change in that picture: `picture + mean of the passes with the new numbers − their mean with the old
/// ones`. Images of few passes are used in the same way, until those of all passes are ready.
#[derive(Debug, Clone)]
pub struct DragBeginning {
    /// The picture with the numbers before the drag: the mean of all passes, or of fewer if no more are evaluated. What
    /// the drag does not move stays as it is there.
    pub picture: Arc<Frame>,
    /// How many passes a frame evaluates, at least 1.
    pub passes: usize,
}

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

    /// The linear picture of these numbers, if the drag knows it without evaluating passes: what these numbers change
    /// in all passes, added to the picture that the drag began with. If that is of all passes, so is this, but for
    /// rounding.
    fn linear(&self, parameters: &[f32]) -> Option<Frame> {
        let _ = parameters;
        None
    }

    /// Whether the last frame is that of all passes, without evaluating only some of them anywhere.
    fn is_of_all_passes(&self) -> bool;

    /// Does a part of the preparation, about as much work as one full evaluation of a pass. Returns whether everything
    /// is prepared.
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
    /// How many passes are evaluated for a frame, and what is added to their mean: the rest of the picture at the
    /// beginning.
    some: Option<(usize, Rest)>,
}

/// What the picture at the beginning has beside the mean of some passes.
enum Rest {
    /// The picture that the drag begins with, and its numbers.
    Picture(Arc<Frame>, Vec<f32>),
    /// The rest.
    Known(Frame),
}

impl WholeFrames {
    /// A drag with pictures by this evaluator, of this many pixels. It may begin with the picture of these numbers.
    pub fn new(evaluator: Arc<dyn Evaluator>, pixels: usize, numbers: &[f32], beginning: Option<&DragBeginning>) -> Self {
        let all = evaluator.passes();
        let some = |DragBeginning { picture, passes }: &DragBeginning| {
            let rest = Rest::Picture(Arc::clone(picture), numbers.to_vec());
            (*passes < all).then(|| ((*passes).max(1), rest))
        };
        Self { some: beginning.and_then(some), evaluator, pixels }
    }
}

impl Drag for WholeFrames {
    fn method(&self) -> Method {
        Method::General
    }

    fn frame(&mut self, parameters: &[f32], framebuffer: &mut Framebuffer) {
        let Some((passes, rest)) = &mut self.some else {
            self.evaluator.draw(parameters, framebuffer);
            return;
        };
        let mean = |numbers: &[f32]| {
            let mut frame = self.evaluator.sum(0..*passes, numbers, &AtomicBool::new(false))?;
            frame.scale(1.0 / *passes as f32);
            Some(frame)
        };
        if let Rest::Picture(picture, numbers) = rest {
            let Some(part) = mean(numbers) else { return };
            *rest = Rest::Known(picture.rest_beside(&part));
        }
        if let (Rest::Known(rest), Some(mut frame)) = (rest, mean(parameters)) {
            frame.add(rest);
            framebuffer.set(&frame);
        }
    }

    fn is_of_all_passes(&self) -> bool {
        self.some.is_none()
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
