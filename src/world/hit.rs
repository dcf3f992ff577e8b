//! Where a ray meets a surface: first the body and the distance, then everything that tracing and formulas need.

use crate::scene::BodyId;
use crate::world::ray::{Departure, PrimitiveId, Ray, Side};
use glam::DVec3;

/// Where a ray meets the surface of one body.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Meeting {
    /// The part of the surface.
    pub(super) primitive: PrimitiveId,
    /// The distance from the origin of the ray in world units, greater than 0.
    pub(super) distance: f64,
}

/// That a ray meets a body, and where.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Intersection {
    /// The body.
    pub body: BodyId,
    /// The part of its surface.
    pub primitive: PrimitiveId,
    /// The distance from the origin of the ray in world units, greater than 0.
    pub distance: f64,
}

impl Intersection {
    pub(super) fn new(body: BodyId, met: Meeting) -> Self {
        Self { body, primitive: met.primitive, distance: met.distance }
    }
}

/// The surface where a ray met it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SurfaceHit {
    /// The body.
    pub body: BodyId,
    /// The part of its surface.
    pub primitive: PrimitiveId,
    /// The side of the surface that was met.
    pub side: Side,
    /// The point, in world coordinates.
    pub point: DVec3,
    /// The normal of the surface itself, of unit length, turned to the side from which the ray came:
    /// `geometric_normal` · `view` ≥ 0.
    pub geometric_normal: DVec3,
    /// The normal to shade with, of unit length, turned to the same side. It differs from the geometric one where a
    /// smooth surface is approximated by flat parts.
    pub shading_normal: DVec3,
    /// The direction to where the ray came from, of unit length.
    pub view: DVec3,
    /// The distance that the ray travelled, in world units.
    pub distance: f64,
}

impl SurfaceHit {
    /// The geometric normal on the front of the surface: outwards on closed bodies.
    pub fn front_normal(&self) -> DVec3 {
        match self.side {
            Side::Front => self.geometric_normal,
            Side::Back => -self.geometric_normal,
        }
    }

    /// Whether light from this direction falls on the side from which the ray came, by both normals.
    #[inline]
    pub fn faces(&self, direction: DVec3) -> bool {
        (self.geometric_normal.dot(direction) > 0.0) & (self.shading_normal.dot(direction) > 0.0)
    }

    /// The side of the surface to which this direction goes.
    pub fn side_towards(&self, direction: DVec3) -> Side {
        if self.geometric_normal.dot(direction) > 0.0 { self.side } else { self.side.opposite() }
    }

    /// The ray that leaves the surface here in this direction (of unit length) to this side.
    #[inline]
    pub fn ray(&self, direction: DVec3, side: Side) -> Ray {
        let leaves = Departure { body: self.body, primitive: self.primitive, side };
        Ray { origin: self.point, direction, leaves: Some(leaves) }
    }
}
