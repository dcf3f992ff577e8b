//! Directional lights: `directional, <x, y, z>`.

use crate::lang::cursor::{Cursor, Reported};
use crate::lang::diagnostic::Diagnostic;
use crate::lang::keywords::Keyword;
use crate::lang::token::Mark;
use crate::scene::movable::Movable;
use crate::scene::syntax::TextForm;
use crate::scene::values::{Vector, vector};
use crate::scene::{MIN_LENGTH, is_within_reach};
use glam::DVec3;
use std::fmt::{Display, Formatter, Result as FmtResult};

/// Light that comes from infinitely far away, in parallel rays.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DirectionalLight {
    direction: DVec3,
}

/// Why there is no such directional light.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum DirectionalLightError {
    /// A component of the direction is beyond [`MAX_COORDINATE`](crate::scene::MAX_COORDINATE), or not a number.
    #[error("a component of the direction is too large")]
    TooFar,
    /// The direction is zero, or shorter than [`MIN_LENGTH`].
    #[error("the direction of a directional light is zero")]
    NoDirection,
}

impl DirectionalLight {
    /// Light that travels in this direction, which may have any length.
    ///
    /// # Errors
    /// Components too large; a direction of no length.
    pub fn new(direction: DVec3) -> Result<Self, DirectionalLightError> {
        if !is_within_reach(direction) {
            return Err(DirectionalLightError::TooFar);
        }
        if direction.length() < MIN_LENGTH {
            return Err(DirectionalLightError::NoDirection);
        }
        Ok(Self { direction })
    }

    /// The direction in which the light travels, as given: of any length.
    pub fn direction(&self) -> DVec3 {
        self.direction
    }

    /// The same that travels in another direction, given by a vector of any length; `None` if that is zero. The vector
    /// in the text keeps its length.
    pub(super) fn aimed(&self, direction: DVec3) -> Option<Self> {
        Self::new(direction.try_normalize()? * self.direction.length()).ok()
    }
}

impl Movable for DirectionalLight {
    /// It is everywhere.
    fn anchor(&self) -> Option<DVec3> {
        None
    }

    /// It is the same everywhere.
    fn moved(&self, _: DVec3) -> Option<Self> {
        Some(*self)
    }
}

impl TextForm for DirectionalLight {
    const KEYWORD: Keyword = Keyword {
        word: "directional",
        doc: "`directional, <x, y, z>`: parallel light from far away, which travels in this direction",
    };
    const CLAUSES: &'static [Keyword] = &[];
    const EXAMPLE: &'static str = "directional, <-0.5, -1, -0.4>";

    fn parse(cursor: &mut Cursor) -> Result<Option<Self>, Reported> {
        cursor.expect(Mark::Comma, "after `directional`")?;
        let direction = vector(cursor, "the direction of the light")?;
        if direction.value.length() < MIN_LENGTH {
            let diagnostic = Diagnostic::error("the direction of the light is zero");
            let help = "light that travels straight down has `directional, <0, -1, 0>`";
            cursor.report(diagnostic.at(direction.span, "this is no direction").help(help));
        }
        // A component out of range is reported where it stands.
        Ok(Self::new(direction.value).ok())
    }
}

impl Display for DirectionalLight {
    fn fmt(&self, f: &mut Formatter<'_>) -> FmtResult {
        write!(f, "directional, {}", Vector(self.direction))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bad_directions_are_refused() {
        assert_eq!(DirectionalLight::new(DVec3::ZERO), Err(DirectionalLightError::NoDirection));
        assert_eq!(DirectionalLight::new(DVec3::Y * 1e31), Err(DirectionalLightError::TooFar));
        assert_eq!(DirectionalLight::new(DVec3::NAN), Err(DirectionalLightError::TooFar));
        assert!(DirectionalLight::new(DVec3::Y * 1e-30).is_ok());
    }
}
