//! The kernels for what a formula gives at every hit: the weights of rays, ambient light and emission.

use crate::formula::binding::{Bindings, SurfaceNodes};
use crate::formula::graph::{Node, NodeId};
use crate::formula::power::{degree, power};
use crate::formula::separation::{Dependence, Separation};
use crate::formula::{Formula, ParameterId};
use crate::plan::contribution::ContributionPlan;
use crate::plan::kernel::{Domain, KernelPlan, Sink};
use crate::plan::slider::Moved;

/// How what a formula gives at every hit, without the weights of rays, depends on moved numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum OwnDependence {
    /// Not at all.
    None,
    /// Each component is one of the moved numbers times what does not move, plus what does not move. `None` for a
    /// component that does not move.
    Linear([Option<(ParameterId, u8)>; 3]),
    /// In another way.
    Other,
}

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

    /// What is given at every hit, without the weights of rays, if it is the same for all hits and all numbers.
    pub fn constant_own(&self) -> Option<[f32; 3]> {
        let numbers = self.nodes.own?.map(|node| self.bindings.graph.constant(node));
        numbers.iter().all(Option::is_some).then(|| numbers.map(Option::unwrap_or_default))
    }

    /// Whether both compute the same.
    pub fn computes_the_same(&self, other: &SurfacePlan) -> bool {
        self.nodes == other.nodes && self.bindings.computes_the_same(&other.bindings)
    }

    /// How what is given at a hit, without the weights of rays, depends on moved components of parameters.
    pub fn own_dependence(&self, moved: &Moved) -> OwnDependence {
        // The contribution of these bindings is what is given.
        let Separation { bindings, dependence, .. } = Separation::new(&self.bindings, moved);
        let terms = match dependence {
            _ if self.nodes.own.is_none() => return OwnDependence::None,
            Dependence::None => return OwnDependence::None,
            Dependence::Inseparable { .. } => return OwnDependence::Other,
            Dependence::Separable(terms) => terms,
        };
        // A factor may be such as 1 - 2·q.
        let number = |factor: NodeId| match bindings.leaves(&[factor])[..] {
            [leaf] if degree(&bindings.graph, factor) == Some(1) => match bindings.graph.node(leaf) {
                Node::Parameter(id, component) => Some((id, component)),
                Node::Constant(_) | Node::Variable(..) | Node::Apply(..) => None,
            },
            _ => None,
        };
        let mut numbers = [None; 3];
        for (component, factor) in terms.iter().flat_map(|term| term.factors.into_iter().enumerate()) {
            let Some(factor) = factor else { continue };
            match (number(factor), &mut numbers[component]) {
                (None, _) => return OwnDependence::Other,
                (found, known @ None) => *known = found,
                (found, known) if found == *known => {}
                (Some(_), Some(_)) => return OwnDependence::Other,
            }
        }
        OwnDependence::Linear(numbers)
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
    #[test]
    fn it_is_known_what_is_linear_in_moved_numbers() {
        let of = |terms: &str, name: &str, components: &[u8]| {
            let text = format!("body_specific; kd: scalar; q: scalar; formula; {terms} = Cd;");
            let (formula, _) = Formula::parse(&Source::new("test", text)).expect("a formula");
            let id = formula.parameter_named(name).expect("a parameter");
            let moved: Vec<(ParameterId, u8)> = components.iter().map(|component| (id, *component)).collect();
            (SurfacePlan::new(&formula).expect("terms").own_dependence(&moved), id)
        };
        let ambient = "ambient = ka*kd*Cd*Ia; emission = <0, q, 1>*max(0, N.V);";
        let (found, kd) = of(ambient, "kd", &[0]);
        assert_eq!(found, OwnDependence::Linear([Some((kd, 0)); 3]));
        let (found, colour) = of(ambient, "Cd", &[0, 1, 2]);
        assert_eq!(found, OwnDependence::Linear([0, 1, 2].map(|component| Some((colour, component)))));
        let (found, colour) = of(ambient, "Cd", &[1]);
        assert_eq!(found, OwnDependence::Linear([None, Some((colour, 1)), None]));
        let (found, q) = of(ambient, "q", &[0]);
        assert_eq!(found, OwnDependence::Linear([None, Some((q, 0)), None]));
        assert_eq!(of(ambient, "kr", &[0]).0, OwnDependence::None);
        assert_eq!(of("reflected = kr*q;", "q", &[0]).0, OwnDependence::None);
        let (found, q) = of("emission = q*N - 2*q*Cd;", "q", &[0]);
        assert_eq!(found, OwnDependence::Linear([Some((q, 0)); 3]));
        for linear in ["<1 - q>*N", "(3 - q/2)*N.V*Cd + q*<2>", "<2*(5 - 3*q)>"] {
            let (found, q) = of(&format!("emission = {linear};"), "q", &[0]);
            assert_eq!(found, OwnDependence::Linear([Some((q, 0)); 3]), "{linear}");
        }
        for other in ["q^2*Cd", "<1/q>", "sin(q)*Cd", "q*Cd*max(0, q - N.V)"] {
            assert_eq!(of(&format!("emission = {other};"), "q", &[0]).0, OwnDependence::Other, "{other}");
        }
        assert_eq!(of("ambient = Cd*Cd;", "Cd", &[0, 1, 2]).0, OwnDependence::Other);
    }
}
