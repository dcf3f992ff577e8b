//! The operands of compiled code. A call holds the offsets of its operands, in bytes, from bases that each run gives.
//! So calls that were built once are valid for every frame, wherever its values lie.

use crate::plan::STREAMS;

/// A kernel writes at most this many streams.
pub(super) const OUTPUTS: usize = 3;

/// The operands of a kernel, as offsets. Each stream has its own base, all outputs have one.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, bytemuck::Zeroable, bytemuck::Pod)]
#[repr(C)]
pub(super) struct KernelCall {
    pub(super) streams: [usize; STREAMS],
    pub(super) outputs: [usize; OUTPUTS],
    pub(super) uniforms: usize,
    /// The number of rounds of its loop; not an offset.
    pub(super) rounds: usize,
}

/// The operands of code that adds to pixels, as offsets.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, bytemuck::Zeroable, bytemuck::Pod)]
#[repr(C)]
pub(super) struct AddCall {
    /// The first segment, and the end of the segments. There is at least one.
    pub(super) segments: usize,
    pub(super) end: usize,
    /// Arrays of lines, one for each component, from the base of the outputs.
    pub(super) sums: usize,
    /// Planes of pixels, one for each component.
    pub(super) planes: usize,
    /// The lines to prefetch. Nothing need be there.
    pub(super) next_lines: usize,
    /// The weight of each span of the chunk.
    pub(super) weights: usize,
    pub(super) unused: [usize; 2],
}

// Both have the size of the operands of a call.
const _: () = assert!(size_of::<KernelCall>() == size_of::<AddCall>());

/// The addresses from which the offsets of operands count.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[repr(C)]
pub(super) struct Bases {
    pub(super) streams: [usize; STREAMS],
    pub(super) outputs: usize,
    pub(super) uniforms: usize,
    pub(super) segments: usize,
    pub(super) planes: usize,
    pub(super) weights: usize,
    pub(super) next_lines: usize,
}
