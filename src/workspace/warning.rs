//! What is said of values that are not taken as given.

use crate::formula::ParameterId;
use crate::formula::invariants::short;
use crate::workspace::owner::OwnerId;
use std::fmt;

/// Why a value is another than the one given.
#[derive(Debug, Clone, PartialEq)]
pub enum Cause {
    /// It is outside the parameter's range.
    Outside([f32; 2]),
    /// Together with the others it would break an invariant.
    GaveWay,
    /// It follows from others, as the text says: `kd = 1 - ks`.
    Locked(String),
    /// The body is opaque.
    Opaque,
    /// The body is matte.
    Matte,
}

/// A value that was not taken as given.
#[derive(Debug, Clone, PartialEq)]
pub struct Warning {
    /// Whose value.
    pub owner: OwnerId,
    /// Of which parameter.
    pub parameter: ParameterId,
    /// Its name as users write it: `ball.kd`.
    pub label: String,
    /// What was given: one number or three.
    pub given: Vec<f32>,
    /// What is taken instead.
    pub taken: Vec<f32>,
    /// Why.
    pub cause: Cause,
}

impl fmt::Display for Warning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (label, given, taken) = (&self.label, show(&self.given), show(&self.taken));
        match &self.cause {
            Cause::Outside([low, high]) => {
                let (low, high) = (short(*low), short(*high));
                write!(f, "`{label}` = {given} is outside {low}..{high}; {taken} is taken")
            }
            Cause::GaveWay => write!(f, "`{label}` = {given} gives way to the invariants; {taken} is taken"),
            Cause::Locked(explanation) => {
                write!(f, "`{label}` = {given} is ignored: it follows from others ({explanation}) and is {taken}")
            }
            Cause::Opaque => write!(f, "`{label}` = {given} is ignored: the body is opaque and never refracts"),
            Cause::Matte => write!(f, "`{label}` = {given} is ignored: the body is matte and never reflects"),
        }
    }
}

/// A value as formulas write it: a number, or `<x, y, z>`.
pub fn show(numbers: &[f32]) -> String {
    match numbers {
        [number] => short(*number),
        numbers => format!("<{}>", numbers.iter().map(|number| short(*number)).collect::<Vec<_>>().join(", ")),
    }
}
