//! The intervals of a graph's nodes, for rewrites that are valid only within bounds.
//!
//! Variables and parameters have known ranges. The interval of an operation follows from those of its operands by the
//! row of its primitive ([`Primitive::interval`]). Two more facts are used: squares are not negative, and the dot
//! product of two directions of unit length is a cosine.

use crate::formula::Formula;
use crate::formula::graph::{Graph, Node, NodeId};
use crate::lang::interval::Interval;
use crate::lang::scalars::Primitive;
use crate::lang::variables::Variable;

/// How far rounding can take the dot product of two unit vectors above 1.
pub(super) const UNIT_SLACK: f64 = 1e-6;

/// The interval of a node, from those of the nodes before it. Directions have unit length within `slack`, which is
/// [`UNIT_SLACK`] or 0.
pub(super) fn interval(graph: &Graph, id: NodeId, formula: &Formula, known: &[Interval], slack: f64) -> Interval {
    match graph.node(id) {
        Node::Constant(bits) => Interval::constant(f32::from_bits(bits)),
        Node::Variable(variable, _) => of_variable(variable, slack),
        Node::Parameter(parameter, _) => {
            let [low, high] = formula.parameter(parameter).range.unwrap_or([f32::MIN, f32::MAX]);
            Interval::new(low.into(), high.into())
        }
        Node::Apply(Primitive::Mul, [x, y, ..]) if x == y => known[x.0 as usize].squared().rounded(),
        Node::Apply(..) if is_unit_dot_product(graph, id) => Interval::new(-1.0 - slack, 1.0 + slack),
        node @ Node::Apply(primitive, _) => {
            let operands: Vec<Interval> = node.operands().iter().map(|id| known[id.0 as usize]).collect();
            primitive.interval(&operands)
        }
    }
}

fn of_variable(variable: Variable, slack: f64) -> Interval {
    match variable {
        Variable::Normal
        | Variable::ToLight
        | Variable::ToViewer
        | Variable::Mirrored
        | Variable::Halfway
        | Variable::Tangent
        | Variable::Bitangent
        | Variable::GeometricNormal => Interval::new(-1.0 - slack, 1.0 + slack),
        Variable::Alpha | Variable::Beta | Variable::Gamma => Interval::new(0.0, std::f64::consts::PI + slack),
        Variable::RelativeIndex => Interval::new(0.0, f64::INFINITY),
        Variable::TotalReflection => Interval::new(0.0, 1.0),
        Variable::Distance => Interval::new(0.0, f64::INFINITY),
        Variable::Visible => Interval::new(0.0, 1.0),
        Variable::Radiance | Variable::SampleWeight | Variable::WeightedRadiance => Interval::new(0.0, f32::MAX.into()),
        // Those of a mesh come from its file.
        Variable::SurfaceU | Variable::SurfaceV => Interval::new(f32::MIN.into(), f32::MAX.into()),
        Variable::Point => Interval::new(f64::NEG_INFINITY, f64::INFINITY),
    }
}

/// Whether a node is `x·x' + y·y' + z·z'` of two directions of unit length.
fn is_unit_dot_product(graph: &Graph, id: NodeId) -> bool {
    let operands = |id: NodeId, wanted: Primitive| match graph.node(id) {
        Node::Apply(primitive, operands) if primitive == wanted => Some([operands[0], operands[1]]),
        Node::Apply(..) | Node::Constant(_) | Node::Variable(..) | Node::Parameter(..) => None,
    };
    let direction = |id: NodeId| match graph.node(id) {
        Node::Variable(variable, component) if of_variable(variable, 0.0).low == -1.0 => Some((variable, component)),
        Node::Variable(..) | Node::Apply(..) | Node::Constant(_) | Node::Parameter(..) => None,
    };
    let product = |id: NodeId, component: u8| {
        let [x, y] = operands(id, Primitive::Mul)?;
        let (x, y) = (direction(x)?, direction(y)?);
        ((x.1, y.1) == (component, component)).then_some((x.0, y.0))
    };
    let found = || {
        let [first_two, third] = operands(id, Primitive::Add)?;
        let [first, second] = operands(first_two, Primitive::Add)?;
        Some([product(first, 0)?, product(second, 1)?, product(third, 2)?])
    };
    found().is_some_and(|[x, y, z]| x == y && y == z)
}
