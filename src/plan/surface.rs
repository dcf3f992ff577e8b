//! The kernels for what a formula gives at every hit: the weights of rays, ambient light and emission.

use crate::formula::binding::{Bindings, SurfaceNodes};
use crate::formula::graph::{Node, NodeId};
use crate::formula::power::power;
use crate::formula::{Formula, ParameterId};
use crate::plan::contribution::ContributionPlan;
use crate::plan::kernel::{Domain, KernelPlan, Sink};

/// The kernels for what a formula gives at every hit, in the order in which they run.
#[derive(Debug, Clone)]
pub struct SurfacePlan {
    /// The graph that all nodes belong to, with its binding times.
    pub bindings: Bindings,
    /// The nodes of what is given.
    pub nodes: SurfaceNodes,
    /// Variables of hits → the hit frontier, once after tracing.
    pub hits: KernelPlan,
    /// Columns of the hit frontier and uniform values of a body → columns of what is given, in every frame.
    pub outputs: ContributionPlan,
}

impl SurfacePlan {
    /// Plans what the formula gives; `None` if it gives nothing.
    pub fn new(formula: &Formula) -> Option<Self> {
        let (bindings, nodes) = Bindings::surface(formula)?;
        let frontier = bindings.frontier.hits.clone();
        let hits = KernelPlan::stage("surface hits", Domain::Hits, bindings.leaves(&frontier), frontier);
        let mut outputs: Vec<NodeId> = nodes.own.into_iter().chain(nodes.weights.into_iter().flatten()).flatten().collect();
        outputs.sort_unstable();
        outputs.dedup();
        let outputs = ContributionPlan::new("surface", &bindings, outputs, &[], Sink::Columns);
        Some(Self { bindings, nodes, hits, outputs })
    }

    /// The columns of red, green and blue of these nodes among the outputs.
    pub fn columns(&self, nodes: [NodeId; 3]) -> [usize; 3] {
        nodes.map(|node| self.outputs.records.outputs.iter().position(|output| *output == node).unwrap_or(0))
    }

    /// Whether both compute the same.
    pub fn computes_the_same(&self, other: &SurfacePlan) -> bool {
        self.nodes == other.nodes && self.bindings.computes_the_same(&other.bindings)
    }

    /// Whether what is given at a hit, without the weights of rays, depends on one of these parameters.
    pub fn own_depends_on(&self, moved: &[ParameterId]) -> bool {
        self.nodes.own.is_some_and(|own| self.depends(&own, moved))
    }

    /// The power of a parameter in a weight, 0 (reflected) or 1 (refracted): the weight is that power of it, 0 or 1,
    /// times what does not depend on it. `None` if it depends on it in another way.
    pub fn power_in_weight(&self, weight: usize, parameter: ParameterId) -> Option<u32> {
        let Some(nodes) = self.nodes.weights[weight] else { return Some(0) };
        let powers = nodes.map(|node| power(&self.bindings.graph, node, |id| id == parameter));
        let [red, green, blue] = powers;
        (red == green && green == blue).then_some(red?).filter(|power| *power <= 1)
    }

    /// Whether a weight, 0 (reflected) or 1 (refracted), depends on one of these parameters.
    pub fn weight_depends_on(&self, weight: usize, moved: &[ParameterId]) -> bool {
        self.nodes.weights[weight].is_some_and(|nodes| self.depends(&nodes, moved))
    }

    fn depends(&self, nodes: &[NodeId], moved: &[ParameterId]) -> bool {
        let leaves = self.bindings.leaves(nodes);
        leaves.into_iter().any(|leaf| matches!(self.bindings.graph.node(leaf), Node::Parameter(id, _) if moved.contains(&id)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lang::source::Source;
    use crate::lang::variables::Predefined;

    #[test]
    fn the_powers_of_kr_and_kt_in_weights_are_known() {
        let powers = |weights: &str| {
            let text =
                format!("formula; F0 = ((1-eta)/(1+eta))^2; F = if(total, 1, F0 + (1-F0)*(1-max(0,N.V))^5); {weights} = Cd;");
            let (formula, _) = Formula::parse(&Source::new("test", text)).expect("a formula");
            let plan = SurfacePlan::new(&formula).expect("weights");
            let [kr, kt] = [Predefined::Reflection, Predefined::Refraction].map(|one| formula.predefined(one));
            [plan.power_in_weight(0, kr), plan.power_in_weight(1, kr), plan.power_in_weight(1, kt)]
        };
        assert_eq!(powers("reflected = kr*F; refracted = kt*(1-F);"), [Some(1), Some(0), Some(1)]);
        assert_eq!(powers("reflected = Cd*kr*F; refracted = (1-F)*(1-kr);"), [Some(1), None, Some(0)]);
        assert_eq!(powers("reflected = F;"), [Some(0), Some(0), Some(0)]);
        assert_eq!(powers("reflected = if(total, kr, kr*F)/2; refracted = kt^2;"), [Some(1), Some(0), None]);
    }
}
