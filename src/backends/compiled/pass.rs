//! What is added up over the hits of a picture, and with which weights.
//!
//! A whole frame is one [`Pass`]: every path with its weight, and one source for all pairs of a body and a light. An image that a drag
//! keeps (see [`drag`](super::drag)) is another. How a pass runs over a tile is in [`tile`](super::tile).

use crate::backends::compiled::columns::Columns;
use crate::backends::compiled::source::Source;
use crate::jit::{PixelCode, Splat};
use crate::plan::Channels;

/// What is added up.
pub(super) struct Pass<'p> {
    pub(super) sources: Vec<Source<'p>>,
    /// The uniform values of all of them.
    pub(super) uniforms: Vec<Splat>,
    /// The static columns of each tile.
    pub(super) columns: &'p [Columns],
    /// What each hit of a body adds, whatever the lights: body by body.
    pub(super) at_hits: Vec<[f32; 3]>,
    /// What each ray adds that left the scene.
    pub(super) at_misses: [f32; 3],
    /// The components that are computed; the others stay as they are.
    pub(super) channels: Channels,
    /// The code that adds to pixels, where there is some for the processor.
    pub(super) code: Option<&'static PixelCode>,
}

impl<'p> Pass<'p> {
    /// Adds a source with its uniform values.
    pub(super) fn push(&mut self, mut source: Source<'p>, mut uniforms: Vec<Splat>) {
        source.first_uniform = self.uniforms.len();
        self.uniforms.append(&mut uniforms);
        self.sources.push(source);
    }
}
