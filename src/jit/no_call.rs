//! In place of the room of calls where kernels cannot run: the same items, and no kernel.

use crate::formula::graph::Graph;
use crate::jit::kernel::KernelPlan;
use crate::jit::lanes::{Lanes, PixelLine, PixelPlanes, Splat, Sums};
use crate::jit::target::{CompileError, Listing, target};
use crate::segment::Segment;

/// A compiled kernel: there is none.
#[derive(Clone)]
pub enum Kernel {}

impl Kernel {
    /// How many outputs it has.
    pub fn outputs(&self) -> usize {
        match *self {}
    }

    /// How many blocks it reads and writes where so many are wanted.
    pub fn whole_rounds(&self, _blocks: usize) -> usize {
        match *self {}
    }

    /// Runs the kernel.
    pub fn run(&self, _columns: &[&[Lanes]], _uniforms: &[Splat], _outputs: &mut [&mut [Lanes]], _blocks: usize) {
        match *self {}
    }
}

/// A kernel and what it reads beside columns.
#[derive(Clone, Copy)]
pub struct Call<'c> {
    /// The kernel.
    pub kernel: &'c Kernel,
    /// Its uniform values.
    pub uniforms: &'c [Splat],
}

/// Runs kernels: there is none.
pub fn run_in_turn(_calls: &[Call], _columns: &[&[Lanes]], _outputs: &mut [&mut [Lanes]], _blocks: usize) {}

/// Says that there is no compiled code for this processor.
pub(super) fn generate(
    _plans: &[KernelPlan],
    _graph: &Graph,
    _listing: Option<&mut Listing>,
) -> Result<Vec<Kernel>, CompileError> {
    let target = target()?;
    Err(CompileError::Processor(target.isa.name().to_owned()))
}

/// Code that adds to pixels and writes them: there is none.
pub enum PixelCode {}

impl PixelCode {
    /// The code: none.
    pub fn get() -> Option<&'static PixelCode> {
        None
    }

    /// Adds.
    pub fn add(&self, _: &[Segment], _: &Sums, _: f32, _: Option<usize>, _: &mut PixelPlanes) {
        match *self {}
    }

    /// Writes.
    pub fn write(&self, _: &PixelPlanes, _: usize, _: &mut [PixelLine]) {
        match *self {}
    }
}
