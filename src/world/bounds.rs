//! Bounding boxes along the axes of the world.

use glam::DVec3;

/// The smallest box that holds something.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bounds {
    /// The lowest coordinates.
    pub low: DVec3,
    /// The highest coordinates.
    pub high: DVec3,
}

impl Bounds {
    /// The box of two boxes.
    #[must_use]
    pub fn union(self, other: Self) -> Self {
        Self { low: self.low.min(other.low), high: self.high.max(other.high) }
    }

    /// The box around points. Without points, it is inside out.
    #[must_use]
    pub(super) fn of_points(points: impl Iterator<Item = DVec3>) -> Self {
        let none = Self { low: DVec3::INFINITY, high: DVec3::NEG_INFINITY };
        points.fold(none, |bounds, point| Self { low: bounds.low.min(point), high: bounds.high.max(point) })
    }

    /// The distance from corner to corner.
    pub fn diagonal(&self) -> f64 {
        (self.high - self.low).length()
    }
}
