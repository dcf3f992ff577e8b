//! The pinhole camera: where it stands, where it looks, and the frame of directions that follows (thesis 9.3.1).
//!
//! Pixels are not known here; see [`crate::trace::View`].

use crate::scene::{MIN_LENGTH, is_within_reach};
use glam::DVec3;

/// The sine of the least angle between gaze and up: below it, "up" does not say which way is up.
const LEAST_SINE: f64 = 1e-9;

/// A camera. It cannot be built with a frame that does not exist.
#[derive(Debug, Clone, PartialEq)]
pub struct Camera {
    position: DVec3,
    gaze: DVec3,
    up: DVec3,
    fov: f64,
    frame: Frame,
}

/// The image plane: `forward` leads from the camera to its middle, one unit away; `right` and `above` lead from there to the
/// right, and to its upper edge.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Frame {
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
    /// The gaze is no direction.
    #[error("the gaze of the camera is zero")]
    NoGaze,
    /// The up vector is no direction.
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
    /// A camera at `position` that looks along `gaze`, with `up` upwards in the picture (of any length, not necessarily
    /// perpendicular), and the vertical angle of view `fov` in degrees, 0 < fov < 180.
    ///
    /// # Errors
    /// Numbers beyond [`MAX_COORDINATE`](crate::scene::MAX_COORDINATE), directions that are zero or parallel, and angles out of range.
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
        if across.length() < LEAST_SINE {
            return Err(CameraError::Parallel);
        }
        let right = across.normalize();
        let half = (fov.to_radians() / 2.0).tan();
        let frame = Frame { forward, right: half * right, above: half * right.cross(forward) };
        Ok(Self { position, gaze, up, fov, frame })
    }

    /// Where it stands.
    pub fn position(&self) -> DVec3 {
        self.position
    }

    /// Where it looks, as given.
    pub fn gaze(&self) -> DVec3 {
        self.gaze
    }

    /// What is up in the picture, as given.
    pub fn up(&self) -> DVec3 {
        self.up
    }

    /// The vertical angle of view in degrees.
    pub fn fov(&self) -> f64 {
        self.fov
    }

    /// The unit direction to the point (`x`, `y`) of the image plane: (0, 0) is the middle of the picture, `y` is 1 at its
    /// upper edge, and `x` grows to the right in the same unit.
    pub fn direction(&self, x: f64, y: f64) -> DVec3 {
        (self.frame.forward + x * self.frame.right + y * self.frame.above).normalize()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_frame_is_right_handed() {
        let camera = Camera::new(DVec3::ZERO, -3.0 * DVec3::Z, DVec3::new(0.0, 2.0, 1.0), 90.0).unwrap();
        assert!(camera.direction(0.0, 0.0).abs_diff_eq(-DVec3::Z, 1e-15));
        assert!(camera.direction(1.0, 0.0).abs_diff_eq(DVec3::new(1.0, 0.0, -1.0).normalize(), 1e-15));
        assert!(camera.direction(0.0, 1.0).abs_diff_eq(DVec3::new(0.0, 1.0, -1.0).normalize(), 1e-15));
    }

    #[test]
    fn cameras_without_a_frame_are_refused() {
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
