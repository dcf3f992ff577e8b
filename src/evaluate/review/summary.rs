//! The few facts about the colours of a picture that a review starts from.

use crate::picture::{Frame, ViewTransform, quantise};
use rayon::prelude::*;

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
        let ranges = frame.linear.par_chunks(PIXELS_AT_ONCE).map(|pixels| {
            let numbers = pixels.as_flattened();
            // Most pictures have no NaN, and then no pixel is looked at.
            let any = numbers.iter().fold(false, |any, number| any | number.is_nan());
            (if any { pixels.iter().filter(|pixel| is_nan(pixel)).count() } else { 0 }, range(numbers))
        });
        let join = |(nan, [low, high]): (usize, [f32; 2]), (more, other): (usize, [f32; 2])| {
            (nan + more, [low.min(other[0]), high.max(other[1])])
        };
        let (nan, range) = ranges.reduce(|| (0, NO_RANGE), join);
        let first = frame.linear.first().copied();
        Self {
            pixels: frame.linear.len(),
            nan,
            first_nan: (nan > 0).then(|| frame.linear.iter().position(is_nan)).flatten(),
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

/// How many pixels a thread looks at without a break.
const PIXELS_AT_ONCE: usize = 1 << 14;

/// The smallest and the largest of no numbers.
const NO_RANGE: [f32; 2] = [f32::INFINITY, f32::NEG_INFINITY];

/// The smallest and the largest number that is not NaN. Several run side by side, so that a number does not wait for
/// the one before it.
fn range(numbers: &[f32]) -> [f32; 2] {
    const LANES: usize = 32;
    let (lines, rest) = numbers.as_chunks::<LANES>();
    let (mut lows, mut highs) = ([f32::INFINITY; LANES], [f32::NEG_INFINITY; LANES]);
    for line in lines {
        for (lane, number) in line.iter().enumerate() {
            // Comparisons with NaN are false.
            lows[lane] = if *number < lows[lane] { *number } else { lows[lane] };
            highs[lane] = if *number > highs[lane] { *number } else { highs[lane] };
        }
    }
    let low = lows.iter().chain(rest).copied().fold(f32::INFINITY, f32::min);
    [low, highs.iter().chain(rest).copied().fold(f32::NEG_INFINITY, f32::max)]
}
