//! Turning an environment about the vertical axis.

use glam::DVec3;

/// A rotation about +y. Positive angles turn counter-clockwise seen from above: from +z towards +x.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Heading {
    sine: f64,
    cosine: f64,
}

impl Heading {
    /// No rotation.
    pub const NONE: Heading = Heading { sine: 0.0, cosine: 1.0 };

    /// A rotation by an angle in degrees, which must be finite. Quarter turns are exact.
    pub fn of_degrees(degrees: f64) -> Self {
        let within = degrees.rem_euclid(360.0);
        let quarters = (within / 90.0).round();
        let (sine, cosine) = (within - 90.0 * quarters).to_radians().sin_cos();
        match quarters as u32 {
            0 | 4 => Self { sine, cosine },
            1 => Self { sine: cosine, cosine: -sine },
            2 => Self { sine: -sine, cosine: -cosine },
            _ => Self { sine: -cosine, cosine: sine },
        }
    }

    /// A direction of the map as a direction of the scene.
    #[inline]
    pub fn to_scene(self, direction: DVec3) -> DVec3 {
        let DVec3 { x, y, z } = direction;
        DVec3::new(self.cosine * x + self.sine * z, y, self.cosine * z - self.sine * x)
    }

    /// A direction of the scene as a direction of the map.
    #[inline]
    pub fn to_map(self, direction: DVec3) -> DVec3 {
        Self { sine: -self.sine, cosine: self.cosine }.to_scene(direction)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn four_quarter_turns_are_none() {
        let quarter = Heading::of_degrees(90.0);
        let direction = DVec3::new(0.3, -0.5, 0.8);
        let turned = |times: usize| (0..times).fold(direction, |direction, _| quarter.to_scene(direction));
        assert_eq!(turned(1), DVec3::new(0.8, -0.5, -0.3), "from +z towards +x");
        assert_eq!(turned(2), DVec3::new(-0.3, -0.5, -0.8));
        assert_eq!(turned(4), direction);
        for (degrees, times) in [(180.0, 2), (-180.0, 2), (270.0, 3), (-90.0, 3), (360.0, 4), (0.0, 0), (-7200.0, 0)] {
            assert_eq!(Heading::of_degrees(degrees).to_scene(direction), turned(times), "{degrees}");
        }
        assert_eq!(Heading::of_degrees(720.0), Heading::NONE);
    }

    #[test]
    fn any_angle_turns_there_and_back() {
        for step in -50..50 {
            let degrees = 13.7 * f64::from(step);
            let heading = Heading::of_degrees(degrees);
            let direction = DVec3::new(0.0, 0.0, 1.0);
            // The right-hand rule: +z turns by the angle towards +x.
            let (x, z) = degrees.to_radians().sin_cos();
            assert!(heading.to_scene(direction).abs_diff_eq(DVec3::new(x, 0.0, z), 1e-13), "{degrees}");
            assert!(heading.to_map(heading.to_scene(direction)).abs_diff_eq(direction, 1e-15), "{degrees}");
        }
    }
}
