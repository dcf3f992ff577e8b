//! Rewrites a formula's graph so that more of it is static or uniform, and less work remains for each record and frame.
//!
//! 1. A power of a static base becomes 2 to the power of the exponent times the logarithm of the base, which is static
//!    (`power`).
//! 2. Products are regrouped: uniform factors together, static factors together, dynamic ones as they are.
//! 3. The contribution, which is linear in its terms, becomes a sum of products `uniform · other`, so that ki, colours
//!    and weights are multiplied once a frame and not once a record.
//!
//! Sums are regrouped only in the contribution (3). There, rounding errors stay as small as those of a term. Inside a
//! power, for example, they could be amplified. A rewrite is done only if intervals prove that it makes no value
//! infinite or NaN that was neither before.

mod power;

use crate::formula::Formula;
use crate::formula::binding_time::BindingTime;
use crate::formula::graph::{Graph, Node, NodeId};
use crate::formula::linear::{Common, LinearForm, Product};
use crate::formula::range::{self, UNIT_SLACK};
use crate::lang::interval::Interval;
use crate::lang::scalars::{Primitive, Recorder};
use std::collections::HashMap;

/// The largest factors of regrouped products: no partial product overflows, and underflow does not matter.
const LARGEST_FACTOR: f64 = 1e6;
/// The largest terms that are multiplied out. Their rounding errors are far below what is visible.
const LARGEST_TERM: f64 = 64.0;
/// How large such terms may become by rounding alone, see [`power`].
const LARGEST_ROUNDED_TERM: f64 = 1e20;
/// Sums of more terms stay as they are.
const MOST_TERMS: usize = 6;

/// The rewritten graph, and the nodes in it that stand for `roots`.
pub(super) fn rewrite(old: &Graph, roots: &[NodeId], formula: &Formula) -> (Graph, Vec<NodeId>) {
    let mut rewriter = Rewriter::new(formula);
    let mut new: Vec<NodeId> = Vec::with_capacity(old.len());
    for index in 0..old.len() {
        let node = old.node(NodeId(index as u32));
        let operands: Vec<NodeId> = node.operands().iter().map(|operand| new[operand.0 as usize]).collect();
        new.push(match node {
            Node::Constant(_) | Node::Variable(..) | Node::Parameter(..) => rewriter.leaf(node),
            Node::Apply(primitive, _) => rewriter.apply(primitive, &operands),
        });
    }
    let roots: Vec<NodeId> = roots.iter().map(|root| rewriter.linear(new[root.0 as usize])).collect();
    // Nodes of abandoned attempts are left out.
    rewriter.graph.reachable(&roots)
}

/// The graph in which these conditions are known, rewritten, with the nodes in it that stand for `roots` and for
/// `kept`. Nodes of variables alone are the same in both graphs.
pub(super) fn specialise(
    old: &Graph,
    known: &HashMap<NodeId, bool>,
    roots: [NodeId; 3],
    kept: &[NodeId],
    formula: &Formula,
) -> (Graph, Vec<NodeId>, Vec<NodeId>) {
    let mut rewriter = Rewriter::new(formula);
    let mut new: Vec<NodeId> = Vec::with_capacity(old.len());
    for index in 0..old.len() {
        let id = NodeId(index as u32);
        let node = old.node(id);
        let operands: Vec<NodeId> = node.operands().iter().map(|operand| new[operand.0 as usize]).collect();
        new.push(match (known.get(&id), node) {
            (Some(holds), _) => rewriter.constant(f32::from(u8::from(*holds))),
            (None, Node::Constant(_) | Node::Variable(..) | Node::Parameter(..)) => rewriter.leaf(node),
            (None, Node::Apply(primitive, _)) => rewriter.apply(primitive, &operands),
        });
    }
    let roots = roots.map(|root| rewriter.linear(new[root.0 as usize]));
    let wanted: Vec<NodeId> = roots.into_iter().chain(kept.iter().map(|id| new[id.0 as usize])).collect();
    let (graph, mut found) = rewriter.graph.reachable(&wanted);
    let kept = found.split_off(roots.len());
    (graph, found, kept)
}

