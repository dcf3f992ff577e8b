//! The change of a formula when parameters move, as a formula of its own: its *tangent*.
//!
//! What a picture adds up is linear in the terms of equation (2). So the picture of the tangent of a formula, on the
//! same hits, is the change of the picture, as long as the weights of rays do not change. Every backend can make it.
//!
//! The tangent has all parameters of the formula, in the same order, and more of them: a *seed* for each parameter that
//! may move, which says how fast it moves, and the intensity of lights. The tangent is the sum of seed times derivative
//! over all of them. Its own `ki` is always 1, because the intensity is part of what is derived.

use crate::formula::derivative::changes;
use crate::formula::equation::{EquationTerm, Site};
use crate::formula::graph::{Graph, Node, NodeId};
use crate::formula::layout::Layout;
use crate::formula::{Formula, Parameter, ParameterId, SurfaceTerms, Term, TermId};
use crate::lang::builtins::Operation;
use crate::lang::scalars::{Primitive, Recorder, Scalars};
use crate::lang::surface_terms::SurfaceTerm;
use crate::lang::types::Type;
use crate::lang::variables::{EvaluatedLights, Owner, Predefined, Variable};
use std::collections::HashMap;

/// A formula whose value is the change of another formula.
#[derive(Debug, Clone)]
pub struct Tangent {
    /// The formula.
    pub formula: Formula,
    /// The parameters that may move, each with its seed in [`formula`](Self::formula).
    pub seeds: Vec<(ParameterId, ParameterId)>,
    /// The intensity of lights, a parameter of [`formula`](Self::formula).
    intensity: ParameterId,
    /// How many parameters are those of the formula that it is the tangent of.
    own: usize,
}

impl Tangent {
    /// The tangent of a formula for moves of these parameters. Parameters that only the weights of rays or misses read
    /// have no effect on it.
    pub fn new(formula: &Formula, moving: &[ParameterId]) -> Self {
        let mut parameters = formula.parameters.clone();
        let mut add = |owner: Owner, ty: Type, like: &Parameter| {
            let slots = |parameter: &Parameter| if parameter.owner == owner { parameter.ty.slots() as u32 } else { 0 };
            let slot = parameters.iter().map(slots).sum();
            let plain = Parameter { name: String::new(), owner, ty, slot, predefined: None, ..like.clone() };
            parameters.push(plain);
            ParameterId(parameters.len() as u32 - 1)
        };
        let unbounded = |like: &Parameter| Parameter { range: None, switch: false, choices: Vec::new(), ..like.clone() };
        let own_intensity = formula.predefined(Predefined::Intensity);
        let intensity = add(Owner::Light, Type::Scalar, formula.parameter(own_intensity));
        let seeds: Vec<(ParameterId, ParameterId)> = moving
            .iter()
            .map(|id| (*id, formula.parameter(*id)))
            .filter(|(_, parameter)| parameter.ty != Type::Texture)
            .map(|(id, parameter)| (id, add(parameter.owner, parameter.ty, &unbounded(parameter))))
            .collect();
        // Bounds of `ki` in a formula may be any. The tangent's own `ki` is 1.
        parameters[own_intensity.0 as usize].range = None;

        let weights = [SurfaceTerm::Reflected, SurfaceTerm::Refracted].map(|term| (term, formula.surface.get(term)));
        let own = [SurfaceTerm::Ambient, SurfaceTerm::Emission].map(|term| (term, formula.surface.get(term)));
        let given: Vec<TermId> = weights.iter().chain(&own).filter_map(|(_, id)| *id).collect();
        let roots: Vec<TermId> = std::iter::once(formula.result).chain(given).collect();
        let (mut graph, nodes) = Graph::of(formula, &roots);
        let nodes: HashMap<TermId, [NodeId; 3]> = roots.iter().copied().zip(nodes).collect();
        let ambient = match own[0].1 {
            Some(id) => nodes[&id],
            None => ambient(&mut graph, formula),
        };
        let weight = graph.parameter(own_intensity, 0);
        let contribution = nodes[&formula.result].map(|component| graph.mul(weight, component));
        let emission = own[1].1.map(|id| nodes[&id]);
        let changing: Vec<NodeId> = contribution.into_iter().chain(ambient).chain(emission.into_iter().flatten()).collect();
        let seed_of = |graph: &mut Graph, parameter: ParameterId, component: u8| {
            let (_, seed) = seeds.iter().find(|(moving, _)| *moving == parameter)?;
            Some(graph.parameter(*seed, component))
        };
        let zero = graph.record_constant(0.0);
        let found = changes(&mut graph, &changing, &seed_of);
        let mut found: Vec<NodeId> = found.into_iter().map(|change| change.unwrap_or(zero)).collect();
        if formula.evaluated_lights() == EvaluatedLights::All {
            // It must be evaluated for all lights too.
            let visible = graph.insert(Node::Variable(Variable::Visible, 0));
            let nothing = graph.mul(visible, zero);
            found[0] = Scalars::add(&mut graph, found[0], nothing);
        }
        let mut writer = TangentWriter {
            graph: &graph,
            parameters: &parameters,
            own_intensity,
            intensity,
            terms: Vec::new(),
            written: HashMap::new(),
        };
        let mut surface = SurfaceTerms::default();
        for (term, id) in weights {
            if let Some(id) = id {
                let slots = formula.ty(id).slots();
                surface.set(term, writer.value(&nodes[&id][..slots]));
            }
        }
        let result = writer.value(&found[..3]);
        surface.set(SurfaceTerm::Ambient, writer.value(&found[3..6]));
        if emission.is_some() {
            surface.set(SurfaceTerm::Emission, writer.value(&found[6..9]));
        }
        let terms = writer.terms;
        let tangent = Formula { parameters, terms, macros: Vec::new(), result, surface, ..formula.clone() };
        Self { formula: tangent, seeds, intensity, own: formula.parameters.len() }
    }

