//! What values a node of the graph can take, as far as its operands' ranges tell: for rewrites that hold only within bounds.
//!
//! A range is an over-estimate. Its ends are those of exact arithmetic; results are rounded to `f32`, so a value may lie beyond an end by
//! some units in the last place, but never on the other side of 0. Directions are of unit length but for an error of rounding, or exactly, as is
//! asked for. Products of unequal signs and the like are not followed far: what is
//! needed is whether a base can be negative, an exponent 0, a term infinite.

use crate::formula::Formula;
use crate::formula::graph::{Graph, Node, NodeId};
use crate::lang::scalars::Primitive;
use crate::lang::variables::Variable;

/// An interval, and whether NaN or −0 may occur beside it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Range {
    /// The lower end, −∞ included.
    pub(super) low: f64,
    /// The upper end, ∞ included.
    pub(super) high: f64,
    /// Whether NaN may occur.
    pub(super) nan: bool,
    /// Whether −0 may occur, which divides to −∞.
    pub(super) negative_zero: bool,
}

/// Rounding of a dot product of unit vectors: by so much it may exceed 1.
pub(super) const UNIT_SLACK: f64 = 1e-6;

impl Range {
    /// Anything at all.
    const ANYTHING: Range = Range { low: f64::NEG_INFINITY, high: f64::INFINITY, nan: true, negative_zero: true };

    fn new(low: f64, high: f64) -> Self {
        Self { low, high, nan: false, negative_zero: low <= 0.0 && high >= 0.0 }
    }

    fn constant(value: f32) -> Self {
        let (nan, negative_zero) = (value.is_nan(), value == 0.0 && value.is_sign_negative());
        if nan { Self::ANYTHING } else { Self { low: value.into(), high: value.into(), nan, negative_zero } }
    }

    /// Whether all values are finite numbers of magnitude up to `limit`.
    pub(super) fn within(&self, limit: f64) -> bool {
        !self.nan && self.low >= -limit && self.high <= limit
    }

    /// The largest magnitude.
    pub(super) fn magnitude(&self) -> f64 {
        self.low.abs().max(self.high.abs())
    }

    /// Whether no value is below 0 or NaN.
    pub(super) fn not_negative(&self) -> bool {
        !self.nan && self.low >= 0.0
    }

    fn contains_zero(&self) -> bool {
        self.low <= 0.0 && self.high >= 0.0
    }

    fn infinite(&self) -> bool {
        self.low == f64::NEG_INFINITY || self.high == f64::INFINITY
    }

    /// The range of results in `low..=high`, which become infinite beyond the largest `f32`.
    fn rounded(mut self) -> Self {
        if self.low.is_nan() || self.high.is_nan() {
            return Self::ANYTHING;
        }
        if self.high > f64::from(f32::MAX) {
            self.high = f64::INFINITY;
        }
        if self.low < f64::from(f32::MIN) {
            self.low = f64::NEG_INFINITY;
        }
        // Subnormal results are zeros with their sign.
        let subnormal = |end: f64| end != 0.0 && end.abs() < f64::from(f32::MIN_POSITIVE);
        if subnormal(self.low) && self.low > 0.0 {
            self.low = 0.0;
        }
        if subnormal(self.high) && self.high < 0.0 {
            self.high = 0.0;
        }
        self.negative_zero = (self.negative_zero || self.low < 0.0) && self.contains_zero();
        self
    }

    fn hull(self, other: Range) -> Range {
        Range {
            low: self.low.min(other.low),
            high: self.high.max(other.high),
            nan: self.nan || other.nan,
            negative_zero: self.negative_zero || other.negative_zero,
        }
    }

    /// Of a function that grows with its argument.
    fn growing(self, function: impl Fn(f64) -> f64) -> Range {
        Range { nan: self.nan, ..Range::new(function(self.low), function(self.high)) }
    }
}