/// A new graph, with the interval and binding time of each node.
struct Rewriter<'f> {
    graph: Graph,
    binding_times: Vec<BindingTime>,
    intervals: Vec<Interval>,
    /// The intervals if directions had exactly unit length.
    exact_intervals: Vec<Interval>,
    formula: &'f Formula,
}

impl<'f> Rewriter<'f> {
    fn new(formula: &'f Formula) -> Self {
        Self {
            graph: Graph::for_parameters_of(formula),
            binding_times: Vec::new(),
            intervals: Vec::new(),
            exact_intervals: Vec::new(),
            formula,
        }
    }

    fn leaf(&mut self, node: Node) -> NodeId {
        let id = self.graph.insert(node);
        self.analyse_new_nodes();
        id
    }

    fn analyse_new_nodes(&mut self) {
        for index in self.binding_times.len()..self.graph.len() {
            let id = NodeId(index as u32);
            self.binding_times.push(BindingTime::of(&self.graph, id, &self.binding_times));
            self.intervals.push(range::interval(&self.graph, id, self.formula, &self.intervals, UNIT_SLACK));
            self.exact_intervals.push(range::interval(&self.graph, id, self.formula, &self.exact_intervals, 0.0));
        }
    }

    fn time(&self, id: NodeId) -> BindingTime {
        self.binding_times[id.0 as usize]
    }

    fn is_static(&self, id: NodeId) -> bool {
        matches!(self.time(id), BindingTime::Static(_))
    }

    fn is_uniform(&self, id: NodeId) -> bool {
        matches!(self.time(id), BindingTime::Uniform | BindingTime::Constant)
    }

    fn interval(&self, id: NodeId) -> Interval {
        self.intervals[id.0 as usize]
    }

    /// A primitive on rewritten operands.
    fn apply(&mut self, primitive: Primitive, operands: &[NodeId]) -> NodeId {
        match (primitive, operands) {
            (Primitive::Pow, &[base, exponent]) => self.power(base, exponent),
            (Primitive::Mul, &[x, y]) => self.product(x, y),
            (primitive, operands) => self.record(primitive, operands),
        }
    }

    /// A product with its uniform factors together and its static factors together.
    fn product(&mut self, x: NodeId, y: NodeId) -> NodeId {
        let plain = self.record(Primitive::Mul, &[x, y]);
        if self.time(plain) != BindingTime::Dynamic {
            return plain;
        }
        let factors: Vec<NodeId> = self.factors(x).into_iter().chain(self.factors(y)).collect();
        if !factors.iter().all(|factor| self.interval(*factor).within(LARGEST_FACTOR)) {
            return plain;
        }
        let largest: f64 = factors.iter().map(|factor| self.interval(*factor).magnitude().max(1.0)).product();
        if largest > LARGEST_FACTOR.powi(4) {
            return plain;
        }
        let [mut uniform, mut fixed, mut dynamic] = [None; 3];
        for factor in factors {
            let group = match self.time(factor) {
                BindingTime::Constant | BindingTime::Uniform => &mut uniform,
                BindingTime::Static(_) => &mut fixed,
                BindingTime::Dynamic => &mut dynamic,
            };
            *group = self.times(*group, Some(factor));
        }
        let varying = self.times(fixed, dynamic);
        self.times(uniform, varying).unwrap_or(plain)
    }

    /// The factors of a product in the form that [`product`](Self::product) gives it, uniform · (static · dynamic), at
    /// most one of each.
    fn factors(&self, id: NodeId) -> Vec<NodeId> {
        let mut factors = Vec::with_capacity(3);
        let mut product = id;
        for _ in 0..2 {
            match self.graph.node(product) {
                Node::Apply(Primitive::Mul, [first, others, ..])
                    if self.time(product) == BindingTime::Dynamic && self.time(first) != BindingTime::Dynamic =>
                {
                    factors.push(first);
                    product = others;
                }
                Node::Apply(..) | Node::Constant(_) | Node::Variable(..) | Node::Parameter(..) => break,
            }
        }
        factors.push(product);
        factors
    }

