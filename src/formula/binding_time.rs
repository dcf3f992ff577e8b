//! Binding times: which parts of a formula are known once rays are traced, which once a frame, which only for every
//! record.
//!
//! Each node of the graph is constant, *static* (made of variables alone: known once traced, for a hit or for a lit
//! record), *uniform* (made of parameters alone: known once a frame, for a body and a light), or *dynamic* (made of
//! both).

use crate::formula::graph::{Graph, Node, NodeId};
use crate::lang::variables::Rate;

/// When a value is known.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum BindingTime {
    /// From the text.
    Constant,
    /// Once traced, for each hit or each lit record.
    Static(Rate),
    /// Once a frame, for each body and light.
    Uniform,
    /// Once a frame, for each lit record.
    Dynamic,
}

impl BindingTime {
    /// That of a node, from those of the nodes before it.
    pub(super) fn of(graph: &Graph, id: NodeId, known: &[BindingTime]) -> BindingTime {
        match graph.node(id) {
            Node::Constant(_) => BindingTime::Constant,
            Node::Variable(variable, _) => BindingTime::Static(variable.rate()),
            Node::Parameter(..) => BindingTime::Uniform,
            node @ Node::Apply(..) => {
                let times = node.operands().iter().map(|operand| known[operand.0 as usize]);
                times.fold(BindingTime::Constant, BindingTime::join)
            }
        }
    }

    /// Of what is computed from both.
    fn join(self, other: BindingTime) -> BindingTime {
        use BindingTime::{Constant, Dynamic, Static, Uniform};
        match (self, other) {
            (Constant, time) | (time, Constant) => time,
            (Uniform, Uniform) => Uniform,
            (Static(one), Static(another)) => Static(one.max(another)),
            (Dynamic, _) | (_, Dynamic) | (Uniform, Static(_)) | (Static(_), Uniform) => Dynamic,
        }
    }
}
