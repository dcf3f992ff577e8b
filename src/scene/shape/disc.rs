//! Discs: `disc, center <x, y, z>, normal <x, y, z>, radius R`.

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

/// A disc; its front is where its normal points.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Disc {
    center: DVec3,
    normal: DVec3,
    radius: f64,
}

/// Why there is no such disc.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum DiscError {
    /// A coordinate of the centre or the normal is beyond [`MAX_COORDINATE`], or not a number.
    #[error("a coordinate is too large")]
    TooFar,
    /// The normal is zero, or shorter than [`MIN_LENGTH`].
    #[error("the normal of a disc is zero")]
    NoNormal,
    /// The radius is not within [`MIN_LENGTH`]..[`MAX_COORDINATE`].
    #[error("the radius must be greater than 0, and within {MIN_LENGTH:e} to {MAX_COORDINATE:e}")]
    Radius,
}

impl Disc {
    /// The disc of that centre, normal (of any length) and radius.
    ///
    /// # Errors
    /// Coordinates too large; a normal of no length; a radius that is not positive, too small or too large.
    pub fn new(center: DVec3, normal: DVec3, radius: f64) -> Result<Self, DiscError> {
        if !(is_within_reach(center) && is_within_reach(normal)) {
            return Err(DiscError::TooFar);
        }
        if normal.length() < MIN_LENGTH {
            return Err(DiscError::NoNormal);
        }
        if !(MIN_LENGTH..=MAX_COORDINATE).contains(&radius) {
            return Err(DiscError::Radius);
        }
        Ok(Self { center, normal, radius })
    }

    /// Its centre, in world coordinates.
    pub fn center(&self) -> DVec3 {
        self.center
    }

    /// The direction to which its front looks, as given: of any length.
    pub fn normal(&self) -> DVec3 {
        self.normal
    }

    /// Its radius in world units, greater than 0.
    pub fn radius(&self) -> f64 {
        self.radius
    }
}

impl Movable for Disc {
    fn anchor(&self) -> Option<DVec3> {
        Some(self.center)
    }

    fn moved(&self, by: DVec3) -> Option<Self> {
        Self::new(self.center + by, self.normal, self.radius).ok()
    }

    fn scaled(&self, by: f64) -> Option<Self> {
        Self::new(self.center, self.normal, self.radius * by).ok()
    }

    fn radius(&self) -> Option<f64> {
        Some(self.radius)
    }

    fn flat_normal(&self) -> Option<DVec3> {
        Some(self.normal)
    }
}

impl TextForm for Disc {
    const KEYWORD: Keyword = Keyword { word: "disc", doc: "`disc, center <x, y, z>, normal <x, y, z>, radius R`" };
    const CLAUSES: &'static [Keyword] = &[
        Keyword { word: "center", doc: "the centre: `center <x, y, z>`" },
        Keyword { word: "normal", doc: "the direction to which the front of the disc looks, of any length: `normal <x, y, z>`" },
        Keyword { word: "radius", doc: "the radius, greater than 0" },
    ];
    const EXAMPLE: &'static str = "disc, center <0, 1, 0>, normal <0, 1, 0>, radius 1";

    fn parse(cursor: &mut Cursor) -> Result<Option<Self>, Reported> {
        cursor.expect(Mark::Comma, "after `disc`")?;
        cursor.expect_word("center", "of the disc")?;
        let center = vector(cursor, "the centre")?;
        cursor.expect(Mark::Comma, "after the centre")?;
        cursor.expect_word("normal", "of the disc")?;
        let normal = vector(cursor, "the normal")?;
        cursor.expect(Mark::Comma, "after the normal")?;
        cursor.expect_word("radius", "of the disc")?;
        let radius = positive(cursor, "the radius")?;
        if normal.value.length() < MIN_LENGTH {
            let diagnostic = Diagnostic::error("the normal of the disc is zero").at(normal.span, "this is no direction");
            cursor.report(diagnostic.help("a disc that looks upwards has `normal <0, 1, 0>`"));
        }
        // Other values out of range are reported where they stand.
        Ok(radius.and_then(|radius| Self::new(center.value, normal.value, radius).ok()))
    }
}

impl Display for Disc {
    fn fmt(&self, f: &mut Formatter<'_>) -> FmtResult {
        let (center, normal) = (Vector(self.center), Vector(self.normal));
        write!(f, "disc, center {center}, normal {normal}, radius {}", SceneNumber(self.radius))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bad_discs_are_refused() {
        assert_eq!(Disc::new(DVec3::ZERO, DVec3::Y, 0.0), Err(DiscError::Radius));
        assert_eq!(Disc::new(DVec3::ZERO, DVec3::ZERO, 1.0), Err(DiscError::NoNormal));
        assert_eq!(Disc::new(DVec3::ZERO, DVec3::Y * 1e31, 1.0), Err(DiscError::TooFar));
        assert_eq!(Disc::new(DVec3::NAN, DVec3::Y, 1.0), Err(DiscError::TooFar));
        assert!(Disc::new(DVec3::Y * 1e30, DVec3::Y * 1e-30, 1e-30).is_ok());
    }
}
