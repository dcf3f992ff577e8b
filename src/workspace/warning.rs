//! Warnings about values that are not used as given.

use crate::formula::ParameterId;
use crate::formula::invariants::short;
use crate::workspace::owner::OwnerId;
use std::fmt;

/// Why a value is not used as given.
#[derive(Debug, Clone, PartialEq)]
pub enum Cause {
    /// It is outside the parameter's range.
    OutOfRange([f32; 2]),
    /// With the other values it would break an invariant.
    Invariant,
    /// It follows from other values, as in `kd = 1 - ks`.
    Locked(String),
    /// The body is opaque.
    Opaque,
    /// The body is matte.
    Matte,
}

/// A value that is not used as given.
#[derive(Debug, Clone, PartialEq)]
pub struct ValueWarning {
    /// The owner of the value.
    pub owner: OwnerId,
    /// The parameter.
    pub parameter: ParameterId,
    /// The name as users write it: `ball.kd`.
    pub label: String,
    /// The value that was given: one number or three.
    pub given: Vec<f32>,
    /// The value that is used.
    pub used: Vec<f32>,
    /// The reason.
    pub cause: Cause,
}

impl fmt::Display for ValueWarning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (label, given, used) = (&self.label, show(&self.given), show(&self.used));
        match &self.cause {
            Cause::OutOfRange([low, high]) => {
                let inside = self.given.iter().all(|number| (low..=high).contains(&number));
                let (low, high) = (short(*low), short(*high));
                if inside {
                    return write!(f, "`{label}` = {given} is not a whole number; {used} is used");
                }
                write!(f, "`{label}` = {given} is outside {low}..{high}; {used} is used")
            }
            Cause::Invariant => write!(f, "`{label}` = {given} breaks an invariant; {used} is used"),
            Cause::Locked(explanation) => {
                write!(f, "`{label}` = {given} is ignored: it follows from other values ({explanation}) and is {used}")
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
