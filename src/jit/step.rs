//! What compiled code is called with: a step says where everything is that it works on, counted in bytes from the bases that a run gives. So
//! steps that were put together once hold for every frame, wherever its values lie.

use crate::plan::STREAMS;

/// A kernel writes so many streams at most.
pub(super) const OUTPUTS: usize = 3;

/// What a kernel works on. Streams are counted each from its own base, outputs from that of the outputs.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, bytemuck::Zeroable, bytemuck::Pod)]
#[repr(C)]
pub(super) struct Reading {
    pub(super) streams: [usize; STREAMS],
    pub(super) outputs: [usize; OUTPUTS],
    pub(super) uniforms: usize,
    /// How many rounds of its loop; not a place.
    pub(super) rounds: usize,
}

/// What code that adds to pixels works on.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, bytemuck::Zeroable, bytemuck::Pod)]
#[repr(C)]
pub(super) struct Addition {
    /// The first segment, and behind the last; there is one at least.
    pub(super) segments: usize,
    pub(super) end: usize,
    /// Arrays of lines, one for each component: counted from the base of the outputs.
    pub(super) sums: usize,
    /// Planes of pixels, one for each component.
    pub(super) planes: usize,
    /// What is going to be read, if anything is there.
    pub(super) coming: usize,
    /// The weight of each span of the chunk.
    pub(super) weights: usize,
    pub(super) unused: [usize; 2],
}

// Either is the work of a step.
const _: () = assert!(size_of::<Reading>() == size_of::<Addition>());

/// Where what steps work on begins: addresses.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[repr(C)]
pub(super) struct Bases {
    pub(super) streams: [usize; STREAMS],
    pub(super) outputs: usize,
    pub(super) uniforms: usize,
    pub(super) segments: usize,
    pub(super) planes: usize,
    pub(super) weights: usize,
    pub(super) coming: usize,
}
