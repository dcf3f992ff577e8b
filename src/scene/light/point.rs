//! Point lights: `point, <x, y, z>`.

use crate::lang::cursor::{Cursor, Reported};
use crate::lang::keywords::Keyword;
use crate::lang::token::Mark;
use crate::scene::is_within_reach;
use crate::scene::movable::Movable;
use crate::scene::syntax::TextForm;
use crate::scene::values::{Vector, vector};
use glam::DVec3;
use std::fmt::{Display, Formatter, Result as FmtResult};

/// A point that shines in all directions.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PointLight {
    position: DVec3,
}

impl PointLight {
    /// A light at this position, in world coordinates.
    pub fn new(position: DVec3) -> Self {
        Self { position }
    }

    /// Its position in world coordinates.
    pub fn position(&self) -> DVec3 {
        self.position
    }
}

impl Movable for PointLight {
    fn anchor(&self) -> Option<DVec3> {
        Some(self.position)
    }

    fn moved(&self, by: DVec3) -> Option<Self> {
        Some(self.position + by).filter(|position| is_within_reach(*position)).map(Self::new)
    }
}

impl TextForm for PointLight {
    const KEYWORD: Keyword = Keyword { word: "point", doc: "`point, <x, y, z>`: a light in one point" };
    const CLAUSES: &'static [Keyword] = &[];
    const EXAMPLE: &'static str = "point, <3, 5, 4>";

    fn parse(cursor: &mut Cursor) -> Result<Option<Self>, Reported> {
        cursor.expect(Mark::Comma, "after `point`")?;
        let position = vector(cursor, "the position of the light")?;
        // A component out of range is reported where it stands.
        Ok(position.value.is_finite().then(|| Self::new(position.value)))
    }
}

impl Display for PointLight {
    fn fmt(&self, f: &mut Formatter<'_>) -> FmtResult {
        write!(f, "point, {}", Vector(self.position))
    }
}
