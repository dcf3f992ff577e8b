//! Functions of a target language for operations that it does not have: written from the meaning of the operation in
//! terms of primitives.

use crate::export::dialect::Dialect;
use crate::export::spelling::spelled;
use crate::lang::builtins::{Operation, Stack};
use crate::lang::scalars::{Primitive, Recorder};
use crate::lang::types::Type;

/// The name of the function for an operation: `op_add_vv`.
pub(super) fn helper_name(operation: Operation) -> String {
    let mut name = String::from("op");
    let mut before = false;
    for letter in operation.name().chars() {
        if letter.is_ascii_uppercase() && !before || name == "op" {
            name.push('_');
        }
        before = letter.is_ascii_uppercase();
        name.push(letter.to_ascii_lowercase());
    }
    name
}

/// The function for an operation.
pub(super) fn helper(dialect: &Dialect, operation: Operation) -> String {
    let operands = || operation.operand_names().iter().zip(operation.operands());
    let parameters: Vec<String> = operands().map(|(name, ty)| dialect.parameter(*ty, &parameter_name(name))).collect();
    let mut body = HelperBody { dialect, values: Vec::new() };
    let mut stack = Stack::new(32, 0);
    for (name, ty) in operands() {
        let name = parameter_name(name);
        match ty {
            Type::Vector => ["x", "y", "z"].iter().for_each(|part| stack.push(body.push(*ty, format!("{name}.{part}")))),
            Type::Scalar | Type::Truth | Type::Texture => stack.push(body.push(*ty, name)),
        }
    }
    operation.apply(&mut body, &mut stack);
    let mut needed = match operation.result() {
        Type::Vector => stack.pop::<3>().to_vec(),
        Type::Scalar | Type::Truth | Type::Texture => stack.pop::<1>().to_vec(),
    };
    let parts: Vec<&str> = needed.iter().map(|value| &*body.values[*value].text).collect();
    let result = match parts[..] {
        [result] => result.to_owned(),
        _ => format!("{}({})", dialect.make_vector, parts.join(", ")),
    };
    let mut text = vec![dialect.function(operation.result(), &helper_name(operation), &parameters)];
    // A meaning may compute what this operation does not need.
    let mut is_needed = vec![false; body.values.len()];
    while let Some(value) = needed.pop() {
        if !std::mem::replace(&mut is_needed[value], true) {
            needed.extend(&body.values[value].operands);
        }
    }
    let statements = body.values.iter().zip(is_needed).filter(|(_, is_needed)| *is_needed);
    text.extend(statements.filter_map(|(value, _)| Some(format!("    {}", value.statement.as_ref()?))));
    text.push(format!("    return {result};"));
    text.push("}\n".to_owned());
    text.join("\n")
}

/// The name of a parameter. Some operands have names that are words of target languages.
fn parameter_name(name: &str) -> String {
    format!("{name}_")
}

/// A value in the body of a function.
struct HelperValue {
    text: String,
    is_truth: bool,
    /// The statement that computes it, and from which values.
    statement: Option<String>,
    operands: Vec<usize>,
}

/// The body of a function that is being written.
struct HelperBody<'d> {
    dialect: &'d Dialect,
    values: Vec<HelperValue>,
}

impl HelperBody<'_> {
    fn push(&mut self, ty: Type, text: String) -> usize {
        self.values.push(HelperValue { text, is_truth: ty == Type::Truth, statement: None, operands: Vec::new() });
        self.values.len() - 1
    }
}

impl Recorder for HelperBody<'_> {
    type Value = usize;

    fn record_constant(&mut self, value: f32) -> usize {
        let number = self.dialect.number(value);
        self.push(Type::Scalar, if number.starts_with('-') { format!("({number})") } else { number })
    }

    fn record(&mut self, primitive: Primitive, operands: &[usize]) -> usize {
        let texts: Vec<&str> = operands.iter().map(|operand| &*self.values[*operand].text).collect();
        let value = spelled(self.dialect, primitive, &texts);
        let is_truth = primitive.yields_truth()
            || primitive == Primitive::Select && operands[1..].iter().any(|operand| self.values[*operand].is_truth);
        let ty = if is_truth { Type::Truth } else { Type::Scalar };
        let name = format!("t{}", self.values.len());
        let statement = Some(self.dialect.value(ty, &name, &value));
        self.values.push(HelperValue { text: name, is_truth, statement, operands: operands.to_vec() });
        self.values.len() - 1
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::export::dialect::DIALECTS;

    #[test]
    fn helpers_have_names_of_their_own() {
        let names: std::collections::BTreeSet<String> = Operation::ALL.iter().map(|own| helper_name(*own)).collect();
        assert_eq!(names.len(), Operation::ALL.len());
        assert_eq!(helper_name(Operation::UnitDotVV), "op_unit_dot_vv");
        assert_eq!(helper_name(Operation::Atan2), "op_atan2");
    }

    #[test]
    fn helpers_are_written_from_the_meaning() {
        let expected = "static inline float op_mod(float x_, float y_) {\n    const float t2 = x_ / y_;\n    \
                        const float t3 = floorf(t2);\n    const float t4 = y_ * t3;\n    const float t5 = x_ - t4;\n    \
                        return t5;\n}\n";
        assert_eq!(helper(&DIALECTS[0], Operation::Mod), expected);
    }
}
