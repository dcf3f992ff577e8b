//! The surface of a body: that of its shape, as its transforms place it in the world.
//!
//! A ray of the world is transformed into the coordinates of the shape, which computes with a direction of unit length
//! there, and the results are transformed back. Normals go by the inverse transpose, which keeps the front the front
//! even where a scale below 0 mirrors. The tangent, the direction in which u grows, goes with the points, and stays in
//! the surface. So T is perpendicular to N, as on every shape, and B = N × T. It need not be the direction in which v
//! grows. The coordinates u and v are those of the shape.

use super::{FrontPoint, Geometry, ShapeSurface, Tolerance};
use crate::scene::{Body, Transform};
use crate::world::bounds::Bounds;
use crate::world::hit::{Meeting, SurfaceHit};
use crate::world::meshes::Meshes;
use crate::world::missing_asset::MissingAsset;
use crate::world::ray::{Departure, PrimitiveId, Ray};
use glam::{DAffine3, DMat3, DVec3};

/// The surface of a body in world coordinates.
#[derive(Debug, Clone, PartialEq)]
pub(in crate::world) struct Surface {
    shape: ShapeSurface,
    /// `None` where the coordinates of the shape are those of the world.
    place: Option<Box<ShapePlace>>,
    bounds: Bounds,
}

/// How the coordinates of a shape become those of the world, and back.
#[derive(Debug, Clone, Copy, PartialEq)]
struct ShapePlace {
    to_world: DAffine3,
    /// The inverse of the matrix in `to_world`.
    inverse: DMat3,
    /// The transpose of `inverse`: what makes a normal of the world, of any length, from one of the shape.
    normals: DMat3,
}

impl ShapePlace {
    fn new(to_world: DAffine3) -> Self {
        let inverse = to_world.matrix3.inverse();
        Self { to_world, inverse, normals: inverse.transpose() }
    }

    /// A point of the world in the coordinates of the shape. The translation goes first: it may be far larger than the
    /// shape.
    fn point(&self, point: DVec3) -> DVec3 {
        self.inverse * (point - self.to_world.translation)
    }

    /// A ray of the world in the coordinates of the shape, and how long a world unit along it is there.
    fn ray(&self, ray: &Ray) -> (Ray, f64) {
        let direction = self.inverse * ray.direction;
        let length = direction.length();
        (Ray { origin: self.point(ray.origin), direction: direction / length, leaves: ray.leaves }, length)
    }

    /// A hit in the coordinates of the shape.
    fn hit(&self, hit: &SurfaceHit) -> SurfaceHit {
        let back = self.to_world.matrix3.transpose();
        SurfaceHit {
            point: self.point(hit.point),
            geometric_normal: (back * hit.geometric_normal).normalize(),
            shading_normal: (back * hit.shading_normal).normalize(),
            view: (self.inverse * hit.view).normalize(),
            ..*hit
        }
    }

    fn meeting(met: Meeting, length: f64) -> Meeting {
        // Greater than 0 even where the quotient vanishes.
        Meeting { distance: (met.distance / length).max(f64::MIN_POSITIVE), ..met }
    }
}

/// The map from the coordinates of a shape to those of the world.
fn to_world(surface: &ShapeSurface, transforms: &[Transform]) -> DAffine3 {
    transforms.iter().fold(DAffine3::IDENTITY, |map, transform| match transform {
        Transform::Fit { center, size } => {
            let Bounds { low, high } = surface.bounds(&map);
            let to_origin = DAffine3::from_translation(-low.midpoint(high));
            let scale = DAffine3::from_scale(DVec3::splat(size / (high - low).max_element()));
            DAffine3::from_translation(*center) * scale * to_origin * map
        }
        Transform::Scale(_) | Transform::Stretch(_) | Transform::Rotate { .. } | Transform::Translate(_) => {
            transform.map().unwrap_or_default() * map
        }
    })
}

impl Surface {
    /// The surface of a body.
    pub(in crate::world) fn new(body: &Body, meshes: &Meshes) -> Result<Self, MissingAsset> {
        let shape = ShapeSurface::new(body, meshes)?;
        let map = to_world(&shape, &body.form.transforms);
        let bounds = shape.bounds(&map);
        Ok(Self { shape, place: (map != DAffine3::IDENTITY).then(|| ShapePlace::new(map).into()), bounds })
    }

