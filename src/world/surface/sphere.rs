//! Spheres.

use super::axis_frame::turns;
use super::{FrontPoint, Geometry, Tolerance};
use crate::scene::shape;
use crate::world::bounds::Bounds;
use crate::world::hit::{Meeting, SurfaceHit};
use crate::world::ray::{Departure, PrimitiveId, Ray, Side};
use glam::{DAffine3, DVec3};
use std::f64::consts::PI;

/// Closer than this to a pole of a unit sphere, the direction along the parallel is noise.
const POLE: f64 = 1e-12;

/// A sphere; its front is the outside.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct SphereSurface {
    center: DVec3,
    radius: f64,
}

impl SphereSurface {
    /// The surface of a sphere.
    pub(super) fn new(shape: &shape::Sphere) -> Self {
        Self { center: shape.center(), radius: shape.radius() }
    }

    /// The direction along the parallel, eastwards, where the outward normal is this; `None` at the poles.
    fn east(normal: DVec3) -> Option<DVec3> {
        let east = DVec3::Y.cross(normal);
        (east.length() >= POLE).then(|| east.normalize())
    }
}

fn meeting(distance: f64) -> Meeting {
    Meeting { primitive: PrimitiveId::ONLY, distance }
}

impl Geometry for SphereSurface {
    fn bounds(&self, map: &DAffine3) -> Bounds {
        // The extent of an ellipsoid along an axis is that of the sphere times the length of the row of the matrix.
        let rows = map.matrix3.transpose();
        let reach = self.radius * DVec3::new(rows.x_axis.length(), rows.y_axis.length(), rows.z_axis.length());
        let center = map.transform_point3(self.center);
        Bounds { low: center - reach, high: center + reach }
    }

    /// The quadratic is solved as in Haines, Günther, Akenine-Möller, "Precision Improvements for Ray/Sphere
    /// Intersection", Ray Tracing Gems (2019): small far spheres keep their shape, and neither root cancels.
    #[inline(always)]
    fn intersect(&self, ray: &Ray, tolerance: &Tolerance) -> Option<Meeting> {
        let origin = ray.origin - self.center;
        let nearest = -origin.dot(ray.direction);
        let discriminant = self.radius * self.radius - (origin + nearest * ray.direction).length_squared();
        if discriminant < 0.0 {
            return None;
        }
        // The root of larger magnitude; the other follows from the product of both.
        let larger = nearest + discriminant.sqrt().copysign(nearest);
        if larger == 0.0 {
            return None;
        }
        let distance = origin.length();
        let smaller = (distance - self.radius) * (distance + self.radius) / larger;
        let (first, second) = (larger.min(smaller), larger.max(smaller));
        let distance = if first > tolerance.along { first } else { second };
        (distance > tolerance.along).then(|| meeting(distance))
    }

    /// A ray that leaves the sphere outwards never comes back; one that leaves it inwards crosses it along a chord.
    #[inline(always)]
    fn intersect_again(&self, ray: &Ray, from: Departure, _: &Tolerance) -> Option<Meeting> {
        match from.side {
            Side::Front => None,
            Side::Back => {
                let chord = -2.0 * (ray.origin - self.center).dot(ray.direction);
                (chord > 0.0).then(|| meeting(chord))
            }
        }
    }

    #[inline(always)]
    fn project(&self, point: DVec3, _: PrimitiveId, direction: DVec3) -> FrontPoint {
        let normal = (point - self.center).try_normalize().unwrap_or(-direction);
        FrontPoint { point: self.center + self.radius * normal, geometric_normal: normal, shading_normal: normal }
    }

    fn tangent(&self, hit: &SurfaceHit) -> DVec3 {
        Self::east(hit.front_normal()).unwrap_or(DVec3::X)
    }

