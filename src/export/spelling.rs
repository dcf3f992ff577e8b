//! How primitives are written in target languages.

use crate::export::dialect::Dialect;
use crate::lang::scalars::Primitive;

/// Primitives that are operators between their operands.
pub(super) const BINARY: [(Primitive, &str); 9] = [
    (Primitive::Add, "+"),
    (Primitive::Sub, "-"),
    (Primitive::Mul, "*"),
    (Primitive::Div, "/"),
    (Primitive::Less, "<"),
    (Primitive::LessEqual, "<="),
    (Primitive::Equal, "=="),
    (Primitive::And, "&&"),
    (Primitive::Or, "||"),
];

/// A primitive of operands that are names, numbers or in parentheses.
pub(super) fn spelled(dialect: &Dialect, primitive: Primitive, operands: &[&str]) -> String {
    let operator = BINARY.iter().find(|(own, _)| *own == primitive).map(|(_, operator)| *operator);
    match (primitive, operands) {
        (_, [x, y]) if operator.is_some() => format!("{x} {} {y}", operator.unwrap_or_default()),
        (Primitive::Neg, [x]) => format!("-{x}"),
        (Primitive::Not, [x]) => format!("!{x}"),
        // In this order the result is y if either is NaN.
        (Primitive::Min, [x, y]) => dialect.select(&format!("({x} < {y})"), x, y),
        (Primitive::Max, [x, y]) => dialect.select(&format!("({x} > {y})"), x, y),
        (Primitive::Select, [condition, then, other]) => dialect.select(condition, then, other),
        (primitive, operands) => format!("{}({})", dialect.primitive(primitive), operands.join(", ")),
    }
}
