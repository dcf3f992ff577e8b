//! The few facts about the colours of a picture that a review starts from.

use crate::picture::{Frame, ViewTransform, quantise};

/// Facts about the linear colours of a picture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PictureSummary {
    /// How many pixels there are.
    pub pixels: usize,
    /// How many of them have a component that is NaN.
    pub nan: usize,
    /// The index of the first of those.
    pub first_nan: Option<usize>,
    /// The smallest and the largest component that is not NaN.
    pub range: [f32; 2],
    /// The colour of every pixel, if they are all alike.
    pub only_colour: Option<[f32; 3]>,
}

impl PictureSummary {
    /// The summary of a picture that still has its NaN.
    pub fn of(frame: &Frame) -> Self {
        let is_nan = |pixel: &[f32; 3]| pixel.iter().any(|component| component.is_nan());
        let components = frame.linear.as_flattened().iter().copied().filter(|component| !component.is_nan());
        let range = components.fold([f32::INFINITY, f32::NEG_INFINITY], |[low, high], one| [low.min(one), high.max(one)]);
        let first = frame.linear.first().copied();
        Self {
            pixels: frame.linear.len(),
            nan: frame.linear.iter().filter(|pixel| is_nan(pixel)).count(),
            first_nan: frame.linear.iter().position(is_nan),
            range,
            only_colour: first.filter(|first| frame.linear.iter().all(|pixel| pixel == first)),
        }
    }

    /// The summary of a picture without NaN that may be black; `None` for most pictures, of which only a few pixels are
    /// read.
    pub fn if_remarkable(frame: &Frame, view: &ViewTransform) -> Option<Self> {
        /// Any byte of a component that is larger is not 0.
        const SURELY_SEEN: f64 = 0.01;
        let is_seen = |component: &f32| f64::from(*component) * view.factor() > SURELY_SEEN;
        let is_bright = frame.linear.as_flattened().iter().any(is_seen);
        (!is_bright).then(|| Self::of(frame))
    }

    /// Whether every byte of the picture is 0.
    pub(super) fn is_black(&self, view: &ViewTransform) -> bool {
        self.pixels > 0 && quantise(&[[self.range[1]; 3]], *view) == [0; 3]
    }
}
