//! Derivatives of nodes of a graph by components of parameters, as nodes of the same graph (forward mode: Wengert,
//! "A simple automatic derivative evaluation program", 1964; Griewank and Walther, *Evaluating Derivatives*, chapter
//! 3).
//!
//! A derivative is computed like any formula, by every backend. Where an operation has a kink, the derivative is that
//! of the branch that its value comes from. Whole numbers (`floor`) and conditions do not change. Noise, textures
//! and measured materials have no formula for their slope; it is measured between two points beside the operands.
//!
//! A change that is 0 stays 0, whatever stands beside it: at `sqrt(max(0, x))` with x < 0 the derivative is 0 and not
//! the product of 0 and infinity. So does an exponential or a quotient that is 0, because it went there fastest.

use crate::formula::ParameterId;
use crate::formula::graph::{Graph, Node, NodeId};
use crate::lang::scalars::{Primitive, Recorder, Scalars};
use std::f32::consts::LN_2;

/// The derivatives of `roots` by each component of a parameter in `by`. The result has a list for each of `by`, with
/// the derivative of each root in it.
pub fn derivatives(graph: &mut Graph, roots: &[NodeId], by: &[(ParameterId, u8)]) -> Vec<Vec<NodeId>> {
    let zero = graph.record_constant(0.0);
    let mut by_one = |moved: &(ParameterId, u8)| {
        let seed =
            |graph: &mut Graph, parameter, component| ((parameter, component) == *moved).then(|| graph.record_constant(1.0));
        changes(graph, roots, &seed).into_iter().map(|change| change.unwrap_or(zero)).collect()
    };
    by.iter().map(&mut by_one).collect()
}

/// How `roots` change where components of parameters change by the nodes that `seed` gives. `None` stands for 0, there
/// and in the result.
pub(super) fn changes(
    graph: &mut Graph,
    roots: &[NodeId],
    seed: &dyn Fn(&mut Graph, ParameterId, u8) -> Option<NodeId>,
) -> Vec<Option<NodeId>> {
    let needed = graph.needed(roots);
    let mut changes: Vec<Option<NodeId>> = vec![None; needed.len()];
    for index in (0..needed.len()).filter(|index| needed[*index]) {
        let id = NodeId(index as u32);
        changes[index] = match graph.node(id) {
            Node::Constant(_) | Node::Variable(..) => None,
            Node::Parameter(parameter, component) => seed(graph, parameter, component),
            Node::Apply(primitive, operands) => {
                let operands = &operands[..primitive.arity()];
                let of: Vec<Option<NodeId>> = operands.iter().map(|operand| changes[operand.0 as usize]).collect();
                let changes = Changes { graph, value: id, operands };
                if of.iter().all(Option::is_none) { None } else { changes.of_apply(primitive, &of) }
            }
        };
    }
    roots.iter().map(|root| changes[root.0 as usize]).collect()
}

/// The rules for one operation: how its value changes with its operands.
struct Changes<'c> {
    graph: &'c mut Graph,
    /// The node of the operation itself.
    value: NodeId,
    operands: &'c [NodeId],
}

