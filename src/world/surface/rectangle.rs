//! Rectangles.

use super::{FrontPoint, Geometry, Tolerance};
use crate::scene::shape;
use crate::world::bounds::Bounds;
use crate::world::hit::{Meeting, SurfaceHit};
use crate::world::ray::{Departure, PrimitiveId, Ray};
use glam::{DAffine3, DVec3};

/// A rectangle A, B, C and A + C − B; its front is the side from which the corners are clockwise.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct RectangleSurface {
    /// The corner B.
    corner: DVec3,
    /// The front normal, of unit length.
    normal: DVec3,
    /// The dot products of these with a point, seen from B, are its coordinates along BA and along BC, 0..1 inside.
    along: [DVec3; 2],
    /// The direction from A to B.
    tangent: DVec3,
    /// Apart from what rays need, so that a surface is small.
    corners: Box<[DVec3; 4]>,
}

impl RectangleSurface {
    /// The surface of a rectangle.
    pub(super) fn new(shape: &shape::Rectangle) -> Self {
        let ([a, b, c], normal) = (shape.corners(), shape.normal());
        let (first, second) = (a - b, c - b);
        let (across_second, across_first) = (second.cross(normal), first.cross(normal));
        let along = [across_second / across_second.dot(first), across_first / across_first.dot(second)];
        Self { corner: b, normal, along, tangent: (b - a).normalize(), corners: Box::new([a, b, c, a + (c - b)]) }
    }
}

impl Geometry for RectangleSurface {
    fn bounds(&self, map: &DAffine3) -> Bounds {
        Bounds::of_points(self.corners.iter().map(|corner| map.transform_point3(*corner)))
    }

    #[inline(always)]
    fn intersect(&self, ray: &Ray, tolerance: &Tolerance) -> Option<Meeting> {
        let height = (self.corner - ray.origin).dot(self.normal);
        // Measured across the plane, not along the ray: a ray that starts in a second, coincident rectangle is not let
        // in however flat it goes.
        if height.abs() <= tolerance.across(self.normal) {
            return None;
        }
        let distance = height / ray.direction.dot(self.normal);
        let from_corner = ray.at(distance) - self.corner;
        // A parallel ray has infinities and NaN here, which are in no range.
        let inside = self.along.iter().all(|along| (0.0..=1.0).contains(&along.dot(from_corner)));
        (distance > 0.0 && inside).then_some(Meeting { primitive: PrimitiveId::ONLY, distance })
    }

    /// A ray that leaves a plane never comes back.
    #[inline(always)]
    fn intersect_again(&self, _: &Ray, _: Departure, _: &Tolerance) -> Option<Meeting> {
        None
    }

    #[inline(always)]
    fn project(&self, point: DVec3, _: PrimitiveId, _: DVec3) -> FrontPoint {
        let point = point + (self.corner - point).dot(self.normal) * self.normal;
        FrontPoint { point, geometric_normal: self.normal, shading_normal: self.normal }
    }

    fn tangent(&self, _: &SurfaceHit) -> DVec3 {
        self.tangent
    }

    fn coordinates(&self, hit: &SurfaceHit) -> [f64; 2] {
        let [from_b_to_a, from_b_to_c] = self.along.map(|along| along.dot(hit.point - self.corner).clamp(0.0, 1.0));
        [1.0 - from_b_to_a, from_b_to_c]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::BodyId;
    use crate::world::ray::Side;

    fn rectangle(a: [f64; 3], b: [f64; 3], c: [f64; 3]) -> RectangleSurface {
        RectangleSurface::new(&shape::Rectangle::new(a.into(), b.into(), c.into()).unwrap())
    }

    fn square() -> RectangleSurface {
        rectangle([0.0; 3], [0.0, 1.0, 0.0], [1.0, 1.0, 0.0])
    }

    fn ray(origin: [f64; 3], direction: [f64; 3]) -> Ray {
        Ray { origin: origin.into(), direction: DVec3::from(direction).normalize(), leaves: None }
    }

    fn hit(point: DVec3, normal: DVec3) -> SurfaceHit {
        SurfaceHit {
            body: BodyId(0),
            primitive: PrimitiveId::ONLY,
            side: Side::Front,
            point,
            geometric_normal: normal,
            shading_normal: normal,
            view: normal,
            distance: 1.0,
        }
    }

    #[test]
    fn rectangles_are_met_within_their_edges_only() {
        let distance = |ray: &Ray| square().intersect(ray, &Tolerance::plain(1e-9)).map(|met| met.distance);
        let down = |x, y| distance(&ray([x, y, 2.0], [0.0, 0.0, -1.0]));
        assert_eq!(down(0.5, 0.5), Some(2.0));
        assert_eq!(down(1.0, 0.0), Some(2.0));
        assert_eq!(down(1.001, 0.5), None);
        assert_eq!(down(0.5, -0.001), None);
        assert_eq!(distance(&ray([0.5, 0.5, 2.0], [1.0, 0.0, 0.0])), None);
        assert_eq!(distance(&ray([-1.0, 0.5, 1e-10], [1.0, 0.0, -1e-10])), None);
    }

    #[test]
    fn the_tangent_leads_from_a_to_b() {
        assert_eq!(square().tangent(&hit(DVec3::ZERO, DVec3::Z)), DVec3::Y);
    }

    #[test]
    fn coordinates_are_shares_of_the_edges() {
        // A slanted rectangle of 5 by 2.
        let [a, b, c] = [[1.0, 2.0, 3.0], [4.0, 2.0, 7.0], [4.0, 4.0, 7.0]];
        let rectangle = rectangle(a, b, c);
        let [a, b, c] = [a, b, c].map(DVec3::from);
        for [u, v] in [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0], [0.25, 0.75], [0.9, 0.1]] {
            let point = a + u * (b - a) + v * (c - b);
            let [found_u, found_v] = rectangle.coordinates(&hit(point, rectangle.normal));
            assert!((found_u - u).abs() < 1e-15 && (found_v - v).abs() < 1e-15, "{u}, {v}: {found_u}, {found_v}");
        }
    }
}
