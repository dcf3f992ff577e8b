//! Rectangles: `rectangle, A, B, C`.

use crate::lang::cursor::{Cursor, Placed, Reported};
use crate::lang::diagnostic::Diagnostic;
use crate::lang::keywords::Keyword;
use crate::lang::token::Mark;
use crate::scene::movable::Movable;
use crate::scene::syntax::TextForm;
use crate::scene::values::{Vector, vector};
use crate::scene::{MIN_LENGTH, is_within_reach};
use glam::DVec3;
use std::fmt::{Display, Formatter, Result as FmtResult};

/// The largest |cosine| of the angle between the edges of a rectangle.
const MAX_COSINE: f64 = 1e-3;

/// A rectangle A, B, C and A + C − B; its front is the side from which the corners are clockwise.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rectangle {
    corners: [DVec3; 3],
    normal: DVec3,
}

/// Why there is no such rectangle.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum RectangleError {
    /// A coordinate is beyond [`MAX_COORDINATE`](crate::scene::MAX_COORDINATE), or not a number.
    #[error("a coordinate is too large")]
    TooFar,
    /// Two neighbouring corners, counted from 0, are the same.
    #[error("two neighbouring corners of a rectangle are the same")]
    NoEdge(usize, usize),
    /// The edges that meet in B are not perpendicular; the cosine of the angle between them.
    #[error("the edges of a rectangle are not perpendicular: the cosine is {0:.3e}")]
    Skewed(f64),
}

impl Rectangle {
    /// The rectangle with the corners `a`, `b`, `c`, clockwise in this order as seen from its front.
    ///
    /// # Errors
    /// Corners too far away; neighbours that coincide; edges that are not perpendicular to |cosine| ≤ 1e-3.
    pub fn new(a: DVec3, b: DVec3, c: DVec3) -> Result<Self, RectangleError> {
        if ![a, b, c].into_iter().all(is_within_reach) {
            return Err(RectangleError::TooFar);
        }
        let (first, second) = (a - b, c - b);
        if first.length() < MIN_LENGTH {
            return Err(RectangleError::NoEdge(0, 1));
        }
        if second.length() < MIN_LENGTH {
            return Err(RectangleError::NoEdge(1, 2));
        }
        let cosine = first.dot(second) / (first.length() * second.length());
        if cosine.abs() > MAX_COSINE {
            return Err(RectangleError::Skewed(cosine));
        }
        // (C − A) × (B − A), written with the edges at B.
        let normal = first.normalize().cross(second.normalize()).normalize();
        Ok(Self { corners: [a, b, c], normal })
    }

    /// The corners A, B, C in world coordinates.
    pub fn corners(&self) -> [DVec3; 3] {
        self.corners
    }

    /// The front normal, normalize((C−A)×(B−A)), of unit length.
    pub fn normal(&self) -> DVec3 {
        self.normal
    }
}

impl Movable for Rectangle {
    /// Its middle.
    fn anchor(&self) -> Option<DVec3> {
        Some(self.corners[0].midpoint(self.corners[2]))
    }

    fn moved(&self, by: DVec3) -> Option<Self> {
        let [a, b, c] = self.corners.map(|corner| corner + by);
        Self::new(a, b, c).ok()
    }

    fn scaled(&self, by: f64) -> Option<Self> {
        let middle = self.corners[0].midpoint(self.corners[2]);
        let [a, b, c] = self.corners.map(|corner| middle + by * (corner - middle));
        Self::new(a, b, c).ok()
    }

    /// A rectangle whose edges are along axes stays one.
    fn stretched(&self, by: DVec3) -> Option<Self> {
        let [a, b, c] = self.corners;
        let is_along_axis = |edge: DVec3| edge.to_array().iter().filter(|part| **part != 0.0).count() == 1;
        if !(is_along_axis(b - a) && is_along_axis(c - b)) {
            return None;
        }
        let middle = a.midpoint(c);
        let [a, b, c] = self.corners.map(|corner| middle + by * (corner - middle));
        Self::new(a, b, c).ok()
    }

    fn flat_normal(&self) -> Option<DVec3> {
        Some(self.normal)
    }
}

