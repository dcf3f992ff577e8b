//! Values as sums of products, each of an *outer* and an *inner* factor: `Σ outer · inner`.
//!
//! Two analyses split a contribution in this way. [`rewrite`](super::rewrite) collects uniform values in the outer
//! factors, so that they are multiplied once a frame. [`separation`](super::separation) collects the values that a
//! dragged slider moves in the outer factors, so that images of the inner ones can be kept. This module has the common
//! part: which primitives are linear in their operands, and the arithmetic of sums of products. The analyses implement
//! [`LinearForm`] to decide which factor goes to which side, and which sums are useful.

use crate::formula::graph::{Graph, Node, NodeId, walk};
use crate::lang::scalars::Primitive;
use std::collections::HashMap;

/// `outer · inner`; a factor that is missing is 1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Product {
    pub(super) outer: Option<NodeId>,
    pub(super) inner: Option<NodeId>,
}

/// Which factor two products of a sum have in common.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Common {
    Outer,
    Inner,
}

/// How an analysis splits values.
pub(super) trait LinearForm {
    /// The graph of the nodes.
    fn graph(&self) -> &Graph;
    /// The node of a primitive on nodes of the graph, added if it is new.
    fn record(&mut self, primitive: Primitive, operands: &[NodeId]) -> NodeId;
    /// The node of a number, added if it is new.
    fn constant(&mut self, value: f32) -> NodeId;
    /// Whether a node is mixed: it may contain both kinds of factors and must be split.
    fn is_mixed(&self, id: NodeId) -> bool;
    /// A node as a single product. `None` if it is mixed and mixed nodes must be split.
    fn whole(&self, id: NodeId) -> Option<Product>;
    /// Whether a sum is still useful.
    fn accepts(&self, sum: &[Product]) -> bool;
    /// Whether two sums may be multiplied out.
    fn multiplies(&self, x: &[Product], y: &[Product]) -> bool;
    /// Whether the products of a sum may be divided by a node, which is not mixed, one by one.
    fn divides(&mut self, sum: &[Product], divisor: NodeId) -> bool;
    /// Whether a choice between two sums by this condition may be made between their products, one by one.
    fn chooses(&self, condition: NodeId) -> bool;
    /// The common factor by which two products can become one.
    fn common(&self, one: &Product, other: &Product) -> Option<Common>;

    /// A value as a sum of products. `None` if it is not linear and [`whole`](Self::whole) does not accept it as one
    /// product.
    fn sum_of_products(&mut self, root: NodeId) -> Option<Vec<Product>> {
        let mut sums: HashMap<NodeId, Vec<Product>> = HashMap::new();
        for id in walk(root, |id| self.linear_operands(id)) {
            let sum = match self.taken_apart(id, &sums) {
                Some(sum) if self.accepts(&sum) => sum,
                Some(_) | None => vec![self.whole(id)?],
            };
            sums.insert(id, sum);
        }
        sums.remove(&root)
    }

    /// The operands of which a mixed node is a linear combination.
    #[expect(clippy::wildcard_enum_match_arm, reason = "all other primitives are not linear")]
    fn linear_operands(&self, id: NodeId) -> Vec<NodeId> {
        let Node::Apply(primitive, [x, y, z, ..]) = self.graph().node(id) else { return Vec::new() };
        match primitive {
            _ if !self.is_mixed(id) => Vec::new(),
            Primitive::Select if self.chooses(x) => vec![y, z],
            Primitive::Add | Primitive::Sub | Primitive::Mul => vec![x, y],
            Primitive::Neg => vec![x],
            Primitive::Div if !self.is_mixed(y) => vec![x],
            _ => Vec::new(),
        }
    }

    /// The sum of products of a linear node, from those of its operands.
    #[expect(clippy::wildcard_enum_match_arm, reason = "all other primitives are not linear")]
    fn taken_apart(&mut self, id: NodeId, known: &HashMap<NodeId, Vec<Product>>) -> Option<Vec<Product>> {
        if self.linear_operands(id).is_empty() {
            return None;
        }
        let Node::Apply(primitive, [x, y, z, ..]) = self.graph().node(id) else { return None };
        match primitive {
            Primitive::Select => Some(self.chosen(x, &known[&y], &known[&z])),
            Primitive::Add => Some(self.gathered(known[&x].iter().chain(&known[&y]).copied())),
            Primitive::Sub => {
                let subtrahend = self.negated(&known[&y])?;
                Some(self.gathered(known[&x].iter().copied().chain(subtrahend)))
            }
            Primitive::Neg => self.negated(&known[&x]),
            Primitive::Mul => {
                let (x, y) = (&known[&x], &known[&y]);
                self.multiplies(x, y).then(|| self.multiplied(x, y))
            }
            Primitive::Div => self.divides(&known[&x], y).then(|| self.divided(&known[&x], y)),
            _ => None,
        }
    }

