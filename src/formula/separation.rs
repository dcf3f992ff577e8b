//! What a moved parameter can change in a contribution, and in which way.
//!
//! While a slider is dragged, a handful of numbers *move* and all others rest. A contribution is *separable* where the graph proves it
//! to be a sum Σ factor · part whose factors are made of moved numbers alone and whose parts of resting ones alone: then images of the
//! parts, summed up over all hits, can be kept, and a frame is a weighed sum of images. Elsewhere the contribution is split into what rests
//! and what is *live*, and of the live part every expensive sub-expression that rests can be kept for each record.

use crate::formula::ParameterId;
use crate::formula::binding::{BindingTime, Bindings};
use crate::formula::graph::{Node, NodeId};
use crate::lang::scalars::Primitive;

/// More terms than this are no gain over computing anew.
const MOST_TERMS: usize = 6;
/// What is nested deeper is not taken apart.
const DEEPEST: usize = 256;
/// What a sub-expression must cost for it to be kept rather than computed again: about what loading it costs, in simple instructions.
const WORTH_KEEPING: u32 = 12;

/// A term of a separable contribution, for red, green and blue: a factor that moves, and a part that rests, which is 1 where missing.
#[derive(Debug, Clone, PartialEq)]
pub struct Term {
    /// Made of moved numbers and constants; none where the term has no such component.
    pub factors: [Option<NodeId>; 3],
    /// Made of what rests.
    pub parts: [Option<NodeId>; 3],
}

/// How a contribution depends on moved numbers.
#[derive(Debug, Clone, PartialEq)]
pub enum Dependence {
    /// Not at all.
    None,
    /// As a sum of terms, beside what rests.
    Separable(Vec<Term>),
    /// In another way: the live part of each component, where there is one, and what rests in it and is worth keeping for each record.
    Live {
        /// What must be computed anew.
        live: [Option<NodeId>; 3],
        /// Dynamic sub-expressions of it that rest.
        kept: Vec<NodeId>,
    },
}

/// A contribution taken apart by what moves.
#[derive(Debug, Clone)]
pub struct Separation {
    /// The formula's graph with the nodes below.
    pub bindings: Bindings,
    /// What rests of red, green and blue, apart from the terms or the live part.
    pub resting: [Option<NodeId>; 3],
    /// What moves.
    pub dependence: Dependence,
}

impl Separation {
    /// Takes the contribution apart for these components of parameters of one owner.
    pub fn new(bindings: &Bindings, moved: &[(ParameterId, u8)]) -> Self {
        let mut separator = Separator { bindings: bindings.clone(), moved: moved.to_vec(), kinds: Vec::new() };
        separator.learn();
        let contribution = bindings.contribution;
        if contribution.iter().all(|component| separator.rests(*component)) {
            let resting = contribution.map(Some);
            return Self { bindings: separator.bindings, resting, dependence: Dependence::None };
        }
        match separator.separable(contribution) {
            Some((resting, terms)) => Self { bindings: separator.bindings, resting, dependence: Dependence::Separable(terms) },
            None => {
                let mut resting = [None; 3];
                let mut live = [None; 3];
                for (component, root) in contribution.into_iter().enumerate() {
                    (resting[component], live[component]) = separator.split(root, 0);
                }
                let kept = separator.worth_keeping(&live);
                Self { bindings: separator.bindings, resting, dependence: Dependence::Live { live, kept } }
            }
        }
    }
}

/// What a node is made of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kind {
    Constant,
    /// Nothing that moves.
    Resting,
    /// Nothing that rests.
    Moved,
    Mixed,
}

impl Kind {
    fn join(self, other: Kind) -> Kind {
        match (self, other) {
            (Kind::Constant, kind) | (kind, Kind::Constant) => kind,
            (one, another) if one == another => one,
            (Kind::Resting | Kind::Moved | Kind::Mixed, _) => Kind::Mixed,
        }
    }
}

struct Separator {
    bindings: Bindings,
    moved: Vec<(ParameterId, u8)>,
    kinds: Vec<Kind>,
}

/// `factor · part`; 1 where one is missing.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Product {
    factor: Option<NodeId>,
    part: Option<NodeId>,
}

type Parts = ([Option<NodeId>; 3], Vec<Term>);

impl Separator {
    fn record(&mut self, primitive: Primitive, operands: &[NodeId]) -> NodeId {
        let id = self.bindings.record(primitive, operands);
        self.learn();
        id
    }

