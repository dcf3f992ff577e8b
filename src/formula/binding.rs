//! Binding times of a formula's graph: which values are computed when, and which are stored.
//!
//! The static and uniform values that dynamic code reads are the *frontier*. Its static values are stored (Guenter,
//! Knoblock, Ruf 1995, "Specializing Shaders").

use crate::formula::binding_time::BindingTime;
use crate::formula::equation::{EquationTerm, Site};
use crate::formula::graph::{Graph, Node, NodeId};
use crate::formula::rewrite::rewrite;
use crate::formula::{Formula, ParameterId, TermId};
use crate::lang::scalars::{Primitive, Recorder};
use crate::lang::surface_terms::SurfaceTerm;
use crate::lang::variables::Rate;

/// The nodes that dynamic code reads, each once, in order.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Frontier {
    /// Static values of a hit.
    pub hits: Vec<NodeId>,
    /// Static values of a lit record.
    pub records: Vec<NodeId>,
    /// Uniform values.
    pub uniforms: Vec<NodeId>,
}

/// What a formula gives at every hit: red, green and blue of each, as nodes of a graph.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SurfaceNodes {
    /// What the hit adds whatever the lights: ambient light and emission.
    pub own: Option<[NodeId; 3]>,
    /// The weights of the reflected and of the refracted ray.
    pub weights: [Option<[NodeId; 3]>; 2],
}

/// A formula's graph with the binding time of every node.
#[derive(Debug, Clone)]
pub struct Bindings {
    /// The graph.
    pub graph: Graph,
    /// What a lit record adds to red, green and blue of its pixel, before the weight of its path: `ki` times the
    /// formula.
    pub contribution: [NodeId; 3],
    /// The nodes that the contribution reads.
    pub frontier: Frontier,
    times: Vec<BindingTime>,
}

impl Bindings {
    /// Rewrites and analyses the contribution of a lit record.
    pub fn new(formula: &Formula) -> Self {
        let mut graph = Graph::new(formula);
        let mut contribution = graph.result();
        for weight in EquationTerm::at(Site::LitRecord).filter_map(|term| term.weight) {
            let weight = graph.parameter(formula.predefined(weight), 0);
            contribution = contribution.map(|component| graph.record(Primitive::Mul, &[weight, component]));
        }
        let (graph, roots) = rewrite(&graph, &contribution, formula);
        Self::analysed(graph, &roots)
    }

    /// Rewrites and analyses what the formula gives at every hit; `None` if it gives nothing. The contribution is that
    /// of a hit, whatever the lights: ambient light and emission.
    pub fn surface(formula: &Formula) -> Option<(Self, SurfaceNodes)> {
        if formula.surface.is_empty() {
            return None;
        }
        let given: Vec<(SurfaceTerm, TermId)> = formula.surface.iter().collect();
        let roots: Vec<TermId> = given.iter().map(|(_, id)| *id).collect();
        let (mut graph, nodes) = Graph::of(formula, &roots);
        let of = |term: SurfaceTerm| given.iter().position(|(known, _)| *known == term).map(|index| nodes[index]);
        let own = match (of(SurfaceTerm::Ambient), of(SurfaceTerm::Emission)) {
            (Some(ambient), Some(emission)) => {
                Some(std::array::from_fn(|component| graph.record(Primitive::Add, &[ambient[component], emission[component]])))
            }
            (one, other) => one.or(other),
        };
        let zero = graph.record_constant(0.0);
        let weights = [SurfaceTerm::Reflected, SurfaceTerm::Refracted].map(of);
        let all = [own, weights[0], weights[1]];
        let roots: Vec<NodeId> = all.into_iter().flat_map(|nodes| nodes.unwrap_or([zero; 3])).collect();
        let (graph, roots) = rewrite(&graph, &roots, formula);
        let node = |term: usize| all[term].map(|_| [roots[3 * term], roots[3 * term + 1], roots[3 * term + 2]]);
        let nodes = SurfaceNodes { own: node(0), weights: [node(1), node(2)] };
        Some((Self::analysed(graph, &roots), nodes))
    }

    /// Analyses a graph. The first three roots are the contribution, and all roots are read.
    pub(super) fn analysed(graph: Graph, roots: &[NodeId]) -> Self {
        let mut times: Vec<BindingTime> = Vec::with_capacity(graph.len());
        for index in 0..graph.len() {
            times.push(BindingTime::of(&graph, NodeId(index as u32), &times));
        }
        let contribution = [roots[0], roots[1], roots[2]];
        let mut bindings = Bindings { graph, contribution, frontier: Frontier::default(), times };
        bindings.frontier = bindings.frontier_of(roots, &[]);
        bindings
    }

