//! Spheres and rectangles: where a ray meets them, their normals and tangents (thesis 3.2.6), in f64 world coordinates.
//!
//! A ray that leaves a surface is not pushed away from it by some small distance. It is known which surface it leaves and
//! to which side, so the root at its origin is left out of the solution instead: this works alike at any scale.

use crate::scene::{MAX_COORDINATE, MIN_LENGTH};
use glam::DVec3;

/// The largest |cosine| of the angle between the edges of a rectangle.
const MAX_COSINE: f64 = 1e-3;

/// A half-line.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ray {
    /// Where it starts.
    pub origin: DVec3,
    /// Where it goes, of unit length.
    pub direction: DVec3,
}

impl Ray {
    /// The point at `distance` from the origin.
    pub fn at(&self, distance: f64) -> DVec3 {
        self.origin + distance * self.direction
    }
}

/// A side of a surface.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Side {
    /// The side to which the front normal points: the outside of a sphere.
    Front,
    /// The other side: the inside of a sphere.
    Back,
}

impl Side {
    /// The other side.
    #[must_use]
    pub fn opposite(self) -> Side {
        match self {
            Side::Front => Side::Back,
            Side::Back => Side::Front,
        }
    }
}

/// The shape of a body.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Shape {
    /// A sphere.
    Sphere(Sphere),
    /// A rectangle.
    Rectangle(Rectangle),
}

/// A sphere; its front is the outside.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sphere {
    center: DVec3,
    radius: f64,
}

/// A rectangle A, B, C and A + C − B, the corners clockwise as seen from its front.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rectangle {
    corners: [DVec3; 3],
    /// The front normal.
    normal: DVec3,
    /// Dot products with these take a point, seen from B, to its place on the edges: BA at 0..1, BC at 0..1.
    across: [DVec3; 2],
}

/// Why there is no such shape.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum ShapeError {
    /// A coordinate is beyond [`MAX_COORDINATE`], or no number.
    #[error("a coordinate is too large")]
    TooFar,
    /// The radius is not within [`MIN_LENGTH`]..[`MAX_COORDINATE`].
    #[error("the radius must be greater than 0, and within {MIN_LENGTH:e} to {MAX_COORDINATE:e}")]
    Radius,
    /// Two neighbouring corners, counted from 0, are the same.
    #[error("two neighbouring corners of a rectangle are the same")]
    NoEdge(usize, usize),
    /// The edges that meet in B are not perpendicular; the cosine of the angle between them.
    #[error("the edges of a rectangle are not perpendicular: the cosine is {0:.3e}")]
    Skewed(f64),
}

fn fits(point: DVec3) -> bool {
    point.is_finite() && point.abs().max_element() <= MAX_COORDINATE
}

impl Sphere {
    /// The sphere of that centre and radius.
    ///
    /// # Errors
    /// A centre too far away; a radius that is not positive, too small or too large.
    pub fn new(center: DVec3, radius: f64) -> Result<Self, ShapeError> {
        if !fits(center) {
            return Err(ShapeError::TooFar);
        }
        if !(MIN_LENGTH..=MAX_COORDINATE).contains(&radius) {
            return Err(ShapeError::Radius);
        }
        Ok(Self { center, radius })
    }

    /// Its centre.
    pub fn center(&self) -> DVec3 {
        self.center
    }

    /// Its radius.
    pub fn radius(&self) -> f64 {
        self.radius
    }

    /// The quadratic is solved as in Haines, Günther, Akenine-Möller, "Precision Improvements for Ray/Sphere
    /// Intersection", Ray Tracing Gems (2019): small far spheres keep their shape, and neither root cancels.
    fn intersect(&self, ray: &Ray, clearance: f64) -> Option<f64> {
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
        let (first, second) = if larger < smaller { (larger, smaller) } else { (smaller, larger) };
        [first, second].into_iter().find(|&root| root > clearance)
    }

    /// A ray that leaves the sphere outwards never comes back; one that leaves it inwards crosses it along a chord.
    fn intersect_leaving(&self, ray: &Ray, side: Side) -> Option<f64> {
        match side {
            Side::Front => None,
            Side::Back => {
                let chord = -2.0 * (ray.origin - self.center).dot(ray.direction);
                (chord > 0.0).then_some(chord)
            }
        }
    }
}

impl Rectangle {
    /// The rectangle with the corners `a`, `b`, `c`, in this order clockwise as seen from its front.
    ///
    /// # Errors
    /// Corners too far away; neighbours that coincide; edges that are not perpendicular to |cosine| ≤ 1e-3.
    pub fn new(a: DVec3, b: DVec3, c: DVec3) -> Result<Self, ShapeError> {
        if ![a, b, c].into_iter().all(fits) {
            return Err(ShapeError::TooFar);
        }
        let (first, second) = (a - b, c - b);
        if first.length() < MIN_LENGTH {
            return Err(ShapeError::NoEdge(0, 1));
        }
        if second.length() < MIN_LENGTH {
            return Err(ShapeError::NoEdge(1, 2));
        }
        let cosine = first.dot(second) / (first.length() * second.length());
        if cosine.abs() > MAX_COSINE {
            return Err(ShapeError::Skewed(cosine));
        }
        // (C − A) × (B − A), written with the edges at B.
        let normal = first.normalize().cross(second.normalize()).normalize();
        let (along_first, along_second) = (second.cross(normal), first.cross(normal));
        let across = [along_first / along_first.dot(first), along_second / along_second.dot(second)];
        Ok(Self { corners: [a, b, c], normal, across })
    }

