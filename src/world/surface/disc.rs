//! Discs.

use super::axis_frame::AxisFrame;
use super::{FrontPoint, Geometry, Tolerance};
use crate::scene::shape;
use crate::world::bounds::Bounds;
use crate::world::hit::{Meeting, SurfaceHit};
use crate::world::ray::{Departure, PrimitiveId, Ray};
use glam::{DAffine3, DVec3};

/// A disc; its front is where its normal points.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct DiscSurface {
    center: DVec3,
    radius: f64,
    /// About the normal.
    frame: AxisFrame,
}

impl DiscSurface {
    /// The surface of a disc.
    pub(super) fn new(shape: &shape::Disc) -> Self {
        Self { center: shape.center(), radius: shape.radius(), frame: AxisFrame::about(shape.normal().normalize()) }
    }
}

impl Geometry for DiscSurface {
    fn bounds(&self, map: &DAffine3) -> Bounds {
        self.frame.circle_bounds(self.center, self.radius, map)
    }

    fn intersect(&self, ray: &Ray, tolerance: &Tolerance) -> Option<Meeting> {
        let normal = self.frame.axis();
        let height = (self.center - ray.origin).dot(normal);
        // As for rectangles: measured across the plane.
        if height.abs() <= tolerance.across(normal) {
            return None;
        }
        let distance = height / ray.direction.dot(normal);
        let inside = (ray.at(distance) - self.center).length() <= self.radius;
        (distance > 0.0 && inside).then_some(Meeting { primitive: PrimitiveId::ONLY, distance })
    }

    /// A ray that leaves a plane never comes back.
    #[inline(always)]
    fn intersect_again(&self, _: &Ray, _: Departure, _: &Tolerance) -> Option<Meeting> {
        None
    }

    fn project(&self, point: DVec3, _: PrimitiveId, _: DVec3) -> FrontPoint {
        let normal = self.frame.axis();
        let point = point + (self.center - point).dot(normal) * normal;
        FrontPoint { point, geometric_normal: normal, shading_normal: normal }
    }

    fn tangent(&self, hit: &SurfaceHit) -> DVec3 {
        self.frame.along_parallel(self.frame.components(hit.point - self.center))
    }

    fn coordinates(&self, hit: &SurfaceHit) -> [f64; 2] {
        AxisFrame::disc_coordinates(self.frame.components(hit.point - self.center), self.radius)
    }
}
