//! Operations of formulas as nodes.

use crate::export::nodes::{
    COLOUR, COORDINATES, FLOAT, FROM_VIEWER, MOST_OCTAVES, NodeGraph, NodeInput, NodeOrigin, NodeValue, VECTOR, input_name,
};
use crate::export::walk::{TermWriter, UNNAMED};
use crate::formula::ParameterId;
use crate::lang::builtins::{Operation, Stack};
use crate::lang::scalars::{Floats, Primitive, Recorder};
use crate::lang::types::Type;
use crate::lang::variables::Variable;

impl NodeGraph<'_> {
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
        let value = if variable == Variable::ToViewer {
            let (from, minus) = (self.input(FROM_VIEWER, VECTOR), self.literal(&[-1.0]));
            let value = self.call("multiply", VECTOR, &[from, minus]);
            self.value(variable.name(), value)
        } else if variable.is_coordinate() {
            let place = self.input(COORDINATES, "vector2");
            let value = self.component(place, usize::from(variable == Variable::SurfaceV));
            self.value(variable.name(), value)
        } else {
            let ty = if variable.ty() == Type::Vector { VECTOR } else { FLOAT };
            self.input(input_name(variable), ty)
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
