//! Turning an environment about the vertical axis.

use glam::DVec3;

/// A rotation about +y. Positive angles turn counter-clockwise seen from above: from +z towards +x.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Heading {
    sine: f64,
    cosine: f64,
}

impl Heading {
    /// A rotation by the angle with this sine and cosine.
    pub fn new(sine: f64, cosine: f64) -> Self {
        Self { sine, cosine }
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
        let quarter = Heading::new(1.0, 0.0);
        let direction = DVec3::new(0.3, -0.5, 0.8);
        let turned = |times: usize| (0..times).fold(direction, |direction, _| quarter.to_scene(direction));
        assert_eq!(turned(1), DVec3::new(0.8, -0.5, -0.3), "from +z towards +x");
        assert_eq!(turned(2), DVec3::new(-0.3, -0.5, -0.8));
        assert_eq!((turned(4), Heading::new(0.0, 1.0).to_scene(direction)), (direction, direction));
    }

    #[test]
    fn any_angle_turns_there_and_back() {
        for step in -50..50 {
            let degrees = 13.7 * f64::from(step);
            let (x, z) = degrees.to_radians().sin_cos();
            let heading = Heading::new(x, z);
            // The right-hand rule: +z turns by the angle towards +x.
            assert!(heading.to_scene(DVec3::Z).abs_diff_eq(DVec3::new(x, 0.0, z), 1e-13), "{degrees}");
            let direction = DVec3::new(0.6, 0.48, -0.64);
            assert!(heading.to_map(heading.to_scene(direction)).abs_diff_eq(direction, 1e-15), "{degrees}");
        }
    }
}
