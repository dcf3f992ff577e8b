//! Triangles.

use super::{FrontPoint, Geometry, Tolerance};
use crate::scene::shape;
use crate::world::bounds::Bounds;
use crate::world::hit::{Meeting, SurfaceHit};
use crate::world::ray::{Departure, PrimitiveId, Ray};
use glam::{DAffine3, DVec3};

/// A triangle; its front is the side from which the corners are clockwise.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct TriangleSurface {
    corners: [DVec3; 3],
    /// The front normal, of unit length.
    normal: DVec3,
}

impl TriangleSurface {
    /// The surface of a triangle.
    pub(super) fn new(shape: &shape::Triangle) -> Self {
        Self { corners: shape.corners(), normal: shape.normal() }
    }

    /// Whether the line of the ray passes the triangle, with its edges.
    ///
    /// Woop, Benthin, Wald, "Watertight Ray/Triangle Intersection", JCGT 2013: seen along the ray, the sides on which
    /// the three edges have the origin. An edge that two triangles share has the same number in both but for its sign,
    /// so no ray passes between them.
    fn is_passed(&self, ray: &Ray) -> bool {
        let sizes = ray.direction.abs();
        let main = [0, 1, 2].into_iter().max_by(|one, other| sizes[*one].total_cmp(&sizes[*other])).unwrap_or_default();
        let [first, second] = [(main + 1) % 3, (main + 2) % 3];
        let shear = [first, second].map(|axis| ray.direction[axis] / ray.direction[main]);
        let [a, b, c] = self.corners.map(|corner| {
            let seen = corner - ray.origin;
            [seen[first] - shear[0] * seen[main], seen[second] - shear[1] * seen[main]]
        });
        let side = |from: [f64; 2], to: [f64; 2]| from[0] * to[1] - from[1] * to[0];
        let sides = [side(a, b), side(b, c), side(c, a)];
        sides.iter().all(|side| *side >= 0.0) || sides.iter().all(|side| *side <= 0.0)
    }
}

impl Geometry for TriangleSurface {
    fn bounds(&self, map: &DAffine3) -> Bounds {
        Bounds::of_points(self.corners.into_iter().map(|corner| map.transform_point3(corner)))
    }

    fn intersect(&self, ray: &Ray, tolerance: &Tolerance) -> Option<Meeting> {
        let height = (self.corners[1] - ray.origin).dot(self.normal);
        // As for rectangles: measured across the plane.
        if height.abs() <= tolerance.across(self.normal) {
            return None;
        }
        let distance = height / ray.direction.dot(self.normal);
        let met = distance > 0.0 && distance.is_finite() && self.is_passed(ray);
        met.then_some(Meeting { primitive: PrimitiveId::ONLY, distance })
    }

    /// A ray that leaves a plane never comes back.
    #[inline(always)]
    fn intersect_again(&self, _: &Ray, _: Departure, _: &Tolerance) -> Option<Meeting> {
        None
    }

    fn project(&self, point: DVec3, _: PrimitiveId, _: DVec3) -> FrontPoint {
        let point = point + (self.corners[1] - point).dot(self.normal) * self.normal;
        FrontPoint { point, geometric_normal: self.normal, shading_normal: self.normal }
    }

    fn tangent(&self, _: &SurfaceHit) -> DVec3 {
        (self.corners[1] - self.corners[0]).normalize()
    }

    /// A point of the triangle is A + u(B − A) + v(C − B), as on the rectangle of these corners.
    fn coordinates(&self, hit: &SurfaceHit) -> [f64; 2] {
        let [a, b, c] = self.corners;
        let place = hit.point - b;
        let share = |edge: DVec3, other: DVec3| {
            let across = other.cross(self.normal);
            (across.dot(place) / across.dot(edge)).clamp(0.0, 1.0)
        };
        [1.0 - share(a - b, c - b), share(c - b, a - b)]
    }
}