    /// Whether both have the same graph and the same contribution.
    pub fn computes_the_same(&self, other: &Bindings) -> bool {
        self.contribution == other.contribution && self.graph.has_the_nodes_of(&other.graph)
    }

    /// The node of a primitive on nodes of the graph, added if it is new.
    pub fn record(&mut self, primitive: Primitive, operands: &[NodeId]) -> NodeId {
        let id = self.graph.record(primitive, operands);
        self.analyse_new_nodes();
        id
    }

    /// The node of a number, added if it is new.
    pub fn constant(&mut self, value: f32) -> NodeId {
        let id = self.graph.record_constant(value);
        self.analyse_new_nodes();
        id
    }

    /// The node of a component of a parameter, added if it is new.
    pub fn parameter(&mut self, parameter: ParameterId, component: u8) -> NodeId {
        let id = self.graph.parameter(parameter, component);
        self.analyse_new_nodes();
        id
    }

    fn analyse_new_nodes(&mut self) {
        for index in self.times.len()..self.graph.len() {
            self.times.push(BindingTime::of(&self.graph, NodeId(index as u32), &self.times));
        }
    }

    /// The nodes that code for `roots` reads. The dynamic nodes in `stored` are read from columns of their own and left
    /// out here.
    pub fn frontier_of(&self, roots: &[NodeId], stored: &[NodeId]) -> Frontier {
        let mut frontier = Frontier::default();
        let mut seen = vec![false; self.graph.len()];
        stored.iter().for_each(|id| seen[id.0 as usize] = true);
        let mut pending = roots.to_vec();
        while let Some(id) = pending.pop() {
            if std::mem::replace(&mut seen[id.0 as usize], true) {
                continue;
            }
            match self.time(id) {
                BindingTime::Constant => {}
                BindingTime::Static(_) if self.is_simple_comparison(id) => {
                    pending.extend_from_slice(self.graph.node(id).operands())
                }
                BindingTime::Static(Rate::Hit) => frontier.hits.push(id),
                BindingTime::Static(Rate::Record) => frontier.records.push(id),
                BindingTime::Uniform => frontier.uniforms.push(id),
                BindingTime::Dynamic => pending.extend_from_slice(self.graph.node(id).operands()),
            }
        }
        frontier.hits.sort_unstable();
        frontier.records.sort_unstable();
        frontier.uniforms.sort_unstable();
        frontier
    }

    /// Whether a node compares something with a constant. It is cheaper to compare again than to store the result. With
    /// several comparisons of one value, only the value is stored.
    fn is_simple_comparison(&self, id: NodeId) -> bool {
        match self.graph.node(id) {
            Node::Apply(Primitive::Less | Primitive::LessEqual | Primitive::Equal, operands) => {
                operands[..2].iter().any(|operand| self.time(*operand) == BindingTime::Constant)
            }
            Node::Apply(..) | Node::Constant(_) | Node::Variable(..) | Node::Parameter(..) => false,
        }
    }

    /// When the value of a node is known.
    pub fn time(&self, id: NodeId) -> BindingTime {
        self.times[id.0 as usize]
    }

