//! How a contribution depends on the parameters that a dragged slider moves.
//!
//! While a slider is dragged, a few numbers *move* and all others are *fixed*. A contribution is *separable* if the
//! graph proves that it is a sum Σ factor · part, where factors depend on moved numbers only and parts on fixed ones
//! only. Then the sum of each part over all hits is an image that can be stored, and a frame is a weighted sum of
//! images. Any other contribution is split into a fixed part and a *moving* part, which must be computed again.
//! Expensive fixed sub-expressions of the moving part can be stored for each record.

use crate::formula::ParameterId;
use crate::formula::binding::Bindings;
use crate::formula::binding_time::BindingTime;
use crate::formula::graph::{Graph, Node, NodeId, walk};
use crate::formula::linear::{Common, LinearForm, Product};
use crate::lang::scalars::Primitive;
use std::collections::{HashMap, HashSet};

/// With more terms than this, images are no faster than computing the contribution again.
const MOST_TERMS: usize = 6;
/// A sub-expression of at least this cost is stored instead of computed again. It is about the cost of loading it, in
/// simple instructions.
const WORTH_STORING: u32 = 12;

/// A term of a separable contribution, for red, green and blue: a moved factor and a fixed part. A part that is missing
/// is 1.
#[derive(Debug, Clone, PartialEq)]
pub struct SeparableTerm {
    /// The factors, which depend on moved numbers and constants. `None` if the component has no such term.
    pub factors: [Option<NodeId>; 3],
    /// The parts, which depend on fixed numbers.
    pub parts: [Option<NodeId>; 3],
}

/// How a contribution depends on the moved numbers.
#[derive(Debug, Clone, PartialEq)]
pub enum Dependence {
    /// Not at all.
    None,
    /// As a fixed part plus a sum of terms.
    Separable(Vec<SeparableTerm>),
    /// In another way.
    Inseparable {
        /// The part that must be computed again in each frame, for the components that depend on moved numbers.
        moving: [Option<NodeId>; 3],
        /// Its fixed dynamic sub-expressions that are stored for each record.
        stored: Vec<NodeId>,
    },
}

/// A contribution, separated for a drag.
#[derive(Debug, Clone)]
pub struct Separation {
    /// The formula's graph, extended by the nodes below.
    pub bindings: Bindings,
    /// The fixed part of red, green and blue.
    pub fixed: [Option<NodeId>; 3],
    /// The part that depends on moved numbers.
    pub dependence: Dependence,
}

impl Separation {
    /// Separates the contribution for these moved components of parameters of one owner.
    pub fn new(bindings: &Bindings, moved: &[(ParameterId, u8)]) -> Self {
        let mut separator = Separator { bindings: bindings.clone(), moved: moved.to_vec(), mobilities: Vec::new() };
        separator.analyse_new_nodes();
        let contribution = bindings.contribution;
        if contribution.iter().all(|component| separator.is_fixed(*component)) {
            let fixed = contribution.map(Some);
            return Self { bindings: separator.bindings, fixed, dependence: Dependence::None };
        }
        match separator.separable(contribution) {
            Some((fixed, terms)) => Self { bindings: separator.bindings, fixed, dependence: Dependence::Separable(terms) },
            None => {
                let mut fixed = [None; 3];
                let mut moving = [None; 3];
                for (component, root) in contribution.into_iter().enumerate() {
                    (fixed[component], moving[component]) = separator.split(root);
                }
                let stored = separator.worth_storing(&moving);
                Self { bindings: separator.bindings, fixed, dependence: Dependence::Inseparable { moving, stored } }
            }
        }
    }
}

/// Whether a node moves: which numbers it depends on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Mobility {
    Constant,
    /// Fixed numbers only.
    Fixed,
    /// Moved numbers only.
    Moved,
    Mixed,
}

impl Mobility {
    fn join(self, other: Mobility) -> Mobility {
        match (self, other) {
            (Mobility::Constant, mobility) | (mobility, Mobility::Constant) => mobility,
            (one, other) if one == other => one,
            (Mobility::Fixed | Mobility::Moved | Mobility::Mixed, _) => Mobility::Mixed,
        }
    }
}

struct Separator {
    bindings: Bindings,
    moved: Vec<(ParameterId, u8)>,
    mobilities: Vec<Mobility>,
}

/// The fixed part of each component, and the terms.
type Separated = ([Option<NodeId>; 3], Vec<SeparableTerm>);

