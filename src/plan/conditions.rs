//! The uniform conditions by which a contribution chooses, and the contributions where they are known.

use crate::formula::Formula;
use crate::formula::binding::{Bindings, Frontier};
use crate::formula::graph::NodeId;
use crate::plan::contribution::ContributionPlan;
use crate::plan::kernel::{Domain, KernelPlan, Sink};

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
    pub(super) fn new(formula: &Formula, bindings: &Bindings) -> Option<Self> {
        let conditions = bindings.uniform_conditions();
        if conditions.is_empty() {
            return None;
        }
        let mut bindings = bindings.clone();
        let numbers = bindings.condition_numbers(&conditions);
        let numbers = KernelPlan::stage("conditions", Domain::Pairs, bindings.leaves(&numbers), numbers);
        Some(Self { bindings, conditions, numbers, formula: formula.clone() })
    }

    /// The kernels where these conditions hold, a bit for each.
    pub fn variant(&self, bindings: &Bindings, holds: u32) -> VariantPlan {
        let known: Vec<(NodeId, bool)> =
            self.conditions.iter().enumerate().map(|(index, condition)| (*condition, holds >> index & 1 == 1)).collect();
        let (bindings, given) = bindings.variant(&self.formula, &known);
        let outputs = bindings.contribution.to_vec();
        let contribution = ContributionPlan::new("variant", &bindings, outputs, &[], Sink::Sums);
        let Frontier { hits, records, .. } = bindings.frontier.clone();
        let hits = KernelPlan::stage("hits of a variant", Domain::Hits, given.hits.clone(), hits);
        let mut records = KernelPlan::stage("records of a variant", Domain::LitRecords, given.hits, records);
        records.streams[1] = given.records;
        VariantPlan { bindings, hits, records, contribution }
    }
}

/// The kernels that evaluate a formula where its uniform conditions are known.
#[derive(Debug, Clone)]
pub struct VariantPlan {
    /// The graph that all nodes belong to, with its binding times. Its frontier is what the variant reads.
    pub bindings: Bindings,
    /// Columns of the hit frontier of all branches → the hit frontier of the variant.
    pub hits: KernelPlan,
    /// Columns of the frontiers of all branches → the record frontier of the variant.
    pub records: KernelPlan,
    /// Red, green and blue of the contribution of each lit record.
    pub contribution: ContributionPlan,
}