    fn coordinates(&self, hit: &SurfaceHit) -> [f64; 2] {
        let normal = hit.front_normal();
        let from_south = normal.x.hypot(normal.z).atan2(-normal.y);
        let longitude = if Self::east(normal).is_some() { normal.x.atan2(normal.z) } else { 0.0 };
        [turns(longitude), from_south / PI]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::BodyId;
    use std::f64::consts::TAU;

    fn sphere(center: DVec3, radius: f64) -> SphereSurface {
        SphereSurface::new(&shape::Sphere::new(center, radius).unwrap())
    }

    fn ray(origin: [f64; 3], direction: [f64; 3]) -> Ray {
        Ray { origin: origin.into(), direction: DVec3::from(direction).normalize(), leaves: None }
    }

    fn distance(sphere: &SphereSurface, ray: &Ray) -> Option<f64> {
        sphere.intersect(ray, &Tolerance::plain(0.0)).map(|met| met.distance)
    }

    /// The hit on the outside of the unit sphere at this point of it.
    fn hit(normal: DVec3) -> SurfaceHit {
        SurfaceHit {
            body: BodyId(0),
            primitive: PrimitiveId::ONLY,
            side: Side::Front,
            point: normal,
            geometric_normal: normal,
            shading_normal: normal,
            view: normal,
            distance: 1.0,
        }
    }

    #[test]
    fn spheres_are_met_from_outside_and_inside() {
        let sphere = sphere(DVec3::new(0.0, 0.0, -5.0), 2.0);
        assert_eq!(distance(&sphere, &ray([0.0; 3], [0.0, 0.0, -1.0])), Some(3.0));
        assert_eq!(distance(&sphere, &ray([0.0, 0.0, -5.0], [0.0, 1.0, 0.0])), Some(2.0));
        assert_eq!(distance(&sphere, &ray([0.0; 3], [0.0, 0.0, 1.0])), None);
        assert_eq!(distance(&sphere, &ray([0.0, 2.1, 0.0], [0.0, 0.0, -1.0])), None);
    }

    #[test]
    fn small_far_spheres_keep_their_shape() {
        // 1e6 radii away, a naive quadratic has lost all digits of the discriminant.
        let sphere = sphere(DVec3::new(0.0, 0.0, -1e6), 1.0);
        for offset in [0.0, 0.25, 0.5, 0.75, 0.999] {
            let hit = distance(&sphere, &ray([offset, 0.0, 0.0], [0.0, 0.0, -1.0])).unwrap();
            assert!((hit - (1e6 - (1.0 - offset * offset).sqrt())).abs() < 1e-9, "{offset}: {hit}");
        }
        assert_eq!(distance(&sphere, &ray([1.001, 0.0, 0.0], [0.0, 0.0, -1.0])), None);
    }

    #[test]
    fn a_chord_is_found_without_the_root_at_the_origin() {
        let sphere = sphere(DVec3::ZERO, 1e-20);
        let inwards = ray([0.0, 0.0, 1e-20], [0.0, 0.6, -0.8]);
        let leaving = |side| Departure { body: BodyId(0), primitive: PrimitiveId::ONLY, side };
        let chord = sphere.intersect_again(&inwards, leaving(Side::Back), &Tolerance::plain(0.0)).unwrap().distance;
        assert!((chord / 1.6e-20 - 1.0).abs() < 1e-14);
        assert_eq!(sphere.intersect_again(&inwards, leaving(Side::Front), &Tolerance::plain(0.0)), None);
    }

    #[test]
    fn tangents_follow_the_parallels() {
        let sphere = sphere(DVec3::ZERO, 1.0);
        assert_eq!(sphere.tangent(&hit(DVec3::Z)), DVec3::X);
        assert_eq!(sphere.tangent(&hit(DVec3::X)), -DVec3::Z);
        assert_eq!(sphere.tangent(&hit(DVec3::Y)), DVec3::X);
        assert_eq!(sphere.tangent(&hit(-DVec3::Y)), DVec3::X);
        let inside = SurfaceHit { side: Side::Back, geometric_normal: -DVec3::Z, ..hit(DVec3::Z) };
        assert_eq!(sphere.tangent(&inside), DVec3::X);
    }

    #[test]
    fn longitude_and_polar_angle_are_the_coordinates() {
        let sphere = sphere(DVec3::ZERO, 1.0);
        let at = |x: f64, y: f64, z: f64| sphere.coordinates(&hit(DVec3::new(x, y, z).normalize()));
        for (point, [u, v]) in [
            ([0.0, 0.0, 1.0], [0.0, 0.5]),
            ([1.0, 0.0, 0.0], [0.25, 0.5]),
            ([0.0, 0.0, -1.0], [0.5, 0.5]),
            ([-1.0, 0.0, 0.0], [0.75, 0.5]),
            ([0.0, 1.0, 0.0], [0.0, 1.0]),
            ([0.0, -1.0, 0.0], [0.0, 0.0]),
            ([1.0, 2f64.sqrt(), 1.0], [0.125, 0.75]),
            ([-1.0, -(2f64.sqrt()), 1.0], [0.875, 0.25]),
        ] {
            let [x, y, z] = point;
            let [found_u, found_v] = at(x, y, z);
            assert!((found_u - u).abs() < 1e-15 && (found_v - v).abs() < 1e-15, "{point:?}: {found_u}, {found_v}");
        }
        // Just west of the meridian where u is 0, u stays below 1.
        let [u, _] = at(-1e-17, 0.0, 1.0);
        assert!((0.0..1.0).contains(&u), "{u}");
    }

    #[test]
    fn u_grows_along_the_tangent() {
        let sphere = sphere(DVec3::ZERO, 1.0);
        for step in 0..40 {
            let (latitude, longitude) = (0.07 * f64::from(step) - 1.4, 0.15 * f64::from(step));
            let normal = DVec3::new(latitude.cos() * longitude.sin(), latitude.sin(), latitude.cos() * longitude.cos());
            let tangent = sphere.tangent(&hit(normal));
            let [u, v] = sphere.coordinates(&hit(normal));
            let [next, same] = sphere.coordinates(&hit((normal + 1e-6 * tangent).normalize()));
            let grown = (next - u).rem_euclid(1.0) * TAU * latitude.cos() / 1e-6;
            assert!((grown - 1.0).abs() < 1e-4 && (same - v).abs() < 1e-10, "{normal}: {grown}");
        }
    }
}
