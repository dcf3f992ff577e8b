//! A formula as a graph of nodes of MaterialX.
//!
//! Operations on vectors are nodes if MaterialX has one. Any other operation is written from its meaning in terms of
//! primitives. Conditions are numbers, 1 or 0. Equal nodes are there once.

use crate::export::dialect::{Dialect, finite};
use crate::export::names::FreeNames;
use crate::export::walk::{TermWriter, UNNAMED};
use crate::formula::{Formula, ParameterId};
use crate::lang::builtins::{Operation, Stack};
use crate::lang::scalars::{Floats, Primitive, Recorder};
use crate::lang::types::Type;
use crate::lang::variables::Variable;
use smallvec::SmallVec;
use std::collections::{BTreeMap, BTreeSet, HashMap};

/// A value of the graph, as an index.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub(super) struct NodeValue(usize);

/// Where a value comes from.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
enum NodeOrigin {
    /// One number or three, by their bits.
    Number(SmallVec<[u32; 3]>),
    /// An input of the graph.
    Input(String),
    /// A node of this category with these inputs.
    Node(String, Vec<(&'static str, NodeInput)>),
}

/// What an input of a node is connected to.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
enum NodeInput {
    Value(NodeValue),
    /// A type, and a value of it.
    Literal(&'static str, String),
}

/// The most octaves of noise.
const MOST_OCTAVES: usize = 32;

/// The types of MaterialX in graphs.
const FLOAT: &str = "float";
const VECTOR: &str = "vector3";
const COLOUR: &str = "color3";

/// A graph that is being written.
pub(super) struct NodeGraph<'g> {
    dialect: &'g Dialect,
    formula: &'g Formula,
    /// The inputs for parameters: their names and types.
    parameters: &'g BTreeMap<ParameterId, (String, &'static str)>,
    /// The categories of the nodes that the document defines.
    power: String,
    noise: String,
    values: Vec<(NodeOrigin, &'static str)>,
    index: HashMap<(NodeOrigin, &'static str), NodeValue>,
    /// The names of nodes.
    labels: HashMap<NodeValue, String>,
    arguments: BTreeMap<Variable, NodeValue>,
    names: FreeNames,
}

impl<'g> NodeGraph<'g> {
    /// A graph without nodes. `function` begins the names of the nodes that the document defines.
    pub(super) fn new(
        dialect: &'g Dialect,
        formula: &'g Formula,
        parameters: &'g BTreeMap<ParameterId, (String, &'static str)>,
        function: &str,
        names: FreeNames,
    ) -> Self {
        Self {
            dialect,
            formula,
            parameters,
            power: format!("{function}_power"),
            noise: format!("{function}_noise"),
            values: Vec::new(),
            index: HashMap::new(),
            labels: HashMap::new(),
            arguments: BTreeMap::new(),
            names,
        }
    }

    /// The variables that the graph reads.
    pub(super) fn variables(&self) -> impl Iterator<Item = Variable> {
        self.arguments.keys().copied()
    }

    /// The value as an output may have it: that of a node, and a colour if it is a vector. Gives its type, too.
    pub(super) fn output(&mut self, value: NodeValue) -> (NodeValue, &'static str) {
        if self.ty(value) == VECTOR {
            return (self.node("convert", COLOUR, &[("in", value)]), COLOUR);
        }
        match self.values[value.0].0 {
            NodeOrigin::Node(..) => (value, FLOAT),
            NodeOrigin::Number(_) | NodeOrigin::Input(_) => (self.node("dot", FLOAT, &[("in", value)]), FLOAT),
        }
    }

    /// The nodes that outputs need, as text, with each the name of its node. Operands come before their users.
    pub(super) fn text(&mut self, outputs: &[NodeValue]) -> (String, Vec<String>) {
        let mut needed = BTreeSet::new();
        let mut pending = outputs.to_vec();
        while let Some(value) = pending.pop() {
            if let (NodeOrigin::Node(_, inputs), true) = (&self.values[value.0].0, needed.insert(value)) {
                pending.extend(inputs.iter().filter_map(|(_, input)| match input {
                    NodeInput::Value(value) => Some(*value),
                    NodeInput::Literal(..) => None,
                }));
            }
        }
        for value in &needed {
            if matches!(self.values[value.0].0, NodeOrigin::Node(..)) && !self.labels.contains_key(value) {
                let name = self.names.take(UNNAMED);
                self.labels.insert(*value, name);
            }
        }
        let text = needed.iter().filter_map(|value| self.node_text(*value)).collect();
        (text, outputs.iter().map(|value| self.labels[value].clone()).collect())
    }

    /// Whether a node that outputs need is of this category.
    pub(super) fn calls(&self, category: &str) -> bool {
        self.values.iter().any(|(origin, _)| matches!(origin, NodeOrigin::Node(own, _) if own == category))
    }

    fn node_text(&self, value: NodeValue) -> Option<String> {
        let (origin, ty) = &self.values[value.0];
        let NodeOrigin::Node(category, inputs) = origin else { return None };
        let inputs = inputs.iter().map(|(name, input)| {
            let (ty, source) = match input {
                NodeInput::Literal(ty, text) => (*ty, format!("value=\"{text}\"")),
                NodeInput::Value(value) => {
                    let (origin, ty) = &self.values[value.0];
                    let source = match origin {
                        NodeOrigin::Number(bits) => {
                            format!("value=\"{}\"", numbers(bits.iter().map(|bits| f32::from_bits(*bits))))
                        }
                        NodeOrigin::Input(name) => format!("interfacename=\"{name}\""),
                        NodeOrigin::Node(..) => format!("nodename=\"{}\"", self.labels[value]),
                    };
                    (*ty, source)
                }
            };
            format!("      <input name=\"{name}\" type=\"{ty}\" {source} />\n")
        });
        let inputs: String = inputs.collect();
        Some(format!("    <{category} name=\"{}\" type=\"{ty}\">\n{inputs}    </{category}>\n", self.labels[&value]))
    }

    fn ty(&self, value: NodeValue) -> &'static str {
        self.values[value.0].1
    }

    /// The value of this origin. It is added if it is new.
    fn insert(&mut self, origin: NodeOrigin, ty: &'static str) -> NodeValue {
        let next = NodeValue(self.values.len());
        let found = *self.index.entry((origin.clone(), ty)).or_insert(next);
        if found == next {
            self.values.push((origin, ty));
        }
        found
    }

    fn node(&mut self, category: &str, ty: &'static str, inputs: &[(&'static str, NodeValue)]) -> NodeValue {
        let inputs = inputs.iter().map(|(name, value)| (*name, NodeInput::Value(*value))).collect();
        self.insert(NodeOrigin::Node(category.to_owned(), inputs), ty)
    }

    /// A node with the inputs of operators and functions.
    fn call(&mut self, category: &str, ty: &'static str, operands: &[NodeValue]) -> NodeValue {
        let names: &[&'static str] = match (category, operands.len()) {
            ("atan2", _) => &["iny", "inx"],
            (_, 1) => &["in"],
            _ => &["in1", "in2", "in3"],
        };
        let inputs: Vec<(&'static str, NodeValue)> = names.iter().copied().zip(operands.iter().copied()).collect();
        self.node(category, ty, &inputs)
    }

    fn input(&mut self, name: &str, ty: &'static str) -> NodeValue {
        self.insert(NodeOrigin::Input(name.to_owned()), ty)
    }

    fn literal(&mut self, numbers: &[f32]) -> NodeValue {
        let bits = numbers.iter().map(|number| finite(*number).to_bits()).collect();
        self.insert(NodeOrigin::Number(bits), if numbers.len() == 1 { FLOAT } else { VECTOR })
    }

    /// The numbers of a value that is known.
    fn known(&self, value: NodeValue) -> Option<SmallVec<[f32; 3]>> {
        match &self.values[value.0].0 {
            NodeOrigin::Number(bits) => Some(bits.iter().map(|bits| f32::from_bits(*bits)).collect()),
            NodeOrigin::Input(_) | NodeOrigin::Node(..) => None,
        }
    }

    /// A component of a vector.
    fn component(&mut self, vector: NodeValue, index: usize) -> NodeValue {
        if let Some(known) = self.known(vector) {
            return self.literal(&[known[index]]);
        }
        if let NodeOrigin::Node(category, inputs) = &self.values[vector.0].0
            && category == "combine3"
            && let Some((_, NodeInput::Value(value))) = inputs.get(index)
        {
            return *value;
        }
        let index = NodeInput::Literal("integer", index.to_string());
        let inputs = vec![("in", NodeInput::Value(vector)), ("index", index)];
        self.insert(NodeOrigin::Node("extract".to_owned(), inputs), FLOAT)
    }

    /// The numbers of a value, one or three.
    fn slots(&mut self, value: NodeValue) -> SmallVec<[NodeValue; 3]> {
        if self.ty(value) == VECTOR {
            (0..3).map(|index| self.component(value, index)).collect()
        } else {
            [value].as_slice().into()
        }
    }

    /// The value of these numbers.
    fn joined(&mut self, numbers: &[NodeValue]) -> NodeValue {
        match numbers {
            [one] => *one,
            numbers => self.call("combine3", VECTOR, numbers),
        }
    }

    /// One value or another, by a condition.
    fn select(&mut self, condition: NodeValue, then: NodeValue, other: NodeValue) -> NodeValue {
        let ty = self.ty(then);
        let (one, zero) = (NodeInput::Value(self.literal(&[1.0])), NodeInput::Value(self.literal(&[0.0])));
        if let NodeOrigin::Node(category, inputs) = self.values[condition.0].0.clone()
            && let [first, second, (_, holds), (_, fails)] = &inputs[..]
        {
            let sides = if (holds, fails) == (&one, &zero) {
                Some((then, other))
            } else if (holds, fails) == (&zero, &one) {
                Some((other, then))
            } else {
                None
            };
            if let Some((then, other)) = sides {
                let chosen = [("in1", NodeInput::Value(then)), ("in2", NodeInput::Value(other))];
                let inputs = [first.clone(), second.clone()].into_iter().chain(chosen).collect();
                return self.insert(NodeOrigin::Node(category, inputs), ty);
            }
        }
        let half = self.literal(&[0.5]);
        self.node("ifgreater", ty, &[("value1", condition), ("value2", half), ("in1", then), ("in2", other)])
    }

    /// Whether a comparison of two numbers holds: 1 or 0.
    fn comparison(&mut self, category: &str, first: NodeValue, second: NodeValue) -> NodeValue {
        let (one, zero) = (self.literal(&[1.0]), self.literal(&[0.0]));
        self.node(category, FLOAT, &[("value1", first), ("value2", second), ("in1", one), ("in2", zero)])
    }

    /// A power as in C. The node `power` knows those of numbers above 0. Small whole exponents become products.
    fn power(&mut self, base: NodeValue, exponent: NodeValue) -> NodeValue {
        match self.known(exponent).map(|known| known[0]) {
            Some(exponent) if [2.0, 3.0, 4.0, 5.0].contains(&exponent) => {
                (1..exponent as usize).fold(base, |product, _| self.call("multiply", FLOAT, &[product, base]))
            }
            Some(whole) if whole > 0.0 && whole.fract() != 0.0 => self.call("power", FLOAT, &[base, exponent]),
            Some(_) | None => {
                let category = self.power.clone();
                self.node(&category, FLOAT, &[("x", base), ("y", exponent)])
            }
        }
    }

    /// The sum of octaves of noise. A number of octaves that is not known becomes a condition of each.
    fn noise(&mut self, point: [NodeValue; 3], a: NodeValue, b: NodeValue, n: NodeValue) -> NodeValue {
        let (zero, category) = (self.literal(&[0.0]), self.noise.clone());
        let [mut sum, mut frequency, mut divisor] = [zero, self.literal(&[1.0]), self.literal(&[1.0])];
        let known = self.known(n).map(|known| known[0]);
        for octave in (1..=MOST_OCTAVES).take_while(|octave| known.is_none_or(|most| *octave as f32 <= most)) {
            let place = point.map(|own| self.record(Primitive::Mul, &[own, frequency]));
            let noise = self.node(&category, FLOAT, &[("px", place[0]), ("py", place[1]), ("pz", place[2])]);
            let mut part = self.record(Primitive::Div, &[noise, divisor]);
            if known.is_none() {
                let number = self.literal(&[octave as f32]);
                let is_used = self.comparison("ifgreatereq", n, number);
                part = self.select(is_used, part, zero);
            }
            sum = self.record(Primitive::Add, &[sum, part]);
            frequency = self.record(Primitive::Mul, &[frequency, b]);
            divisor = self.record(Primitive::Mul, &[divisor, a]);
        }
        sum
    }

    /// The colour of a texture.
    fn texture(&mut self, texture: NodeValue, u: NodeValue, v: NodeValue) -> NodeValue {
        let place = self.node("combine2", "vector2", &[("in1", u), ("in2", v)]);
        let white = NodeInput::Literal(COLOUR, "1, 1, 1".to_owned());
        let inputs = vec![("file", NodeInput::Value(texture)), ("texcoord", NodeInput::Value(place)), ("default", white)];
        let colour = self.insert(NodeOrigin::Node("image".to_owned(), inputs), COLOUR);
        self.call("convert", VECTOR, &[colour])
    }

    /// An operation by its meaning in terms of primitives.
    fn by_meaning(&mut self, operation: Operation, operands: &[NodeValue]) -> NodeValue {
        let filler = self.literal(&[0.0]);
        let mut stack = Stack::new(32, filler);
        for operand in operands {
            self.slots(*operand).into_iter().for_each(|slot| stack.push(slot));
        }
        operation.apply(self, &mut stack);
        match operation.result() {
            Type::Vector => self.joined(&stack.pop::<3>()),
            Type::Scalar | Type::Truth | Type::Texture => stack.pop::<1>()[0],
        }
    }
}

