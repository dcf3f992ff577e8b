//! Rewrites of a formula's graph that make more of it static or uniform, so that less is left to do for every record and frame.
//!
//! 1. A power of a static base becomes 2 to the power of the exponent times the base's logarithm, which is static.
//! 2. Products are regrouped: uniform factors together, static factors together, the rest as it is.
//! 3. The contribution itself, which is linear in its terms, becomes a sum of products `uniform · rest`, so that ki, colours and weights
//!    are multiplied once a frame rather than once a record.
//!
//! Sums are regrouped only in the contribution (3), where rounding errors of the size of a term's stay that small: inside of, say, a
//! power they could be amplified. And everything is done only where ranges prove that nothing becomes infinite or NaN that was not.

use crate::formula::Formula;
use crate::formula::binding::BindingTime;
use crate::formula::graph::{Graph, Node, NodeId, walk};
use crate::formula::range::{self, Range, UNIT_SLACK};
use crate::lang::scalars::{Primitive, Recorder};
use std::collections::HashMap;

/// Factors of regrouped products are at most so large, so that no partial product overflows, and what underflows does not matter.
const TAME_FACTOR: f64 = 1e6;
/// Terms that are multiplied out are at most so large: their rounding errors are then far below what a colour shows.
const TAME_TERM: f64 = 64.0;
/// By rounding alone terms may grow so large nevertheless.
const LARGEST_TERM: f64 = 1e20;
/// The logarithm of a power of a cosine, as far as rounding takes it beyond 0.
const BEYOND_ONE: f64 = 60.0;
/// A sum of more terms stays as it is.
const MOST_TERMS: usize = 6;

/// The rewritten graph, and in it the nodes that stand for `roots`.
pub(super) fn rewrite(old: &Graph, roots: [NodeId; 3], formula: &Formula) -> (Graph, [NodeId; 3]) {
    let mut rewriter = Rewriter { graph: Graph::empty(), times: Vec::new(), ranges: Vec::new(), exact: Vec::new(), formula };
    let mut new: Vec<NodeId> = Vec::with_capacity(old.len());
    for index in 0..old.len() {
        let node = old.node(NodeId(index as u32));
        let operands: Vec<NodeId> = node.operands().iter().map(|operand| new[operand.0 as usize]).collect();
        new.push(match node {
            Node::Constant(_) | Node::Variable(..) | Node::Parameter(..) => rewriter.leaf(node),
            Node::Apply(primitive, _) => rewriter.apply(primitive, &operands),
        });
    }
    let roots = roots.map(|root| rewriter.linear(new[root.0 as usize]));
    // What was tried on the way and not used is left behind.
    rewriter.graph.reachable(roots)
}

struct Rewriter<'f> {
    graph: Graph,
    times: Vec<BindingTime>,
    ranges: Vec<Range>,
    /// The ranges if directions were of unit length exactly.
    exact: Vec<Range>,
    formula: &'f Formula,
}

/// Whether a power by way of a logarithm of single precision is good enough: its relative error grows with the logarithm of the power.
/// Where the base is at most 1, powers of large logarithm are next to nothing (or, by negative exponents, beyond any colour).
fn is_accurate(base: Range, exponent: Range) -> bool {
    const LARGEST_BASE: f64 = 1.0 + 1e-5;
    const LARGEST_LOGARITHM: f64 = 8.0;
    let logarithm = if base.low > 0.0 { base.low.log2().abs().max(base.high.log2().abs()) } else { f64::INFINITY };
    base.magnitude() <= LARGEST_BASE || logarithm * exponent.magnitude() <= LARGEST_LOGARITHM
}

/// A value as `uniform · rest`; where one is missing, it is 1.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Product {
    uniform: Option<NodeId>,
    rest: Option<NodeId>,
}

