//! Binding times: which parts of a formula are known after tracing, which once a frame, and which for each record only.
//!
//! Each node of the graph is constant, *static* (made of variables alone: known once traced, for a hit or for a lit
//! record), *uniform* (made of parameters alone: known once a frame, for a body and a light), or *dynamic* (made of
//! both).

use crate::formula::graph::{Graph, Node, NodeId};
use crate::lang::variables::Rate;

/// When a value is known.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum BindingTime {
    /// Known from the text.
    Constant,
    /// Known after tracing, for each hit or each lit record.
    Static(Rate),
    /// Known once a frame, for each pair of a body and a light.
    Uniform,
    /// Computed once a frame, for each lit record.
    Dynamic,
}

impl BindingTime {
    /// The binding time of a node, from the binding times of the nodes before it.
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

    /// The binding time of a value that is computed from both.
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
