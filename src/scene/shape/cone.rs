//! Cones: `cone, A, B, radius R`.

use crate::lang::cursor::{Cursor, Reported};
use crate::lang::diagnostic::Diagnostic;
use crate::lang::keywords::Keyword;
use crate::lang::token::Mark;
use crate::scene::movable::Movable;
use crate::scene::syntax::TextForm;
use crate::scene::values::{SceneNumber, Vector, positive, vector};
use crate::scene::{MAX_COORDINATE, MIN_LENGTH, is_within_reach};
use glam::DVec3;
use std::fmt::{Display, Formatter, Result as FmtResult};

/// A closed cone; its front is the outside.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cone {
    base: DVec3,
    apex: DVec3,
    radius: f64,
}

/// Why there is no such cone.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum ConeError {
    /// A coordinate is beyond [`MAX_COORDINATE`], or not a number.
    #[error("a coordinate is too large")]
    TooFar,
    /// The apex is the centre of the base.
    #[error("the cone has no height")]
    NoHeight,
    /// The radius is not within [`MIN_LENGTH`]..[`MAX_COORDINATE`].
    #[error("the radius must be greater than 0, and within {MIN_LENGTH:e} to {MAX_COORDINATE:e}")]
    Radius,
}

impl Cone {
    /// The cone from a base with this centre to an apex, with that radius.
    ///
    /// # Errors
    /// Points too far away; both in one place; a radius that is not positive, too small or too large.
    pub fn new(base: DVec3, apex: DVec3, radius: f64) -> Result<Self, ConeError> {
        if !(is_within_reach(base) && is_within_reach(apex)) {
            return Err(ConeError::TooFar);
        }
        if base.distance(apex) < MIN_LENGTH {
            return Err(ConeError::NoHeight);
        }
        if !(MIN_LENGTH..=MAX_COORDINATE).contains(&radius) {
            return Err(ConeError::Radius);
        }
        Ok(Self { base, apex, radius })
    }

    /// The centre of the base, in world coordinates.
    pub fn base(&self) -> DVec3 {
        self.base
    }

    /// The apex, in world coordinates.
    pub fn apex(&self) -> DVec3 {
        self.apex
    }

    /// The radius of its base in world units, greater than 0.
    pub fn radius(&self) -> f64 {
        self.radius
    }
}

impl Movable for Cone {
    /// The middle of its axis.
    fn anchor(&self) -> Option<DVec3> {
        Some(self.base.midpoint(self.apex))
    }

    fn moved(&self, by: DVec3) -> Option<Self> {
        Self::new(self.base + by, self.apex + by, self.radius).ok()
    }

    fn scaled(&self, by: f64) -> Option<Self> {
        let middle = self.base.midpoint(self.apex);
        let [base, apex] = [self.base, self.apex].map(|end| middle + by * (end - middle));
        Self::new(base, apex, self.radius * by).ok()
    }

    fn radius(&self) -> Option<f64> {
        Some(self.radius)
    }
}

impl TextForm for Cone {
    const KEYWORD: Keyword =
        Keyword { word: "cone", doc: "`cone, A, B, radius R`: the centre of the base and the apex; the base is closed" };
    const CLAUSES: &'static [Keyword] = &[Keyword { word: "radius", doc: "the radius, greater than 0" }];
    const EXAMPLE: &'static str = "cone, <0, 0, 0>, <0, 2, 0>, radius 1";

    fn parse(cursor: &mut Cursor) -> Result<Option<Self>, Reported> {
        cursor.expect(Mark::Comma, "after `cone`")?;
        let base = vector(cursor, "the centre of the base")?;
        cursor.expect(Mark::Comma, "after the centre of the base")?;
        let apex = vector(cursor, "the apex")?;
        cursor.expect(Mark::Comma, "after the apex")?;
        cursor.expect_word("radius", "of the cone")?;
        let radius = positive(cursor, "the radius")?;
        if base.value.distance(apex.value) < MIN_LENGTH {
            let diagnostic = Diagnostic::error("the cone has no height")
                .at(apex.span, "the apex is also here")
                .at(base.span, "the centre of the base");
            cursor.report(diagnostic.help("give an apex away from the base; a flat piece is a `disc`"));
        }
        // Other values out of range are reported where they stand.
        Ok(radius.and_then(|radius| Self::new(base.value, apex.value, radius).ok()))
    }
}

impl Display for Cone {
    fn fmt(&self, f: &mut Formatter<'_>) -> FmtResult {
        write!(f, "cone, {}, {}, radius {}", Vector(self.base), Vector(self.apex), SceneNumber(self.radius))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bad_cones_are_refused() {
        assert_eq!(Cone::new(DVec3::ZERO, DVec3::Y, 0.0), Err(ConeError::Radius));
        assert_eq!(Cone::new(DVec3::ZERO, DVec3::Y, f64::NAN), Err(ConeError::Radius));
        assert_eq!(Cone::new(DVec3::ONE, DVec3::ONE, 1.0), Err(ConeError::NoHeight));
        assert_eq!(Cone::new(DVec3::ZERO, DVec3::Y * 1e31, 1.0), Err(ConeError::TooFar));
        assert_eq!(Cone::new(DVec3::NAN, DVec3::Y, 1.0), Err(ConeError::TooFar));
        assert!(Cone::new(DVec3::ZERO, DVec3::Y * 1e30, 1e-30).is_ok());
    }
}
