//! Where directions are in images in latitude-longitude form, also called equirectangular.
//!
//! The convention is that of OpenEXR ("Technical Introduction to OpenEXR", environment maps, `ENVMAP_LATLONG`), and of
//! the plugin `envmap` of Mitsuba. Row 0 is at the top, towards +y. The middle of the image is +z. The longitude is
//! atan2(x, z); it is 0 in the middle and grows to the left, so +x is a quarter of the width left of the middle, and
//! −z is at both edges. So the image is what somebody in the middle of the sphere sees who looks towards +z.

use glam::DVec3;
use std::f64::consts::{PI, TAU};

/// A place in an image: u from the left edge and v from the upper one, each 0..=1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct MapPlace {
    /// 0.5 − longitude / 2π.
    pub(super) u: f64,
    /// The polar angle / π.
    pub(super) v: f64,
}

impl MapPlace {
    /// The place of a direction of any length greater than 0.
    #[inline]
    pub(super) fn of(direction: DVec3) -> Self {
        let DVec3 { x, y, z } = direction;
        Self { u: 0.5 - x.atan2(z) / TAU, v: x.hypot(z).atan2(y) / PI }
    }
}

/// The direction of unit length at `u` whose polar angle has this sine and cosine.
#[inline]
pub(super) fn direction(u: f64, [sine, cosine]: [f64; 2]) -> DVec3 {
    let (x, z) = (TAU * (0.5 - u)).sin_cos();
    DVec3::new(sine * x, cosine, sine * z)
}

/// The solid angle between two rows at `v`, all around.
pub(super) fn zone(above: f64, below: f64) -> f64 {
    // The difference of two cosines, without cancellation.
    let (middle, half) = (0.5 * PI * (above + below), 0.5 * PI * (below - above));
    TAU * 2.0 * middle.sin() * half.sin()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn axes_are_where_the_convention_puts_them() {
        // From the documentation of Mitsuba's `envmap`: u = 0.25 at +x, 0.5 at +z, 0.75 at −x, 0 or 1 at −z.
        for (axis, u, v) in [(DVec3::X, 0.25, 0.5), (DVec3::Z, 0.5, 0.5), (-DVec3::X, 0.75, 0.5)] {
            assert_eq!(MapPlace::of(axis), MapPlace { u, v }, "{axis}");
            let (sine, cosine) = (PI * v).sin_cos();
            assert!(direction(u, [sine, cosine]).abs_diff_eq(axis, 1e-15), "{axis}");
        }
        assert!([0.0, 1.0].contains(&MapPlace::of(-DVec3::Z).u));
        assert_eq!([DVec3::Y, -DVec3::Y].map(|axis| MapPlace::of(axis).v), [0.0, 1.0]);
        // The length does not matter.
        assert_eq!(MapPlace::of(DVec3::new(1e20, 1e20, 0.0)), MapPlace { u: 0.25, v: 0.25 });
    }

    #[test]
    fn zones_have_the_solid_angles_of_archimedes() {
        // A zone of the unit sphere has the area 2π times its height.
        assert!((zone(0.0, 1.0) - 4.0 * PI).abs() < 1e-14);
        assert!((zone(0.0, 0.5) - TAU).abs() < 1e-14);
        assert!((zone(1.0 / 3.0, 0.5) - 0.5 * TAU).abs() < 1e-14);
        // A small cap is a disc.
        let radius = 1e-9 * PI;
        assert!((zone(0.0, 1e-9) / (PI * radius * radius) - 1.0).abs() < 1e-12);
    }
}
