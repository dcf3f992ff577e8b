//! The kernels that evaluate a formula.

use crate::formula::binding::{Bindings, Frontier};
use crate::formula::graph::{Graph, Node, NodeId};
use crate::formula::{Formula, Parameter};
use crate::lang::variables::Owner;
use crate::plan::kernel::{Domain, KernelPlan, Sink};
use crate::plan::surface::SurfacePlan;

/// The kernels that evaluate a formula, in the order in which they run.
#[derive(Debug, Clone)]
pub struct FormulaPlan {
    /// The graph that all nodes belong to, with its binding times.
    pub bindings: Bindings,
    /// Variables of hits → the hit frontier, once after tracing.
    pub hits: KernelPlan,
    /// Variables of lit records → the record frontier, once after tracing.
    pub records: KernelPlan,
    /// Red, green and blue of the contribution of each lit record, in every frame.
    pub contribution: ContributionPlan,
    /// What the formula gives at every hit, if it gives anything.
    pub surface: Option<SurfacePlan>,
    /// The uniform conditions by which the contribution chooses, if it does.
    pub conditions: Option<ConditionPlan>,
}

/// The uniform conditions by which a contribution chooses, see [`variants`](crate::formula::variants).
#[derive(Debug, Clone)]
pub struct ConditionPlan {
    /// The graph that the numbers belong to.
    pub bindings: Bindings,
    /// The conditions, nodes of the graph of the formula's plan.
    pub conditions: Vec<NodeId>,
    /// Parameters of pairs of a body and a light → 1 where each condition holds, else 0.
    pub numbers: KernelPlan,
    formula: Formula,
}

impl ConditionPlan {
    fn new(formula: &Formula, bindings: &Bindings) -> Option<Self> {
        let conditions = bindings.uniform_conditions();
        if conditions.is_empty() {
            return None;
        }
        let mut bindings = bindings.clone();
        let numbers = bindings.condition_numbers(&conditions);
        let numbers = KernelPlan::stage("conditions", Domain::Pairs, bindings.leaves(&numbers), numbers);
        Some(Self { bindings, conditions, numbers, formula: formula.clone() })
    }

    /// The contribution where these conditions hold, a bit for each, with the graph that it belongs to.
    pub fn variant(&self, bindings: &Bindings, holds: u32) -> (Bindings, ContributionPlan) {
        let known: Vec<(NodeId, bool)> =
            self.conditions.iter().enumerate().map(|(index, condition)| (*condition, holds >> index & 1 == 1)).collect();
        let bindings = bindings.variant(&self.formula, &known);
        let outputs = bindings.contribution.to_vec();
        let contribution = ContributionPlan::new("variant", &bindings, outputs, &[], Sink::Sums);
        (bindings, contribution)
    }
}

/// The parameter numbers that a kernel of uniform values reads, in the order of its columns.
pub fn parameter_slots(plan: &KernelPlan, graph: &Graph, parameters: &[Parameter]) -> Vec<ParameterSlot> {
    let slot = |leaf: &NodeId| match graph.node(*leaf) {
        Node::Parameter(id, component) => {
            let parameter = &parameters[id.0 as usize];
            Some(ParameterSlot { owner: parameter.owner, slot: parameter.slot as usize + usize::from(component) })
        }
        Node::Constant(_) | Node::Variable(..) | Node::Apply(..) => None,
    };
    // Uniform values are computed from parameters alone.
    plan.streams[0].iter().filter_map(slot).collect()
}

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

impl FormulaPlan {
    /// Plans the evaluation of a formula.
    pub fn new(formula: &Formula) -> Self {
        let bindings = Bindings::new(formula);
        let conditions = ConditionPlan::new(formula, &bindings);
        Self { conditions, ..Self::of(bindings, SurfacePlan::new(formula)) }
    }

    /// Plans the evaluation of an analysed formula.
    pub fn of(bindings: Bindings, surface: Option<SurfacePlan>) -> Self {
        let Frontier { hits, records, .. } = bindings.frontier.clone();
        let stage = |name, domain, nodes: Vec<NodeId>| KernelPlan::stage(name, domain, bindings.leaves(&nodes), nodes);
        let (hits, records) = (stage("hits", Domain::Hits, hits), stage("records", Domain::LitRecords, records));
        let outputs = bindings.contribution.to_vec();
        let contribution = ContributionPlan::new("contributions", &bindings, outputs, &[], Sink::Sums);
        Self { bindings, hits, records, contribution, surface, conditions: None }
    }

    /// Whether both compute the same.
    pub fn computes_the_same(&self, other: &FormulaPlan) -> bool {
        let surfaces = match (&self.surface, &other.surface) {
            (Some(one), Some(other)) => one.computes_the_same(other),
            (None, None) => true,
            (Some(_), None) | (None, Some(_)) => false,
        };
        surfaces && self.bindings.computes_the_same(&other.bindings)
    }
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