    /// The box around it.
    pub(in crate::world) fn bounds(&self) -> Bounds {
        self.bounds
    }

    /// Where a ray from elsewhere first meets the surface, at a distance greater than 0. Surfaces within `tolerance`
    /// (in world units, ≥ 0) of the origin are not met.
    #[inline(always)]
    pub(in crate::world) fn intersect(&self, ray: &Ray, tolerance: f64) -> Option<Meeting> {
        match &self.place {
            None => self.shape.intersect(ray, &Tolerance::plain(tolerance)),
            Some(place) => {
                let (ray, length) = place.ray(ray);
                let met = self.shape.intersect(&ray, &Tolerance::placed(tolerance, length, &place.normals))?;
                Some(ShapePlace::meeting(met, length))
            }
        }
    }

    /// Where a ray that starts on this very surface meets it again.
    #[inline(always)]
    pub(in crate::world) fn intersect_again(&self, ray: &Ray, from: Departure, tolerance: f64) -> Option<Meeting> {
        match &self.place {
            None => self.shape.intersect_again(ray, from, &Tolerance::plain(tolerance)),
            Some(place) => {
                let (ray, length) = place.ray(ray);
                let tolerance = Tolerance::placed(tolerance, length, &place.normals);
                Some(ShapePlace::meeting(self.shape.intersect_again(&ray, from, &tolerance)?, length))
            }
        }
    }

    /// Whether finding the part that a ray meets takes a search.
    #[inline]
    pub(in crate::world) fn is_searched(&self) -> bool {
        self.shape.is_searched()
    }

    /// Where the line of a ray meets this part of a surface that is searched.
    pub(in crate::world) fn intersect_part(&self, ray: &Ray, part: PrimitiveId) -> Option<Meeting> {
        let Some(place) = &self.place else { return self.shape.intersect_part(ray, part) };
        let (ray, length) = place.ray(ray);
        Some(ShapePlace::meeting(self.shape.intersect_part(&ray, part)?, length))
    }

    /// Whether a ray meets the surface before `end` (in world units). `from` is where it starts on this very surface,
    /// if it does.
    pub(in crate::world) fn is_met_before(&self, ray: &Ray, from: Option<Departure>, tolerance: f64, end: f64) -> bool {
        let Some(place) = &self.place else { return self.shape.is_met_before(ray, from, &Tolerance::plain(tolerance), end) };
        let (ray, length) = place.ray(ray);
        let tolerance = Tolerance::placed(tolerance, length, &place.normals);
        self.shape.is_met_before(&ray, from, &tolerance, end * length)
    }

    /// The point of the surface nearest to `point`, which is on it but for rounding, see [`Geometry::project`].
    #[inline(always)]
    pub(in crate::world) fn project(&self, point: DVec3, primitive: PrimitiveId, direction: DVec3) -> FrontPoint {
        let Some(place) = &self.place else { return self.shape.project(point, primitive, direction) };
        let direction = (place.inverse * direction).normalize();
        let front = self.shape.project(place.point(point), primitive, direction);
        FrontPoint {
            point: place.to_world.transform_point3(front.point),
            geometric_normal: (place.normals * front.geometric_normal).normalize(),
            shading_normal: (place.normals * front.shading_normal).normalize(),
        }
    }

    /// The tangent at a hit, see [`World::tangent`](crate::world::World::tangent).
    pub(in crate::world) fn tangent(&self, hit: &SurfaceHit) -> DVec3 {
        let Some(place) = &self.place else { return self.shape.tangent(hit) };
        place.to_world.transform_vector3(self.shape.tangent(&place.hit(hit))).normalize()
    }

    /// The surface coordinates of a hit, see [`World::coordinates`](crate::world::World::coordinates).
    pub(in crate::world) fn coordinates(&self, hit: &SurfaceHit) -> [f64; 2] {
        match &self.place {
            None => self.shape.coordinates(hit),
            Some(place) => self.shape.coordinates(&place.hit(hit)),
        }
    }
}