/// The fixed part and the moving part of a value, which is their sum.
type FixedAndMoving = (Option<NodeId>, Option<NodeId>);

impl Separator {
    fn analyse_new_nodes(&mut self) {
        for index in self.mobilities.len()..self.bindings.graph.len() {
            let node = self.bindings.graph.node(NodeId(index as u32));
            self.mobilities.push(match node {
                Node::Constant(_) => Mobility::Constant,
                Node::Variable(..) => Mobility::Fixed,
                Node::Parameter(id, component) if self.moved.contains(&(id, component)) => Mobility::Moved,
                Node::Parameter(..) => Mobility::Fixed,
                Node::Apply(..) => {
                    let operands = node.operands().iter().map(|operand| self.mobilities[operand.0 as usize]);
                    operands.fold(Mobility::Constant, Mobility::join)
                }
            });
        }
    }

    fn mobility(&self, id: NodeId) -> Mobility {
        self.mobilities[id.0 as usize]
    }

    fn is_fixed(&self, id: NodeId) -> bool {
        matches!(self.mobility(id), Mobility::Constant | Mobility::Fixed)
    }

    /// The components as sums of terms. `None` if a component is not such a sum, or there are too many terms.
    fn separable(&mut self, contribution: [NodeId; 3]) -> Option<Separated> {
        let mut fixed = [None; 3];
        let mut terms: Vec<SeparableTerm> = Vec::new();
        for (component, root) in contribution.into_iter().enumerate() {
            let mut index = 0;
            for product in self.sum_of_products(root)? {
                let Some(factor) = product.outer else {
                    let one = self.constant(1.0);
                    fixed[component] = Some(product.inner.unwrap_or(one));
                    continue;
                };
                if index == terms.len() {
                    terms.push(SeparableTerm { factors: [None; 3], parts: [None; 3] });
                }
                terms[index].factors[component] = Some(factor);
                terms[index].parts[component] = product.inner;
                index += 1;
            }
        }
        (terms.len() <= MOST_TERMS).then_some((fixed, terms))
    }

    /// The fixed and the moving addends of a sum.
    fn split(&mut self, root: NodeId) -> FixedAndMoving {
        let mut splits: HashMap<NodeId, FixedAndMoving> = HashMap::new();
        for id in walk(root, |id| self.addends(id).map_or(Vec::new(), |(_, operands)| operands.to_vec())) {
            let split = match self.addends(id) {
                _ if self.is_fixed(id) => (Some(id), None),
                Some((primitive, operands)) => {
                    let [(x, moving_x), (y, moving_y)] = operands.map(|operand| splits[&operand]);
                    (self.joined(primitive, x, y), self.joined(primitive, moving_x, moving_y))
                }
                None => (None, Some(id)),
            };
            splits.insert(id, split);
        }
        splits[&root]
    }

    /// The operands of a sum or a difference that is not fixed.
    fn addends(&self, id: NodeId) -> Option<(Primitive, [NodeId; 2])> {
        match self.bindings.graph.node(id) {
            Node::Apply(primitive @ (Primitive::Add | Primitive::Sub), [x, y, ..]) if !self.is_fixed(id) => {
                Some((primitive, [x, y]))
            }
            Node::Apply(..) | Node::Constant(_) | Node::Variable(..) | Node::Parameter(..) => None,
        }
    }

    fn joined(&mut self, primitive: Primitive, x: Option<NodeId>, y: Option<NodeId>) -> Option<NodeId> {
        match (x, y) {
            (Some(x), Some(y)) => Some(self.record(primitive, &[x, y])),
            (None, Some(y)) if primitive == Primitive::Sub => Some(self.record(Primitive::Neg, &[y])),
            (one, other) => one.or(other),
        }
    }

    /// The largest dynamic sub-expressions of `moving` that are fixed and cost more to compute than to load.
    fn worth_storing(&self, moving: &[Option<NodeId>; 3]) -> Vec<NodeId> {
        let mut stored = Vec::new();
        let mut seen = vec![false; self.bindings.graph.len()];
        let mut pending: Vec<NodeId> = moving.iter().flatten().copied().collect();
        while let Some(id) = pending.pop() {
            if std::mem::replace(&mut seen[id.0 as usize], true) || self.bindings.time(id) != BindingTime::Dynamic {
                continue;
            }
            if !self.is_fixed(id) {
                pending.extend_from_slice(self.bindings.graph.node(id).operands());
            } else if self.cost(id) >= WORTH_STORING {
                stored.push(id);
            }
        }
        stored.sort_unstable();
        stored
    }