    /// The corners A, B, C.
    pub fn corners(&self) -> [DVec3; 3] {
        self.corners
    }

    /// The front normal, normalize((C−A)×(B−A)).
    pub fn normal(&self) -> DVec3 {
        self.normal
    }

    fn intersect(&self, ray: &Ray, clearance: f64) -> Option<f64> {
        let [_, b, _] = self.corners;
        let height = (b - ray.origin).dot(self.normal);
        // Measured across the plane, not along the ray, so that a ray in a second, coincident rectangle cannot slip in
        // however low it goes.
        if height.abs() <= clearance {
            return None;
        }
        let distance = height / ray.direction.dot(self.normal);
        let place = ray.at(distance) - b;
        // Infinities and NaN of a parallel ray are in no range.
        let inside = self.across.iter().all(|across| (0.0..=1.0).contains(&across.dot(place)));
        (distance > 0.0 && inside).then_some(distance)
    }
}

impl Shape {
    /// The distance at which a ray from elsewhere first meets the shape, greater than 0, or `None`.
    ///
    /// A surface within `clearance` (in world units, ≥ 0) of the origin is not met: it coincides with the surface that the
    /// ray comes from.
    pub fn intersect(&self, ray: &Ray, clearance: f64) -> Option<f64> {
        match self {
            Shape::Sphere(sphere) => sphere.intersect(ray, clearance),
            Shape::Rectangle(rectangle) => rectangle.intersect(ray, clearance),
        }
    }

    /// The distance at which a ray that starts on this very shape, and leaves it to `side`, meets it again.
    ///
    /// The root at the origin is left out analytically.
    pub fn intersect_leaving(&self, ray: &Ray, side: Side) -> Option<f64> {
        match self {
            Shape::Sphere(sphere) => sphere.intersect_leaving(ray, side),
            Shape::Rectangle(_) => None,
        }
    }

    /// The point of the surface that `point`, which is on it but for rounding, stands for, and the front normal there.
    /// `direction`, where the ray that found it goes, helps where rounding leaves nothing else to go by.
    pub fn settle(&self, point: DVec3, direction: DVec3) -> (DVec3, DVec3) {
        match self {
            Shape::Sphere(sphere) => {
                let normal = (point - sphere.center).try_normalize().unwrap_or(-direction);
                (sphere.center + sphere.radius * normal, normal)
            }
            Shape::Rectangle(rectangle) => {
                let [_, b, _] = rectangle.corners;
                (point + (b - point).dot(rectangle.normal) * rectangle.normal, rectangle.normal)
            }
        }
    }

    /// The tangent where the front normal is `normal`: on a rectangle the direction from A to B, on a sphere
    /// normalize(<0,1,0> × normal), or <1,0,0> at the poles.
    pub fn tangent(&self, normal: DVec3) -> DVec3 {
        match self {
            Shape::Sphere(_) => {
                let east = DVec3::Y.cross(normal);
                // Closer than this to a pole the direction is noise.
                if east.length() < 1e-12 { DVec3::X } else { east.normalize() }
            }
            Shape::Rectangle(rectangle) => {
                let [a, b, _] = rectangle.corners;
                (b - a).normalize()
            }
        }
    }

