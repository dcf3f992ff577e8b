//! Cones.

use super::axis_frame::AxisFrame;
use super::chord::{Chord, Passage, ahead, slab, way_out};
use super::{FrontPoint, Geometry, Tolerance};
use crate::scene::shape;
use crate::world::bounds::Bounds;
use crate::world::hit::{Meeting, SurfaceHit};
use crate::world::ray::{Departure, PrimitiveId, Ray, Side};
use glam::{DAffine3, DVec2, DVec3};

const WALL: PrimitiveId = PrimitiveId(0);
const BASE: PrimitiveId = PrimitiveId(1);

/// A closed cone; its front is the outside. Its parts are its wall and its base.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct ConeSurface {
    base: DVec3,
    /// About the direction from the base to the apex.
    frame: AxisFrame,
    height: f64,
    radius: f64,
    /// The normal of the wall: its component away from the axis, and that along the axis.
    normal: DVec2,
}

impl ConeSurface {
    /// The surface of a cone.
    pub(super) fn new(shape: &shape::Cone) -> Self {
        let (axis, radius) = (shape.apex() - shape.base(), shape.radius());
        let height = axis.length();
        let normal = DVec2::new(height, radius).normalize();
        Self { base: shape.base(), frame: AxisFrame::about(axis.normalize()), height, radius, normal }
    }

    /// The components of a point.
    fn place(&self, point: DVec3) -> DVec3 {
        self.frame.components(point - self.base)
    }

    /// The product whose square is 0 on the wall, negative inside, of vectors by components from the apex.
    fn product(&self, one: DVec3, other: DVec3) -> f64 {
        let [away, along] = (self.normal * self.normal).to_array();
        away * one.truncate().dot(other.truncate()) - along * one.z * other.z
    }

    /// The distances between which a line is within the wall, which goes on without end below the base. From
    /// components of its origin and its direction.
    fn within_wall(&self, origin: DVec3, direction: DVec3) -> Option<[f64; 2]> {
        let origin = origin - self.height * DVec3::Z;
        let curve = self.product(direction, direction);
        let slope = self.product(origin, direction);
        let value = self.product(origin, origin);
        let square = slope * slope - curve * value;
        // A line that is steeper than the wall always passes it, even where rounding hides that, at the apex.
        if square < 0.0 && curve > 0.0 {
            return None;
        }
        // The root of larger magnitude; the other follows from the product of both.
        let sum = -(slope + square.max(0.0).sqrt().copysign(slope));
        let (far, near) = (sum / curve, if sum == 0.0 { 0.0 } else { value / sum });
        if curve > 0.0 {
            // Both are on the same side of the apex.
            let below = origin.z - slope / curve * direction.z < 0.0;
            return below.then(|| [near.min(far), near.max(far)]);
        }
        // One is on the mirror image of the wall beyond the apex. Parallel to the wall, there is only one.
        let roots = if curve < 0.0 { [near, far] } else { [near, near] };
        Some(match direction.z < 0.0 {
            true => [roots[0].max(roots[1]), f64::INFINITY],
            false => [f64::NEG_INFINITY, roots[0].min(roots[1])],
        })
    }

    /// The height of the base as seen from a point with these components. Above, the wall closes the cone.
    fn planes(from: DVec3) -> [f64; 2] {
        [-from.z, f64::INFINITY]
    }
}

impl Geometry for ConeSurface {
    fn bounds(&self, map: &DAffine3) -> Bounds {
        let apex = map.transform_point3(self.base + self.height * self.frame.axis());
        self.frame.circle_bounds(self.base, self.radius, map).union(Bounds { low: apex, high: apex })
    }

    fn intersect(&self, ray: &Ray, tolerance: &Tolerance) -> Option<Meeting> {
        let (origin, direction) = (self.place(ray.origin), self.frame.components(ray.direction));
        // As for cylinders: from the point of the ray nearest to the middle.
        let step = (0.5 * self.height * DVec3::Z - origin).dot(direction);
        let wall = self.within_wall(origin + step * direction, direction)?.map(|root| {
            let distance = root + step;
            Passage { distance, part: WALL, at_origin: distance.abs() <= tolerance.along }
        });
        let base = slab(Self::planes(origin), direction.z, [BASE; 2], tolerance.across(self.frame.axis()))?;
        Chord::LINE.between(wall).between(base).first()
    }

    /// A ray that leaves the cone outwards never comes back; one that leaves it inwards crosses it along a chord.
    fn intersect_again(&self, ray: &Ray, from: Departure, _: &Tolerance) -> Option<Meeting> {
        if from.side == Side::Front {
            return None;
        }
        let (origin, direction) = (self.place(ray.origin), self.frame.components(ray.direction));
        let wall = if from.primitive == WALL {
            let curve = self.product(direction, direction);
            match curve > 0.0 {
                // The root that is not at the origin.
                true => -2.0 * self.product(origin - self.height * DVec3::Z, direction) / curve,
                // Down inside the wall, which it does not meet again; or out by rounding.
                false if direction.z < 0.0 => f64::INFINITY,
                false => 0.0,
            }
        } else {
            // Beside the wall by rounding: it leaves at once.
            self.within_wall(origin, direction).map_or(0.0, |[_, leave]| leave)
        };
        way_out([(wall, WALL), ahead(Self::planes(origin), direction.z, [BASE; 2], from.primitive)])
    }

    fn project(&self, point: DVec3, part: PrimitiveId, _: DVec3) -> FrontPoint {
        let (place, axis) = (self.place(point), self.frame.axis());
        let (point, normal) = if part == BASE {
            (point - place.z * axis, -axis)
        } else if let Some(outward) = place.with_z(0.0).try_normalize() {
            let normal = self.normal.x * outward + self.normal.y * DVec3::Z;
            // The wall is the plane through the apex with this normal, along the line nearest to the point.
            let off = (place - self.height * DVec3::Z).dot(normal);
            (self.base + self.frame.vector(place - off * normal), self.frame.vector(normal))
        } else {
            (self.base + self.height * axis, axis)
        };
        FrontPoint { point, geometric_normal: normal, shading_normal: normal }
    }

    fn tangent(&self, hit: &SurfaceHit) -> DVec3 {
        self.frame.along_parallel(self.place(hit.point))
    }

    fn coordinates(&self, hit: &SurfaceHit) -> [f64; 2] {
        let place = self.place(hit.point);
        match hit.primitive == WALL {
            true => AxisFrame::wall_coordinates(place, self.height),
            false => AxisFrame::disc_coordinates(place, self.radius),
        }
    }
}