impl TextForm for Rectangle {
    const KEYWORD: Keyword =
        Keyword { word: "rectangle", doc: "`rectangle, A, B, C`: three corners, clockwise as seen from the front" };
    const CLAUSES: &'static [Keyword] = &[];
    const EXAMPLE: &'static str = "rectangle, <-2, 0, -1>, <2, 0, -1>, <2, 0, 1>";

    fn parse(cursor: &mut Cursor) -> Result<Option<Self>, Reported> {
        let mut corners = [Placed { value: DVec3::ZERO, span: cursor.span() }; 3];
        for (corner, letter) in corners.iter_mut().zip(["A", "B", "C"]) {
            cursor.expect(Mark::Comma, &format!("before corner {letter} of the rectangle"))?;
            *corner = vector(cursor, &format!("corner {letter}"))?;
        }
        let [a, b, c] = corners.map(|corner| corner.value);
        match Self::new(a, b, c) {
            Ok(rectangle) => return Ok(Some(rectangle)),
            Err(RectangleError::NoEdge(first, second)) => {
                let diagnostic = Diagnostic::error("an edge of the rectangle has no length")
                    .at(corners[second].span, "the same as the corner before")
                    .at(corners[first].span, "the corner before");
                let form = "give three corners in order, clockwise as seen from the front; the fourth follows";
                cursor.report(diagnostic.help(form));
            }
            Err(RectangleError::Skewed(cosine)) => {
                cursor.report(skewed(&corners, cosine));
            }
            // Reported where the coordinate stands.
            Err(RectangleError::TooFar) => {}
        }
        Ok(None)
    }
}

/// The error that the edges are not perpendicular, with a corner C that would mend it.
fn skewed(corners: &[Placed<DVec3>; 3], cosine: f64) -> Diagnostic {
    let [a, b, c] = corners.map(|corner| corner.value);
    let angle = cosine.clamp(-1.0, 1.0).acos().to_degrees();
    let edge = a - b;
    let square = c - edge * ((c - b).dot(edge) / edge.length_squared());
    let off = (angle - 90.0).abs();
    let message = format!("the edges of the rectangle are not perpendicular: they are {off:.3}° off");
    let mark = format!("at B they meet at {angle:.3}°, cosine {cosine:.4}; up to 0.001 is taken");
    // Corners on one line leave nothing to build the right corner from.
    let mend = (square - b).length() > 1e-3 * (c - b).length();
    let mend = mend.then(|| format!("with this A and B, C could be {}", Vector(square)));
    Diagnostic::error(message).at(corners[0].span.to(corners[2].span), mark).help_if(mend)
}

impl Display for Rectangle {
    fn fmt(&self, f: &mut Formatter<'_>) -> FmtResult {
        let [a, b, c] = self.corners.map(Vector);
        write!(f, "rectangle, {a}, {b}, {c}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_front_of_a_rectangle_sees_its_corners_clockwise() {
        // From +z, (0,0) (0,1) (1,1) turn clockwise.
        let square = Rectangle::new(DVec3::ZERO, DVec3::Y, DVec3::new(1.0, 1.0, 0.0)).unwrap();
        assert_eq!(square.normal(), DVec3::Z);
        let [a, b, c] = square.corners();
        assert_eq!(square.normal(), (c - a).cross(b - a).normalize());
    }

    #[test]
    fn bad_rectangles_are_refused() {
        let corner = |x, y| DVec3::new(x, y, 0.0);
        let skewed = Rectangle::new(corner(0.0, 0.0), corner(0.0, 1.0), corner(1.0, 1.1));
        assert!(matches!(skewed, Err(RectangleError::Skewed(cosine)) if (cosine + 0.0995).abs() < 1e-4), "{skewed:?}");
        assert!(Rectangle::new(corner(0.0, 0.0), corner(0.0, 1.0), corner(1.0, 1.0009)).is_ok());
        assert_eq!(Rectangle::new(DVec3::X, DVec3::X, DVec3::Y), Err(RectangleError::NoEdge(0, 1)));
        assert_eq!(Rectangle::new(DVec3::X, DVec3::Y, DVec3::Y), Err(RectangleError::NoEdge(1, 2)));
        assert_eq!(Rectangle::new(DVec3::X, DVec3::Y, DVec3::Y * 1e300), Err(RectangleError::TooFar));
        assert!(Rectangle::new(DVec3::X * 1e30, DVec3::ZERO, DVec3::Y * 1e-30).is_ok());
    }
}
