//! The axes of bodies that are round about an axis: discs, cylinders, cones.

use crate::world::bounds::Bounds;
use glam::{DAffine3, DVec3};
use std::f64::consts::TAU;

/// If the sine of the angle between an axis and the y axis is less than this, they count as parallel.
const PARALLEL: f64 = 1e-12;

/// Three perpendicular directions of unit length, right-handed: towards longitude 0, towards a quarter turn, and along
/// the axis.
///
/// The longitude is 0 in the direction normalize(<0,1,0> × axis). If the axis is parallel to y, it is 0 towards +z, as
/// on spheres. Seen from the tip of the axis, it grows counter-clockwise.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct AxisFrame {
    zero: DVec3,
    quarter: DVec3,
    axis: DVec3,
}

impl AxisFrame {
    /// The frame about an axis of unit length.
    pub(super) fn about(axis: DVec3) -> Self {
        let across = DVec3::Y.cross(axis);
        let zero = if across.length() < PARALLEL { DVec3::Z } else { across.normalize() };
        let quarter = axis.cross(zero).normalize();
        Self { zero: quarter.cross(axis).normalize(), quarter, axis }
    }

    /// The axis, of unit length.
    pub(super) fn axis(&self) -> DVec3 {
        self.axis
    }

    /// The components of a vector along the three directions. The last one is along the axis.
    pub(super) fn components(&self, vector: DVec3) -> DVec3 {
        DVec3::new(vector.dot(self.zero), vector.dot(self.quarter), vector.dot(self.axis))
    }

    /// The vector of these components.
    pub(super) fn vector(&self, components: DVec3) -> DVec3 {
        components.x * self.zero + components.y * self.quarter + components.z * self.axis
    }

    /// The surface coordinates of a point with these components on a wall of this height: the longitude as a part of a
    /// turn, 0 on the axis, and the share of the height.
    pub(super) fn wall_coordinates(components: DVec3, height: f64) -> [f64; 2] {
        [turns(components.y.atan2(components.x)), (components.z / height).clamp(0.0, 1.0)]
    }

    /// The same on a disc of this radius, with the share of the radius.
    pub(super) fn disc_coordinates(components: DVec3, radius: f64) -> [f64; 2] {
        [turns(components.y.atan2(components.x)), (components.x.hypot(components.y) / radius).min(1.0)]
    }

    /// The direction in which the longitude grows at a point with these components. On the axis, it is that at
    /// longitude 0.
    pub(super) fn along_parallel(&self, components: DVec3) -> DVec3 {
        let across = DVec3::new(-components.y, components.x, 0.0);
        across.try_normalize().map_or(self.quarter, |across| self.vector(across))
    }

    /// The box around a circle about the axis that is transformed by `map`.
    pub(super) fn circle_bounds(&self, center: DVec3, radius: f64, map: &DAffine3) -> Bounds {
        let [zero, quarter] = [self.zero, self.quarter].map(|across| map.transform_vector3(across));
        let reach = radius * (zero * zero + quarter * quarter).map(f64::sqrt);
        let center = map.transform_point3(center);
        Bounds { low: center - reach, high: center + reach }
    }
}

/// An angle in radians as a part of a turn, at least 0 and less than 1.
pub(super) fn turns(angle: f64) -> f64 {
    let turns = angle.rem_euclid(TAU) / TAU;
    // A tiny negative angle is rounded to a whole turn.
    if turns < 1.0 { turns } else { 0.0 }
}
