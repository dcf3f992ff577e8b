//! The sum over the hits of a picture that a pass computes.
//!
//! A whole frame is one [`Pass`]: every path with its weight, and one source for all pairs of a body and a light. An
//! image of a drag (see [`drag`](super::drag)) is another. [`tile`](super::tile) runs a pass over a tile.

use crate::backends::compiled::columns::Columns;
use crate::backends::compiled::source::ContributionSource;
use crate::backends::compiled::surface::SurfacePass;
use crate::jit::{PixelCode, Splat};
use crate::plan::Channels;

/// The terms of the sum.
pub(super) struct Pass<'p> {
    pub(super) sources: Vec<ContributionSource<'p>>,
    /// The uniform values of all of them.
    pub(super) uniforms: Vec<Splat>,
    /// The static columns of each tile.
    pub(super) columns: &'p [Columns],
    /// The terms without lights at each hit of a body, body by body.
    pub(super) at_hits: Vec<[f32; 3]>,
    /// The terms of each ray that leaves the scene.
    pub(super) at_misses: [f32; 3],
    /// The components that are computed. The others do not change.
    pub(super) channels: Channels,
    /// The code that adds to pixels, if the processor supports it.
    pub(super) code: Option<&'static PixelCode>,
    /// What the formula gives at every hit, if it gives anything.
    pub(super) surface: Option<SurfacePass<'p>>,
}

impl<'p> Pass<'p> {
    /// Adds a source with its uniform values.
    pub(super) fn push(&mut self, mut source: ContributionSource<'p>, mut uniforms: Vec<Splat>) {
        source.first_uniform = self.uniforms.len();
        self.uniforms.append(&mut uniforms);
        self.sources.push(source);
    }
}
