//! Binding times: which parts of a formula are known after tracing, which once a frame, and which for each record only.
//!
//! Each node of the graph is constant, *static* (made of variables alone: known once traced, for a hit or for a lit
//! record), *uniform* (made of parameters alone: known once a frame, for a body and a light), or *dynamic* (made of
//! both).
//!
//! The colour of a texture at static coordinates is static too, though it depends on which texture the owner has. No
//! slider chooses another texture. So it is looked up once for each hit, and again when a texture is replaced.

use crate::formula::graph::{Graph, Node, NodeId};
use crate::lang::scalars::Primitive;
use crate::lang::variables::{Owner, Rate};

/// What a parameter of an owner is the same for.
fn rate_of(owner: Owner) -> Rate {
    match owner {
        Owner::Global | Owner::Body => Rate::Hit,
        Owner::Light => Rate::Record,
    }
}

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
            node @ Node::Apply(primitive, _) => {
                let joined = |operands: &[NodeId]| {
                    let times = operands.iter().map(|operand| known[operand.0 as usize]);
                    times.fold(BindingTime::Constant, BindingTime::join)
                };
                match (primitive, node.operands()) {
                    (Primitive::Texture, [number, coordinates @ ..]) => match (graph.node(*number), joined(coordinates)) {
                        (Node::Parameter(texture, _), BindingTime::Static(rate)) => {
                            BindingTime::Static(rate.max(rate_of(graph.owner(texture))))
                        }
                        (_, time) => time.join(known[number.0 as usize]),
                    },
                    (_, operands) => joined(operands),
                }
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
