//! The numbers and vectors of the scene language: how they are parsed, and how they are printed.

use crate::lang::cursor::{Cursor, Placed, Reported};
use crate::lang::diagnostic::Diagnostic;
use crate::scene::{MAX_COORDINATE, MIN_LENGTH};
use glam::DVec3;
use std::fmt::{Display, Formatter, Result as FmtResult};

/// A number as the scene language writes it.
pub(super) struct SceneNumber(pub(super) f64);

impl Display for SceneNumber {
    fn fmt(&self, f: &mut Formatter<'_>) -> FmtResult {
        let size = self.0.abs();
        // Both forms are the shortest that read back exactly. The exponent avoids rows of zeros.
        if size != 0.0 && !(1e-5..1e16).contains(&size) { write!(f, "{:e}", self.0) } else { write!(f, "{}", self.0) }
    }
}

/// A vector as the scene language writes it.
pub(super) struct Vector(pub(super) DVec3);

impl Display for Vector {
    fn fmt(&self, f: &mut Formatter<'_>) -> FmtResult {
        write!(f, "<{}, {}, {}>", SceneNumber(self.0.x), SceneNumber(self.0.y), SceneNumber(self.0.z))
    }
}

/// Parses a vector of numbers up to [`MAX_COORDINATE`]; `what` names it in messages. A larger component is reported and
/// becomes NaN, which no shape and no camera accepts without a further error.
pub(super) fn vector(cursor: &mut Cursor, what: &str) -> Result<Placed<DVec3>, Reported> {
    let vector = cursor.vector(what)?;
    let components = vector.value.map(|number| {
        if number.value.abs() <= MAX_COORDINATE {
            return number.value;
        }
        let diagnostic = Diagnostic::error(format!("a component of {what} is too large"));
        cursor.report(diagnostic.at(number.span, format!("scenes reach from {:e} to {MAX_COORDINATE:e}", -MAX_COORDINATE)));
        f64::NAN
    });
    Ok(Placed { value: DVec3::from(components), span: vector.span })
}

/// Parses a number within [`MIN_LENGTH`]..[`MAX_COORDINATE`]; any other is reported, and gives `None`.
pub(super) fn positive(cursor: &mut Cursor, what: &str) -> Result<Option<f64>, Reported> {
    let number = cursor.number(what)?;
    if (MIN_LENGTH..=MAX_COORDINATE).contains(&number.value) {
        return Ok(Some(number.value));
    }
    let (message, mark) = if number.value > MAX_COORDINATE {
        (format!("{what} is too large"), format!("at most {MAX_COORDINATE:e}"))
    } else if number.value > 0.0 {
        (format!("{what} is too small"), format!("at least {MIN_LENGTH:e}"))
    } else {
        (format!("{what} must be greater than 0"), format!("it is {}", SceneNumber(number.value)))
    };
    cursor.report(Diagnostic::error(message).at(number.span, mark));
    Ok(None)
}
