//! The frame of a tree: coordinates in which everything lies within −1..1, and rays in these coordinates.

use crate::bvh::shear::Shear;
use glam::DVec3;

/// By how much boxes are enlarged on each side, in the coordinates of the frame.
///
/// Coordinates and directions are rounded to 24 bits. A point on a ray that is inside the frame is then off by less
/// than a dozen units of the last place of 1, which are 6e-8 each.
pub(super) const PADDING: f32 = 2e-6;

/// A frame keeps its origin, and so all bits of coordinates, if these are at most this many times half the size.
const FARTHEST: f64 = 4.0;

/// Coordinates in which the box of all that a tree holds is within −1..1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct TreeFrame {
    center: DVec3,
    /// Units of the frame in one unit outside: a power of two.
    scale: f64,
    /// The box of all, in the coordinates of the frame, with padding.
    low: DVec3,
    high: DVec3,
}

/// A ray in the coordinates of a frame. It starts where the original one enters the box of the frame, so its
/// coordinates are small and the same for any distance of the camera.
#[derive(Debug, Clone, Copy)]
pub(super) struct FrameRay {
    pub(super) origin: [f32; 3],
    /// One divided by the components of the direction, the largest of which is ±1. All are finite.
    pub(super) inverse: [f32; 3],
    /// What was cut off in front of the origin, in lengths of the direction here.
    start: f64,
    /// The length of the original direction in lengths of the direction here.
    length: f64,
}

impl TreeFrame {
    /// The frame for this box: its lowest and its highest coordinates.
    pub(super) fn new([low, high]: [DVec3; 2]) -> Self {
        // Not the difference: of the largest numbers it would be infinite.
        let (middle, half) = (low.midpoint(high), (0.5 * high - 0.5 * low).max_element());
        let farthest = low.abs().max(high.abs()).max_element();
        let (center, reach) = if farthest <= FARTHEST * half { (DVec3::ZERO, farthest) } else { (middle, half) };
        let scale = if reach > 0.0 { (-reach.log2().ceil()).exp2() } else { 1.0 };
        let padding = DVec3::splat(f64::from(PADDING));
        Self { center, scale, low: (low - center) * scale - padding, high: (high - center) * scale + padding }
    }

    /// Whether [`point`](Self::point) does not round.
    pub(super) fn point_is_exact(&self) -> bool {
        self.center == DVec3::ZERO
    }

    /// How long a unit of the frame is.
    #[inline(always)]
    pub(super) fn unit(&self) -> f64 {
        1.0 / self.scale
    }

    /// A point in the coordinates of the frame.
    #[inline(always)]
    pub(super) fn point(&self, point: DVec3) -> DVec3 {
        (point - self.center) * self.scale
    }

    /// A ray in the coordinates of the frame; `None` if it passes beside the box of the frame. `shear` belongs to it.
    /// The origin is in these coordinates already, and the direction is that of the ray outside.
    #[inline(always)]
    pub(super) fn ray(&self, origin: DVec3, direction: DVec3, shear: &Shear) -> Option<FrameRay> {
        let shortening = shear.factors[2].abs();
        let direction = direction * shortening;
        let inverse = direction.recip();
        let is_inside = origin.cmpge(self.low).all() && origin.cmple(self.high).all();
        let start = if is_inside { 0.0 } else { self.entry(origin, inverse)? };
        let origin = (origin + start * direction).as_vec3().to_array();
        let inverse = [bounded(inverse.x), bounded(inverse.y), bounded(inverse.z)];
        Some(FrameRay { origin, inverse, start, length: self.scale / shortening })
    }

    /// The same for a direction of unit length and an origin outside. It costs less: most of it is computed in f32.
    #[inline(always)]
    pub(super) fn unit_ray(&self, origin: DVec3, direction: DVec3) -> Option<FrameRay> {
        let from = self.point(origin);
        let (mut origin, mut start) = (narrow(from), 0.0);
        // Beside the box of the frame, coordinates may be as large as inside.
        if !origin.iter().all(|coordinate| coordinate.abs() <= 1.0 + PADDING) {
            start = self.entry(from, direction.recip())?;
            origin = narrow(from + start * direction);
        }
        let inverse = narrow(direction).map(|component| component.recip().clamp(-STEEPEST, STEEPEST));
        Some(FrameRay { origin, inverse, start, length: self.scale })
    }

    /// The distance at which a ray from outside enters the box of the frame; `None` if it passes beside.
    #[inline(always)]
    fn entry(&self, origin: DVec3, inverse: DVec3) -> Option<f64> {
        // The largest distance of a near side, and the smallest one of a far side.
        let (one, other) = ((self.low - origin) * inverse, (self.high - origin) * inverse);
        let (near, far) = (one.min(other).max_element(), one.max(other).min_element());
        // NaN, on a side and along it, is passed on to the tree.
        (!(near > far || far < 0.0)).then(|| near.max(0.0))
    }
}

#[inline(always)]
fn narrow(vector: DVec3) -> [f32; 3] {
    [vector.x as f32, vector.y as f32, vector.z as f32]
}

/// The most that one divided by a component of a direction may be.
const STEEPEST: f32 = 1e18;

/// A number as f32. Its product with a coordinate is finite.
#[inline(always)]
fn bounded(inverse: f64) -> f32 {
    inverse.clamp(f64::from(-STEEPEST), f64::from(STEEPEST)) as f32
}

impl FrameRay {
    /// A distance, in lengths of the original direction, as a limit in the frame. It is never too small.
    #[inline(always)]
    pub(super) fn limit(&self, distance: f64) -> f32 {
        // More is added than rounding to f32 can take away.
        let limit = distance * self.length - self.start;
        (limit + limit.abs() * f64::from(f32::EPSILON)) as f32
    }
}