impl Recorder for NodeGraph<'_> {
    type Value = NodeValue;

    fn record_constant(&mut self, value: f32) -> NodeValue {
        self.literal(&[value])
    }

    fn record(&mut self, primitive: Primitive, operands: &[NodeValue]) -> NodeValue {
        let known: Option<Vec<f32>> = operands.iter().map(|operand| Some(self.known(*operand)?[0])).collect();
        if let Some(known) = known {
            return self.literal(&[primitive.apply(&mut Floats, &known)]);
        }
        let one = self.literal(&[1.0]);
        match (primitive, operands) {
            (Primitive::Neg, [x]) => {
                let minus = self.literal(&[-1.0]);
                self.call("multiply", FLOAT, &[*x, minus])
            }
            (Primitive::Exp2, [x]) => {
                let two = self.literal(&[2.0]);
                self.call("power", FLOAT, &[two, *x])
            }
            (Primitive::Log2, [x]) => {
                let (log, factor) = (self.call("ln", FLOAT, &[*x]), self.literal(&[std::f32::consts::LOG2_E]));
                self.call("multiply", FLOAT, &[log, factor])
            }
            (Primitive::Atan, [x]) => self.call("atan2", FLOAT, &[*x, one]),
            (Primitive::Pow, [x, y]) => self.power(*x, *y),
            (Primitive::Perlin, [x, y, z, a, b, n]) => self.noise([*x, *y, *z], *a, *b, *n),
            (Primitive::Less, [x, y]) => self.comparison("ifgreater", *y, *x),
            (Primitive::LessEqual, [x, y]) => self.comparison("ifgreatereq", *y, *x),
            (Primitive::Equal, [x, y]) => self.comparison("ifequal", *x, *y),
            (Primitive::Not, [p]) => {
                let zero = self.literal(&[0.0]);
                self.select(*p, zero, one)
            }
            (Primitive::Select, [condition, then, other]) => self.select(*condition, *then, *other),
            (primitive, operands) => self.call(self.dialect.primitive(primitive), FLOAT, operands),
        }
    }
}

