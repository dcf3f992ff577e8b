//! A contribution to a picture: its kernels, and the pairs of a body and a light that it covers.

use crate::jit::Kernel;
use crate::plan::Channels;
use crate::scene::BodyId;
use crate::world::{EmitterId, World};
use std::ops::Range;

/// A contribution of some pairs of a body and a light.
pub(super) struct ContributionSource<'p> {
    /// Static columns → contributions, stored.
    pub(super) overwrite: &'p Kernel,
    /// The same, added to the sums.
    pub(super) add: &'p Kernel,
    /// The components that the kernels compute.
    pub(super) channels: Channels,
    /// The index of its variant among those in use; 0 for kernels of all branches.
    pub(super) variant: usize,
    /// The index of the first uniform value of its pairs of a body and a light, and the number of values of a pair.
    pub(super) first_uniform: usize,
    pub(super) uniform_count: usize,
    /// Whether each pair contributes.
    pub(super) active: Vec<bool>,
    /// The number of lights.
    pub(super) lights: usize,
    /// The world, which knows the light of each emitter.
    pub(super) world: &'p World,
}

impl ContributionSource<'_> {
    /// The index of the pair of a body and the light of an emitter.
    pub(super) fn pair(&self, body: BodyId, emitter: EmitterId) -> usize {
        body.index() * self.lights + self.world.light_of(emitter).index()
    }

    /// The indices of the uniform values of a pair.
    pub(super) fn uniforms_of(&self, pair: usize) -> Range<usize> {
        let first = self.first_uniform + pair * self.uniform_count;
        first..first + self.uniform_count
    }
}
