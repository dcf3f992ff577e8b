//! Boxes along the axes of the world.

use super::chord::{Chord, ahead, slab, way_out};
use super::{FrontPoint, Geometry, Tolerance};
use crate::scene::shape;
use crate::world::bounds::Bounds;
use crate::world::hit::{Meeting, SurfaceHit};
use crate::world::ray::{Departure, PrimitiveId, Ray, Side};
use glam::{DAffine3, DVec3};

/// A box; its front is the outside. Its parts are its faces: those towards −x, +x, −y, +y, −z, +z.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct AxisBoxSurface {
    bounds: Bounds,
}

/// The two faces that an axis passes, the lower one first.
const fn faces(axis: usize) -> [PrimitiveId; 2] {
    [PrimitiveId(2 * axis as u32), PrimitiveId(2 * axis as u32 + 1)]
}

/// The axis that passes a face, and whether the face is the upper one.
fn place_of(face: PrimitiveId) -> (usize, bool) {
    // Faces have numbers below 6.
    ((face.0 / 2 % 3) as usize, face.0 % 2 == 1)
}

impl AxisBoxSurface {
    /// The surface of a box.
    pub(super) fn new(shape: &shape::AxisBox) -> Self {
        let [one, other] = shape.corners();
        Self { bounds: Bounds { low: one.min(other), high: one.max(other) } }
    }

    /// The planes of the faces that an axis passes, as seen from a point.
    fn planes(&self, axis: usize, from: DVec3) -> [f64; 2] {
        [self.bounds.low[axis] - from[axis], self.bounds.high[axis] - from[axis]]
    }

    /// The outward normal of a face, the direction in which u grows on it, and that in which v grows.
    fn directions(face: PrimitiveId) -> [DVec3; 3] {
        let (axis, upper) = place_of(face);
        let normal = if upper { DVec3::AXES[axis] } else { -DVec3::AXES[axis] };
        let right = if axis == 1 { DVec3::X } else { DVec3::Y.cross(normal) };
        [normal, right, normal.cross(right)]
    }
}

impl Geometry for AxisBoxSurface {
    fn bounds(&self, map: &DAffine3) -> Bounds {
        let Bounds { low, high } = self.bounds;
        let corners = (0..8_u32).map(|corner| {
            let upper = [0, 1, 2].map(|axis| corner >> axis & 1 == 1);
            DVec3::select(upper.into(), high, low)
        });
        Bounds::of_points(corners.map(|corner| map.transform_point3(corner)))
    }

    fn intersect(&self, ray: &Ray, tolerance: &Tolerance) -> Option<Meeting> {
        let mut chord = Chord::LINE;
        for axis in 0..3 {
            let planes = self.planes(axis, ray.origin);
            chord = chord.between(slab(planes, ray.direction[axis], faces(axis), tolerance.across(DVec3::AXES[axis]))?);
        }
        chord.first()
    }

    /// A ray that leaves the box outwards never comes back; one that leaves a face inwards goes to another face.
    fn intersect_again(&self, ray: &Ray, from: Departure, _: &Tolerance) -> Option<Meeting> {
        let face = |axis| ahead(self.planes(axis, ray.origin), ray.direction[axis], faces(axis), from.primitive);
        match from.side {
            Side::Front => None,
            Side::Back => way_out([0, 1, 2].map(face)),
        }
    }

    fn project(&self, point: DVec3, face: PrimitiveId, _: DVec3) -> FrontPoint {
        let ((axis, upper), [normal, ..]) = (place_of(face), Self::directions(face));
        let mut point = point;
        point[axis] = if upper { self.bounds.high[axis] } else { self.bounds.low[axis] };
        FrontPoint { point, geometric_normal: normal, shading_normal: normal }
    }

    fn tangent(&self, hit: &SurfaceHit) -> DVec3 {
        let [_, right, _] = Self::directions(hit.primitive);
        right
    }

    fn coordinates(&self, hit: &SurfaceHit) -> [f64; 2] {
        let [_, right, up] = Self::directions(hit.primitive);
        let (middle, size) = (self.bounds.low.midpoint(self.bounds.high), self.bounds.high - self.bounds.low);
        [right, up].map(|along| (0.5 + along.dot(hit.point - middle) / along.abs().dot(size)).clamp(0.0, 1.0))
    }
}
