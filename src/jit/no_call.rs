//! In place of the room of calls where kernels cannot run: the same items, and no kernel.

use crate::formula::graph::Graph;
use crate::jit::kernel::KernelSpec;
use crate::jit::lanes::{Line, Operands, PixelLine, PixelPlanes, Splat, Streams};
use crate::jit::target::{CompileError, Listing, target};
use crate::jit::width::Width;
use crate::picture::Transfer;
use crate::plan::STREAMS;
use std::ops::Range;

/// A compiled kernel: there is none.
#[derive(Clone)]
pub enum Kernel {}

impl Kernel {
    /// How many columns it writes.
    pub fn outputs(&self) -> usize {
        match *self {}
    }

    /// How many lines it reads and writes where so many are wanted.
    pub fn whole_rounds(&self, _lines: usize) -> usize {
        match *self {}
    }

    /// Runs the kernel.
    pub fn run(&self, _streams: Streams, _uniforms: &[Splat], _outputs: &mut [&mut [Line]], _lines: usize) {
        match *self {}
    }
}

/// Work for compiled code on the pixels of a tile: there is none.
#[derive(Default)]
pub struct Program;

impl Program {
    /// The memory of a step, in bytes.
    pub const BYTES_PER_STEP: usize = 0;

    /// Forgets all steps.
    pub fn clear(&mut self) {}

    /// How many steps there are: none.
    pub fn len(&self) -> usize {
        0
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        true
    }

    /// The memory that the steps take.
    pub fn bytes(&self) -> usize {
        0
    }

    /// Gives back memory that is not needed.
    pub fn shrink(&mut self) {}

    /// Has the steps fetched.
    pub fn fetch(&self) {}

    /// Runs a kernel.
    pub fn contribute(&mut self, kernel: &Kernel, _: [Range<usize>; STREAMS], _: usize, _: Range<usize>, _: Range<usize>) {
        match *kernel {}
    }

    /// Adds to pixels.
    pub fn add(&mut self, code: &'static PixelCode, _: Range<usize>, _: usize, _: Option<usize>, _: usize) {
        match *code {}
    }

    /// Takes no steps.
    pub fn run(&self, _: Range<usize>, _: &mut Operands) {}
}

/// Says that there is no compiled code for this processor.
pub(super) fn generate(
    width: Width,
    _specs: &[KernelSpec],
    _graph: &Graph,
    _listing: Option<&mut Listing>,
) -> Result<Vec<Kernel>, CompileError> {
    let target = target(width)?;
    Err(CompileError::Processor(target.isa.name().to_owned()))
}

/// Has the processor fetch a list: not here.
pub fn fetch<T>(_: &[T]) {}

/// Code that adds to pixels and writes them: there is none.
pub enum PixelCode {}

impl PixelCode {
    /// The code: none.
    pub fn get(_: Width) -> Option<&'static PixelCode> {
        None
    }

    /// Writes.
    pub fn write(&self, _: Transfer, _: &PixelPlanes, _: usize, _: &mut [PixelLine], _: &[Line]) {
        match *self {}
    }
}
