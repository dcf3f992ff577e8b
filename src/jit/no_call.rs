//! In place of the room of calls where kernels cannot run: the same items, and no kernel.

use crate::formula::graph::Graph;
use crate::jit::kernel::KernelPlan;
use crate::jit::lanes::Lanes;
use crate::jit::target::{CompileError, Listing, target};

/// A compiled kernel: there is none.
#[derive(Clone)]
pub enum Kernel {}

impl Kernel {
    /// How many outputs it has.
    pub fn outputs(&self) -> usize {
        match *self {}
    }

    /// Runs the kernel.
    pub fn run(&self, _columns: &[&[Lanes]], _uniforms: &[Lanes], _outputs: &mut [&mut [Lanes]], _blocks: usize) {
        match *self {}
    }
}

/// Says that there is no compiled code for this processor.
pub(super) fn generate(
    _plans: &[KernelPlan],
    _graph: &Graph,
    _listing: Option<&mut Listing>,
) -> Result<Vec<Kernel>, CompileError> {
    let (isa, _) = target()?;
    Err(CompileError::Processor(isa.name().to_owned()))
}