    /// Each product of one sum times each product of another.
    fn multiplied(&mut self, x: &[Product], y: &[Product]) -> Vec<Product> {
        let mut products = Vec::with_capacity(x.len() * y.len());
        for (one, other) in x.iter().flat_map(|one| y.iter().map(move |other| (one, other))) {
            let outer = self.times(one.outer, other.outer);
            let inner = self.times(one.inner, other.inner);
            products.push(Product { outer, inner });
        }
        self.gathered(products)
    }

    /// The products divided by a node that is not mixed, on the side of that node.
    fn divided(&mut self, sum: &[Product], divisor: NodeId) -> Vec<Product> {
        let is_outer = self.whole(divisor).is_some_and(|whole| whole.outer.is_some());
        let one = self.constant(1.0);
        let mut divide = |factor: Option<NodeId>| Some(self.record(Primitive::Div, &[factor.unwrap_or(one), divisor]));
        let divided = |product: &Product| match is_outer {
            true => Product { outer: divide(product.outer), ..*product },
            false => Product { inner: divide(product.inner), ..*product },
        };
        let quotients: Vec<Product> = sum.iter().map(divided).collect();
        self.gathered(quotients)
    }

    /// One of two sums, by a condition that belongs to the inner factors.
    fn chosen(&mut self, condition: NodeId, x: &[Product], y: &[Product]) -> Vec<Product> {
        let [zero, one] = [0.0, 1.0].map(|number| self.constant(number));
        let inner = |product: Option<&Product>| product.map_or(zero, |product| product.inner.unwrap_or(one));
        let mut pairs: Vec<(Option<NodeId>, [NodeId; 2])> = Vec::new();
        for product in x {
            let other = y.iter().find(|other| other.outer == product.outer);
            pairs.push((product.outer, [inner(Some(product)), inner(other)]));
        }
        for product in y.iter().filter(|product| x.iter().all(|other| other.outer != product.outer)) {
            pairs.push((product.outer, [zero, inner(Some(product))]));
        }
        let mut products = Vec::with_capacity(pairs.len());
        for (outer, [yes, no]) in pairs {
            products.push(Product { outer, inner: Some(self.record(Primitive::Select, &[condition, yes, no])) });
        }
        products
    }

    /// The products with the opposite sign.
    fn negated(&mut self, sum: &[Product]) -> Option<Vec<Product>> {
        let minus_one = self.constant(-1.0);
        let minus_one = self.whole(minus_one)?;
        Some(self.multiplied(&[minus_one], sum))
    }

    /// The products as a sum, in which products with a common factor are combined.
    fn gathered(&mut self, products: impl IntoIterator<Item = Product>) -> Vec<Product> {
        let mut sum: Vec<Product> = Vec::new();
        for product in products {
            let found = sum.iter().enumerate().find_map(|(index, other)| Some((index, self.common(other, &product)?)));
            match found {
                Some((index, Common::Outer)) => sum[index].inner = self.plus(sum[index].inner, product.inner),
                Some((index, Common::Inner)) => sum[index].outer = self.plus(sum[index].outer, product.outer),
                None => sum.push(product),
            }
        }
        sum
    }

    /// The sum of two factors; one that is missing is 1.
    fn plus(&mut self, x: Option<NodeId>, y: Option<NodeId>) -> Option<NodeId> {
        let one = self.constant(1.0);
        Some(self.record(Primitive::Add, &[x.unwrap_or(one), y.unwrap_or(one)]))
    }

    /// The product of two factors; one that is missing is 1.
    fn times(&mut self, x: Option<NodeId>, y: Option<NodeId>) -> Option<NodeId> {
        match (x, y) {
            (Some(x), Some(y)) => Some(self.record(Primitive::Mul, &[x, y])),
            (one, other) => one.or(other),
        }
    }
}