    /// The variables and parameters that `roots` are computed from, each once, in the order of their nodes.
    pub fn leaves(&self, roots: &[NodeId]) -> Vec<NodeId> {
        let mut seen = vec![false; self.graph.len()];
        let mut pending = roots.to_vec();
        let mut leaves = Vec::new();
        while let Some(id) = pending.pop() {
            if std::mem::replace(&mut seen[id.0 as usize], true) {
                continue;
            }
            match self.graph.node(id) {
                Node::Constant(_) => {}
                Node::Variable(..) | Node::Parameter(..) => leaves.push(id),
                node @ Node::Apply(..) => pending.extend_from_slice(node.operands()),
            }
        }
        leaves.sort_unstable();
        leaves
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lang::source::Source;

    fn bindings(text: &str) -> Bindings {
        let (formula, _) = Formula::parse(&Source::new("test", text)).expect("a formula");
        Bindings::new(&formula)
    }

    #[test]
    fn phong_reads_two_numbers_of_a_record() {
        let phong = bindings(
            "body_specific; kd: scalar, constraint 0..1; ks: scalar, constraint 0..1; h: scalar, constraint 0..500; formula;
             = kd*IL*Cd*max(0, N.L) + ks*IL*pow(max(0, R.V), h);",
        );
        assert_eq!(phong.frontier.records.len(), 2);
        assert_eq!(phong.frontier.hits.len(), 0);
        // The uniform values are the colours of the two terms, with ki, and the exponent. Everything that can be
        // multiplied once a frame is.
        assert_eq!(phong.frontier.uniforms.len(), 7);
        let called = |primitive| {
            (0..phong.graph.len() as u32).any(|id| matches!(phong.graph.node(NodeId(id)), Node::Apply(p, _) if p == primitive))
        };
        assert!(called(Primitive::Exp2) && !called(Primitive::Pow));
    }

    #[test]
    fn a_power_of_unknown_sign_reads_the_class_of_its_base_too() {
        let open = bindings("body_specific; h: scalar; formula; = Cd*pow(N.V, h);");
        assert_eq!(open.frontier.hits.len(), 2);
        // The base may be NaN: the power stays.
        let wild = bindings("body_specific; h: scalar; formula; = Cd*pow(sqrt(N.V), h);");
        assert_eq!(wild.frontier.hits.len(), 1);
    }

    #[test]
    fn products_are_regrouped_by_binding_time() {
        let chain =
            bindings("body_specific; a: scalar, constraint 0..1; b: scalar, constraint 0..1; formula; = Cd*(a*alpha*b*(N.V));");
        assert_eq!((chain.frontier.records.len(), chain.frontier.uniforms.len()), (1, 3));
    }

    #[test]
    fn sums_of_colours_are_multiplied_out() {
        // A highlight whose colour turns metallic, with a bounded and an unbounded exponent. With an unbounded one, a
        // cosine slightly above 1 by rounding would have infinite powers.
        for exponent in ["1 + 99*s", "3/(1 - s)"] {
            let metal = bindings(&format!(
                "body_specific; s: scalar, constraint 0..1; m: scalar, constraint 0..1; formula; white = <1, 1, 1>;
                 = IL*pow(max(0, R.V), {exponent})*(white + m*(1 - max(0, N.L))*(Cd - white));"
            ));
            // The colours of the highlight and of its part with the cosine, and the exponent.
            assert_eq!((metal.frontier.records.len(), metal.frontier.uniforms.len()), (2, 7), "{exponent}");
        }
        // The power of a base that can exceed 1 by more than rounding can be infinite: it stays a factor of the whole.
        let wild =
            bindings("body_specific; s: scalar, constraint 0..1; formula; = IL*pow(2*max(0, R.V), 3/(1 - s))*(Cd + (N.L)*Cd*s);");
        assert_eq!(
            wild.contribution.iter().filter(|root| matches!(wild.graph.node(**root), Node::Apply(Primitive::Add, _))).count(),
            0
        );
    }

    #[test]
    fn what_depends_on_the_hit_alone_is_stored_once_a_hit() {
        let marbled = bindings("formula; = perlin(point, 2, 2, 4)*Cd*(N.L);");
        assert_eq!((marbled.frontier.hits.len(), marbled.frontier.records.len()), (1, 1));
    }

    #[test]
    fn textures_at_static_coordinates_are_looked_up_once() {
        let declared = "body_specific; wood: texture; s: scalar; light_specific; slide: texture; formula;";
        let counts = |text: &str| {
            let Frontier { hits, records, uniforms } = bindings(&format!("{declared} {text}")).frontier;
            (hits.len(), records.len(), uniforms.len())
        };
        // Red, green and blue of the texture.
        assert_eq!(counts("= wood(u, 3*v)*(N.L);"), (0, 3, 1), "the cosine is multiplied in");
        assert_eq!(counts("= s*wood(u, 3*v);"), (3, 0, 2));
        // That of a light differs from light to light.
        assert_eq!(counts("= s*slide(u, v);"), (0, 3, 2));
        // The coordinates move with a slider: u, v, the number of the texture, s, and ki.
        assert_eq!(counts("= wood(s*u, v);"), (2, 0, 3));
        assert_eq!(counts("= wood(s, 0.5)*alpha;").0, 0, "one colour for a body");
    }

    #[test]
    fn uniform_parts_are_computed_outside_the_loop() {
        let uniform = bindings("body_specific; s: scalar; formula; = Cd*(1 - s^3)*(N.L);");
        // The three components of Cd·(1 − s³), and ki.
        assert_eq!(uniform.frontier.uniforms.len(), 4);
    }
}
