//! A formula as a graph of scalar operations with shared nodes: the input of compiled code.
//!
//! Vectors are split into their components, equal sub-expressions and macros become one node, and constants are folded
//! by the reference meaning. Operands have smaller numbers than their users, so walking the graph needs no recursion.

use crate::formula::{Formula, ParameterId, Term, TermId};
use crate::lang::builtins::Stack;
use crate::lang::scalars::{Floats, Primitive, Recorder, flush};
use crate::lang::types::Type;
use crate::lang::variables::{Owner, Variable};
use std::collections::{BTreeSet, HashMap};
use std::sync::Arc;

/// A node, as an index into a [`Graph`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct NodeId(pub u32);

/// A scalar value, by how it is computed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Node {
    /// A number, by its bits, so that −0 and each NaN are different numbers.
    Constant(u32),
    /// A component (0 for a scalar) of a variable.
    Variable(Variable, u8),
    /// A component (0 for a scalar) of a parameter.
    Parameter(ParameterId, u8),
    /// A primitive. Its operands are the first nodes of this list.
    Apply(Primitive, [NodeId; Primitive::MAX_ARITY]),
}

impl Node {
    /// Its operands.
    pub fn operands(&self) -> &[NodeId] {
        match self {
            Node::Constant(_) | Node::Variable(..) | Node::Parameter(..) => &[],
            Node::Apply(primitive, operands) => &operands[..primitive.arity()],
        }
    }
}

/// The nodes that can be reached from `root`, each once, operands before their users. `next` returns the operands to
/// follow.
pub(super) fn walk(root: NodeId, next: impl Fn(NodeId) -> Vec<NodeId>) -> BTreeSet<NodeId> {
    let mut found = BTreeSet::new();
    let mut pending = vec![root];
    while let Some(id) = pending.pop() {
        if found.insert(id) {
            pending.extend(next(id));
        }
    }
    found
}

/// A formula's graph.
#[derive(Debug, Clone)]
pub struct Graph {
    nodes: Vec<Node>,
    index: HashMap<Node, NodeId>,
    result: [NodeId; 3],
    /// The owner of each parameter of the formula.
    owners: Arc<[Owner]>,
}

impl Graph {
    /// The graph of a formula.
    pub fn new(formula: &Formula) -> Self {
        let (mut graph, results) = Self::of(formula, &[formula.result]);
        graph.result = results[0];
        graph
    }

    /// A graph of these expressions of a formula, and their nodes. A scalar has the same node three times.
    pub fn of(formula: &Formula, roots: &[TermId]) -> (Self, Vec<[NodeId; 3]>) {
        let mut graph = Graph::for_parameters_of(formula);
        // The nodes of each term. A scalar has the same node three times.
        let mut built: Vec<[NodeId; 3]> = Vec::with_capacity(formula.terms.len());
        let mut stack = Stack::new(16, NodeId(0));
        for (index, term) in formula.terms.iter().enumerate() {
            let ty = formula.ty(TermId(index as u32));
            let nodes = match term {
                Term::Number(value) => [graph.record_constant(*value); 3],
                Term::Material(material) => [graph.record_constant(formula.material(*material).number); 3],
                Term::Variable(variable) => graph.leaf(ty, |component| Node::Variable(*variable, component)),
                Term::Parameter(parameter) => graph.leaf(ty, |component| Node::Parameter(*parameter, component)),
                Term::Apply(operation, operands) => {
                    for (operand, ty) in operands.iter().zip(operation.operands()) {
                        built[operand.0 as usize][..ty.slots()].iter().for_each(|node| stack.push(*node));
                    }
                    operation.apply(&mut graph, &mut stack);
                    match operation.result() {
                        Type::Scalar | Type::Truth | Type::Texture => stack.pop::<1>().map(|node| [node; 3])[0],
                        Type::Vector => stack.pop::<3>(),
                    }
                }
                Term::ByComponents(operation, operands) => {
                    let vectors = formula.vectors(operands);
                    for (number, operand) in operands.iter().enumerate() {
                        let slots = if vectors >> number & 1 == 1 { 3 } else { 1 };
                        built[operand.0 as usize][..slots].iter().for_each(|node| stack.push(*node));
                    }
                    operation.apply_by_components(vectors, &mut graph, &mut stack);
                    stack.pop::<3>()
                }
            };
            built.push(nodes);
        }
        let results = roots.iter().map(|root| built[root.0 as usize]).collect();
        (graph, results)
    }

    /// A graph without nodes, for nodes of this formula.
    pub(super) fn for_parameters_of(formula: &Formula) -> Self {
        Self::empty(formula.parameters.iter().map(|parameter| parameter.owner).collect())
    }

    /// A graph without nodes, for parameters of these owners.
    pub(crate) fn empty(owners: Arc<[Owner]>) -> Self {
        Graph { nodes: Vec::new(), index: HashMap::new(), result: [NodeId(0); 3], owners }
    }

