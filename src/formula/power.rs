//! The power that parameters have in a value, and its degree as a polynomial.

use crate::formula::ParameterId;
use crate::formula::graph::{Graph, Node, NodeId};
use crate::lang::scalars::Primitive;

/// The power of some parameters in a value: multiplied by a positive number, they multiply the value by that power of
/// it. `None` if that is not known of the value.
pub fn power(graph: &Graph, root: NodeId, counts: impl Fn(ParameterId) -> bool) -> Option<u32> {
    // The powers of the nodes up to the root, operands before their users.
    let mut powers: Vec<Option<u32>> = Vec::with_capacity(root.0 as usize + 1);
    for index in 0..=root.0 {
        let node = graph.node(NodeId(index));
        let of = |id: NodeId| powers[id.0 as usize];
        let is_zero = |id: NodeId| graph.constant(id) == Some(0.0);
        let same = |x: NodeId, y: NodeId| match (of(x), of(y)) {
            (power, _) if is_zero(y) => power,
            (_, power) if is_zero(x) => power,
            (one, other) => one.filter(|_| one == other),
        };
        powers.push(match node {
            Node::Parameter(id, _) => Some(u32::from(counts(id))),
            Node::Constant(_) | Node::Variable(..) => Some(0),
            Node::Apply(Primitive::Mul, [x, y, ..]) => of(x).zip(of(y)).map(|(x, y)| x + y),
            Node::Apply(Primitive::Div, [x, y, ..]) => of(x).filter(|_| of(y) == Some(0)),
            Node::Apply(Primitive::Neg, [x, ..]) => of(x),
            Node::Apply(Primitive::Add | Primitive::Sub, [x, y, ..]) => same(x, y),
            Node::Apply(Primitive::Select, [condition, x, y, ..]) if of(condition) == Some(0) => same(x, y),
            Node::Apply(..) => node.operands().iter().all(|operand| of(*operand) == Some(0)).then_some(0),
        });
    }
    powers[root.0 as usize]
}

/// The degree of a value as a polynomial of its leaves with constant coefficients. `None` if it is not known to be one.
pub fn degree(graph: &Graph, root: NodeId) -> Option<u32> {
    let mut degrees: Vec<Option<u32>> = Vec::with_capacity(root.0 as usize + 1);
    for index in 0..=root.0 {
        let node = graph.node(NodeId(index));
        let of = |id: NodeId| degrees[id.0 as usize];
        degrees.push(match node {
            Node::Constant(_) => Some(0),
            Node::Parameter(..) | Node::Variable(..) => Some(1),
            Node::Apply(Primitive::Add | Primitive::Sub, [x, y, ..]) => of(x).zip(of(y)).map(|(x, y)| x.max(y)),
            Node::Apply(Primitive::Mul, [x, y, ..]) => of(x).zip(of(y)).map(|(x, y)| x + y),
            Node::Apply(Primitive::Div, [x, y, ..]) => of(x).filter(|_| of(y) == Some(0)),
            Node::Apply(Primitive::Neg, [x, ..]) => of(x),
            Node::Apply(..) => node.operands().iter().all(|operand| of(*operand) == Some(0)).then_some(0),
        });
    }
    degrees[root.0 as usize]
}