impl TermWriter for NodeGraph<'_> {
    type Written = NodeValue;

    fn number(&mut self, number: f32) -> NodeValue {
        self.literal(&[number])
    }

    fn argument(&mut self, variable: Variable) -> NodeValue {
        if let Some(known) = self.arguments.get(&variable) {
            return *known;
        }
        let value = match variable {
            Variable::ToViewer => {
                let (from, minus) = (self.input(FROM_VIEWER, VECTOR), self.literal(&[-1.0]));
                let value = self.call("multiply", VECTOR, &[from, minus]);
                self.value(variable.name(), value)
            }
            Variable::SurfaceU | Variable::SurfaceV => {
                let place = self.input(COORDINATES, "vector2");
                let index = if variable == Variable::SurfaceU { 0 } else { 1 };
                let value = self.component(place, index);
                self.value(variable.name(), value)
            }
            Variable::Normal
            | Variable::GeometricNormal
            | Variable::Tangent
            | Variable::Point
            | Variable::ToLight
            | Variable::Distance
            | Variable::Visible
            | Variable::RelativeIndex
            | Variable::TotalReflection
            | Variable::Mirrored
            | Variable::Halfway
            | Variable::Bitangent
            | Variable::Alpha
            | Variable::Beta
            | Variable::Gamma
            | Variable::Radiance
            | Variable::SampleWeight
            | Variable::WeightedRadiance => {
                let ty = if variable.ty() == Type::Vector { VECTOR } else { FLOAT };
                self.input(input_name(variable), ty)
            }
        };
        self.arguments.insert(variable, value);
        value
    }

    fn parameter(&mut self, parameter: ParameterId) -> NodeValue {
        let (name, ty) = self.parameters.get(&parameter).cloned().unwrap_or_default();
        let input = self.input(&name, ty);
        match self.formula.parameter(parameter).ty {
            Type::Vector if ty != VECTOR => self.call("convert", VECTOR, &[input]),
            Type::Scalar | Type::Truth if ty != FLOAT => self.call("convert", FLOAT, &[input]),
            Type::Vector | Type::Scalar | Type::Truth | Type::Texture => input,
        }
    }

    fn apply(&mut self, operation: Operation, operands: Vec<NodeValue>) -> NodeValue {
        let ty = if operation.result() == Type::Vector { VECTOR } else { FLOAT };
        let known = operands.iter().all(|operand| self.known(*operand).is_some());
        match (operation, &*operands) {
            (Operation::TextureColour, [texture, u, v]) => self.texture(*texture, *u, *v),
            (operation, operands) if known => self.by_meaning_of_numbers(operation, operands),
            (Operation::Spread, [x]) => self.call("convert", VECTOR, &[*x]),
            (Operation::MulSV, [x, y]) => self.call("multiply", VECTOR, &[*y, *x]),
            (Operation::NegV, [x]) => {
                let minus = self.literal(&[-1.0]);
                self.call("multiply", VECTOR, &[*x, minus])
            }
            (Operation::UnitDotVV, [x, y]) => {
                let (cosine, low, high) =
                    (self.call("dotproduct", FLOAT, &[*x, *y]), self.literal(&[-1.0]), self.literal(&[1.0]));
                self.node("clamp", FLOAT, &[("in", cosine), ("low", low), ("high", high)])
            }
            (Operation::Clamp, [x, low, high]) => self.node("clamp", FLOAT, &[("in", *x), ("low", *low), ("high", *high)]),
            (Operation::MixS | Operation::LerpS | Operation::MixV | Operation::LerpV, [a, b, t]) => {
                self.node("mix", ty, &[("fg", *b), ("bg", *a), ("mix", *t)])
            }
            (Operation::IfS | Operation::IfV, [condition, then, other]) => match self.known(*condition) {
                Some(known) => {
                    if known[0] != 0.0 {
                        *then
                    } else {
                        *other
                    }
                }
                None => self.select(*condition, *then, *other),
            },
            (operation, operands) => match self.dialect.native(operation) {
                Some(category) => self.call(category, ty, operands),
                None => self.by_meaning(operation, operands),
            },
        }
    }

    fn by_components(&mut self, operation: Operation, operands: Vec<NodeValue>) -> NodeValue {
        let components = [0, 1, 2].map(|index| {
            let own = operands.iter().map(|operand| match self.ty(*operand) {
                VECTOR => self.component(*operand, index),
                _ => *operand,
            });
            let own = own.collect();
            self.apply(operation, own)
        });
        self.joined(&components)
    }

    fn value(&mut self, wanted: &str, value: NodeValue) -> NodeValue {
        let is_node = matches!(self.values[value.0].0, NodeOrigin::Node(..));
        if is_node && wanted != UNNAMED && !self.labels.contains_key(&value) {
            let name = self.names.take(wanted);
            self.labels.insert(value, name);
        }
        value
    }

    fn is_long(&self, _: &NodeValue) -> bool {
        false
    }
}

