//! Rectangle lights: `rectangle, A, B, C`.

use crate::lang::cursor::{Cursor, Reported};
use crate::lang::keywords::Keyword;
use crate::scene::movable::Movable;
use crate::scene::shape::Rectangle;
use crate::scene::syntax::TextForm;
use crate::scene::transform::rotation;
use glam::DVec3;
use std::fmt::{Display, Formatter, Result as FmtResult};

/// A point light that is spread evenly over a rectangle. It shines to both sides.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RectangleLight {
    rectangle: Rectangle,
}

impl RectangleLight {
    /// A light that is spread over this rectangle.
    pub fn new(rectangle: Rectangle) -> Self {
        Self { rectangle }
    }

    /// The rectangle, in world coordinates.
    pub fn rectangle(&self) -> &Rectangle {
        &self.rectangle
    }

    /// The directions of its sides AB and BC, and of its normal, of unit length.
    pub(super) fn axes(&self) -> [DVec3; 3] {
        let [a, b, c] = self.rectangle.corners();
        [(b - a).normalize(), (c - b).normalize(), self.rectangle.normal()]
    }

    /// The same with other corners, each given by its vector from the middle; `None` if there is no such rectangle.
    fn with_corners(&self, moved: impl Fn(DVec3) -> DVec3) -> Option<Self> {
        let [a, b, c] = self.rectangle.corners();
        let middle = a.midpoint(c);
        let [a, b, c] = [a, b, c].map(|corner| middle + moved(corner - middle));
        Rectangle::new(a, b, c).ok().map(Self::new)
    }

    /// The same, turned about an axis through its middle.
    pub(super) fn turned(&self, axis: DVec3, degrees: f64) -> Option<Self> {
        let rotation = rotation(axis, degrees);
        self.with_corners(|corner| rotation * corner)
    }

    /// The same, larger by a factor along each of its [axes](Self::axes), about its middle.
    pub(super) fn stretched_along(&self, by: DVec3) -> Option<Self> {
        let axes = self.axes();
        self.with_corners(|corner| (0..3).map(|axis| by[axis] * corner.dot(axes[axis]) * axes[axis]).sum())
    }
}

impl Movable for RectangleLight {
    /// Its middle.
    fn anchor(&self) -> Option<DVec3> {
        self.rectangle.anchor()
    }

    fn moved(&self, by: DVec3) -> Option<Self> {
        self.rectangle.moved(by).map(Self::new)
    }

    fn scaled(&self, by: f64) -> Option<Self> {
        self.rectangle.scaled(by).map(Self::new)
    }

    fn flat_normal(&self) -> Option<DVec3> {
        self.rectangle.flat_normal()
    }
}

impl TextForm for RectangleLight {
    const KEYWORD: Keyword = Keyword {
        word: "rectangle",
        doc: "`rectangle, A, B, C`: a point light that is spread over the rectangle with these three corners",
    };
    const CLAUSES: &'static [Keyword] = Rectangle::CLAUSES;
    const EXAMPLE: &'static str = "rectangle, <-1, 4, -1>, <1, 4, -1>, <1, 4, 1>";

    fn parse(cursor: &mut Cursor) -> Result<Option<Self>, Reported> {
        Ok(Rectangle::parse(cursor)?.map(Self::new))
    }
}

impl Display for RectangleLight {
    fn fmt(&self, f: &mut Formatter<'_>) -> FmtResult {
        self.rectangle.fmt(f)
    }
}
