//! The kinds of surfaces: what each of them must answer, and the table of all.

mod rectangle;
mod sphere;

use crate::scene::Shape;
use crate::world::bounds::Bounds;
use crate::world::hit::{Meeting, SurfaceHit};
use crate::world::ray::{Departure, PrimitiveId, Ray};
use glam::DVec3;

/// What a surface answers. Each kind implements it in a file of its own.
pub(super) trait Geometry {
    /// The box around it.
    fn bounds(&self) -> Bounds;

    /// Where a ray from elsewhere first meets the surface, at a distance greater than 0.
    ///
    /// A surface within `tolerance` (in world units, ≥ 0) of the origin is not met: it coincides with the surface that
    /// the ray comes from.
    fn intersect(&self, ray: &Ray, tolerance: f64) -> Option<Meeting>;

    /// Where a ray that starts on this very surface meets it again. The root at the origin is left out analytically.
    fn intersect_again(&self, ray: &Ray, from: Departure, tolerance: f64) -> Option<Meeting>;

    /// The point of the surface nearest to `point`, which is on it but for rounding, with its front normals.
    /// `direction`, that of the ray that found it, decides where rounding leaves nothing else to go by.
    fn project(&self, point: DVec3, primitive: PrimitiveId, direction: DVec3) -> FrontPoint;

    /// The tangent at a hit, see [`World::tangent`](super::World::tangent).
    fn tangent(&self, hit: &SurfaceHit) -> DVec3;

    /// The surface coordinates of a hit, see [`World::coordinates`](super::World::coordinates).
    fn coordinates(&self, hit: &SurfaceHit) -> [f64; 2];
}

/// A point of a surface with its normals on the front, of unit length.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct FrontPoint {
    pub(super) point: DVec3,
    pub(super) geometric_normal: DVec3,
    pub(super) shading_normal: DVec3,
}

/// Declares [`Surface`] from rows: the variant of [`Shape`] that a surface is built from, and the type of the surface.
macro_rules! surfaces {
    ($($kind:ident: $module:ident::$type:ident,)*) => {
        /// The surface of a body.
        #[derive(Debug, Clone, PartialEq)]
        pub(super) enum Surface {
            $($kind($module::$type),)*
        }

        impl Surface {
            /// The surface of a shape.
            pub(super) fn new(shape: &Shape) -> Self {
                match shape {
                    $(Shape::$kind(shape) => Surface::$kind($module::$type::new(shape)),)*
                }
            }
        }

        impl Geometry for Surface {
            fn bounds(&self) -> Bounds {
                match self {
                    $(Surface::$kind(surface) => surface.bounds(),)*
                }
            }

            #[inline]
            fn intersect(&self, ray: &Ray, tolerance: f64) -> Option<Meeting> {
                match self {
                    $(Surface::$kind(surface) => surface.intersect(ray, tolerance),)*
                }
            }

            #[inline]
            fn intersect_again(&self, ray: &Ray, from: Departure, tolerance: f64) -> Option<Meeting> {
                match self {
                    $(Surface::$kind(surface) => surface.intersect_again(ray, from, tolerance),)*
                }
            }

            #[inline]
            fn project(&self, point: DVec3, primitive: PrimitiveId, direction: DVec3) -> FrontPoint {
                match self {
                    $(Surface::$kind(surface) => surface.project(point, primitive, direction),)*
                }
            }

            fn tangent(&self, hit: &SurfaceHit) -> DVec3 {
                match self {
                    $(Surface::$kind(surface) => surface.tangent(hit),)*
                }
            }

            fn coordinates(&self, hit: &SurfaceHit) -> [f64; 2] {
                match self {
                    $(Surface::$kind(surface) => surface.coordinates(hit),)*
                }
            }
        }
    };
}