impl NodeGraph<'_> {
    /// The value of an operation on known values.
    fn by_meaning_of_numbers(&mut self, operation: Operation, operands: &[NodeValue]) -> NodeValue {
        let mut stack = Stack::new(32, 0.0);
        for operand in operands {
            self.known(*operand).unwrap_or_default().iter().for_each(|number| stack.push(*number));
        }
        operation.apply(&mut Floats, &mut stack);
        match operation.result() {
            Type::Vector => self.literal(&stack.pop::<3>()),
            Type::Scalar | Type::Truth | Type::Texture => self.literal(&stack.pop::<1>()),
        }
    }
}

/// The name of the input for a variable. Those of one letter are taken in code that MaterialX generates.
pub(super) fn input_name(variable: Variable) -> &'static str {
    match variable {
        Variable::Normal => "normal",
        Variable::GeometricNormal => "geometricnormal",
        Variable::Tangent => "tangent",
        Variable::Point => "position",
        Variable::ToLight => "lightdirection",
        Variable::Distance => "lightdistance",
        other => other.name(),
    }
}

/// The inputs for the direction from the viewer, and for the coordinates of the surface.
pub(super) const FROM_VIEWER: &str = "viewdirection";
pub(super) const COORDINATES: &str = "texcoord";

/// Numbers as values of attributes.
pub(super) fn numbers(numbers: impl IntoIterator<Item = f32>) -> String {
    numbers.into_iter().map(|number| number.to_string()).collect::<Vec<_>>().join(", ")
}
