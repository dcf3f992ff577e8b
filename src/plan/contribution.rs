//! How outputs are computed in a frame: first uniform values from parameters, then records from columns and uniform
//! values.

use crate::formula::Parameter;
use crate::formula::binding::{Bindings, Frontier};
use crate::formula::graph::{Graph, Node, NodeId};
use crate::lang::variables::Owner;
use crate::plan::kernel::{Domain, KernelPlan, Sink};

/// How outputs are computed from columns and parameters in a frame: first uniform values, then records.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ContributionPlan {
    /// Parameters of pairs of a body and a light → uniform values. Its records are the pairs, and its first stream
    /// holds the parameters.
    pub uniforms: KernelPlan,
    /// Columns of the hit frontier, of the record frontier and of a drag, and uniform values → outputs.
    pub records: KernelPlan,
}

/// A number among the parameters of an owner of some kind.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct ParameterSlot {
    /// The kind of owner.
    pub owner: Owner,
    /// The slot in the row of the owner, see [`Layout`](crate::formula::layout::Layout).
    pub slot: usize,
}

/// The parameter numbers that a kernel reads from its first stream, in the order of the columns.
pub fn parameter_slots(plan: &KernelPlan, graph: &Graph, parameters: &[Parameter]) -> Vec<ParameterSlot> {
    let slot = |leaf: &NodeId| match graph.node(*leaf) {
        Node::Parameter(id, component) => {
            let parameter = &parameters[id.0 as usize];
            Some(ParameterSlot { owner: parameter.owner, slot: parameter.slot as usize + usize::from(component) })
        }
        Node::Constant(_) | Node::Variable(..) | Node::Apply(..) => None,
    };
    plan.streams[0].iter().filter_map(slot).collect()
}

impl ContributionPlan {
    /// Plans the computation of `outputs`; `stored` are dynamic nodes that are read from columns of a drag.
    pub(super) fn new(name: &'static str, bindings: &Bindings, outputs: Vec<NodeId>, stored: &[NodeId], sink: Sink) -> Self {
        let Frontier { uniforms, .. } = bindings.frontier_of(&outputs, stored);
        let leaves = bindings.leaves(&uniforms);
        let records = KernelPlan {
            name,
            domain: Domain::LitRecords,
            streams: [bindings.frontier.hits.clone(), bindings.frontier.records.clone(), stored.to_vec()],
            uniforms: uniforms.clone(),
            outputs,
            sink,
        };
        Self { uniforms: KernelPlan::stage("uniforms", Domain::Pairs, leaves, uniforms), records }
    }

    /// The parameter numbers that the uniform values are computed from, in the order of the columns of their kernel.
    /// `graph` is the graph of the plan.
    pub fn leaves(&self, graph: &Graph, parameters: &[Parameter]) -> Vec<ParameterSlot> {
        parameter_slots(&self.uniforms, graph, parameters)
    }
}