    /// What has a value of its own of a parameter.
    pub(super) fn owner(&self, parameter: ParameterId) -> Owner {
        self.owners.get(parameter.0 as usize).copied().unwrap_or(Owner::Light)
    }

    /// The index of a node. It is added without change if it is new. Its operands are nodes of this graph.
    pub(crate) fn insert(&mut self, node: Node) -> NodeId {
        self.add(node)
    }

    /// For each node, whether `roots` need it.
    pub(crate) fn needed(&self, roots: &[NodeId]) -> Vec<bool> {
        let mut needed = vec![false; self.len()];
        let mut pending = roots.to_vec();
        while let Some(id) = pending.pop() {
            if !std::mem::replace(&mut needed[id.0 as usize], true) {
                pending.extend_from_slice(self.node(id).operands());
            }
        }
        needed
    }

    /// The graph of the nodes that `roots` need, in the same order, and the roots in it. The first three become its
    /// result.
    pub(super) fn reachable(&self, roots: &[NodeId]) -> (Graph, Vec<NodeId>) {
        let mut graph = Graph::empty(Arc::clone(&self.owners));
        let mut new_ids = vec![NodeId(0); self.len()];
        for (index, _) in self.needed(roots).iter().enumerate().filter(|(_, needed)| **needed) {
            let node = match self.nodes[index] {
                Node::Apply(primitive, operands) => Node::Apply(primitive, operands.map(|operand| new_ids[operand.0 as usize])),
                leaf @ (Node::Constant(_) | Node::Variable(..) | Node::Parameter(..)) => leaf,
            };
            new_ids[index] = graph.add(node);
        }
        let roots: Vec<NodeId> = roots.iter().map(|root| new_ids[root.0 as usize]).collect();
        roots.iter().zip(&mut graph.result).for_each(|(root, result)| *result = *root);
        (graph, roots)
    }

    fn leaf(&mut self, ty: Type, node: impl Fn(u8) -> Node) -> [NodeId; 3] {
        match ty {
            Type::Scalar | Type::Truth | Type::Texture => [self.add(node(0)); 3],
            Type::Vector => [0, 1, 2].map(|component| self.add(node(component))),
        }
    }

    fn add(&mut self, node: Node) -> NodeId {
        if let Some(id) = self.index.get(&node) {
            return *id;
        }
        let id = NodeId(self.nodes.len() as u32);
        self.nodes.push(node);
        self.index.insert(node, id);
        id
    }

    /// The node of a component of a parameter, added if the formula does not read it.
    pub fn parameter(&mut self, parameter: ParameterId, component: u8) -> NodeId {
        self.add(Node::Parameter(parameter, component))
    }

    /// The node of this index.
    pub fn node(&self, id: NodeId) -> Node {
        self.nodes[id.0 as usize]
    }

    /// How many nodes there are.
    pub fn len(&self) -> usize {
        self.nodes.len()
    }

    /// Whether two graphs have the same nodes in the same order.
    pub fn has_the_nodes_of(&self, other: &Graph) -> bool {
        self.nodes == other.nodes
    }

    /// Whether it has no nodes. The graph of a formula has at least one.
    pub fn is_empty(&self) -> bool {
        self.nodes.is_empty()
    }

    /// Red, green and blue of the formula.
    pub fn result(&self) -> [NodeId; 3] {
        self.result
    }

    /// The value of a constant node.
    pub fn constant(&self, id: NodeId) -> Option<f32> {
        match self.node(id) {
            Node::Constant(bits) => Some(f32::from_bits(bits)),
            Node::Variable(..) | Node::Parameter(..) | Node::Apply(..) => None,
        }
    }

    /// The values of some nodes by the reference meaning. `leaf` gives the values of variables and parameters.
    pub fn evaluate(&self, roots: &[NodeId], leaf: impl Fn(NodeId) -> f32) -> Vec<f32> {
        self.evaluate_with(&mut Floats, roots, leaf)
    }

    /// The values of some nodes with another meaning of the primitives, such as
    /// [`Doubles`](crate::lang::scalars::Doubles). `leaf` gives the values of variables and parameters.
    pub fn evaluate_with<M: crate::lang::scalars::Scalars>(
        &self,
        scalars: &mut M,
        roots: &[NodeId],
        leaf: impl Fn(NodeId) -> M::Value,
    ) -> Vec<M::Value> {
        let unknown = scalars.constant(0.0);
        let mut values = vec![unknown; self.len()];
        for (index, _) in self.needed(roots).iter().enumerate().filter(|(_, needed)| **needed) {
            values[index] = match self.nodes[index] {
                Node::Constant(bits) => scalars.constant(f32::from_bits(bits)),
                Node::Variable(..) | Node::Parameter(..) => leaf(NodeId(index as u32)),
                Node::Apply(primitive, operands) => {
                    let operands = operands.map(|operand| values[operand.0 as usize]);
                    primitive.apply(scalars, &operands[..primitive.arity()])
                }
            };
        }
        roots.iter().map(|root| values[root.0 as usize]).collect()
    }

