//! The uniform conditions by which a contribution chooses, and the contributions where they are known.

use crate::formula::Formula;
use crate::formula::binding::Bindings;
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
