//! The frame of a tree: coordinates in which everything lies within −1..1, and rays in these coordinates.

use crate::bvh::shear::Shear;
use glam::DVec3;

/// By how much boxes are enlarged on each side, in the coordinates of the frame.
///
/// Coordinates and directions are rounded to 24 bits. A point on a ray that is inside the frame is then off by less than
/// a dozen units of the last place of 1, which are 6e-8 each.
pub(super) const PADDING: f32 = 2e-6;

/// Coordinates in which the box of all that a tree holds is within −1..1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Frame {
    center: DVec3,
    /// Units of the frame in one unit outside.
    scale: f64,
    /// Half the size of the box in the coordinates of the frame, with padding.
    half: DVec3,
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

impl Frame {
    /// The frame for this box: its lowest and its highest coordinates.
    pub(super) fn new([low, high]: [DVec3; 2]) -> Self {
        // Not the difference: of the largest numbers it would be infinite.
        let (center, half) = (low.midpoint(high), 0.5 * high - 0.5 * low);
        let reach = half.max_element();
        let scale = if reach > 0.0 { 1.0 / reach } else { 1.0 };
        Self { center, scale, half: half * scale + DVec3::splat(f64::from(PADDING)) }
    }

    /// A point in the coordinates of the frame.
    #[inline(always)]
    pub(super) fn point(&self, point: DVec3) -> DVec3 {
        (point - self.center) * self.scale
    }

    /// A ray in the coordinates of the frame; `None` if it passes beside the box of the frame. `shear` belongs to it.
    #[inline(always)]
    pub(super) fn ray(&self, origin: DVec3, direction: DVec3, shear: &Shear) -> Option<FrameRay> {
        let origin = self.point(origin);
        let shortening = shear.factors[2].abs();
        let direction = direction * shortening;
        let inverse = direction.recip();
        let mut start = 0.0;
        if origin.abs().cmpgt(self.half).any() {
            // The largest distance of a near side, and the smallest one of a far side.
            let (one, other) = ((-self.half - origin) * inverse, (self.half - origin) * inverse);
            let (near, far) = (one.min(other).max_element(), one.max(other).min_element());
            // NaN, on a side and along it, is passed on to the tree.
            if near > far || far < 0.0 {
                return None;
            }
            start = near.max(0.0);
        }
        let origin = (origin + start * direction).as_vec3().to_array();
        let inverse = [bounded(inverse.x), bounded(inverse.y), bounded(inverse.z)];
        Some(FrameRay { origin, inverse, start, length: self.scale / shortening })
    }
}

/// A number as f32. Its product with a coordinate is finite.
#[inline(always)]
fn bounded(inverse: f64) -> f32 {
    const MOST: f64 = 1e18;
    inverse.clamp(-MOST, MOST) as f32
}

impl FrameRay {
    /// A distance, in lengths of the original direction, as a limit in the frame. It is never too small.
    #[inline(always)]
    pub(super) fn limit(&self, distance: f64) -> f32 {
        ((distance * self.length - self.start) as f32).next_up()
    }
}
