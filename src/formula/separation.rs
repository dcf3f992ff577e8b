//! What a moved parameter can change in a contribution, and in which way.
//!
//! While a slider is dragged, a handful of numbers *move* and all others rest. A contribution is *separable* where the graph proves it
//! to be a sum Σ factor · part whose factors are made of moved numbers alone and whose parts of resting ones alone: then images of the
//! parts, summed up over all hits, can be kept, and a frame is a weighed sum of images. Elsewhere the contribution is split into what rests
//! and what is *live*, and of the live part every expensive sub-expression that rests can be kept for each record.

use crate::formula::ParameterId;
use crate::formula::binding::{BindingTime, Bindings};
use crate::formula::graph::{Node, NodeId, walk};
use crate::lang::scalars::Primitive;
use std::collections::{HashMap, HashSet};

/// More terms than this are no gain over computing anew.
const MOST_TERMS: usize = 6;
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
                    (resting[component], live[component]) = separator.split(root);
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

/// What rests of a value, and what is live; their sum is the value.
type Split = (Option<NodeId>, Option<NodeId>);

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
            for product in self.terms(root)? {
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
    fn terms(&mut self, root: NodeId) -> Option<Vec<Product>> {
        let mut sums = HashMap::new();
        for id in walk(root, |id| self.linear_operands(id)) {
            let terms = self.terms_of(id, &sums)?;
            sums.insert(id, terms);
        }
        sums.remove(&root)
    }

    /// The operands whose terms those of a node are made of.
    #[expect(clippy::wildcard_enum_match_arm, reason = "only what is linear is separable")]
    fn linear_operands(&self, id: NodeId) -> Vec<NodeId> {
        let Node::Apply(primitive, [x, y, ..]) = self.bindings.graph.node(id) else { return Vec::new() };
        match primitive {
            _ if self.kind(id) != Kind::Mixed => Vec::new(),
            Primitive::Add | Primitive::Sub | Primitive::Mul => vec![x, y],
            Primitive::Neg | Primitive::Div => vec![x],
            _ => Vec::new(),
        }
    }

    /// The terms of a node, from those of its linear operands.
    #[expect(clippy::wildcard_enum_match_arm, reason = "only what is linear is separable")]
    fn terms_of(&mut self, id: NodeId, known: &HashMap<NodeId, Vec<Product>>) -> Option<Vec<Product>> {
        match self.kind(id) {
            Kind::Constant | Kind::Resting => return Some(vec![Product { factor: None, part: Some(id) }]),
            Kind::Moved => return Some(vec![Product { factor: Some(id), part: None }]),
            Kind::Mixed => {}
        }
        let Node::Apply(primitive, [x, y, ..]) = self.bindings.graph.node(id) else { return None };
        let mut sum = Vec::new();
        match primitive {
            Primitive::Add | Primitive::Sub => {
                let (one, mut other) = (&known[&x], known[&y].clone());
                if primitive == Primitive::Sub {
                    self.negate(&mut other);
                }
                for term in one.iter().copied().chain(other) {
                    self.gather(&mut sum, term);
                }
            }
            Primitive::Neg => {
                sum.clone_from(&known[&x]);
                self.negate(&mut sum);
            }
            Primitive::Mul => {
                let (one, other) = (&known[&x], &known[&y]);
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
                for term in &known[&x] {
                    let divided = if resting { term.part } else { term.factor };
                    let quotient = Some(self.record(Primitive::Div, &[divided.unwrap_or(one), y]));
                    let term = if resting { Product { part: quotient, ..*term } } else { Product { factor: quotient, ..*term } };
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
    fn split(&mut self, root: NodeId) -> Split {
        let mut splits: HashMap<NodeId, Split> = HashMap::new();
        for id in walk(root, |id| self.addends(id).map_or(Vec::new(), |(_, operands)| operands.to_vec())) {
            let split = match self.addends(id) {
                _ if self.rests(id) => (Some(id), None),
                Some((primitive, operands)) => {
                    let [(x, live_x), (y, live_y)] = operands.map(|operand| splits[&operand]);
                    (self.joined(primitive, x, y), self.joined(primitive, live_x, live_y))
                }
                None => (None, Some(id)),
            };
            splits.insert(id, split);
        }
        splits[&root]
    }

    /// What a node that does not rest is the sum or the difference of.
    fn addends(&self, id: NodeId) -> Option<(Primitive, [NodeId; 2])> {
        match self.bindings.graph.node(id) {
            Node::Apply(primitive @ (Primitive::Add | Primitive::Sub), [x, y, ..]) if !self.rests(id) => {
                Some((primitive, [x, y]))
            }
            Node::Apply(..) | Node::Constant(_) | Node::Variable(..) | Node::Parameter(..) => None,
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

    /// What a dynamic node costs, in simple instructions; more than is worth keeping is not counted.
    fn cost(&self, id: NodeId) -> u32 {
        let mut seen = HashSet::new();
        let mut pending = vec![id];
        let mut cost = 0;
        while let Some(id) = pending.pop() {
            if self.bindings.time(id) != BindingTime::Dynamic || !seen.insert(id) {
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::formula::Formula;
    use crate::formula::graph::Graph;
    use crate::lang::source::Source;
    use crate::lang::variables::Predefined;

    /// Macros that each use the one before twice: `step` with `M` for it.
    fn chain(length: usize, first: &str, step: &str, result: &str) -> Formula {
        let last = format!("M{length}");
        let lines: String =
            (1..=length).map(|index| format!("M{index} = {};", step.replace('M', &format!("M{}", index - 1)))).collect();
        let text = format!(
            "body_specific; kd: scalar, constraint 0..1; ks: scalar, constraint 0..1; formula; M0 = {first}; {lines} = {};",
            result.replace('M', &last)
        );
        Formula::parse(&Source::new("chain", text)).expect("a formula").0
    }

    /// Some numbers for variables and parameters.
    fn value(node: Node) -> f32 {
        match node {
            Node::Parameter(id, component) => 0.3 + 0.07 * id.0 as f32 + 0.1 * f32::from(component),
            Node::Variable(variable, component) => 0.2 + 0.05 * f32::from(variable as u8) + 0.15 * f32::from(component),
            Node::Constant(_) | Node::Apply(..) => f32::NAN,
        }
    }

    fn values(graph: &Graph, roots: &[Option<NodeId>]) -> Vec<f32> {
        let known: Vec<NodeId> = roots.iter().flatten().copied().collect();
        let mut values = graph.evaluate(&known, |id| value(graph.node(id))).into_iter();
        roots.iter().map(|root| root.map_or(0.0, |_| values.next().expect("a value of each root"))).collect()
    }

    /// Holds the contribution, rewritten and taken apart, against the formula as it is typed; and how it depends on kd.
    fn check(formula: &Formula) -> Dependence {
        let graph = Graph::new(formula);
        let ki = value(Node::Parameter(formula.predefined(Predefined::Intensity), 0));
        let typed: Vec<f32> = values(&graph, &graph.result().map(Some)).iter().map(|number| ki * number).collect();
        let near = |one: &[f32], what: &str| {
            let close = |(a, b): (&f32, &f32)| a == b || (a - b).abs() <= 1e-5 * a.abs();
            assert!(one.iter().zip(&typed).all(close), "{what}: {one:?}, typed {typed:?}");
        };
        let bindings = Bindings::new(formula);
        near(&values(&bindings.graph, &bindings.contribution.map(Some)), "rewritten");
        let kd = formula.parameter_named("kd").expect("a parameter");
        let Separation { bindings, resting, dependence } = Separation::new(&bindings, &[(kd, 0)]);
        assert!(bindings.graph.len() < 2000, "{} nodes", bindings.graph.len());
        let mut sum = values(&bindings.graph, &resting);
        match &dependence {
            Dependence::None => {}
            Dependence::Separable(terms) => {
                for Term { factors, parts } in terms {
                    let factors = values(&bindings.graph, factors);
                    let whole = |component: usize| parts[component].map(|part| values(&bindings.graph, &[Some(part)])[0]);
                    (0..3).for_each(|component| sum[component] += factors[component] * whole(component).unwrap_or(1.0));
                }
            }
            Dependence::Live { live, .. } => {
                sum.iter_mut().zip(values(&bindings.graph, live)).for_each(|(sum, live)| *sum += live);
            }
        }
        near(&sum, "taken apart");
        dependence
    }

    const DYNAMIC: &str = "kd*(N.L) + ks";

    #[test]
    fn sums_of_shared_nodes_are_taken_apart_once() {
        for (step, result) in [
            ("M + M", "M*Cd*9.5e-7"),
            ("M*3 - M", "M*Cd*9.5e-7"),
            ("M - M*0.5", "M*Cd*2000"),
            ("M*ks + M/2", "M*Cd"),
            ("-(M*0.75) - M*ks", "M*Cd"),
        ] {
            // 2²⁰ times the sum, first; and more doublings than there could be nodes.
            for length in [20, 45] {
                let result = if length == 45 { format!("({result})*1e-7") } else { result.to_owned() };
                let dependence = check(&chain(length, DYNAMIC, step, &result));
                assert!(matches!(dependence, Dependence::Separable(_)), "{step}: {dependence:?}");
            }
        }
    }

    #[test]
    fn products_of_shared_nodes_are_taken_apart_once() {
        // A power of kd, and a polynomial of too high a degree.
        assert!(matches!(check(&chain(45, "kd*(N.L)", "M*M", "M*Cd")), Dependence::Separable(_)));
        assert!(matches!(check(&chain(2, DYNAMIC, "M*M", "M*Cd")), Dependence::Separable(_)));
        assert!(matches!(check(&chain(45, DYNAMIC, "M*M", "M*Cd")), Dependence::Live { .. }));
    }

    #[test]
    fn what_is_live_is_split_off_once() {
        for step in ["M + M", "M - M*0.5 - M"] {
            let dependence = check(&chain(45, "exp(-kd*alpha) + ks*(N.L)", step, "Cd*(M*1e-12)"));
            assert!(matches!(dependence, Dependence::Live { .. }), "{step}: {dependence:?}");
        }
        let sum = check(&chain(45, "<1, 2, 3>*(exp(-kd*alpha)) + Cd*ks*alpha", "M + M", "M"));
        assert!(matches!(sum, Dependence::Live { .. }));
    }
}