    fn constant(&mut self, value: f32) -> NodeId {
        let id = self.bindings.constant(value);
        self.learn();
        id
    }

    /// The kinds of nodes that are new.
    fn learn(&mut self) {
        for index in self.kinds.len()..self.bindings.graph.len() {
            let node = self.bindings.graph.node(NodeId(index as u32));
            self.kinds.push(match node {
                Node::Constant(_) => Kind::Constant,
                Node::Variable(..) => Kind::Resting,
                Node::Parameter(id, component) if self.moved.contains(&(id, component)) => Kind::Moved,
                Node::Parameter(..) => Kind::Resting,
                Node::Apply(..) => {
                    let kinds = node.operands().iter().map(|operand| self.kinds[operand.0 as usize]);
                    kinds.fold(Kind::Constant, Kind::join)
                }
            });
        }
    }

    fn kind(&self, id: NodeId) -> Kind {
        self.kinds[id.0 as usize]
    }

    fn rests(&self, id: NodeId) -> bool {
        matches!(self.kind(id), Kind::Constant | Kind::Resting)
    }

    /// The components as sums of terms, if they all are.
    fn separable(&mut self, contribution: [NodeId; 3]) -> Option<Parts> {
        let mut resting = [None; 3];
        let mut terms: Vec<Term> = Vec::new();
        for (component, root) in contribution.into_iter().enumerate() {
            let mut place = 0;
            for product in self.terms(root, 0)? {
                let Some(factor) = product.factor else {
                    let one = self.constant(1.0);
                    resting[component] = Some(product.part.unwrap_or(one));
                    continue;
                };
                if place == terms.len() {
                    terms.push(Term { factors: [None; 3], parts: [None; 3] });
                }
                terms[place].factors[component] = Some(factor);
                terms[place].parts[component] = product.part;
                place += 1;
            }
        }
        (terms.len() <= MOST_TERMS).then_some((resting, terms))
    }

    /// A value as a sum of products, no two with the same factor.
    #[expect(clippy::wildcard_enum_match_arm, reason = "only what is linear is separable")]
    fn terms(&mut self, id: NodeId, depth: usize) -> Option<Vec<Product>> {
        match self.kind(id) {
            Kind::Constant | Kind::Resting => return Some(vec![Product { factor: None, part: Some(id) }]),
            Kind::Moved => return Some(vec![Product { factor: Some(id), part: None }]),
            Kind::Mixed => {}
        }
        let Node::Apply(primitive, operands) = self.bindings.graph.node(id) else { return None };
        if depth > DEEPEST {
            return None;
        }
        let [x, y] = [operands[0], operands[1]];
        let mut sum = Vec::new();
        match primitive {
            Primitive::Add | Primitive::Sub => {
                let (one, mut other) = (self.terms(x, depth + 1)?, self.terms(y, depth + 1)?);
                if primitive == Primitive::Sub {
                    self.negate(&mut other);
                }
                for term in one.into_iter().chain(other) {
                    self.gather(&mut sum, term);
                }
            }
            Primitive::Neg => {
                sum = self.terms(x, depth + 1)?;
                self.negate(&mut sum);
            }
            Primitive::Mul => {
                let (one, other) = (self.terms(x, depth + 1)?, self.terms(y, depth + 1)?);
                if one.len() * other.len() > 2 * MOST_TERMS {
                    return None;
                }
                for (a, b) in one.iter().flat_map(|a| other.iter().map(move |b| (a, b))) {
                    let factor = self.times(a.factor, b.factor);
                    let part = self.times(a.part, b.part);
                    self.gather(&mut sum, Product { factor, part });
                }
            }
            Primitive::Div if self.kind(y) != Kind::Mixed => {
                let one = self.constant(1.0);
                let resting = self.rests(y);
                for term in self.terms(x, depth + 1)? {
                    let divided = if resting { &term.part } else { &term.factor };
                    let quotient = Some(self.record(Primitive::Div, &[divided.unwrap_or(one), y]));
                    let term = if resting { Product { part: quotient, ..term } } else { Product { factor: quotient, ..term } };
                    self.gather(&mut sum, term);
                }
            }
            _ => return None,
        }
        (sum.len() <= MOST_TERMS).then_some(sum)
    }

    fn negate(&mut self, terms: &mut [Product]) {
        for term in terms {
            let value = match term.part {
                Some(part) => part,
                None => self.constant(1.0),
            };
            term.part = Some(self.record(Primitive::Neg, &[value]));
        }
    }