    /// xⁿ for whole n from −4 to 4, as products: within four units in the last place of `powf`, at a fraction of the
    /// cost.
    fn small_power(&mut self, x: NodeId, exponent: f32) -> Option<NodeId> {
        if exponent.fract() != 0.0 || !(1.0..=4.0).contains(&exponent.abs()) {
            return None;
        }
        // The reciprocal first: x² may be too small for a normal number where 1/x² is still in range.
        let base = if exponent < 0.0 {
            let one = self.record_constant(1.0);
            self.record(Primitive::Div, &[one, x])
        } else {
            x
        };
        Some(match exponent.abs() as u32 {
            1 => base,
            2 => self.record(Primitive::Mul, &[base, base]),
            3 => {
                let square = self.record(Primitive::Mul, &[base, base]);
                self.record(Primitive::Mul, &[square, base])
            }
            _ => {
                let square = self.record(Primitive::Mul, &[base, base]);
                self.record(Primitive::Mul, &[square, square])
            }
        })
    }

    /// A simpler node with the same value in all cases, NaN and −0 included.
    fn simplified(&mut self, primitive: Primitive, operands: &[NodeId]) -> Option<NodeId> {
        let is = |index: usize, value: f32| self.constant(operands[index]).is_some_and(|x| x.to_bits() == value.to_bits());
        if primitive == Primitive::Pow {
            let exponent = self.constant(operands[1])?;
            return if exponent == 0.0 { Some(self.record_constant(1.0)) } else { self.small_power(operands[0], exponent) };
        }
        if primitive == Primitive::Select {
            let condition = self.constant(operands[0])?;
            return Some(if condition != 0.0 { operands[1] } else { operands[2] });
        }
        if let Primitive::And | Primitive::Or = primitive {
            // One operand is known: it decides, or the other one does.
            let known = [0, 1].into_iter().find_map(|index| Some((self.constant(operands[index])?, operands[1 - index])));
            let (value, other) = known?;
            let decides = (value != 0.0) == (primitive == Primitive::Or);
            return Some(if decides { self.record_constant(value) } else { other });
        }
        let first = matches!(primitive, Primitive::Mul | Primitive::Div) && is(1, 1.0)
            || primitive == Primitive::Sub && is(1, 0.0)
            || primitive == Primitive::Add && is(1, -0.0);
        let second = primitive == Primitive::Mul && is(0, 1.0) || primitive == Primitive::Add && is(0, -0.0);
        if first { Some(operands[0]) } else { second.then(|| operands[1]) }
    }
}

impl Recorder for Graph {
    type Value = NodeId;

    fn record_constant(&mut self, value: f32) -> NodeId {
        self.add(Node::Constant(flush(value).to_bits()))
    }

    fn record(&mut self, primitive: Primitive, operands: &[NodeId]) -> NodeId {
        let constants: Option<Vec<f32>> = operands.iter().map(|id| self.constant(*id)).collect();
        if let Some(constants) = constants {
            let value = primitive.apply(&mut Floats, &constants);
            return self.record_constant(value);
        }
        if let Some(same) = self.simplified(primitive, operands) {
            return same;
        }
        let mut slots = [NodeId(0); Primitive::MAX_ARITY];
        slots[..operands.len()].copy_from_slice(operands);
        self.add(Node::Apply(primitive, slots))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lang::source::Source;

    fn graph(formula: &str) -> Graph {
        let source = Source::new("test", format!("body_specific; p: scalar; q: vector; formula; {formula}"));
        let (formula, _) = Formula::parse(&source).unwrap_or_else(|errors| panic!("{}", errors.located(&source)));
        Graph::new(&formula)
    }

    #[test]
    fn equal_expressions_are_one_node() {
        let shared = graph("A = p*alpha; B = p*alpha; = <A, B, A*B>;");
        let [red, green, blue] = shared.result();
        assert_eq!(red, green);
        assert_eq!(shared.node(blue).operands(), [red, green]);
    }

    #[test]
    fn constants_fold_by_the_reference_meaning() {
        let folded = graph("= <2^0.5, 1/0, max(1, 2)*p>;");
        let [red, green, _] = folded.result();
        assert_eq!(folded.constant(red), Some(2.0_f32.powf(0.5)));
        assert_eq!(folded.constant(green), Some(f32::INFINITY));
    }

    #[test]
    fn only_true_identities_are_simplified() {
        let kept = graph("= <p*1, p*0, p + 0>;");
        let [red, green, blue] = kept.result();
        assert!(matches!(kept.node(red), Node::Parameter(..)));
        assert!(matches!(kept.node(green), Node::Apply(Primitive::Mul, _)), "0 times infinity is not 0");
        assert!(matches!(kept.node(blue), Node::Apply(Primitive::Add, _)), "-0 + 0 is 0");
    }

    #[test]
    fn deep_sums_need_no_stack() {
        let sum = vec!["alpha"; 45_000].join("+");
        assert!(graph(&format!("= <p, p, {sum}>;")).len() > 40_000);
    }
}
