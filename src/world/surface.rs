//! The kinds of surfaces: what each of them must answer, and the table of all.
//!
//! A surface of a [`Shape`] answers in the coordinates of the shape. The [`Surface`] of a body answers in those of the
//! world, whatever transforms the body has (`surface/placed.rs`).

mod axis_box;
mod axis_frame;
mod chord;
mod cone;
mod cylinder;
mod disc;
mod mesh;
mod placed;
mod rectangle;
mod sphere;
#[cfg(test)]
mod tests;
mod tolerance;
mod triangle;

use crate::scene::{Body, Shape};
use crate::world::bounds::Bounds;
use crate::world::hit::{Meeting, SurfaceHit};
use crate::world::meshes::Meshes;
use crate::world::missing_asset::MissingAsset;
use crate::world::ray::{Departure, PrimitiveId, Ray};
use glam::{DAffine3, DVec3};

pub(super) use placed::Surface;
use tolerance::Tolerance;

/// What the surface of a shape answers, in the coordinates of the shape. Each kind implements it in a file of its own.
trait Geometry {
    /// The box around it, after it is transformed by `map`.
    fn bounds(&self, map: &DAffine3) -> Bounds;

    /// Where a ray from elsewhere first meets the surface, at a distance greater than 0.
    ///
    /// A surface within the tolerance of the origin is not met: it coincides with the surface that the ray comes from.
    fn intersect(&self, ray: &Ray, tolerance: &Tolerance) -> Option<Meeting>;

    /// Where a ray that starts on this very surface meets it again. The root at the origin is left out analytically.
    fn intersect_again(&self, ray: &Ray, from: Departure, tolerance: &Tolerance) -> Option<Meeting>;

    /// Whether finding the part that a ray meets takes a search.
    fn is_searched(&self) -> bool {
        false
    }

    /// Where the line of a ray meets this part of a surface that is searched.
    fn intersect_part(&self, _: &Ray, _: PrimitiveId) -> Option<Meeting> {
        None
    }

    /// Whether a ray meets the surface before `end`, at a distance greater than 0. `from` is where it starts on this
    /// very surface, if it does.
    fn is_met_before(&self, ray: &Ray, from: Option<Departure>, tolerance: &Tolerance, end: f64) -> bool {
        let met = match from {
            Some(from) => self.intersect_again(ray, from, tolerance),
            None => self.intersect(ray, tolerance),
        };
        met.is_some_and(|met| met.distance < end)
    }

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

/// Declares [`ShapeSurface`] from rows: the variant of [`Shape`] that a surface is built from, and the type of the
/// surface. Meshes are beside the rows: their triangles are not in the scene.
macro_rules! surfaces {
    ($($kind:ident: $module:ident::$type:ident,)*) => {
        /// The surface of a shape.
        #[derive(Debug, Clone, PartialEq)]
        enum ShapeSurface {
            $($kind($module::$type),)*
            Mesh(mesh::MeshSurface),
        }

        impl ShapeSurface {
            /// The surface of the shape of a body.
            fn new(body: &Body, meshes: &Meshes) -> Result<Self, MissingAsset> {
                Ok(match &body.form.shape {
                    $(Shape::$kind(shape) => ShapeSurface::$kind($module::$type::new(shape)),)*
                    Shape::Mesh(named) => {
                        let (tree, smooth) = meshes.of_body(body, named.path())?;
                        ShapeSurface::Mesh(mesh::MeshSurface::new(tree, smooth))
                    }
                })
            }
        }

        impl Geometry for ShapeSurface {
            fn bounds(&self, map: &DAffine3) -> Bounds {
                match self {
                    $(ShapeSurface::$kind(surface) => surface.bounds(map),)*
                    ShapeSurface::Mesh(surface) => surface.bounds(map),
                }
            }

            #[inline(always)]
            fn intersect(&self, ray: &Ray, tolerance: &Tolerance) -> Option<Meeting> {
                match self {
                    $(ShapeSurface::$kind(surface) => surface.intersect(ray, tolerance),)*
                    ShapeSurface::Mesh(surface) => surface.intersect(ray, tolerance),
                }
            }

            #[inline(always)]
            fn intersect_again(&self, ray: &Ray, from: Departure, tolerance: &Tolerance) -> Option<Meeting> {
                match self {
                    $(ShapeSurface::$kind(surface) => surface.intersect_again(ray, from, tolerance),)*
                    ShapeSurface::Mesh(surface) => surface.intersect_again(ray, from, tolerance),
                }
            }

            #[inline]
            fn is_searched(&self) -> bool {
                match self {
                    $(ShapeSurface::$kind(surface) => surface.is_searched(),)*
                    ShapeSurface::Mesh(surface) => surface.is_searched(),
                }
            }

            fn intersect_part(&self, ray: &Ray, part: PrimitiveId) -> Option<Meeting> {
                match self {
                    $(ShapeSurface::$kind(surface) => surface.intersect_part(ray, part),)*
                    ShapeSurface::Mesh(surface) => surface.intersect_part(ray, part),
                }
            }

            fn is_met_before(&self, ray: &Ray, from: Option<Departure>, tolerance: &Tolerance, end: f64) -> bool {
                match self {
                    $(ShapeSurface::$kind(surface) => surface.is_met_before(ray, from, tolerance, end),)*
                    ShapeSurface::Mesh(surface) => surface.is_met_before(ray, from, tolerance, end),
                }
            }

            #[inline(always)]
            fn project(&self, point: DVec3, primitive: PrimitiveId, direction: DVec3) -> FrontPoint {
                match self {
                    $(ShapeSurface::$kind(surface) => surface.project(point, primitive, direction),)*
                    ShapeSurface::Mesh(surface) => surface.project(point, primitive, direction),
                }
            }

            fn tangent(&self, hit: &SurfaceHit) -> DVec3 {
                match self {
                    $(ShapeSurface::$kind(surface) => surface.tangent(hit),)*
                    ShapeSurface::Mesh(surface) => surface.tangent(hit),
                }
            }

            fn coordinates(&self, hit: &SurfaceHit) -> [f64; 2] {
                match self {
                    $(ShapeSurface::$kind(surface) => surface.coordinates(hit),)*
                    ShapeSurface::Mesh(surface) => surface.coordinates(hit),
                }
            }
        }
    };
}

surfaces! {
    Sphere: sphere::SphereSurface,
    Rectangle: rectangle::RectangleSurface,
    Triangle: triangle::TriangleSurface,
    Disc: disc::DiscSurface,
    Box: axis_box::AxisBoxSurface,
    Cylinder: cylinder::CylinderSurface,
    Cone: cone::ConeSurface,
}
