//! Boxes along the axes of the world: `box, A, B`.

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

/// A box along the axes of the world; its front is the outside.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AxisBox {
    corners: [DVec3; 2],
}

/// Why there is no such box.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum AxisBoxError {
    /// A coordinate is beyond [`MAX_COORDINATE`](crate::scene::MAX_COORDINATE), or not a number.
    #[error("a coordinate is too large")]
    TooFar,
    /// Both corners have the same coordinate on this axis, counted from 0.
    #[error("the corners of a box have the same {}", AXES[*.0 % 3])]
    Flat(usize),
}

const AXES: [&str; 3] = ["x", "y", "z"];

impl AxisBox {
    /// The box between two opposite corners.
    ///
    /// # Errors
    /// Corners too far away; corners with a common coordinate.
    pub fn new(one: DVec3, other: DVec3) -> Result<Self, AxisBoxError> {
        if !(is_within_reach(one) && is_within_reach(other)) {
            return Err(AxisBoxError::TooFar);
        }
        match (0..3).find(|axis| (one[*axis] - other[*axis]).abs() < MIN_LENGTH) {
            Some(axis) => Err(AxisBoxError::Flat(axis)),
            None => Ok(Self { corners: [one, other] }),
        }
    }

    /// Two opposite corners in world coordinates, as given.
    pub fn corners(&self) -> [DVec3; 2] {
        self.corners
    }

    fn middle(&self) -> DVec3 {
        self.corners[0].midpoint(self.corners[1])
    }
}

impl Movable for AxisBox {
    /// Its middle.
    fn anchor(&self) -> Option<DVec3> {
        Some(self.middle())
    }

    fn moved(&self, by: DVec3) -> Option<Self> {
        let [one, other] = self.corners.map(|corner| corner + by);
        Self::new(one, other).ok()
    }

    fn scaled(&self, by: f64) -> Option<Self> {
        let middle = self.middle();
        let [one, other] = self.corners.map(|corner| middle + by * (corner - middle));
        Self::new(one, other).ok()
    }

    fn stretched(&self, by: DVec3) -> Option<Self> {
        let middle = self.middle();
        let [one, other] = self.corners.map(|corner| middle + by * (corner - middle));
        Self::new(one, other).ok()
    }
}

impl TextForm for AxisBox {
    const KEYWORD: Keyword =
        Keyword { word: "box", doc: "`box, A, B`: two opposite corners; the edges are parallel to the axes" };
    const CLAUSES: &'static [Keyword] = &[];
    const EXAMPLE: &'static str = "box, <-1, 0, -1>, <1, 2, 1>";

    fn parse(cursor: &mut Cursor) -> Result<Option<Self>, Reported> {
        cursor.expect(Mark::Comma, "before a corner of the box")?;
        let one = vector(cursor, "a corner of the box")?;
        cursor.expect(Mark::Comma, "before the opposite corner of the box")?;
        let other = vector(cursor, "the opposite corner of the box")?;
        match Self::new(one.value, other.value) {
            Ok(axis_box) => return Ok(Some(axis_box)),
            Err(AxisBoxError::Flat(axis)) => {
                let axis = AXES.get(axis).copied().unwrap_or_default();
                let diagnostic = Diagnostic::error(format!("the box is flat: both corners have the same {axis}"))
                    .at(other.span, format!("the same {axis} as the other corner"))
                    .at(one.span, "the other corner");
                cursor
                    .report(diagnostic.help("give opposite corners, which differ in x, y and z; a flat piece is a `rectangle`"));
            }
            // Reported where the coordinate stands.
            Err(AxisBoxError::TooFar) => {}
        }
        Ok(None)
    }
}

impl Display for AxisBox {
    fn fmt(&self, f: &mut Formatter<'_>) -> FmtResult {
        let [one, other] = self.corners.map(Vector);
        write!(f, "box, {one}, {other}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bad_boxes_are_refused() {
        assert_eq!(AxisBox::new(DVec3::ZERO, DVec3::new(1.0, 0.0, 1.0)), Err(AxisBoxError::Flat(1)));
        assert_eq!(AxisBoxError::Flat(1).to_string(), "the corners of a box have the same y");
        assert_eq!(AxisBox::new(DVec3::ZERO, DVec3::ONE * 1e31), Err(AxisBoxError::TooFar));
        assert_eq!(AxisBox::new(DVec3::NAN, DVec3::ONE), Err(AxisBoxError::TooFar));
        assert!(AxisBox::new(DVec3::ONE * 1e30, DVec3::ONE * -1e30).is_ok());
        assert!(AxisBox::new(DVec3::ONE * 1e-30, DVec3::ZERO).is_ok());
    }
}
