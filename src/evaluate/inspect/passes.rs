//! The colours of a pixel in the passes of a picture. A picture is their mean.

use crate::evaluate::inspect::Inspector;
use crate::picture::mean_colour;
use crate::trace::View;
use rayon::prelude::*;
use std::ops::Range;

/// The colours of a pixel in the first passes of a picture.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct PassColours {
    /// Linear red, green and blue in each pass, unclamped: the interpreter's, bit for bit.
    pub colours: Vec<[f32; 3]>,
}

impl PassColours {
    /// The colour of the pixel in the picture: the mean of the passes. Black without a pass.
    pub fn mean(&self) -> [f32; 3] {
        mean_colour(&self.colours)
    }
}

impl Inspector<'_> {
    /// The colours of a pixel, given as column and row from the top left, in some passes; on all threads of the current
    /// pool. Outside the picture there are none.
    pub fn pass_colours(&self, view: &View, pixel: [u32; 2], passes: Range<u32>) -> Vec<[f32; 3]> {
        let colour = |pass: u32| self.inspect(&view.with_pass(pass), pixel).map(|inspection| inspection.total);
        passes.into_par_iter().filter_map(colour).collect()
    }
}