    /// The lowest and highest coordinates of the shape.
    pub fn bounds(&self) -> (DVec3, DVec3) {
        match self {
            Shape::Sphere(Sphere { center, radius }) => (center - DVec3::splat(*radius), center + DVec3::splat(*radius)),
            Shape::Rectangle(rectangle) => {
                let [a, b, c] = rectangle.corners;
                let d = a + (c - b);
                (a.min(b).min(c).min(d), a.max(b).max(c).max(d))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ray(origin: [f64; 3], direction: [f64; 3]) -> Ray {
        Ray { origin: origin.into(), direction: DVec3::from(direction).normalize() }
    }

    fn square() -> Rectangle {
        Rectangle::new(DVec3::ZERO, DVec3::Y, DVec3::new(1.0, 1.0, 0.0)).unwrap()
    }

    #[test]
    fn spheres_are_met_from_outside_and_inside() {
        let sphere = Shape::Sphere(Sphere::new(DVec3::new(0.0, 0.0, -5.0), 2.0).unwrap());
        assert_eq!(sphere.intersect(&ray([0.0; 3], [0.0, 0.0, -1.0]), 0.0), Some(3.0));
        assert_eq!(sphere.intersect(&ray([0.0, 0.0, -5.0], [0.0, 1.0, 0.0]), 0.0), Some(2.0));
        assert_eq!(sphere.intersect(&ray([0.0; 3], [0.0, 0.0, 1.0]), 0.0), None);
        assert_eq!(sphere.intersect(&ray([0.0, 2.1, 0.0], [0.0, 0.0, -1.0]), 0.0), None);
    }

    #[test]
    fn small_far_spheres_keep_their_shape() {
        // 1e6 radii away a naive quadratic has lost all digits of the discriminant.
        let sphere = Sphere::new(DVec3::new(0.0, 0.0, -1e6), 1.0).unwrap();
        for offset in [0.0, 0.25, 0.5, 0.75, 0.999] {
            let hit = sphere.intersect(&ray([offset, 0.0, 0.0], [0.0, 0.0, -1.0]), 0.0).unwrap();
            assert!((hit - (1e6 - (1.0 - offset * offset).sqrt())).abs() < 1e-9, "{offset}: {hit}");
        }
        assert_eq!(sphere.intersect(&ray([1.001, 0.0, 0.0], [0.0, 0.0, -1.0]), 0.0), None);
    }

    #[test]
    fn a_chord_is_found_without_the_root_at_the_origin() {
        let sphere = Shape::Sphere(Sphere::new(DVec3::ZERO, 1e-20).unwrap());
        let inwards = ray([0.0, 0.0, 1e-20], [0.0, 0.6, -0.8]);
        let chord = sphere.intersect_leaving(&inwards, Side::Back).unwrap();
        assert!((chord / 1.6e-20 - 1.0).abs() < 1e-14);
        assert_eq!(sphere.intersect_leaving(&inwards, Side::Front), None);
    }

    #[test]
    fn the_front_of_a_rectangle_sees_its_corners_clockwise() {
        // From +z, (0,0) (0,1) (1,1) turn clockwise.
        assert_eq!(square().normal(), DVec3::Z);
        let [a, b, c] = square().corners();
        assert_eq!(square().normal(), (c - a).cross(b - a).normalize());
    }

    #[test]
    fn rectangles_are_met_within_their_edges_only() {
        let square = Shape::Rectangle(square());
        let hit = |x, y| square.intersect(&ray([x, y, 2.0], [0.0, 0.0, -1.0]), 1e-9);
        assert_eq!(hit(0.5, 0.5), Some(2.0));
        assert_eq!(hit(1.0, 0.0), Some(2.0));
        assert_eq!(hit(1.001, 0.5), None);
        assert_eq!(hit(0.5, -0.001), None);
        assert_eq!(square.intersect(&ray([0.5, 0.5, 2.0], [1.0, 0.0, 0.0]), 1e-9), None);
        assert_eq!(square.intersect(&ray([-1.0, 0.5, 1e-10], [1.0, 0.0, -1e-10]), 1e-9), None);
    }

    #[test]
    fn bad_shapes_are_refused() {
        let corner = |x, y| DVec3::new(x, y, 0.0);
        let skewed = Rectangle::new(corner(0.0, 0.0), corner(0.0, 1.0), corner(1.0, 1.1));
        assert!(matches!(skewed, Err(ShapeError::Skewed(cosine)) if (cosine + 0.0995).abs() < 1e-4), "{skewed:?}");
        assert!(Rectangle::new(corner(0.0, 0.0), corner(0.0, 1.0), corner(1.0, 1.0009)).is_ok());
        assert_eq!(Rectangle::new(DVec3::X, DVec3::X, DVec3::Y), Err(ShapeError::NoEdge(0, 1)));
        assert_eq!(Rectangle::new(DVec3::X, DVec3::Y, DVec3::Y), Err(ShapeError::NoEdge(1, 2)));
        assert_eq!(Rectangle::new(DVec3::X, DVec3::Y, DVec3::Y * 1e300), Err(ShapeError::TooFar));
        assert_eq!(Sphere::new(DVec3::ZERO, 0.0), Err(ShapeError::Radius));
        assert_eq!(Sphere::new(DVec3::ZERO, f64::NAN), Err(ShapeError::Radius));
        assert!(Rectangle::new(DVec3::X * 1e30, DVec3::ZERO, DVec3::Y * 1e-30).is_ok());
    }

    #[test]
    fn tangents_follow_the_edges_and_the_parallels() {
        assert_eq!(Shape::Rectangle(square()).tangent(DVec3::Z), DVec3::Y);
        let sphere = Shape::Sphere(Sphere::new(DVec3::ZERO, 1.0).unwrap());
        assert_eq!(sphere.tangent(DVec3::Z), DVec3::X);
        assert_eq!(sphere.tangent(DVec3::Y), DVec3::X);
        assert_eq!(sphere.tangent(-DVec3::Y), DVec3::X);
    }
}
