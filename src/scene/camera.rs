//! The pinhole camera: its position, its direction, and the image plane that follows from them (thesis 9.3.1).
//!
//! Pixels are not known here, see [`crate::trace::View`]. How a camera is led around a scene is in `camera/motion.rs`.

mod motion;

pub use motion::ViewSide;

use crate::scene::{MIN_LENGTH, is_within_reach};
use glam::DVec3;

/// The sine of the smallest angle between gaze and up. Below it, `up` does not define a direction in the image.
const MIN_SINE: f64 = 1e-9;

/// A camera. It always has an image plane: other values are refused.
#[derive(Debug, Clone, PartialEq)]
pub struct Camera {
    position: DVec3,
    gaze: DVec3,
    up: DVec3,
    fov: f64,
    plane: ImagePlane,
}

/// The image plane. `forward` leads from the camera to its middle, one unit away. From there `above` leads to its upper
/// edge, and `right`, which has the same length, to the right.
#[derive(Debug, Clone, Copy, PartialEq)]
struct ImagePlane {
    forward: DVec3,
    right: DVec3,
    above: DVec3,
}

/// Why there is no such camera.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum CameraError {
    /// The position, gaze or up is not a vector of numbers up to [`MAX_COORDINATE`](crate::scene::MAX_COORDINATE).
    #[error("a number of the camera is too large")]
    TooLarge,
    /// The gaze is zero, or too short to be a direction.
    #[error("the gaze of the camera is zero")]
    NoGaze,
    /// The up vector is zero, or too short to be a direction.
    #[error("the up vector of the camera is zero")]
    NoUp,
    /// Gaze and up are parallel.
    #[error("gaze and up are parallel")]
    Parallel,
    /// The angle is not between 0 and 180 degrees.
    #[error("the field of view must be greater than 0 and less than 180 degrees")]
    Fov,
}

impl Camera {
    /// A camera at `position` that looks along `gaze`, with the vertical angle of view `fov` in degrees, 0 < fov < 180.
    /// `up` points upwards in the picture. It may have any length, and need not be perpendicular to the gaze.
    ///
    /// # Errors
    /// Numbers beyond [`MAX_COORDINATE`](crate::scene::MAX_COORDINATE), directions that are zero or parallel, and
    /// angles out of range.
    pub fn new(position: DVec3, gaze: DVec3, up: DVec3, fov: f64) -> Result<Self, CameraError> {
        if ![position, gaze, up].into_iter().all(is_within_reach) {
            return Err(CameraError::TooLarge);
        }
        if gaze.length() < MIN_LENGTH {
            return Err(CameraError::NoGaze);
        }
        if up.length() < MIN_LENGTH {
            return Err(CameraError::NoUp);
        }
        if !(fov > 0.0 && fov < 180.0) {
            return Err(CameraError::Fov);
        }
        let forward = gaze.normalize();
        let across = forward.cross(up.normalize());
        if across.length() < MIN_SINE {
            return Err(CameraError::Parallel);
        }
        let right = across.normalize();
        let half = (fov.to_radians() / 2.0).tan();
        let plane = ImagePlane { forward, right: half * right, above: half * right.cross(forward) };
        Ok(Self { position, gaze, up, fov, plane })
    }

    /// Its position in world coordinates.
    pub fn position(&self) -> DVec3 {
        self.position
    }

    /// The direction in which it looks, as given: of any length.
    pub fn gaze(&self) -> DVec3 {
        self.gaze
    }

    /// The direction that is up in the picture, as given: of any length.
    pub fn up(&self) -> DVec3 {
        self.up
    }

    /// The vertical angle of view in degrees, more than 0 and less than 180.
    pub fn fov(&self) -> f64 {
        self.fov
    }

    /// The unit direction to the point (`x`, `y`) of the image plane: (0, 0) is the middle of the picture, `y` is 1 at
    /// its upper edge, and `x` grows to the right in the same unit.
    pub fn direction(&self, x: f64, y: f64) -> DVec3 {
        (self.plane.forward + x * self.plane.right + y * self.plane.above).normalize()
    }