/// The range of a node from those of the nodes before it. Lengths of directions and the like are off by `slack` at most: [`UNIT_SLACK`], or nothing.
pub(super) fn range(graph: &Graph, id: NodeId, formula: &Formula, known: &[Range], slack: f64) -> Range {
    let of = |id: &NodeId| known[id.0 as usize];
    match graph.node(id) {
        Node::Constant(bits) => Range::constant(f32::from_bits(bits)),
        Node::Variable(variable, _) => of_variable(variable, slack),
        Node::Parameter(parameter, _) => {
            let [low, high] = formula.parameter(parameter).range.unwrap_or([f32::MIN, f32::MAX]);
            Range::new(low.into(), high.into())
        }
        node @ Node::Apply(primitive, _) => {
            if unit_dot_product(graph, id) {
                return Range::new(-1.0 - slack, 1.0 + slack);
            }
            let operands: Vec<Range> = node.operands().iter().map(of).collect();
            apply(primitive, &operands, node.operands()).rounded()
        }
    }
}

fn of_variable(variable: Variable, slack: f64) -> Range {
    match variable {
        Variable::Normal
        | Variable::ToLight
        | Variable::ToViewer
        | Variable::Mirrored
        | Variable::Halfway
        | Variable::Tangent
        | Variable::Bitangent => Range::new(-1.0 - slack, 1.0 + slack),
        Variable::Alpha | Variable::Beta | Variable::Gamma => Range::new(0.0, std::f64::consts::PI + slack),
        Variable::Distance => Range::new(0.0, f64::INFINITY),
        Variable::Point => Range::new(f64::NEG_INFINITY, f64::INFINITY),
    }
}

