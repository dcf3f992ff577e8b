//! Replaces `call` where kernels cannot run: the same items, without any kernel.

use crate::formula::graph::Graph;
use crate::jit::kernel::KernelSpec;
use crate::jit::lanes::{Line, Operands, PixelLine, PixelPlanes, Splat, Streams};
use crate::jit::target::{CompileError, Listing, target};
use crate::picture::encoder::Encoder;
use crate::plan::STREAMS;
use crate::simd::Width;
use std::ops::Range;

/// A compiled kernel: there is none.
#[derive(Clone)]
pub enum Kernel {}

impl Kernel {
    /// The number of columns that it writes.
    pub fn outputs(&self) -> usize {
        match *self {}
    }

    /// Rounds a number of lines up to whole rounds.
    pub fn whole_rounds(&self, _lines: usize) -> usize {
        match *self {}
    }

    /// Runs the kernel.
    pub fn run(&self, _streams: Streams, _uniforms: &[Splat], _outputs: &mut [&mut [Line]], _lines: usize) {
        match *self {}
    }
}

/// The calls of compiled code for a tile: there are none.
#[derive(Default)]
pub struct CallList;

impl CallList {
    /// The memory of a call, in bytes.
    pub const BYTES_PER_CALL: usize = 0;

    /// Removes all calls.
    pub fn clear(&mut self) {}

    /// The number of calls: 0.
    pub fn len(&self) -> usize {
        0
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        true
    }

    /// The memory of the calls.
    pub fn bytes(&self) -> usize {
        0
    }

    /// Frees memory that is not needed.
    pub fn shrink(&mut self) {}

    /// Prefetches the calls.
    pub fn fetch(&self) {}

    /// Runs a kernel.
    pub fn contribute(&mut self, kernel: &Kernel, _: [Range<usize>; STREAMS], _: usize, _: Range<usize>, _: Range<usize>) {
        match *kernel {}
    }

    /// Adds to pixels.
    pub fn add(&mut self, code: &'static PixelCode, _: Range<usize>, _: usize, _: Option<usize>, _: usize) {
        match *code {}
    }

    /// Makes no calls.
    pub fn run(&self, _: Range<usize>, _: &mut Operands) {}
}

/// Fails: there is no compiled code for this processor.
pub(super) fn generate(
    width: Width,
    _specs: &[KernelSpec],
    _graph: &Graph,
    _listing: Option<&mut Listing>,
) -> Result<Vec<Kernel>, CompileError> {
    let target = target(width)?;
    Err(CompileError::Processor(target.isa.name().to_owned()))
}

/// Would prefetch a list.
pub fn fetch<T>(_: &[T]) {}

/// Code that adds to pixels and writes them: there is none.
pub enum PixelCode {}

impl PixelCode {
    /// The code: none.
    pub fn get(_: Width) -> Option<&'static PixelCode> {
        None
    }

    /// Writes.
    pub(crate) fn write(&self, _: &Encoder, _: &PixelPlanes, _: usize, _: &mut [PixelLine], _: &[Line]) {
        match *self {}
    }
}
