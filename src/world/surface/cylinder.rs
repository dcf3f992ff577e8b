//! Cylinders.

use super::axis_frame::AxisFrame;
use super::chord::{Chord, Passage, ahead, slab, way_out};
use super::{FrontPoint, Geometry, Tolerance};
use crate::scene::shape;
use crate::world::bounds::Bounds;
use crate::world::hit::{Meeting, SurfaceHit};
use crate::world::ray::{Departure, PrimitiveId, Ray, Side};
use glam::{DAffine3, DVec3};

const WALL: PrimitiveId = PrimitiveId(0);
const ENDS: [PrimitiveId; 2] = [PrimitiveId(1), PrimitiveId(2)];
/// Below this square of its sine, the angle between a ray and the axis counts as 0.
const PARALLEL: f64 = 1e-30;

/// A closed cylinder; its front is the outside. Its parts are its wall, its base and its top.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct CylinderSurface {
    base: DVec3,
    /// About the direction from base to top.
    frame: AxisFrame,
    height: f64,
    radius: f64,
}

impl CylinderSurface {
    /// The surface of a cylinder.
    pub(super) fn new(shape: &shape::Cylinder) -> Self {
        let [base, top] = shape.centers();
        let axis = top - base;
        Self { base, frame: AxisFrame::about(axis.normalize()), height: axis.length(), radius: shape.radius() }
    }

    /// The components of a point.
    fn place(&self, point: DVec3) -> DVec3 {
        self.frame.components(point - self.base)
    }

    /// The distances between which a line is within the wall, from components of its origin and its direction.
    fn within_wall(&self, origin: DVec3, direction: DVec3) -> Option<[f64; 2]> {
        let (origin, direction) = (origin.truncate(), direction.truncate());
        let (from_axis, slope) = (origin.length(), direction.length_squared());
        if slope < PARALLEL {
            return (from_axis <= self.radius).then_some([f64::NEG_INFINITY, f64::INFINITY]);
        }
        let middle = -origin.dot(direction) / slope;
        let square = self.radius * self.radius - (origin + middle * direction).length_squared();
        if square < 0.0 {
            return None;
        }
        // The root of larger magnitude; the other follows from the product of both, as on spheres.
        let larger = middle + (square / slope).sqrt().copysign(middle);
        if larger == 0.0 {
            return None;
        }
        let smaller = (from_axis - self.radius) * (from_axis + self.radius) / (slope * larger);
        Some([larger.min(smaller), larger.max(smaller)])
    }

    /// The heights of the ends as seen from a point with these components.
    fn planes(&self, from: DVec3) -> [f64; 2] {
        [-from.z, self.height - from.z]
    }
}

impl Geometry for CylinderSurface {
    fn bounds(&self, map: &DAffine3) -> Bounds {
        let top = self.base + self.height * self.frame.axis();
        let ends = [self.base, top].map(|center| self.frame.circle_bounds(center, self.radius, map));
        ends[0].union(ends[1])
    }

    fn intersect(&self, ray: &Ray, tolerance: &Tolerance) -> Option<Meeting> {
        let (origin, direction) = (self.place(ray.origin), self.frame.components(ray.direction));
        // The roots are taken from the point of the ray nearest to the middle, where coordinates are small: far bodies
        // keep their shape.
        let step = (0.5 * self.height * DVec3::Z - origin).dot(direction);
        let wall = self.within_wall(origin + step * direction, direction)?.map(|root| {
            let distance = root + step;
            Passage { distance, part: WALL, at_origin: distance.abs() <= tolerance.along }
        });
        let ends = slab(self.planes(origin), direction.z, ENDS, tolerance.across(self.frame.axis()))?;
        Chord::LINE.between(wall).between(ends).first()
    }

    /// A ray that leaves the cylinder outwards never comes back; one that leaves it inwards crosses it along a chord.
    fn intersect_again(&self, ray: &Ray, from: Departure, _: &Tolerance) -> Option<Meeting> {
        if from.side == Side::Front {
            return None;
        }
        let (origin, direction) = (self.place(ray.origin), self.frame.components(ray.direction));
        let slope = direction.truncate().length_squared();
        let wall = match from.primitive {
            WALL if slope < PARALLEL => f64::INFINITY,
            // The root that is not at the origin.
            WALL => -2.0 * origin.truncate().dot(direction.truncate()) / slope,
            // Beside the wall by rounding: it leaves at once.
            _ => self.within_wall(origin, direction).map_or(0.0, |[_, leave]| leave),
        };
        way_out([(wall, WALL), ahead(self.planes(origin), direction.z, ENDS, from.primitive)])
    }

    fn project(&self, point: DVec3, part: PrimitiveId, direction: DVec3) -> FrontPoint {
        let (place, axis) = (self.place(point), self.frame.axis());
        let (point, normal) = match part {
            WALL => {
                let outward = self.frame.components(-direction).with_z(0.0);
                let outward = place.with_z(0.0).try_normalize().or(outward.try_normalize()).unwrap_or(DVec3::X);
                (self.base + self.frame.vector(self.radius * outward + place.z * DVec3::Z), self.frame.vector(outward))
            }
            part if part == ENDS[0] => (point - place.z * axis, -axis),
            _ => (point + (self.height - place.z) * axis, axis),
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