    /// A value as a sum of products `uniform · other` in which everything uniform is multiplied out.
    fn linear(&mut self, root: NodeId) -> NodeId {
        let Some(sum) = self.sum_of_products(root) else { return root };
        let mut total: Option<NodeId> = None;
        for term in sum {
            let value = self.times(term.outer, term.inner);
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

    /// Whether a term is small enough for sums to be regrouped.
    fn is_small(&self, term: &Product) -> bool {
        let small = |id: NodeId| {
            self.exact_intervals[id.0 as usize].within(LARGEST_TERM) && self.interval(id).within(LARGEST_ROUNDED_TERM)
        };
        [term.outer, term.inner].into_iter().flatten().all(small)
    }

    /// Whether multiplying each term of a sum by a uniform value costs no more than multiplying the sum.
    fn may_scale(&self, sum: &[Product]) -> bool {
        // A term without a uniform factor costs one more multiplication; that of the sum is saved. The factors of a
        // large term must not be multiplied in another order: some alone may be too small for a number.
        let without = sum.iter().filter(|term| term.outer.is_none()).count();
        without <= 1 && sum.iter().all(|term| self.is_small(term))
    }
}

/// Outer factors are uniform. A value that is not linear, or not useful to multiply out, is an inner factor as a whole.
impl LinearForm for Rewriter<'_> {
    fn graph(&self) -> &Graph {
        &self.graph
    }

    fn record(&mut self, primitive: Primitive, operands: &[NodeId]) -> NodeId {
        let id = self.graph.record(primitive, operands);
        self.analyse_new_nodes();
        id
    }

    fn constant(&mut self, value: f32) -> NodeId {
        let id = self.graph.record_constant(value);
        self.analyse_new_nodes();
        id
    }

    fn is_mixed(&self, id: NodeId) -> bool {
        self.time(id) == BindingTime::Dynamic
    }

    fn whole(&self, id: NodeId) -> Option<Product> {
        Some(match self.is_uniform(id) {
            true => Product { outer: Some(id), inner: None },
            false => Product { outer: None, inner: Some(id) },
        })
    }

    fn accepts(&self, sum: &[Product]) -> bool {
        sum.len() <= MOST_TERMS
    }

    fn multiplies(&self, x: &[Product], y: &[Product]) -> bool {
        /// A factor that is not uniform is multiplied into sums of at most this many terms that are not uniform either.
        /// Most components differ in uniform factors only and share the rest.
        const MOST_PRODUCTS: usize = 2;
        match (x, y) {
            ([Product { outer: Some(uniform), inner: None }], sum) | (sum, [Product { outer: Some(uniform), inner: None }]) => {
                self.interval(*uniform).within(LARGEST_TERM) && self.may_scale(sum)
            }
            ([factor], sum) | (sum, [factor]) if sum.len() > 1 => {
                let products = sum.iter().filter(|term| term.inner.is_some()).count();
                products <= MOST_PRODUCTS && self.is_small(factor) && sum.iter().all(|term| self.is_small(term))
            }
            _ => false,
        }
    }

    fn divides(&mut self, sum: &[Product], divisor: NodeId) -> bool {
        let one = self.constant(1.0);
        let reciprocal = self.record(Primitive::Div, &[one, divisor]);
        self.is_uniform(divisor) && self.interval(reciprocal).within(LARGEST_TERM) && self.may_scale(sum)
    }

    fn chooses(&self, _: NodeId) -> bool {
        false
    }

    fn common(&self, one: &Product, other: &Product) -> Option<Common> {
        if !self.is_small(one) || !self.is_small(other) {
            return None;
        }
        let both_static = [one, other].into_iter().all(|term| term.inner.is_some_and(|inner| self.is_static(inner)));
        if one.inner == other.inner {
            Some(Common::Inner)
        } else if one.outer == other.outer && both_static {
            Some(Common::Outer)
        } else {
            None
        }
    }
}
