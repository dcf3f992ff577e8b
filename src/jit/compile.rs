//! The kernels of a formula: which there are.

use crate::formula::Formula;
use crate::formula::binding::Bindings;
use crate::formula::graph::NodeId;
use crate::jit::call::{Kernel, generate};
use crate::jit::kernel::KernelPlan;
use crate::jit::target::{CompileError, Listing};

/// How many blocks of four records the contribution kernel computes side by side. Four hide most of the latency of a
/// polynomial's chain of multiplications.
const INTERLEAVE: usize = 4;

/// A formula's kernels, with the nodes that their columns stand for.
pub struct CompiledFormula {
    /// The graph and its binding times.
    pub bindings: Bindings,
    /// The variables that [`hit_kernel`](Self::hit_kernel) reads, in the order of its columns.
    pub hit_leaves: Vec<NodeId>,
    /// The variables that [`record_kernel`](Self::record_kernel) reads, in the order of its columns.
    pub record_leaves: Vec<NodeId>,
    /// The parameters that [`uniform_kernel`](Self::uniform_kernel) reads, in the order of its columns.
    pub uniform_leaves: Vec<NodeId>,
    /// Variables of hits → the hit frontier.
    pub hit_kernel: Kernel,
    /// Variables of lit records → the record frontier.
    pub record_kernel: Kernel,
    /// Parameters of (body, light) pairs → uniform values.
    pub uniform_kernel: Kernel,
    /// Hit frontier, record frontier; uniforms → red, green, blue, added to.
    pub contribution_kernel: Kernel,
}

impl CompiledFormula {
    /// Compiles a formula.
    ///
    /// # Errors
    /// The processor is not supported, or the formula is beyond what the code generator takes.
    pub fn new(formula: &Formula) -> Result<Self, CompileError> {
        Self::compile(formula, None)
    }

    /// Compiles a formula and lists the stages.
    ///
    /// # Errors
    /// The processor is not supported, or the formula is beyond what the code generator takes.
    pub fn listing(formula: &Formula) -> Result<Listing, CompileError> {
        let mut listing = Listing::default();
        Self::compile(formula, Some(&mut listing))?;
        Ok(listing)
    }

    fn compile(formula: &Formula, listing: Option<&mut Listing>) -> Result<Self, CompileError> {
        let bindings = Bindings::new(formula);
        let hit_leaves = bindings.leaves(&bindings.hit_frontier);
        let record_leaves = bindings.leaves(&bindings.record_frontier);
        let uniform_leaves = bindings.leaves(&bindings.uniforms);
        let stage = |name, columns: &[NodeId], outputs: &[NodeId]| KernelPlan {
            name,
            columns: columns.to_vec(),
            uniforms: Vec::new(),
            outputs: outputs.to_vec(),
            accumulate: false,
            interleave: 1,
        };
        let plans = [
            stage("hits", &hit_leaves, &bindings.hit_frontier),
            stage("records", &record_leaves, &bindings.record_frontier),
            stage("uniforms", &uniform_leaves, &bindings.uniforms),
            KernelPlan {
                name: "contributions",
                columns: [bindings.hit_frontier.as_slice(), &bindings.record_frontier].concat(),
                uniforms: bindings.uniforms.clone(),
                outputs: bindings.contribution.to_vec(),
                accumulate: true,
                interleave: INTERLEAVE,
            },
        ];
        let [hit_kernel, record_kernel, uniform_kernel, contribution_kernel] = generate(&plans, &bindings.graph, listing)?;
        Ok(Self {
            bindings,
            hit_leaves,
            record_leaves,
            uniform_leaves,
            hit_kernel,
            record_kernel,
            uniform_kernel,
            contribution_kernel,
        })
    }
}