    /// The cost of a dynamic node, in simple instructions. Counting stops when the node is worth storing.
    fn cost(&self, id: NodeId) -> u32 {
        let mut seen = HashSet::new();
        let mut pending = vec![id];
        let mut cost = 0;
        while let Some(id) = pending.pop() {
            if self.bindings.time(id) != BindingTime::Dynamic || !seen.insert(id) {
                continue;
            }
            if let Node::Apply(primitive, _) = self.bindings.graph.node(id) {
                cost += primitive.cost();
            }
            if cost >= WORTH_STORING {
                break;
            }
            pending.extend_from_slice(self.bindings.graph.node(id).operands());
        }
        cost
    }
}

/// Outer factors are moved, inner ones fixed. Mixed nodes must be split.
impl LinearForm for Separator {
    fn graph(&self) -> &Graph {
        &self.bindings.graph
    }

    fn record(&mut self, primitive: Primitive, operands: &[NodeId]) -> NodeId {
        let id = self.bindings.record(primitive, operands);
        self.analyse_new_nodes();
        id
    }

    fn constant(&mut self, value: f32) -> NodeId {
        let id = self.bindings.constant(value);
        self.analyse_new_nodes();
        id
    }

    fn is_mixed(&self, id: NodeId) -> bool {
        self.mobility(id) == Mobility::Mixed
    }

    fn whole(&self, id: NodeId) -> Option<Product> {
        match self.mobility(id) {
            Mobility::Constant | Mobility::Fixed => Some(Product { outer: None, inner: Some(id) }),
            Mobility::Moved => Some(Product { outer: Some(id), inner: None }),
            Mobility::Mixed => None,
        }
    }

    fn accepts(&self, sum: &[Product]) -> bool {
        sum.len() <= MOST_TERMS
    }

    fn multiplies(&self, x: &[Product], y: &[Product]) -> bool {
        // Some of the products will have a factor in common.
        x.len() * y.len() <= 2 * MOST_TERMS
    }

    fn divides(&mut self, _: &[Product], _: NodeId) -> bool {
        true
    }

    fn chooses(&self, condition: NodeId) -> bool {
        self.is_fixed(condition)
    }