    /// The point of the scene at a depth, in world units, that is seen at (`x`, `y`) of the image plane. The depth is
    /// measured along the gaze.
    pub fn point_at(&self, [x, y]: [f64; 2], depth: f64) -> DVec3 {
        self.position + depth * (self.plane.forward + x * self.plane.right + y * self.plane.above)
    }

    /// How far a point lies before the camera, along the gaze, in world units. Negative behind it.
    pub fn depth_of(&self, point: DVec3) -> f64 {
        (point - self.position).dot(self.plane.forward)
    }

    /// Where a point is seen in the image plane; `None` unless it is before the camera.
    pub fn project(&self, point: DVec3) -> Option<[f64; 2]> {
        let depth = self.depth_of(point);
        let scale = depth * self.plane.right.length_squared();
        let offset = point - self.position;
        let seen = [offset.dot(self.plane.right) / scale, offset.dot(self.plane.above) / scale];
        (depth > 0.0 && seen.iter().all(|coordinate| coordinate.is_finite())).then_some(seen)
    }

    /// The directions to the right, upwards and forwards in the picture, of unit length.
    pub fn axes(&self) -> [DVec3; 3] {
        [self.plane.right.normalize(), self.plane.above.normalize(), self.plane.forward]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_image_plane_is_right_handed() {
        let camera = Camera::new(DVec3::ZERO, -3.0 * DVec3::Z, DVec3::new(0.0, 2.0, 1.0), 90.0).unwrap();
        assert!(camera.direction(0.0, 0.0).abs_diff_eq(-DVec3::Z, 1e-15));
        assert!(camera.direction(1.0, 0.0).abs_diff_eq(DVec3::new(1.0, 0.0, -1.0).normalize(), 1e-15));
        assert!(camera.direction(0.0, 1.0).abs_diff_eq(DVec3::new(0.0, 1.0, -1.0).normalize(), 1e-15));
    }

    #[test]
    fn a_point_is_projected_to_where_it_is_seen() {
        let camera = Camera::new(DVec3::new(1.0, 2.0, 3.0), DVec3::new(0.5, -0.3, -2.0), DVec3::Y, 50.0).unwrap();
        let point = camera.point_at([0.7, -0.4], 6.0);
        assert!((camera.depth_of(point) - 6.0).abs() < 1e-12);
        let [x, y] = camera.project(point).unwrap();
        assert!((x - 0.7).abs() < 1e-12 && (y + 0.4).abs() < 1e-12);
        assert!((point - camera.position()).normalize().abs_diff_eq(camera.direction(0.7, -0.4), 1e-12));
        assert_eq!(camera.project(camera.point_at([0.7, -0.4], -6.0)), None);
        assert_eq!(camera.project(camera.position()), None);
    }

    #[test]
    fn cameras_without_an_image_plane_are_refused() {
        let new = |gaze, up, fov| Camera::new(DVec3::ZERO, gaze, up, fov).err();
        assert_eq!(new(DVec3::ZERO, DVec3::Y, 45.0), Some(CameraError::NoGaze));
        assert_eq!(new(DVec3::X, DVec3::ZERO, 45.0), Some(CameraError::NoUp));
        assert_eq!(new(DVec3::X, -2.0 * DVec3::X, 45.0), Some(CameraError::Parallel));
        assert_eq!(new(DVec3::X, DVec3::Y, 180.0), Some(CameraError::Fov));
        assert_eq!(new(DVec3::X, DVec3::Y, f64::NAN), Some(CameraError::Fov));
        assert_eq!(new(1e31 * DVec3::X, DVec3::Y, 45.0), Some(CameraError::TooLarge));
        assert_eq!(new(1e30 * DVec3::X, 1e-30 * DVec3::Y, 45.0), None);
    }
}
