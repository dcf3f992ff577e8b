//! The kernels that evaluate a formula.

use crate::formula::Formula;
use crate::formula::binding::{Bindings, Frontier};
use crate::formula::graph::NodeId;
use crate::plan::conditions::ConditionPlan;
use crate::plan::contribution::ContributionPlan;
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