    fn times(&mut self, x: Option<NodeId>, y: Option<NodeId>) -> Option<NodeId> {
        match (x, y) {
            (Some(x), Some(y)) => Some(self.record(Primitive::Mul, &[x, y])),
            (one, other) => one.or(other),
        }
    }

    fn gather(&mut self, sum: &mut Vec<Product>, term: Product) {
        match sum.iter().position(|other| other.factor == term.factor) {
            Some(place) => {
                let one = self.constant(1.0);
                let [x, y] = [sum[place].part, term.part].map(|part| part.unwrap_or(one));
                sum[place].part = Some(self.record(Primitive::Add, &[x, y]));
            }
            None => sum.push(term),
        }
    }

    /// A sum as what rests of it and what is live.
    fn split(&mut self, id: NodeId, depth: usize) -> (Option<NodeId>, Option<NodeId>) {
        if self.rests(id) {
            return (Some(id), None);
        }
        match self.bindings.graph.node(id) {
            Node::Apply(primitive @ (Primitive::Add | Primitive::Sub), operands) if depth <= DEEPEST => {
                let (x, live_x) = self.split(operands[0], depth + 1);
                let (y, live_y) = self.split(operands[1], depth + 1);
                (self.joined(primitive, x, y), self.joined(primitive, live_x, live_y))
            }
            Node::Apply(..) | Node::Constant(_) | Node::Variable(..) | Node::Parameter(..) => (None, Some(id)),
        }
    }

    fn joined(&mut self, primitive: Primitive, x: Option<NodeId>, y: Option<NodeId>) -> Option<NodeId> {
        match (x, y) {
            (Some(x), Some(y)) => Some(self.record(primitive, &[x, y])),
            (None, Some(y)) if primitive == Primitive::Sub => Some(self.record(Primitive::Neg, &[y])),
            (one, other) => one.or(other),
        }
    }

    /// The largest dynamic sub-expressions of `live` that rest and cost more to compute than to load.
    fn worth_keeping(&self, live: &[Option<NodeId>; 3]) -> Vec<NodeId> {
        let mut kept = Vec::new();
        let mut seen = vec![false; self.bindings.graph.len()];
        let mut pending: Vec<NodeId> = live.iter().flatten().copied().collect();
        while let Some(id) = pending.pop() {
            if std::mem::replace(&mut seen[id.0 as usize], true) || self.bindings.time(id) != BindingTime::Dynamic {
                continue;
            }
            if !self.rests(id) {
                pending.extend_from_slice(self.bindings.graph.node(id).operands());
            } else if self.cost(id) >= WORTH_KEEPING {
                kept.push(id);
            }
        }
        kept.sort_unstable();
        kept
    }

    /// What a dynamic node costs, in simple instructions.
    fn cost(&self, id: NodeId) -> u32 {
        let mut seen = vec![false; self.bindings.graph.len()];
        let mut pending = vec![id];
        let mut cost = 0;
        while let Some(id) = pending.pop() {
            if std::mem::replace(&mut seen[id.0 as usize], true) || self.bindings.time(id) != BindingTime::Dynamic {
                continue;
            }
            if let Node::Apply(primitive, _) = self.bindings.graph.node(id) {
                cost += cost_of(primitive);
            }
            if cost >= WORTH_KEEPING {
                break;
            }
            pending.extend_from_slice(self.bindings.graph.node(id).operands());
        }
        cost
    }
}

/// About how many simple instructions a primitive takes.
fn cost_of(primitive: Primitive) -> u32 {
    match primitive {
        Primitive::Neg
        | Primitive::Add
        | Primitive::Sub
        | Primitive::Mul
        | Primitive::Floor
        | Primitive::Ceil
        | Primitive::Abs
        | Primitive::Min
        | Primitive::Max
        | Primitive::Less
        | Primitive::LessEqual
        | Primitive::Equal
        | Primitive::And
        | Primitive::Or
        | Primitive::Not
        | Primitive::Select => 1,
        Primitive::Div | Primitive::Sqrt => 5,
        Primitive::Exp | Primitive::Exp2 | Primitive::Log | Primitive::Log2 => 16,
        Primitive::Sin | Primitive::Cos | Primitive::Tan => 24,
        Primitive::Asin | Primitive::Acos | Primitive::Atan | Primitive::Atan2 => 24,
        Primitive::Pow => 60,
        Primitive::Perlin => 1000,
    }
}