    /// The parameter numbers of the tangent: those of the formula, and seeds. `seeds` are the numbers of the formula
    /// that move, by their indices in `numbers`, and how fast. Others stay. Both layouts are for the same scene.
    pub fn numbers(&self, layouts: [&Layout; 2], numbers: &[f32], seeds: &[(usize, f32)]) -> Vec<f32> {
        let [from, to] = layouts;
        let mut result = vec![0.0; to.len()];
        for owner in Owner::ALL {
            let own = self.formula.parameters[..self.own].iter().filter(|parameter| parameter.owner == owner);
            let slots = own.map(|parameter| parameter.ty.slots()).sum::<usize>();
            for index in 0..from.owners(owner) {
                let (source, target) = (from.row(owner, index), to.row(owner, index));
                result[target..target + slots].copy_from_slice(&numbers[source..source + slots]);
            }
        }
        let own = self.formula.parameter(self.formula.predefined(Predefined::Intensity));
        for light in 0..from.owners(Owner::Light) {
            let at = to.index(own, light);
            result[to.index(self.formula.parameter(self.intensity), light)] = result[at];
            result[at] = 1.0;
        }
        for (index, speed) in seeds {
            let Some((owner, row, slot)) = from.owner_of(*index) else { continue };
            let holds = |(moving, _): &&(ParameterId, ParameterId)| {
                let parameter = self.formula.parameter(*moving);
                let first = parameter.slot as usize;
                parameter.owner == owner && (first..first + parameter.ty.slots()).contains(&slot)
            };
            if let Some((moving, seed)) = self.seeds.iter().find(holds) {
                let component = slot - self.formula.parameter(*moving).slot as usize;
                result[to.index(self.formula.parameter(*seed), row) + component] = *speed;
            }
        }
        result
    }
}

/// The ambient term of a formula that gives none: ka · Cd · Ia.
fn ambient(graph: &mut Graph, formula: &Formula) -> [NodeId; 3] {
    let mut product: Option<[NodeId; 3]> = None;
    for factor in EquationTerm::at(Site::Hit).flat_map(EquationTerm::factors) {
        let (id, slots) = (formula.predefined(factor), factor.ty().slots() as u8);
        let value = [0, 1, 2].map(|component: u8| graph.parameter(id, component.min(slots - 1)));
        product = Some(match product {
            None => value,
            Some(sofar) => std::array::from_fn(|at| graph.mul(sofar[at], value[at])),
        });
    }
    product.unwrap_or_else(|| [graph.record_constant(0.0); 3])
}

/// Writes nodes of a graph as expressions of a formula.
struct TangentWriter<'w> {
    graph: &'w Graph,
    /// All parameters of the tangent.
    parameters: &'w [Parameter],
    /// The predefined intensity, and what is read in its place.
    own_intensity: ParameterId,
    intensity: ParameterId,
    terms: Vec<Term>,
    written: HashMap<NodeId, TermId>,
}

