//! Rectangle lights: `rectangle, A, B, C`.

use crate::lang::cursor::{Cursor, Reported};
use crate::lang::keywords::Keyword;
use crate::scene::movable::Movable;
use crate::scene::shape::Rectangle;
use crate::scene::syntax::TextForm;
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
