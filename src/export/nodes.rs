//! A formula as a graph of nodes of MaterialX.
//!
//! Operations on vectors are nodes if MaterialX has one. Any other operation is written from its meaning in terms of
//! primitives. Conditions are numbers, 1 or 0. Equal nodes are there once.

mod operations;

use crate::export::dialect::{Dialect, finite};
use crate::export::names::FreeNames;
use crate::export::walk::UNNAMED;
use crate::formula::{Formula, ParameterId};
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
}

/// The names of inputs for variables that have others. Those of one letter are taken in code that MaterialX generates.
const INPUT_NAMES: [(Variable, &str); 6] = [
    (Variable::Normal, "normal"),
    (Variable::GeometricNormal, "geometricnormal"),
    (Variable::Tangent, "tangent"),
    (Variable::Point, "position"),
    (Variable::ToLight, "lightdirection"),
    (Variable::Distance, "lightdistance"),
];

/// The name of the input for a variable.
pub(super) fn input_name(variable: Variable) -> &'static str {
    INPUT_NAMES.iter().find(|(own, _)| *own == variable).map_or(variable.name(), |(_, name)| *name)
}

/// The inputs for the direction from the viewer, and for the coordinates of the surface.
pub(super) const FROM_VIEWER: &str = "viewdirection";
pub(super) const COORDINATES: &str = "texcoord";

/// Numbers as values of attributes.
pub(super) fn numbers(numbers: impl IntoIterator<Item = f32>) -> String {
    numbers.into_iter().map(|number| number.to_string()).collect::<Vec<_>>().join(", ")
}