impl TangentWriter<'_> {
    /// A scalar, or a vector of three nodes.
    fn value(&mut self, nodes: &[NodeId]) -> TermId {
        let needed = self.graph.needed(nodes);
        for (index, _) in needed.iter().enumerate().filter(|(_, needed)| **needed) {
            self.write(NodeId(index as u32));
        }
        let operands: Vec<TermId> = nodes.iter().map(|node| self.written[node]).collect();
        if operands.len() == 1 { operands[0] } else { self.apply(Operation::MakeVector, operands) }
    }

    fn push(&mut self, term: Term) -> TermId {
        self.terms.push(term);
        TermId(self.terms.len() as u32 - 1)
    }

    fn apply(&mut self, operation: Operation, operands: Vec<TermId>) -> TermId {
        self.push(Term::Apply(operation, operands))
    }

    fn component(&mut self, of: Term, is_vector: bool, component: u8) -> TermId {
        const COMPONENTS: [Operation; 3] = [Operation::GetX, Operation::GetY, Operation::GetZ];
        let whole = self.push(of);
        if is_vector { self.apply(COMPONENTS[usize::from(component.min(2))], vec![whole]) } else { whole }
    }

    /// Writes a node whose operands are written.
    fn write(&mut self, id: NodeId) {
        if self.written.contains_key(&id) {
            return;
        }
        let term = match self.graph.node(id) {
            Node::Constant(bits) => self.push(Term::Number(f32::from_bits(bits))),
            Node::Variable(variable, component) => {
                self.component(Term::Variable(variable), variable.ty() == Type::Vector, component)
            }
            Node::Parameter(parameter, component) => {
                let id = if parameter == self.own_intensity { self.intensity } else { parameter };
                let is_vector = self.parameters[parameter.0 as usize].ty == Type::Vector;
                self.component(Term::Parameter(id), is_vector, component)
            }
            Node::Apply(primitive, operands) => {
                let operands = operands[..primitive.arity()].iter().map(|operand| self.written[operand]).collect();
                self.primitive(primitive, operands)
            }
        };
        self.written.insert(id, term);
    }

    fn primitive(&mut self, primitive: Primitive, operands: Vec<TermId>) -> TermId {
        let operation = match primitive {
            Primitive::Neg => Operation::NegS,
            Primitive::Add => Operation::AddSS,
            Primitive::Sub => Operation::SubSS,
            Primitive::Mul => Operation::MulSS,
            Primitive::Div => Operation::DivSS,
            Primitive::Sqrt => Operation::Sqrt,
            Primitive::Floor => Operation::Floor,
            Primitive::Ceil => Operation::Ceil,
            Primitive::Abs => Operation::Abs,
            Primitive::Min => Operation::MinSS,
            Primitive::Max => Operation::MaxSS,
            Primitive::Exp => Operation::Exp,
            Primitive::Exp2 => Operation::Exp2,
            Primitive::Log => Operation::Log,
            Primitive::Log2 => Operation::Log2,
            Primitive::Pow => Operation::PowerSS,
            Primitive::Sin => Operation::Sin,
            Primitive::Cos => Operation::Cos,
            Primitive::Tan => Operation::Tan,
            Primitive::Asin => Operation::Asin,
            Primitive::Acos => Operation::Acos,
            Primitive::Atan => Operation::Atan,
            Primitive::Atan2 => Operation::Atan2,
            Primitive::Less => Operation::Less,
            Primitive::LessEqual => Operation::LessEqual,
            Primitive::Equal => Operation::Equal,
            Primitive::And => Operation::And,
            Primitive::Or => Operation::Or,
            Primitive::Not => Operation::Not,
            Primitive::Select => Operation::IfS,
            Primitive::Perlin => {
                let point = self.apply(Operation::MakeVector, operands[..3].to_vec());
                let rest = operands[3..].iter().copied();
                return self.apply(Operation::Perlin, std::iter::once(point).chain(rest).collect());
            }
            Primitive::Texture => {
                return self.of_colour(Term::Apply(Operation::TextureColour, operands[..3].to_vec()), operands[3]);
            }
            Primitive::Measured => {
                let [light, view] = [1, 3].map(|first| self.direction([operands[first], operands[first + 1]]));
                let (normal, tangent) = (self.vector([0.0, 0.0, 1.0]), self.vector([1.0, 0.0, 0.0]));
                let all = vec![operands[0], light, view, normal, tangent];
                return self.of_colour(Term::Apply(Operation::MeasuredReflectance, all), operands[5]);
            }
        };
        self.apply(operation, operands)
    }

    fn number(&mut self, value: f32) -> TermId {
        self.push(Term::Number(value))
    }

    /// A component of a colour of which a node computes only one. The last operand says which one.
    fn of_colour(&mut self, colour: Term, component: TermId) -> TermId {
        let number = &self.terms[component.0 as usize];
        let component = if let Term::Number(component) = number { *component as u8 } else { 0 };
        self.component(colour, true, component)
    }

    /// The direction of a point of the plane, seen from the pole below: (2x, 2y, 1 − r²)/(1 + r²).
    fn direction(&mut self, [x, y]: [TermId; 2]) -> TermId {
        let [xx, yy] = [x, y].map(|x| self.apply(Operation::MulSS, vec![x, x]));
        let square = self.apply(Operation::AddSS, vec![xx, yy]);
        let one = self.number(1.0);
        let (sum, rest) = (self.apply(Operation::AddSS, vec![one, square]), self.apply(Operation::SubSS, vec![one, square]));
        let double = [x, y].map(|x| self.apply(Operation::AddSS, vec![x, x]));
        let vector = self.apply(Operation::MakeVector, vec![double[0], double[1], rest]);
        self.apply(Operation::DivVS, vec![vector, sum])
    }

    fn vector(&mut self, [x, y, z]: [f32; 3]) -> TermId {
        let components = [x, y, z].map(|component| self.number(component));
        self.apply(Operation::MakeVector, components.to_vec())
    }
}
