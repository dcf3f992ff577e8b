//! Triangles: `triangle, A, B, C`.

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

/// The smallest height of a triangle above its longest edge, as a part of that edge.
const MIN_HEIGHT: f64 = 1e-9;

/// A triangle; its front is the side from which the corners are clockwise.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Triangle {
    corners: [DVec3; 3],
    normal: DVec3,
}

/// Why there is no such triangle.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum TriangleError {
    /// A coordinate is beyond [`MAX_COORDINATE`](crate::scene::MAX_COORDINATE), or not a number.
    #[error("a coordinate is too large")]
    TooFar,
    /// Two corners, counted from 0, are the same.
    #[error("two corners of a triangle are the same")]
    NoEdge(usize, usize),
    /// The corners lie on one line, or nearly so.
    #[error("the corners of a triangle lie on one line")]
    Flat,
}

impl Triangle {
    /// The triangle with the corners `a`, `b`, `c`, clockwise in this order as seen from its front.
    ///
    /// # Errors
    /// Corners too far away; corners that coincide; corners on one line, to 1e-9 of the longest edge.
    pub fn new(a: DVec3, b: DVec3, c: DVec3) -> Result<Self, TriangleError> {
        let corners = [a, b, c];
        if !corners.into_iter().all(is_within_reach) {
            return Err(TriangleError::TooFar);
        }
        for (first, second) in [(0, 1), (1, 2), (0, 2)] {
            if corners[first].distance(corners[second]) < MIN_LENGTH {
                return Err(TriangleError::NoEdge(first, second));
            }
        }
        let edges = [b - a, c - b, a - c];
        let lengths = edges.map(DVec3::length);
        let longest = (0..3).max_by(|one, other| lengths[*one].total_cmp(&lengths[*other])).unwrap_or_default();
        // The two shorter edges keep most digits. Two edges that follow one another have the same product everywhere.
        let [one, other] = [edges[(longest + 1) % 3], edges[(longest + 2) % 3]];
        let across = other.normalize().cross(one.normalize());
        let height = across.length() * one.length() / lengths[longest] * other.length();
        if height < MIN_HEIGHT * lengths[longest] {
            return Err(TriangleError::Flat);
        }
        Ok(Self { corners, normal: across.normalize() })
    }

    /// The corners A, B, C in world coordinates.
    pub fn corners(&self) -> [DVec3; 3] {
        self.corners
    }

    /// The front normal, normalize((C−A)×(B−A)), of unit length.
    pub fn normal(&self) -> DVec3 {
        self.normal
    }

    fn middle(&self) -> DVec3 {
        let [a, b, c] = self.corners;
        (a + b + c) / 3.0
    }
}

impl Movable for Triangle {
    /// Its centre of gravity.
    fn anchor(&self) -> Option<DVec3> {
        Some(self.middle())
    }

    fn moved(&self, by: DVec3) -> Option<Self> {
        let [a, b, c] = self.corners.map(|corner| corner + by);
        Self::new(a, b, c).ok()
    }

    fn scaled(&self, by: f64) -> Option<Self> {
        let middle = self.middle();
        let [a, b, c] = self.corners.map(|corner| middle + by * (corner - middle));
        Self::new(a, b, c).ok()
    }

    fn stretched(&self, by: DVec3) -> Option<Self> {
        let middle = self.middle();
        let [a, b, c] = self.corners.map(|corner| middle + by * (corner - middle));
        Self::new(a, b, c).ok()
    }

    fn flat_normal(&self) -> Option<DVec3> {
        Some(self.normal)
    }
}

impl TextForm for Triangle {
    const KEYWORD: Keyword =
        Keyword { word: "triangle", doc: "`triangle, A, B, C`: three corners, clockwise as seen from the front" };
    const CLAUSES: &'static [Keyword] = &[];
    const EXAMPLE: &'static str = "triangle, <-1, 0, 0>, <0, 3, 0>, <1, 0, 0>";

    fn parse(cursor: &mut Cursor) -> Result<Option<Self>, Reported> {
        let mut corners = [Placed { value: DVec3::ZERO, span: cursor.span() }; 3];
        for (corner, letter) in corners.iter_mut().zip(["A", "B", "C"]) {
            cursor.expect(Mark::Comma, &format!("before corner {letter} of the triangle"))?;
            *corner = vector(cursor, &format!("corner {letter}"))?;
        }
        let [a, b, c] = corners.map(|corner| corner.value);
        let form = "give three corners that are not on one line, clockwise as seen from the front";
        match Self::new(a, b, c) {
            Ok(triangle) => return Ok(Some(triangle)),
            Err(TriangleError::NoEdge(first, second)) => {
                let diagnostic = Diagnostic::error("two corners of the triangle are the same")
                    .at(corners[second].span, "the same as the other corner")
                    .at(corners[first].span, "the other corner");
                cursor.report(diagnostic.help(form));
            }
            Err(TriangleError::Flat) => {
                let diagnostic = Diagnostic::error("the corners of the triangle lie on one line");
                let all = corners[0].span.to(corners[2].span);
                cursor.report(diagnostic.at(all, "nothing is between them").help(form));
            }
            // Reported where the coordinate stands.
            Err(TriangleError::TooFar) => {}
        }
        Ok(None)
    }
}

impl Display for Triangle {
    fn fmt(&self, f: &mut Formatter<'_>) -> FmtResult {
        let [a, b, c] = self.corners.map(Vector);
        write!(f, "triangle, {a}, {b}, {c}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_front_of_a_triangle_sees_its_corners_clockwise() {
        // From +z, (0,0) (0,1) (1,0) turn clockwise.
        let corners = [DVec3::ZERO, DVec3::Y, DVec3::X];
        for first in 0..3 {
            let [a, b, c] = [0, 1, 2].map(|corner| corners[(first + corner) % 3]);
            let normal = Triangle::new(a, b, c).unwrap().normal();
            assert!(normal.abs_diff_eq(DVec3::Z, 1e-15) && normal.abs_diff_eq((c - a).cross(b - a), 1e-15));
            assert!(Triangle::new(c, b, a).unwrap().normal().abs_diff_eq(-DVec3::Z, 1e-15));
        }
    }

    #[test]
    fn bad_triangles_are_refused() {
        assert_eq!(Triangle::new(DVec3::X, DVec3::X, DVec3::Y), Err(TriangleError::NoEdge(0, 1)));
        assert_eq!(Triangle::new(DVec3::X, DVec3::Y, DVec3::Y), Err(TriangleError::NoEdge(1, 2)));
        assert_eq!(Triangle::new(DVec3::X, DVec3::Y, DVec3::X), Err(TriangleError::NoEdge(0, 2)));
        assert_eq!(Triangle::new(DVec3::ZERO, DVec3::ONE, 3.0 * DVec3::ONE), Err(TriangleError::Flat));
        assert_eq!(Triangle::new(DVec3::ZERO, DVec3::X * 2.0, DVec3::new(1.0, 1e-9, 0.0)), Err(TriangleError::Flat));
        assert!(Triangle::new(DVec3::ZERO, DVec3::X * 2.0, DVec3::new(1.0, 1e-8, 0.0)).is_ok());
        assert_eq!(Triangle::new(DVec3::X, DVec3::Y, DVec3::Y * 1e300), Err(TriangleError::TooFar));
        assert!(Triangle::new(DVec3::ZERO, DVec3::Y * 1e-30, DVec3::X * 1e-30).is_ok());
        assert!(Triangle::new(DVec3::ZERO, DVec3::Y * 1e30, DVec3::X * 1e30).is_ok());
    }
}