impl Changes<'_> {
    /// The change of the value from the changes of the operands; `None` stands for 0. One of them is not.
    fn of_apply(mut self, primitive: Primitive, of: &[Option<NodeId>]) -> Option<NodeId> {
        let (x, y) = (self.operands[0], self.operands.get(1).copied().unwrap_or(self.operands[0]));
        let (dx, dy) = (of[0], of.get(1).copied().flatten());
        let value = self.value;
        match primitive {
            Primitive::Neg => dx.map(|dx| self.graph.neg(dx)),
            Primitive::Add => self.sum(dx, dy),
            Primitive::Sub => {
                let dy = dy.map(|dy| self.graph.neg(dy));
                self.sum(dx, dy)
            }
            Primitive::Mul => {
                let (left, right) = (self.times(y, dx), self.times(x, dy));
                self.sum(left, right)
            }
            Primitive::Div => {
                // (dx − value · dy)/y
                let falling = self.vanishing_times(value, dy).map(|change| self.graph.neg(change));
                let change = self.sum(dx, falling)?;
                Some(self.quotient(change, y))
            }
            Primitive::Sqrt => {
                let double = Scalars::add(self.graph, value, value);
                dx.map(|dx| self.quotient(dx, double))
            }
            Primitive::Exp => self.vanishing_times(value, dx),
            Primitive::Exp2 => {
                let change = self.vanishing_times(value, dx);
                self.scaled(LN_2, change)
            }
            Primitive::Log => dx.map(|dx| self.quotient(dx, x)),
            Primitive::Log2 => {
                let change = dx.map(|dx| self.quotient(dx, x));
                self.scaled(LN_2.recip(), change)
            }
            Primitive::Pow => self.of_power([x, y], [dx, dy]),
            Primitive::Sin | Primitive::Cos | Primitive::Tan => {
                let slope = self.circular_slope(primitive, x);
                self.times(slope, dx)
            }
            Primitive::Asin | Primitive::Acos | Primitive::Atan => {
                let divisor = self.inverse_divisor(primitive, x);
                dx.map(|dx| self.quotient(dx, divisor))
            }
            Primitive::Atan2 => self.of_angle([x, y], [dx, dy]),
            Primitive::Abs => {
                let zero = self.graph.record_constant(0.0);
                let negative = self.graph.less(x, zero);
                let opposite = dx.map(|dx| self.graph.neg(dx));
                self.chosen(negative, opposite, dx)
            }
            Primitive::Min => {
                let first = self.graph.less(x, y);
                self.chosen(first, dx, dy)
            }
            Primitive::Max => {
                let first = self.graph.less(y, x);
                self.chosen(first, dx, dy)
            }
            Primitive::Select => self.chosen(x, dy, of[2]),
            Primitive::Perlin | Primitive::Texture | Primitive::Measured => Some(self.measured(primitive, of)),
            Primitive::Floor
            | Primitive::Ceil
            | Primitive::Less
            | Primitive::LessEqual
            | Primitive::Equal
            | Primitive::And
            | Primitive::Or
            | Primitive::Not => None,
        }
    }

    fn sum(&mut self, x: Option<NodeId>, y: Option<NodeId>) -> Option<NodeId> {
        match (x, y) {
            (Some(x), Some(y)) => Some(Scalars::add(self.graph, x, y)),
            (one, other) => one.or(other),
        }
    }

    /// A factor times a change, which stays 0 where it is 0.
    fn times(&mut self, factor: NodeId, change: Option<NodeId>) -> Option<NodeId> {
        let change = change?;
        if Graph::constant(self.graph, change) == Some(1.0) {
            return Some(factor);
        }
        let product = self.graph.mul(factor, change);
        Some(self.unless_zero(change, product))
    }

    /// The same, for a factor that goes to 0 faster than anything grows: where it is 0, so is the product. So the
    /// derivative of `exp(-1/x)` is 0 at 0.
    fn vanishing_times(&mut self, factor: NodeId, change: Option<NodeId>) -> Option<NodeId> {
        let product = self.times(factor, change)?;
        Some(if product == factor { product } else { self.unless_zero(factor, product) })
    }

    fn scaled(&mut self, factor: f32, change: Option<NodeId>) -> Option<NodeId> {
        let factor = self.graph.record_constant(factor);
        change.map(|change| self.graph.mul(factor, change))
    }

    /// A change divided by a number; it stays 0 where it is 0.
    fn quotient(&mut self, change: NodeId, divisor: NodeId) -> NodeId {
        let quotient = self.graph.div(change, divisor);
        self.unless_zero(change, quotient)
    }

    /// 0 where the change is 0, else this result.
    fn unless_zero(&mut self, change: NodeId, result: NodeId) -> NodeId {
        if Graph::constant(self.graph, change).is_some_and(|change| change != 0.0) {
            return result;
        }
        let zero = self.graph.record_constant(0.0);
        let unchanged = self.graph.equal(change, zero);
        self.graph.select(unchanged, zero, result)
    }

    /// The change of what a condition chooses.
    fn chosen(&mut self, condition: NodeId, then: Option<NodeId>, otherwise: Option<NodeId>) -> Option<NodeId> {
        if then.is_none() && otherwise.is_none() {
            return None;
        }
        let zero = self.graph.record_constant(0.0);
        Some(self.graph.select(condition, then.unwrap_or(zero), otherwise.unwrap_or(zero)))
    }

    /// d(xʸ) = y·x^(y−1)·dx + xʸ·ln|x|·dy. Where xʸ is 0, so is the second term.
    fn of_power(&mut self, [x, y]: [NodeId; 2], [dx, dy]: [Option<NodeId>; 2]) -> Option<NodeId> {
        let by_base = dx.and_then(|dx| {
            let one = self.graph.record_constant(1.0);
            let less = self.graph.sub(y, one);
            let power = self.graph.pow(x, less);
            let slope = self.graph.mul(y, power);
            self.vanishing_times(slope, Some(dx))
        });
        let by_exponent = dy.and_then(|dy| {
            let size = self.graph.abs(x);
            let logarithm = self.graph.log(size);
            let slope = self.graph.mul(self.value, logarithm);
            let slope = self.unless_zero(self.value, slope);
            self.vanishing_times(slope, Some(dy))
        });
        self.sum(by_base, by_exponent)
    }

    /// How fast a sine, a cosine or a tangent grows.
    fn circular_slope(&mut self, primitive: Primitive, x: NodeId) -> NodeId {
        if primitive == Primitive::Sin {
            self.graph.cos(x)
        } else if primitive == Primitive::Cos {
            let sine = self.graph.sin(x);
            self.graph.neg(sine)
        } else {
            let (one, square) = (self.graph.record_constant(1.0), self.graph.mul(self.value, self.value));
            Scalars::add(self.graph, one, square)
        }
    }

    /// What a change is divided by for an arc sine, an arc cosine or an arc tangent: √(1 − x²), −√(1 − x²), 1 + x².
    fn inverse_divisor(&mut self, primitive: Primitive, x: NodeId) -> NodeId {
        let (one, square) = (self.graph.record_constant(1.0), self.graph.mul(x, x));
        if primitive == Primitive::Atan {
            return Scalars::add(self.graph, one, square);
        }
        let rest = self.graph.sub(one, square);
        let root = self.graph.sqrt(rest);
        if primitive == Primitive::Acos { self.graph.neg(root) } else { root }
    }

    /// The angle of (x, y): (x·dy − y·dx)/(x² + y²). The operands are y and x.
    fn of_angle(&mut self, [y, x]: [NodeId; 2], [dy, dx]: [Option<NodeId>; 2]) -> Option<NodeId> {
        let falling = self.times(y, dx).map(|change| self.graph.neg(change));
        let rising = self.times(x, dy);
        let change = self.sum(rising, falling)?;
        let (x, y) = (self.graph.mul(x, x), self.graph.mul(y, y));
        let square = Scalars::add(self.graph, x, y);
        Some(self.quotient(change, square))
    }

    /// The change of noise, a texture or a measured material, from its values at two points on both sides of the
    /// operands, in the direction in which they change.
    fn measured(&mut self, primitive: Primitive, of: &[Option<NodeId>]) -> NodeId {
        /// How far the points are away, as the sum over the operands. With `f32`, less would be rounded away.
        const STEP: f32 = 1.0 / 512.0;
        let (zero, step) = (self.graph.record_constant(0.0), self.graph.record_constant(STEP));
        let mut size = zero;
        for change in of.iter().flatten() {
            let change = self.graph.abs(*change);
            size = Scalars::add(self.graph, size, change);
        }
        let scale = self.graph.div(step, size);
        let scale = self.unless_zero(size, scale);
        let mut at = |sign: f32| {
            let sign = self.graph.record_constant(sign);
            let scale = self.graph.mul(sign, scale);
            let moved = self.operands.iter().zip(of).map(|(operand, change)| match change {
                Some(change) => {
                    let change = self.graph.mul(scale, *change);
                    Scalars::add(self.graph, *operand, change)
                }
                None => *operand,
            });
            let moved: Vec<NodeId> = moved.collect();
            primitive.apply(self.graph, &moved)
        };
        let (high, low) = (at(1.0), at(-1.0));
        let difference = self.graph.sub(high, low);
        let double = Scalars::add(self.graph, scale, scale);
        let slope = self.graph.div(difference, double);
        self.unless_zero(size, slope)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::formula::Formula;
    use crate::lang::scalars::Doubles;
    use crate::lang::source::Source;

    /// The derivative of an expression by `p`, where `p` and `alpha` have these values, in double precision.
    fn slope(expression: &str, p: f64, alpha: f64) -> f64 {
        let text = format!("body_specific; p: scalar; formula; = <{expression}>;");
        let source = Source::new("test", text);
        let (formula, _) = Formula::parse(&source).unwrap_or_else(|errors| panic!("{}", errors.located(&source)));
        let mut graph = Graph::new(&formula);
        let by = formula.parameter_named("p").unwrap();
        let roots = graph.result();
        let slopes = derivatives(&mut graph, &roots, &[(by, 0)]);
        let leaf = |id| match graph.node(id) {
            Node::Parameter(..) => p,
            Node::Variable(..) => alpha,
            Node::Constant(_) | Node::Apply(..) => unreachable!("no leaf"),
        };
        graph.evaluate_with(&mut Doubles, &slopes[0][..1], leaf)[0]
    }

    #[test]
    fn closed_forms() {
        let p = 0.3_f64;
        let cases: &[(&str, f64)] = &[
            ("alpha", 0.0),
            ("p", 1.0),
            ("-p*p*p", -3.0 * p * p),
            ("alpha - p", -1.0),
            ("p - 3*p", -2.0),
            ("alpha/p", -0.7 / (p * p)),
            ("p/alpha", 1.0 / 0.7),
            ("sqrt(p)", 0.5 / p.sqrt()),
            ("exp(2*p)", 2.0 * (2.0 * p).exp()),
            ("exp2(p)", p.exp2() * std::f64::consts::LN_2),
            ("log(p)", 1.0 / p),
            ("log2(p)", 1.0 / (p * std::f64::consts::LN_2)),
            ("pow(alpha, p)", 0.7_f64.powf(p) * 0.7_f64.ln()),
            ("pow(p, alpha)", 0.7 * p.powf(-0.3)),
            ("pow(p, p)", p.powf(p) * (p.ln() + 1.0)),
            ("sin(p)", p.cos()),
            ("cos(p)", -p.sin()),
            ("tan(p)", 1.0 / p.cos().powi(2)),
            ("asin(p)", 1.0 / (1.0 - p * p).sqrt()),
            ("acos(p)", -1.0 / (1.0 - p * p).sqrt()),
            ("atan(p)", 1.0 / (1.0 + p * p)),
            ("atan2(p, alpha)", 0.7 / (p * p + 0.49)),
            ("atan2(alpha, p)", -0.7 / (p * p + 0.49)),
            ("abs(p - 1)", -1.0),
            ("min(p, alpha) + 2*max(p, alpha)", 1.0),
            ("max(p, 0.1)", 1.0),
            ("if(p < alpha, 3*p, 5*p)", 3.0),
            ("floor(10*p) + ceil(p)", 0.0),
        ];
        for (expression, wanted) in cases {
            let found = slope(expression, p, 0.7_f32.into());
            // Constants such as ln 2 have the precision of `f32`.
            assert!((found - wanted).abs() < 1e-6 * wanted.abs().max(1.0), "{expression}: {found}, {wanted}");
        }
    }

    #[test]
    fn what_does_not_change_has_no_infinite_slope() {
        for expression in [
            "sqrt(max(0, -p))",
            "pow(max(0, -p), 0.5)",
            "pow(max(0, -1), p)",
            "log(max(0, -p))",
            "alpha/max(0, -p)",
            "tanh(1e3 + p)",
            "exp(-1/max(0, -p))",
        ] {
            assert_eq!(slope(expression, 0.3, 0.7), 0.0, "{expression}");
        }
    }

    #[test]
    fn noise_has_the_slope_between_its_neighbours() {
        let (expression, p, h) = ("perlin(<p*alpha, 0.3, p>, 2, 2, 3)", 0.37, 1e-4);
        let at = |p: f64| {
            let point = [p * 0.7, 0.3, p];
            crate::lang::noise::perlin(point, 2.0, 2.0, 3.0)
        };
        let wanted = (at(p + h) - at(p - h)) / (2.0 * h);
        let found = slope(expression, p, 0.7);
        assert!((found - wanted).abs() < 2e-3 * wanted.abs(), "{found}, {wanted}");
    }
}
