//! In place of the room of calls where kernels cannot run: the same items, and no kernel.

use crate::formula::graph::Graph;
use crate::jit::kernel::KernelPlan;
use crate::jit::lanes::{Line, PixelLine, PixelPlanes, Splat, Streams, Sums};
use crate::jit::target::{CompileError, Listing, target};
use crate::segment::Segment;

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

/// A kernel and what it reads.
#[derive(Clone, Copy)]
pub struct Call<'c> {
    /// The kernel.
    pub kernel: &'c Kernel,
    /// Its columns.
    pub streams: Streams<'c>,
    /// Its uniform values.
    pub uniforms: &'c [Splat],
}

/// Runs kernels: there is none.
pub fn run_in_turn(_calls: &[Call], _outputs: &mut [&mut [Line]], _lines: usize) {}

/// Says that there is no compiled code for this processor.
pub(super) fn generate(
    _plans: &[KernelPlan],
    _graph: &Graph,
    _listing: Option<&mut Listing>,
) -> Result<Vec<Kernel>, CompileError> {
    let target = target()?;
    Err(CompileError::Processor(target.isa.name().to_owned()))
}

/// Has the processor fetch a list: not here.
pub fn fetch<T>(_: &[T]) {}

/// Code that adds to pixels and writes them: there is none.
pub enum PixelCode {}

impl PixelCode {
    /// The code: none.
    pub fn get() -> Option<&'static PixelCode> {
        None
    }

    /// Adds.
    pub fn add(&self, _: &[Segment], _: &Sums, _: f32, _: Option<usize>, _: &mut PixelPlanes, _: &[Line]) -> usize {
        match *self {}
    }

    /// Writes.
    pub fn write(&self, _: &PixelPlanes, _: usize, _: &mut [PixelLine]) {
        match *self {}
    }
}