surfaces! {
    Sphere: sphere::SphereSurface,
    Rectangle: rectangle::RectangleSurface,
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lang::source::Source;
    use crate::scene::{BodyId, Scene};
    use crate::world::World;

    fn world(shape: &str) -> World {
        let text = format!("bodies; b: {shape}; lights; camera; position <0,0,9>; gaze <0,0,-1>; up <0,1,0>; fov 45;");
        World::new(Scene::parse(&Source::new("scene", text)).unwrap().0)
    }

    /// Rays from around a box through points of it, without order.
    fn rays(bounds: &Bounds, count: u32) -> impl Iterator<Item = Ray> {
        let (low, size, diagonal) = (bounds.low, bounds.high - bounds.low, bounds.diagonal());
        (1..=count).map(move |number| {
            // The R₅ sequence (Roberts 2018).
            let share = |power: i32| (f64::from(number) * 0.880_271_510_5_f64.powi(power)).fract();
            let (height, turn) = (2.0 * share(1) - 1.0, std::f64::consts::TAU * share(2));
            let around = (1.0 - height * height).sqrt();
            let origin = low + size / 2.0 + diagonal * DVec3::new(around * turn.cos(), height, around * turn.sin());
            let target = low + size * DVec3::new(share(3), share(4), share(5));
            Ray { origin, direction: (target - origin).normalize(), leaves: None }
        })
    }

    /// What [`Geometry`] promises, for the example of every shape.
    #[test]
    fn every_kind_of_surface_keeps_the_promises() {
        for syntax in Shape::SYNTAX {
            let world = world(syntax.example);
            let surface = &world.surfaces[0];
            let bounds = surface.bounds();
            let (size, name) = (bounds.diagonal(), syntax.keyword.word);
            let mut hits = 0;
            for ray in rays(&bounds, 1000) {
                let Some(met) = world.nearest(&ray) else { continue };
                let hit = world.surface_hit(&ray, &met);
                hits += 1;
                assert_eq!(hit.body, BodyId(0));
                assert!((hit.point - ray.at(met.distance)).length() < 1e-12 * size, "{name}: {hit:?} is not on the ray");
                let inside = Bounds { low: bounds.low, high: bounds.high }.union(Bounds { low: hit.point, high: hit.point });
                assert!(inside.diagonal() <= size * (1.0 + 1e-12), "{name}: {hit:?} is out of bounds");
                for unit in [hit.geometric_normal, hit.shading_normal, world.tangent(&hit)] {
                    assert!((unit.length() - 1.0).abs() < 1e-12, "{name}: {unit} is not of unit length");
                }
                assert!(hit.geometric_normal.dot(hit.view) >= 0.0 && hit.geometric_normal.dot(hit.shading_normal) > 0.0);
                assert!(world.tangent(&hit).dot(hit.geometric_normal).abs() < 1e-12, "{name}: the tangent leaves the surface");
                assert!(world.coordinates(&hit).iter().all(|share| (0.0..=1.0).contains(share)), "{name}");
                check_leaving(&world, &ray, &hit, name);
                check_coordinates(&world, &hit, 1e-6 * size, name);
            }
            assert!(hits > 200, "{name}: {hits} hits");
        }
    }

    /// Nothing is between a hit and the origin of its ray, and a ray that goes on meets what one meets that starts just
    /// beyond.
    fn check_leaving(world: &World, ray: &Ray, hit: &SurfaceHit, name: &str) {
        assert!(!world.is_occluded(&hit.ray(hit.view, hit.side), hit.distance), "{name}: something is before {hit:?}");
        let step = 1e-6 * world.extent();
        let onward = world.nearest(&hit.ray(ray.direction, hit.side.opposite())).map(|met| met.distance);
        let beyond = Ray { origin: hit.point + step * ray.direction, direction: ray.direction, leaves: None };
        match (onward, world.nearest(&beyond).map(|met| met.distance + step)) {
            (Some(onward), Some(beyond)) => {
                assert!((onward - beyond).abs() < 1e-9 * world.extent(), "{name}: {onward}, {beyond}")
            }
            (Some(onward), None) => assert!(onward < 2.0 * step, "{name}: {onward}"),
            (None, beyond) => assert_eq!(beyond, None, "{name}"),
        }
    }

    /// A step along the tangent lets u grow, and leaves v as it is.
    fn check_coordinates(world: &World, hit: &SurfaceHit, step: f64, name: &str) {
        let origin = hit.point + step * (world.tangent(hit) + hit.geometric_normal);
        let ray = Ray { origin, direction: -hit.geometric_normal, leaves: None };
        let Some(met) = world.nearest(&ray).filter(|met| met.distance < 2.0 * step) else { return };
        let next = world.surface_hit(&ray, &met);
        let ([u, v], [next_u, next_v]) = (world.coordinates(hit), world.coordinates(&next));
        // Where a surface is closed, u starts again at 0.
        let grown = (next_u - u).rem_euclid(1.0);
        assert!(grown > 0.0 && grown < 0.1, "{name}: u goes from {u} to {next_u} at {hit:?}");
        assert!((next_v - v).abs() < 1e-3 * grown, "{name}: v goes from {v} to {next_v} at {hit:?}");
    }
}
