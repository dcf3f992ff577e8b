//! Spheres: `sphere, center <x, y, z>, radius R`.

use crate::lang::cursor::{Cursor, Reported};
use crate::lang::keywords::Keyword;
use crate::lang::token::Mark;
use crate::scene::movable::Movable;
use crate::scene::syntax::TextForm;
use crate::scene::values::{SceneNumber, Vector, positive, vector};
use crate::scene::{MAX_COORDINATE, MIN_LENGTH, is_within_reach};
use glam::DVec3;
use std::fmt::{Display, Formatter, Result as FmtResult};

/// A sphere; its front is the outside.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sphere {
    center: DVec3,
    radius: f64,
}

/// Why there is no such sphere.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum SphereError {
    /// A coordinate of the centre is beyond [`MAX_COORDINATE`], or not a number.
    #[error("a coordinate is too large")]
    TooFar,
    /// The radius is not within [`MIN_LENGTH`]..[`MAX_COORDINATE`].
    #[error("the radius must be greater than 0, and within {MIN_LENGTH:e} to {MAX_COORDINATE:e}")]
    Radius,
}

impl Sphere {
    /// The sphere of that centre and radius.
    ///
    /// # Errors
    /// A centre too far away; a radius that is not positive, too small or too large.
    pub fn new(center: DVec3, radius: f64) -> Result<Self, SphereError> {
        if !is_within_reach(center) {
            return Err(SphereError::TooFar);
        }
        if !(MIN_LENGTH..=MAX_COORDINATE).contains(&radius) {
            return Err(SphereError::Radius);
        }
        Ok(Self { center, radius })
    }

    /// Its centre, in world coordinates.
    pub fn center(&self) -> DVec3 {
        self.center
    }

    /// Its radius in world units, greater than 0.
    pub fn radius(&self) -> f64 {
        self.radius
    }
}

impl Movable for Sphere {
    fn anchor(&self) -> Option<DVec3> {
        Some(self.center)
    }

    fn moved(&self, by: DVec3) -> Option<Self> {
        Self::new(self.center + by, self.radius).ok()
    }

    fn scaled(&self, by: f64) -> Option<Self> {
        Self::new(self.center, self.radius * by).ok()
    }

    fn radius(&self) -> Option<f64> {
        Some(self.radius)
    }
}

impl TextForm for Sphere {
    const KEYWORD: Keyword = Keyword { word: "sphere", doc: "`sphere, center <x, y, z>, radius R`" };
    const CLAUSES: &'static [Keyword] = &[
        Keyword { word: "center", doc: "the centre: `center <x, y, z>`" },
        Keyword { word: "radius", doc: "the radius, greater than 0" },
    ];
    const EXAMPLE: &'static str = "sphere, center <0, 1, 0>, radius 1";

    fn parse(cursor: &mut Cursor) -> Result<Option<Self>, Reported> {
        cursor.expect(Mark::Comma, "after `sphere`")?;
        cursor.expect_word("center", "of the sphere")?;
        let center = vector(cursor, "the centre")?;
        cursor.expect(Mark::Comma, "after the centre")?;
        cursor.expect_word("radius", "of the sphere")?;
        let radius = positive(cursor, "the radius")?;
        // Values out of range are reported where they stand.
        Ok(radius.and_then(|radius| Self::new(center.value, radius).ok()))
    }
}

impl Display for Sphere {
    fn fmt(&self, f: &mut Formatter<'_>) -> FmtResult {
        write!(f, "sphere, center {}, radius {}", Vector(self.center), SceneNumber(self.radius))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bad_spheres_are_refused() {
        assert_eq!(Sphere::new(DVec3::ZERO, 0.0), Err(SphereError::Radius));
        assert_eq!(Sphere::new(DVec3::ZERO, f64::NAN), Err(SphereError::Radius));
        assert_eq!(Sphere::new(DVec3::ZERO, 1e31), Err(SphereError::Radius));
        assert_eq!(Sphere::new(DVec3::Y * 1e300, 1.0), Err(SphereError::TooFar));
        assert_eq!(Sphere::new(DVec3::NAN, 1.0), Err(SphereError::TooFar));
        assert!(Sphere::new(DVec3::Y * 1e30, 1e-30).is_ok());
    }
}