impl Rewriter<'_> {
    fn leaf(&mut self, node: Node) -> NodeId {
        let id = self.graph.insert(node);
        self.learn();
        id
    }

    /// The node of a primitive, as it is.
    fn record(&mut self, primitive: Primitive, operands: &[NodeId]) -> NodeId {
        let id = self.graph.record(primitive, operands);
        self.learn();
        id
    }

    fn constant(&mut self, value: f32) -> NodeId {
        let id = self.graph.record_constant(value);
        self.learn();
        id
    }

    /// Binding times and ranges of nodes that are new.
    fn learn(&mut self) {
        for index in self.times.len()..self.graph.len() {
            let id = NodeId(index as u32);
            self.times.push(BindingTime::of(&self.graph, id, &self.times));
            self.ranges.push(range::range(&self.graph, id, self.formula, &self.ranges, UNIT_SLACK));
            self.exact.push(range::range(&self.graph, id, self.formula, &self.exact, 0.0));
        }
    }

    fn time(&self, id: NodeId) -> BindingTime {
        self.times[id.0 as usize]
    }

    fn range(&self, id: NodeId) -> Range {
        self.ranges[id.0 as usize]
    }

    /// A primitive on rewritten operands.
    fn apply(&mut self, primitive: Primitive, operands: &[NodeId]) -> NodeId {
        match (primitive, operands) {
            (Primitive::Pow, &[base, exponent]) => self.power(base, exponent),
            (Primitive::Mul, &[x, y]) => self.product(x, y),
            (primitive, operands) => self.record(primitive, operands),
        }
    }

    fn is_static(&self, id: NodeId) -> bool {
        matches!(self.time(id), BindingTime::Static(_))
    }

    fn is_uniform(&self, id: NodeId) -> bool {
        matches!(self.time(id), BindingTime::Uniform | BindingTime::Constant)
    }

    /// xʸ = 2^(y·log₂|x|), with the sign that a negative base gives. The logarithm is static, where the base is.
    fn power(&mut self, base: NodeId, exponent: NodeId) -> NodeId {
        let (x, y) = (self.range(base), self.range(exponent));
        let changing = matches!(self.time(exponent), BindingTime::Uniform | BindingTime::Dynamic);
        if !self.is_static(base) || !changing || x.nan || y.nan || !is_accurate(x, y) {
            return self.record(Primitive::Pow, &[base, exponent]);
        }
        // The logarithm of 0 is taken as a finite number, so that 0 times it is 0 (x⁰ is 1, for 0 and ∞ too); and exponents as finite
        // ones, and other than 0 as of some size, so that the product is beyond the range of 2ˣ (or 0, for the base 1).
        let magnitude = if x.not_negative() { base } else { self.record(Primitive::Abs, &[base]) };
        let logarithm = self.record(Primitive::Log2, &[magnitude]);
        let (least, largest) = (self.constant(f32::MIN), self.constant(f32::MAX));
        let logarithm = self.record(Primitive::Max, &[least, logarithm]);
        let logarithm = self.record(Primitive::Min, &[largest, logarithm]);
        let bounded = self.bounded_exponent(exponent);
        let mut product = self.record(Primitive::Mul, &[bounded, logarithm]);
        // The power of a cosine that rounding takes beyond 1 is infinite only by an exponent without bounds, where the next number below gives 0.
        // Whatever it is taken for, a bounded one can be multiplied out.
        if x.high > 1.0 && self.exact[base.0 as usize].high <= 1.0 && self.range(product).high > BEYOND_ONE {
            let most = self.constant(BEYOND_ONE as f32);
            product = self.record(Primitive::Min, &[most, product]);
        }
        let power = self.record(Primitive::Exp2, &[product]);
        if x.not_negative() && (y.low >= 0.0 || !x.negative_zero) {
            return power;
        }
        let sign = self.sign_of_power(base, exponent);
        self.record(Primitive::Mul, &[sign, power])
    }

    /// The exponent within ±`f32::MAX`, and where it is not 0, at least 1e-36 in magnitude.
    fn bounded_exponent(&mut self, exponent: NodeId) -> NodeId {
        const LEAST: f32 = 1e-36;
        let range = self.range(exponent);
        let mut bounded = exponent;
        if range.low < f64::from(LEAST) && range.high > f64::from(-LEAST) {
            let [zero, up, down] = [0.0, LEAST, -LEAST].map(|value| self.constant(value));
            let mut small = zero;
            if range.low < 0.0 {
                let at_most = self.record(Primitive::Min, &[down, exponent]);
                let negative = self.record(Primitive::Less, &[exponent, zero]);
                small = self.record(Primitive::Select, &[negative, at_most, small]);
            }
            bounded = small;
            if range.high > 0.0 {
                let at_least = self.record(Primitive::Max, &[up, exponent]);
                let positive = self.record(Primitive::Less, &[zero, exponent]);
                bounded = self.record(Primitive::Select, &[positive, at_least, small]);
            }
        }
        if range.high == f64::INFINITY {
            let largest = self.constant(f32::MAX);
            bounded = self.record(Primitive::Min, &[largest, bounded]);
        }
        if range.low == f64::NEG_INFINITY {
            let least = self.constant(f32::MIN);
            bounded = self.record(Primitive::Max, &[least, bounded]);
        }
        bounded
    }

    /// What |x|ʸ has to be multiplied with where x may be negative or −0: 1, −1, or NaN. A static number tells the case, so that
    /// the rest is uniform where the exponent is.
    fn sign_of_power(&mut self, base: NodeId, exponent: NodeId) -> NodeId {
        let [zero, half, one, two, minus] = [0.0, 0.5, 1.0, 2.0, -1.0].map(|value| self.constant(value));
        let nan = self.constant(f32::NAN);
        // −0 and −∞ have powers with broken exponents, as if they were 0 and ∞.
        let (least, infinity) = (self.constant(f32::MIN), self.constant(f32::INFINITY));
        let endless = self.record(Primitive::Less, &[base, least]);
        let kind = self.record(Primitive::Select, &[endless, two, one]);
        let reciprocal = self.record(Primitive::Div, &[one, base]);
        let minus_infinity = self.record(Primitive::Neg, &[infinity]);
        let negative_zero = self.record(Primitive::Equal, &[reciprocal, minus_infinity]);
        let is_zero = self.record(Primitive::Equal, &[base, zero]);
        let negative_zero = self.record(Primitive::And, &[negative_zero, is_zero]);
        let other = self.record(Primitive::Select, &[negative_zero, two, zero]);
        let negative = self.record(Primitive::Less, &[base, zero]);
        let class = self.record(Primitive::Select, &[negative, kind, other]);

        let floor = self.record(Primitive::Floor, &[exponent]);
        let whole = self.record(Primitive::Equal, &[floor, exponent]);
        let halved = self.record(Primitive::Mul, &[exponent, half]);
        let floor = self.record(Primitive::Floor, &[halved]);
        let even = self.record(Primitive::Equal, &[floor, halved]);
        let of_whole = self.record(Primitive::Select, &[even, one, minus]);
        let odd_or_one = self.record(Primitive::Select, &[whole, of_whole, one]);
        let odd_or_nan = self.record(Primitive::Select, &[whole, of_whole, nan]);

        let ordinary = self.record(Primitive::Less, &[class, half]);
        let endless = self.record(Primitive::Less, &[one, class]);
        let signed = self.record(Primitive::Select, &[endless, odd_or_one, odd_or_nan]);
        self.record(Primitive::Select, &[ordinary, one, signed])
    }

    /// A product with its uniform factors together and its static factors together.
    fn product(&mut self, x: NodeId, y: NodeId) -> NodeId {
        let plain = self.graph.record(Primitive::Mul, &[x, y]);
        self.learn();
        if self.time(plain) != BindingTime::Dynamic {
            return plain;
        }
        let mut factors = Vec::new();
        self.factors(x, &mut factors);
        self.factors(y, &mut factors);
        if !factors.iter().all(|factor| self.range(*factor).within(TAME_FACTOR)) {
            return plain;
        }
        let total: f64 = factors.iter().map(|factor| self.range(*factor).magnitude().max(1.0)).product();
        if total > TAME_FACTOR.powi(4) {
            return plain;
        }
        let [mut uniform, mut fixed, mut rest] = [None; 3];
        for factor in factors {
            let group = match self.time(factor) {
                BindingTime::Constant | BindingTime::Uniform => &mut uniform,
                BindingTime::Static(_) => &mut fixed,
                BindingTime::Dynamic => &mut rest,
            };
            let before = *group;
            let after = self.times(before, Some(factor));
            match self.time(factor) {
                BindingTime::Constant | BindingTime::Uniform => uniform = after,
                BindingTime::Static(_) => fixed = after,
                BindingTime::Dynamic => rest = after,
            }
        }
        let varying = self.times(fixed, rest);
        self.times(uniform, varying).unwrap_or(plain)
    }

    /// The product of two factors that may be missing.
    fn times(&mut self, x: Option<NodeId>, y: Option<NodeId>) -> Option<NodeId> {
        match (x, y) {
            (Some(x), Some(y)) => Some(self.record(Primitive::Mul, &[x, y])),
            (one, other) => one.or(other),
        }
    }

    /// The factors of a product: as it was built by [`product`](Self::product), uniform · (static · rest), one of each at most.
    fn factors(&self, id: NodeId, into: &mut Vec<NodeId>) {
        let mut at = id;
        for _ in 0..2 {
            match self.graph.node(at) {
                Node::Apply(Primitive::Mul, operands)
                    if self.time(at) == BindingTime::Dynamic && self.time(operands[0]) != BindingTime::Dynamic =>
                {
                    into.push(operands[0]);
                    at = operands[1];
                }
                Node::Apply(..) | Node::Constant(_) | Node::Variable(..) | Node::Parameter(..) => break,
            }
        }
        into.push(at);
    }

    /// A value as a sum of products `uniform · rest`, with all that is uniform multiplied out.
    fn linear(&mut self, root: NodeId) -> NodeId {
        let mut sums = HashMap::new();
        for id in walk(root, |id| self.linear_operands(id)) {
            let terms = self.terms(id, &sums);
            sums.insert(id, terms);
        }
        self.sum(&sums[&root])
    }

    /// The operands that a node is a sum or a product of, but for uniform factors; none where it is neither, or is not dynamic.
    #[expect(clippy::wildcard_enum_match_arm, reason = "only what is linear is taken apart")]
    fn linear_operands(&self, id: NodeId) -> Vec<NodeId> {
        let Node::Apply(primitive, [x, y, ..]) = self.graph.node(id) else { return Vec::new() };
        match primitive {
            _ if self.time(id) != BindingTime::Dynamic => Vec::new(),
            Primitive::Add | Primitive::Sub => vec![x, y],
            Primitive::Mul if self.is_uniform(x) => vec![y],
            Primitive::Mul | Primitive::Div if self.is_uniform(y) => vec![x],
            Primitive::Neg => vec![x],
            Primitive::Mul => vec![x, y],
            _ => Vec::new(),
        }
    }

    /// The terms of a product of two values that are not uniform, where one of them is a sum: `Σ uniform · (other · rest)`, if it is hardly more
    /// work so. Components mostly differ in what is uniform, and share the rest.
    fn multiplied_out(&mut self, x: NodeId, y: NodeId, known: &HashMap<NodeId, Vec<Product>>) -> Option<Vec<Product>> {
        let (sum, other) = match (&*known[&x], &*known[&y]) {
            ([other], sum) | (sum, [other]) if sum.len() > 1 => (sum, other),
            _ => return None,
        };
        let work = sum.iter().filter(|term| term.rest.is_some()).count();
        if work > 2 || !self.is_tame(other) || !sum.iter().all(|term| self.is_tame(term)) {
            return None;
        }
        let scaled = |term: &Product| Product {
            uniform: self.times(other.uniform, term.uniform),
            rest: self.times(other.rest, term.rest),
        };
        Some(sum.iter().map(scaled).collect())
    }

    /// The terms of a value, from those of its linear operands; itself where there are too many, or too large ones.
    fn terms(&mut self, id: NodeId, known: &HashMap<NodeId, Vec<Product>>) -> Vec<Product> {
        let itself = if self.is_uniform(id) {
            Product { uniform: Some(id), rest: None }
        } else {
            Product { uniform: None, rest: Some(id) }
        };
        let Node::Apply(primitive, [x, y, ..]) = self.graph.node(id) else { return vec![itself] };
        let terms = match (primitive, &*self.linear_operands(id)) {
            (_, []) => None,
            (Primitive::Add | Primitive::Sub, _) => {
                let mut sum = known[&x].clone();
                for term in &known[&y] {
                    let term = if primitive == Primitive::Sub { self.negated(*term) } else { *term };
                    self.gather(&mut sum, term);
                }
                (sum.len() <= MOST_TERMS).then_some(sum)
            }
            (Primitive::Mul, [_, _]) => self.multiplied_out(x, y, known),
            (Primitive::Neg, _) => {
                let minus = self.constant(-1.0);
                self.scaled(minus, &known[&x])
            }
            (Primitive::Div, _) => {
                let one = self.constant(1.0);
                let reciprocal = self.record(Primitive::Div, &[one, y]);
                self.scaled(reciprocal, &known[&x])
            }
            (_, [sum, ..]) => self.scaled(if *sum == x { y } else { x }, &known[sum]),
        };
        terms.unwrap_or_else(|| vec![itself])
    }

    /// The terms of `uniform · sum`, if it is no more work so.
    fn scaled(&mut self, uniform: NodeId, terms: &[Product]) -> Option<Vec<Product>> {
        if !self.range(uniform).within(TAME_TERM) {
            return None;
        }
        let bare = terms.iter().filter(|term| term.uniform.is_none()).count();
        // Each term without a uniform factor costs a multiplication more; that of the sum is saved. Of a large term the product must not be
        // taken in another order: the factors alone may be too small for a number.
        if bare > 1 || !terms.iter().all(|term| self.is_tame(term)) {
            return None;
        }
        let scaled = |term: &Product| Product { uniform: self.times(Some(uniform), term.uniform), rest: term.rest };
        Some(terms.iter().map(scaled).collect())
    }

    fn is_tame(&self, term: &Product) -> bool {
        let tame = |id: NodeId| self.exact[id.0 as usize].within(TAME_TERM) && self.range(id).within(LARGEST_TERM);
        [term.uniform, term.rest].into_iter().flatten().all(tame)
    }

    fn negated(&mut self, term: Product) -> Product {
        let minus = self.constant(-1.0);
        Product { uniform: self.times(Some(minus), term.uniform), rest: term.rest }
    }

    /// Adds a term to a sum, together with one that has the same uniform factor (two static ones become one) or the same rest.
    fn gather(&mut self, sum: &mut Vec<Product>, term: Product) {
        let tame = self.is_tame(&term);
        for other in sum.iter_mut() {
            if !tame || !self.is_tame(other) {
                continue;
            }
            if other.rest == term.rest {
                let one = self.constant(1.0);
                let [x, y] = [other.uniform, term.uniform].map(|uniform| uniform.unwrap_or(one));
                other.uniform = Some(self.record(Primitive::Add, &[x, y]));
                return;
            }
            if let (Some(x), Some(y)) = (other.rest, term.rest)
                && other.uniform == term.uniform
                && self.is_static(x)
                && self.is_static(y)
            {
                other.rest = Some(self.record(Primitive::Add, &[x, y]));
                return;
            }
        }
        sum.push(term);
    }

    fn sum(&mut self, terms: &[Product]) -> NodeId {
        let mut total: Option<NodeId> = None;
        for term in terms {
            let value = self.times(term.uniform, term.rest);
            total = match (total, value) {
                (Some(total), Some(value)) => Some(self.record(Primitive::Add, &[total, value])),
                (one, other) => one.or(other),
            };
        }
        match total {
            Some(total) => total,
            None => self.constant(1.0),
        }
    }
}
