//! Numbers out of range become the nearest one within it, with a warning.

use crate::lang::diagnostic::Diagnostic;
use crate::workspace::spanned_toml::{Value, parse_integer};
use std::ops::RangeInclusive;

/// The whole number in a range that is nearest to a value, with a warning if it is another.
pub(super) fn nearest_whole(value: Value, range: RangeInclusive<i64>) -> Result<(i64, Option<Diagnostic>), Diagnostic> {
    let (low, high) = (*range.start(), *range.end());
    let expected = format!("a whole number from {low} to {high}");
    let number = value.integer(&expected)?;
    // A number that does not fit 64 bits is beyond any range.
    let beyond = if number.as_str().starts_with('-') { i64::MIN } else { i64::MAX };
    let given = parse_integer(number).unwrap_or(beyond);
    let taken = given.clamp(low, high);
    Ok((taken, (taken != given).then(|| outside(value, number.as_str(), &expected, &taken.to_string()))))
}

/// The number in a range that is nearest to a value, with a warning if it is another.
pub(super) fn nearest_number(value: Value, [low, high]: [f32; 2]) -> Result<(f32, Option<Diagnostic>), Diagnostic> {
    let given = value.number()? as f32;
    let taken = given.clamp(low, high);
    let expected = format!("a number from {low} to {high}");
    Ok((taken, (taken != given).then(|| outside(value, &given.to_string(), &expected, &taken.to_string()))))
}

fn outside(value: Value, given: &str, expected: &str, taken: &str) -> Diagnostic {
    Diagnostic::warning(format!("{given} is out of range; {taken} is used")).at(value.span, format!("expected {expected}"))
}
