//! The exact test of a ray and a triangle, in f64 and without gaps.
//!
//! After S. Woop, C. Benthin, I. Wald: "Watertight Ray/Triangle Intersection", Journal of Computer Graphics Techniques
//! 2(1), 2013. The corners are moved and sheared so that the ray is the z axis. Then the triangle is met if the origin
//! lies on the same side of its three edges. Two triangles that share an edge compute the same sheared corners and the
//! same products for it, so a ray never passes between them.

use glam::DVec3;

/// Where a ray meets a triangle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TriangleHit {
    /// The number of the triangle.
    pub triangle: u32,
    /// The distance from the origin of the ray in lengths of its direction. It may be negative.
    pub distance: f64,
    /// The share of each corner in the point that is met. Their sum is 1.
    pub weights: [f64; 3],
}

/// A ray for tests with triangles.
#[derive(Debug, Clone, Copy)]
pub(super) struct Shear {
    origin: [f64; 3],
    /// The axes: the last one is that of the largest component of the direction.
    pub(super) axes: [usize; 3],
    /// By how much the first two components move with the last one; and one divided by the last component of the
    /// direction.
    pub(super) factors: [f64; 3],
}

impl Shear {
    #[inline(always)]
    pub(super) fn new(origin: DVec3, direction: DVec3) -> Self {
        let size = direction.abs();
        let last = if size.x >= size.y && size.x >= size.z {
            0
        } else if size.y >= size.z {
            1
        } else {
            2
        };
        let axes = [(last + 1) % 3, (last + 2) % 3, last];
        let direction = direction.to_array();
        let inverse = 1.0 / direction[last];
        Self { origin: origin.to_array(), axes, factors: [direction[axes[0]] * inverse, direction[axes[1]] * inverse, inverse] }
    }

    /// Where the ray meets the triangle, also behind its origin: the distance and the shares of the corners.
    #[inline(always)]
    pub(super) fn meet(&self, corners: [DVec3; 3]) -> Option<(f64, [f64; 3])> {
        let (a, b, c) = (self.sheared(corners[0]), self.sheared(corners[1]), self.sheared(corners[2]));
        let edges = [c[0] * b[1] - c[1] * b[0], a[0] * c[1] - a[1] * c[0], b[0] * a[1] - b[1] * a[0]];
        let [u, v, w] = edges;
        if (u < 0.0 || v < 0.0 || w < 0.0) && (u > 0.0 || v > 0.0 || w > 0.0) {
            return None;
        }
        let sum = u + v + w;
        if sum == 0.0 {
            return None;
        }
        let weights = [u / sum, v / sum, w / sum];
        let height = weights[0] * a[2] + weights[1] * b[2] + weights[2] * c[2];
        let distance = height * self.factors[2];
        distance.is_finite().then_some((distance, weights))
    }

    /// A corner, moved and sheared so that the ray is the last axis.
    #[inline(always)]
    fn sheared(&self, corner: DVec3) -> [f64; 3] {
        let [x, y, z] = self.axes;
        let corner = corner.to_array();
        let height = corner[z] - self.origin[z];
        let across = corner[x] - self.origin[x] - self.factors[0] * height;
        let along = corner[y] - self.origin[y] - self.factors[1] * height;
        [across, along, height]
    }
}

/// Where a ray meets a triangle, also behind its origin. The direction may have any length but 0.
///
/// A ray along the plane of the triangle does not meet it.
pub fn intersect_triangle(origin: DVec3, direction: DVec3, triangle: u32, corners: [DVec3; 3]) -> Option<TriangleHit> {
    let (distance, weights) = Shear::new(origin, direction).meet(corners)?;
    Some(TriangleHit { triangle, distance, weights })
}