/// Whether a node is `x·x' + y·y' + z·z'` of two directions of unit length.
fn unit_dot_product(graph: &Graph, id: NodeId) -> bool {
    let operands = |id: NodeId, wanted: Primitive| match graph.node(id) {
        Node::Apply(primitive, operands) if primitive == wanted => Some([operands[0], operands[1]]),
        Node::Apply(..) | Node::Constant(_) | Node::Variable(..) | Node::Parameter(..) => None,
    };
    let direction = |id: NodeId| match graph.node(id) {
        Node::Variable(variable, component) if of_variable(variable, 0.0).low < 0.0 && variable != Variable::Point => {
            Some((variable, component))
        }
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

fn apply(primitive: Primitive, operands: &[Range], nodes: &[NodeId]) -> Range {
    use f64::consts::{FRAC_PI_2, PI};
    use std::f64;
    let anything = Range { nan: operands.iter().any(|range| range.nan), ..Range::ANYTHING };
    let x = operands[0];
    let y = operands.get(1).copied().unwrap_or(x);
    let nan = x.nan || y.nan;
    match primitive {
        Primitive::Neg => Range { nan, negative_zero: x.contains_zero(), ..Range::new(-x.high, -x.low) },
        Primitive::Add => {
            let opposite =
                x.high == f64::INFINITY && y.low == f64::NEG_INFINITY || x.low == f64::NEG_INFINITY && y.high == f64::INFINITY;
            let negative_zero = x.negative_zero && y.negative_zero;
            if opposite { Range::ANYTHING } else { Range { nan, negative_zero, low: x.low + y.low, high: x.high + y.high } }
        }
        Primitive::Sub => {
            let opposite =
                x.high == f64::INFINITY && y.high == f64::INFINITY || x.low == f64::NEG_INFINITY && y.low == f64::NEG_INFINITY;
            let negative_zero = x.negative_zero && y.contains_zero();
            if opposite { Range::ANYTHING } else { Range { nan, negative_zero, low: x.low - y.high, high: x.high - y.low } }
        }
        // A square, where the operands are one node.
        Primitive::Mul if nodes.first() == nodes.get(1) && !x.infinite() => {
            let low = if x.contains_zero() { 0.0 } else { x.low.abs().min(x.high.abs()).powi(2) };
            Range { low, high: x.magnitude().powi(2), nan, negative_zero: false }
        }
        Primitive::Mul => {
            let undefined = x.infinite() && y.contains_zero() || y.infinite() && x.contains_zero();
            let product = |a: f64, b: f64| if a == 0.0 || b == 0.0 { 0.0 } else { a * b };
            let corners = [product(x.low, y.low), product(x.low, y.high), product(x.high, y.low), product(x.high, y.high)];
            let (low, high) = extremes(&corners);
            let negative_zero = x.negative_zero || y.negative_zero || x.low < 0.0 || y.low < 0.0;
            Range { low, high, nan: nan || undefined, negative_zero }
        }
        Primitive::Div => {
            let undefined = x.contains_zero() && y.contains_zero() || x.infinite() && y.infinite();
            let nan = nan || undefined;
            if y.low > 0.0 || y.high < 0.0 {
                let corners = [x.low / y.low, x.low / y.high, x.high / y.low, x.high / y.high];
                if corners.iter().any(|corner| corner.is_nan()) {
                    return Range::ANYTHING;
                }
                let (low, high) = extremes(&corners);
                return Range { low, high, nan, negative_zero: true };
            }
            if x.low >= 0.0 && y.low >= 0.0 && !y.negative_zero {
                return Range {
                    low: if y.high == f64::INFINITY { 0.0 } else { x.low / y.high },
                    high: f64::INFINITY,
                    nan,
                    negative_zero: x.negative_zero,
                };
            }
            Range { nan, ..Range::ANYTHING }
        }
        Primitive::Sqrt => Range {
            nan: nan || x.low < 0.0,
            negative_zero: x.negative_zero,
            ..Range::new(x.low.max(0.0).sqrt(), x.high.max(0.0).sqrt())
        },
        Primitive::Floor => x.growing(f64::floor),
        Primitive::Ceil => x.growing(f64::ceil),
        Primitive::Abs => {
            let low = if x.contains_zero() { 0.0 } else { x.low.abs().min(x.high.abs()) };
            Range { low, high: x.magnitude(), nan, negative_zero: false }
        }
        Primitive::Min | Primitive::Max => {
            // The second operand where either is NaN.
            let negative_zero = x.negative_zero || y.negative_zero;
            if nan {
                return Range { nan: y.nan, negative_zero, ..x.hull(y) };
            }
            let (low, high) = if primitive == Primitive::Min {
                (x.low.min(y.low), x.high.min(y.high))
            } else {
                (x.low.max(y.low), x.high.max(y.high))
            };
            Range { low, high, nan: false, negative_zero }
        }
        Primitive::Exp => Range { negative_zero: false, ..x.growing(f64::exp) },
        Primitive::Exp2 => Range { negative_zero: false, ..x.growing(f64::exp2) },
        Primitive::Log => Range { nan: nan || x.low < 0.0, ..x.growing(|x| x.max(0.0).ln()) },
        Primitive::Log2 => Range { nan: nan || x.low < 0.0, ..x.growing(|x| x.max(0.0).log2()) },
        Primitive::Pow => {
            if !x.not_negative() || y.nan {
                return Range::ANYTHING;
            }
            // A base near 1 that rounding takes beyond it grows without bound only with an unbounded exponent.
            let high = if y.low >= 0.0 && x.high < f64::INFINITY && y.high < f64::INFINITY {
                x.high.max(1.0).powf(y.high)
            } else {
                f64::INFINITY
            };
            let negative_zero = x.negative_zero;
            let low = if negative_zero && y.low < 0.0 { f64::NEG_INFINITY } else { 0.0 };
            Range { low, high, nan: false, negative_zero }
        }
        Primitive::Sin | Primitive::Cos => Range { nan: nan || x.infinite(), ..Range::new(-1.0, 1.0) },
        Primitive::Tan => Range { nan: nan || x.infinite(), ..Range::ANYTHING },
        Primitive::Asin => Range { nan: !x.within(1.0), ..Range::new(-FRAC_PI_2 - 1e-6, FRAC_PI_2 + 1e-6) },
        Primitive::Acos => Range { nan: !x.within(1.0), negative_zero: false, ..Range::new(0.0, PI + 1e-6) },
        Primitive::Atan => Range { nan, ..Range::new(-FRAC_PI_2 - 1e-6, FRAC_PI_2 + 1e-6) },
        Primitive::Atan2 => Range { nan, ..Range::new(-PI - 1e-6, PI + 1e-6) },
        Primitive::Perlin => anything,
        Primitive::Less | Primitive::LessEqual | Primitive::Equal | Primitive::And | Primitive::Or | Primitive::Not => {
            Range { negative_zero: false, ..Range::new(0.0, 1.0) }
        }
        Primitive::Select => operands[1].hull(operands[2]),
    }
}

fn extremes(values: &[f64]) -> (f64, f64) {
    values.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| (low.min(*value), high.max(*value)))
}
