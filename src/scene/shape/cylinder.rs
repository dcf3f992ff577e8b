//! Cylinders: `cylinder, A, B, radius R`.

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

/// A closed cylinder; its front is the outside.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cylinder {
    base: DVec3,
    top: DVec3,
    radius: f64,
}

/// Why there is no such cylinder.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum CylinderError {
    /// A coordinate is beyond [`MAX_COORDINATE`], or not a number.
    #[error("a coordinate is too large")]
    TooFar,
    /// The centres of base and top are the same.
    #[error("the cylinder has no height")]
    NoHeight,
    /// The radius is not within [`MIN_LENGTH`]..[`MAX_COORDINATE`].
    #[error("the radius must be greater than 0, and within {MIN_LENGTH:e} to {MAX_COORDINATE:e}")]
    Radius,
}

impl Cylinder {
    /// The cylinder between two circles with these centres and that radius.
    ///
    /// # Errors
    /// Centres too far away; both in one place; a radius that is not positive, too small or too large.
    pub fn new(base: DVec3, top: DVec3, radius: f64) -> Result<Self, CylinderError> {
        if !(is_within_reach(base) && is_within_reach(top)) {
            return Err(CylinderError::TooFar);
        }
        if base.distance(top) < MIN_LENGTH {
            return Err(CylinderError::NoHeight);
        }
        if !(MIN_LENGTH..=MAX_COORDINATE).contains(&radius) {
            return Err(CylinderError::Radius);
        }
        Ok(Self { base, top, radius })
    }

    /// The centres of base and top, in world coordinates.
    pub fn centers(&self) -> [DVec3; 2] {
        [self.base, self.top]
    }

    /// Its radius in world units, greater than 0.
    pub fn radius(&self) -> f64 {
        self.radius
    }
}

impl Movable for Cylinder {
    /// The middle of its axis.
    fn anchor(&self) -> Option<DVec3> {
        Some(self.base.midpoint(self.top))
    }

    fn moved(&self, by: DVec3) -> Option<Self> {
        Self::new(self.base + by, self.top + by, self.radius).ok()
    }

    fn scaled(&self, by: f64) -> Option<Self> {
        let middle = self.base.midpoint(self.top);
        let [base, top] = [self.base, self.top].map(|end| middle + by * (end - middle));
        Self::new(base, top, self.radius * by).ok()
    }

    fn radius(&self) -> Option<f64> {
        Some(self.radius)
    }
}

impl TextForm for Cylinder {
    const KEYWORD: Keyword =
        Keyword { word: "cylinder", doc: "`cylinder, A, B, radius R`: the centres of base and top; it is closed at both ends" };
    const CLAUSES: &'static [Keyword] = &[Keyword { word: "radius", doc: "the radius, greater than 0" }];
    const EXAMPLE: &'static str = "cylinder, <0, 0, 0>, <0, 2, 0>, radius 1";

    fn parse(cursor: &mut Cursor) -> Result<Option<Self>, Reported> {
        cursor.expect(Mark::Comma, "after `cylinder`")?;
        let base = vector(cursor, "the centre of the base")?;
        cursor.expect(Mark::Comma, "after the centre of the base")?;
        let top = vector(cursor, "the centre of the top")?;
        cursor.expect(Mark::Comma, "after the centre of the top")?;
        cursor.expect_word("radius", "of the cylinder")?;
        let radius = positive(cursor, "the radius")?;
        if base.value.distance(top.value) < MIN_LENGTH {
            let diagnostic = Diagnostic::error("the cylinder has no height")
                .at(top.span, "the centre of the top is also here")
                .at(base.span, "the centre of the base");
            cursor.report(diagnostic.help("give the centres of two ends that are apart; a flat piece is a `disc`"));
        }
        // Other values out of range are reported where they stand.
        Ok(radius.and_then(|radius| Self::new(base.value, top.value, radius).ok()))
    }
}

impl Display for Cylinder {
    fn fmt(&self, f: &mut Formatter<'_>) -> FmtResult {
        write!(f, "cylinder, {}, {}, radius {}", Vector(self.base), Vector(self.top), SceneNumber(self.radius))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bad_cylinders_are_refused() {
        assert_eq!(Cylinder::new(DVec3::ZERO, DVec3::Y, 0.0), Err(CylinderError::Radius));
        assert_eq!(Cylinder::new(DVec3::ZERO, DVec3::Y, f64::NAN), Err(CylinderError::Radius));
        assert_eq!(Cylinder::new(DVec3::ONE, DVec3::ONE, 1.0), Err(CylinderError::NoHeight));
        assert_eq!(Cylinder::new(DVec3::ZERO, DVec3::Y * 1e31, 1.0), Err(CylinderError::TooFar));
        assert_eq!(Cylinder::new(DVec3::NAN, DVec3::Y, 1.0), Err(CylinderError::TooFar));
        assert!(Cylinder::new(DVec3::ZERO, DVec3::Y * 1e30, 1e-30).is_ok());
    }
}
