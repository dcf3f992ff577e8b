//! In place of the room of calls where kernels cannot run: the same items, and no kernel.

use crate::formula::graph::Graph;
use crate::jit::kernel::KernelPlan;
use crate::jit::lanes::{Line, PixelLine, PixelPlanes, Splat, Streams, Sums};
use crate::jit::target::{CompileError, Listing, target};
use crate::segment::Segment;
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
pub struct Program<'p> {
    sums: &'p mut Sums,
    planes: &'p mut PixelPlanes,
}

/// Room for the steps of a program.
#[derive(Default)]
pub struct Steps;

/// Where the weights of a chunk are kept.
#[derive(Debug, Clone, Copy)]
pub struct Weights;

impl<'p> Program<'p> {
    /// An empty one.
    pub fn new(_: &'p mut Steps, sums: &'p mut Sums, planes: &'p mut PixelPlanes) -> Self {
        Self { sums, planes }
    }

    /// Runs a kernel.
    pub fn contribute(&mut self, kernel: &'p Kernel, _: Streams<'p>, _: &'p [Splat], _: Range<usize>, _: Range<usize>) {
        match *kernel {}
    }

    /// Keeps no weights.
    pub fn weigh(&mut self, _: impl ExactSizeIterator<Item = f32>) -> Weights {
        Weights
    }

    /// Does not add.
    pub fn add(&mut self, _: &'p [Segment], _: Weights, _: Option<usize>, _: &[Line]) -> bool {
        false
    }

    /// The sums and pixels.
    pub fn run(&mut self) -> (&mut Sums, &mut PixelPlanes) {
        (self.sums, self.planes)
    }
}

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

    /// Writes.
    pub fn write(&self, _: &PixelPlanes, _: usize, _: &mut [PixelLine]) {
        match *self {}
    }
}