    fn common(&self, one: &Product, other: &Product) -> Option<Common> {
        (one.outer == other.outer).then_some(Common::Outer)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::formula::Formula;
    use crate::formula::graph::Graph;
    use crate::lang::source::Source;
    use crate::lang::variables::Predefined;

    /// Macros that each use the one before twice: `step` with `M` for it.
    fn chain(length: usize, first: &str, step: &str, result: &str) -> Formula {
        let last = format!("M{length}");
        let lines: String =
            (1..=length).map(|index| format!("M{index} = {};", step.replace('M', &format!("M{}", index - 1)))).collect();
        let text = format!(
            "body_specific; kd: scalar, constraint 0..1; ks: scalar, constraint 0..1; formula; M0 = {first}; {lines} = {};",
            result.replace('M', &last)
        );
        Formula::parse(&Source::new("chain", text)).expect("a formula").0
    }

    /// Some numbers for variables and parameters.
    fn value(node: Node) -> f32 {
        match node {
            Node::Parameter(id, component) => 0.3 + 0.07 * id.0 as f32 + 0.1 * f32::from(component),
            Node::Variable(variable, component) => 0.2 + 0.05 * f32::from(variable as u8) + 0.15 * f32::from(component),
            Node::Constant(_) | Node::Apply(..) => f32::NAN,
        }
    }

    fn values(graph: &Graph, roots: &[Option<NodeId>]) -> Vec<f32> {
        let known: Vec<NodeId> = roots.iter().flatten().copied().collect();
        let mut values = graph.evaluate(&known, |id| value(graph.node(id))).into_iter();
        roots.iter().map(|root| root.map_or(0.0, |_| values.next().expect("a value of each root"))).collect()
    }

    /// Compares the rewritten and separated contribution with the typed formula, and checks how it depends on kd.
    fn check(formula: &Formula) -> Dependence {
        let graph = Graph::new(formula);
        let ki = value(Node::Parameter(formula.predefined(Predefined::Intensity), 0));
        let typed: Vec<f32> = values(&graph, &graph.result().map(Some)).iter().map(|number| ki * number).collect();
        let near = |one: &[f32], what: &str| {
            let close = |(a, b): (&f32, &f32)| a == b || (a - b).abs() <= 1e-5 * a.abs();
            assert!(one.iter().zip(&typed).all(close), "{what}: {one:?}, typed {typed:?}");
        };
        let bindings = Bindings::new(formula);
        near(&values(&bindings.graph, &bindings.contribution.map(Some)), "rewritten");
        let kd = formula.parameter_named("kd").expect("a parameter");
        let Separation { bindings, fixed, dependence } = Separation::new(&bindings, &[(kd, 0)]);
        assert!(bindings.graph.len() < 2000, "{} nodes", bindings.graph.len());
        let mut sum = values(&bindings.graph, &fixed);
        match &dependence {
            Dependence::None => {}
            Dependence::Separable(terms) => {
                for SeparableTerm { factors, parts } in terms {
                    let factors = values(&bindings.graph, factors);
                    let whole = |component: usize| parts[component].map(|part| values(&bindings.graph, &[Some(part)])[0]);
                    (0..3).for_each(|component| sum[component] += factors[component] * whole(component).unwrap_or(1.0));
                }
            }
            Dependence::Inseparable { moving, .. } => {
                sum.iter_mut().zip(values(&bindings.graph, moving)).for_each(|(sum, moving)| *sum += moving);
            }
        }
        near(&sum, "taken apart");
        dependence
    }

    const DYNAMIC: &str = "kd*(N.L) + ks";

    #[test]
    fn sums_of_shared_nodes_are_taken_apart_once() {
        for (step, result) in [
            ("M + M", "M*Cd*9.5e-7"),
            ("M*3 - M", "M*Cd*9.5e-7"),
            ("M - M*0.5", "M*Cd*2000"),
            ("M*ks + M/2", "M*Cd"),
            ("-(M*0.75) - M*ks", "M*Cd"),
        ] {
            // 2²⁰ times the sum, first; and more doublings than there could be nodes.
            for length in [20, 45] {
                let result = if length == 45 { format!("({result})*1e-7") } else { result.to_owned() };
                let dependence = check(&chain(length, DYNAMIC, step, &result));
                assert!(matches!(dependence, Dependence::Separable(_)), "{step}: {dependence:?}");
            }
        }
    }

    #[test]
    fn products_of_shared_nodes_are_taken_apart_once() {
        // A power of kd, and a polynomial of too high a degree.
        assert!(matches!(check(&chain(45, "kd*(N.L)", "M*M", "M*Cd")), Dependence::Separable(_)));
        assert!(matches!(check(&chain(2, DYNAMIC, "M*M", "M*Cd")), Dependence::Separable(_)));
        assert!(matches!(check(&chain(45, DYNAMIC, "M*M", "M*Cd")), Dependence::Inseparable { .. }));
    }

    #[test]
    fn the_moving_part_is_split_off_once() {
        for step in ["M + M", "M - M*0.5 - M"] {
            let dependence = check(&chain(45, "exp(-kd*alpha) + ks*(N.L)", step, "Cd*(M*1e-12)"));
            assert!(matches!(dependence, Dependence::Inseparable { .. }), "{step}: {dependence:?}");
        }
        let sum = check(&chain(45, "<1, 2, 3>*(exp(-kd*alpha)) + Cd*ks*alpha", "M + M", "M"));
        assert!(matches!(sum, Dependence::Inseparable { .. }));
    }
    #[test]
    fn choices_by_what_does_not_move_are_taken_apart() {
        for (result, terms) in [
            ("if(N.L > 0.1, Cd*(kd*(N.L) + ks), <0>)", 1),
            ("if(N.L > 0.9, Cd*(kd*(N.L) + ks), kd*<1, 2, 3> - <ks>)", 2),
            ("if(N.L > 0.9, <1>, kd^2*Cd + kd*<ks>)", 2),
            ("Cd*if(N.L > ks, if(alpha > 0.1, kd, ks), 2*kd)", 2),
            ("if(kd > 0.5, Cd, <ks>)", 0),
            ("if(N.L > 0.1, Cd*sin(kd*alpha), <0>)", 0),
        ] {
            let found = check(&chain(0, "1", "M", result));
            match found {
                Dependence::Separable(found) => assert_eq!(found.len(), terms, "{result}"),
                Dependence::None | Dependence::Inseparable { .. } => assert_eq!(terms, 0, "{result}: {found:?}"),
            }
        }
    }
}
