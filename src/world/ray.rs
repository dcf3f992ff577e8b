//! Rays, and the sides of surfaces that they leave.

use crate::scene::BodyId;
use glam::DVec3;

/// A part of the surface of one body, counted from 0. A box has six, a cylinder three, a cone two, other bodies one.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct PrimitiveId(pub u32);

impl PrimitiveId {
    /// The only part of a surface that has no others.
    pub const ONLY: PrimitiveId = PrimitiveId(0);
}

/// A half-line, with the surface that it leaves.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ray {
    /// Where it starts, in world coordinates.
    pub origin: DVec3,
    /// Its direction, of unit length.
    pub direction: DVec3,
    /// The surface on which it starts; `None` for a ray of the camera.
    pub leaves: Option<Departure>,
}

/// Where a ray starts on a surface.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Departure {
    /// The body.
    pub body: BodyId,
    /// The part of its surface.
    pub primitive: PrimitiveId,
    /// The side of the surface to which the ray leaves.
    pub side: Side,
}

/// A side of a surface.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Side {
    /// The side to which the front normal points: the outside of a closed body.
    Front,
    /// The other side: the inside of a closed body.
    Back,
}

impl Ray {
    /// The point at `distance` (in world units) from the origin.
    pub fn at(&self, distance: f64) -> DVec3 {
        self.origin + distance * self.direction
    }
}

impl Side {
    /// The other side.
    #[must_use]
    pub fn opposite(self) -> Side {
        match self {
            Side::Front => Side::Back,
            Side::Back => Side::Front,
        }
    }
}
