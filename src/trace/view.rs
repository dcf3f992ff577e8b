//! The settings of tracing: picture size, depth, shadows, default index of refraction; and the primary ray of each
//! pixel (thesis 3.2.1, 8.4).

use crate::sampling::{Route, SampleKey, pixel_point};
use crate::scene::Camera;
use crate::world::Ray;

/// The largest width and height in pixels. The number of pixels always fits 32 bits.
pub const MAX_SIDE: u32 = 32_768;
/// The largest depth of the tree of rays.
pub const MAX_DEPTH: u32 = 9;
/// The most passes that a picture is the mean of.
pub const MAX_PASSES: u32 = 65_536;

/// How a scene is traced. It cannot be built with values out of range.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct View {
    width: u32,
    height: u32,
    depth: u32,
    shadows: bool,
    default_index: f64,
    pass: u32,
}

/// Why there is no such view.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum ViewError {
    /// Width or height is 0 or beyond [`MAX_SIDE`].
    #[error("the picture is {0}×{1} pixels; both must be within 1 to {MAX_SIDE}")]
    Size(u32, u32),
    /// The depth is 0 or beyond [`MAX_DEPTH`].
    #[error("the depth is {0}; it must be within 1 to {MAX_DEPTH}")]
    Depth(u32),
    /// The default index is not a positive number up to 1e30.
    #[error("the default refractive index is {0}; it must be greater than 0")]
    Index(f64),
}

impl View {
    /// A view of `width` × `height` pixels (1..=[`MAX_SIDE`] each), depth 5, with shadow rays, default index 1.5, and
    /// rays through the centres of pixels.
    ///
    /// # Errors
    /// A size out of range.
    pub fn new(width: u32, height: u32) -> Result<Self, ViewError> {
        let sides = 1..=MAX_SIDE;
        if !sides.contains(&width) || !sides.contains(&height) {
            return Err(ViewError::Size(width, height));
        }
        Ok(Self { width, height, depth: 5, shadows: true, default_index: 1.5, pass: 0 })
    }

    /// The same with trees of rays up to `depth` (1..=[`MAX_DEPTH`]; 1: no reflections or refractions).
    ///
    /// # Errors
    /// A depth out of range.
    pub fn with_depth(self, depth: u32) -> Result<Self, ViewError> {
        if (1..=MAX_DEPTH).contains(&depth) { Ok(Self { depth, ..self }) } else { Err(ViewError::Depth(depth)) }
    }

    /// The same with shadow rays on or off; without them every light reaches every hit.
    #[must_use]
    pub fn with_shadows(self, shadows: bool) -> Self {
        Self { shadows, ..self }
    }

    /// The same with that index of refraction for bodies that give none.
    ///
    /// # Errors
    /// An index that is not within 1e-30 to 1e30, as those of bodies are.
    pub fn with_default_index(self, default_index: f64) -> Result<Self, ViewError> {
        if (1e-30..=1e30).contains(&default_index) {
            Ok(Self { default_index, ..self })
        } else {
            Err(ViewError::Index(default_index))
        }
    }

    /// The same for another pass of the picture, counted from 0. In each pass a ray goes through another point of its
    /// pixel, in the first one through the centre; and hits take other samples of lights. A smooth picture is the mean
    /// of passes 0, 1, 2 and so on.
    #[must_use]
    pub fn with_pass(self, pass: u32) -> Self {
        Self { pass, ..self }
    }

    /// Pixels in a row.
    pub fn width(&self) -> u32 {
        self.width
    }

    /// Rows of pixels.
    pub fn height(&self) -> u32 {
        self.height
    }

    /// The number of pixels.
    pub fn pixels(&self) -> u32 {
        self.width * self.height
    }

    /// The largest depth of a hit; that of the primary ray is 1.
    pub fn depth(&self) -> u32 {
        self.depth
    }

    /// Whether shadow rays are sent.
    pub fn shadows(&self) -> bool {
        self.shadows
    }

    /// The index of refraction of bodies that give none.
    pub fn default_index(&self) -> f64 {
        self.default_index
    }

    /// The pass of the picture, counted from 0.
    pub fn pass(&self) -> u32 {
        self.pass
    }

    /// Which samples a hit takes, by its pixel and the route to it.
    #[inline]
    pub fn sample_key(&self, pixel: u32, route: Route) -> SampleKey {
        SampleKey { pass: self.pass, pixel, route }
    }

    /// The primary ray of a pixel, counted row by row from the top left, in world coordinates. Pixels are square, and
    /// the camera's angle of view spans the height of the picture.
    pub fn primary_ray(&self, camera: &Camera, pixel: u32) -> Ray {
        let (width, height) = (f64::from(self.width), f64::from(self.height));
        let [x, y] = pixel_point(self.pass, pixel);
        let column = f64::from(pixel % self.width) + x;
        let row = f64::from(pixel / self.width) + y;
        let (x, y) = ((2.0 * column - width) / height, (height - 2.0 * row) / height);
        Ray { origin: camera.position(), direction: camera.direction(x, y), leaves: None }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    #[test]
    fn pixels_are_square_and_the_angle_spans_the_height() {
        let camera = Camera::new(DVec3::ZERO, DVec3::NEG_Z, DVec3::Y, 90.0).unwrap();
        let view = View::new(4, 2).unwrap();
        let through = |view: View, pixel| {
            let direction = view.primary_ray(&camera, pixel).direction;
            (direction / -direction.z).truncate()
        };
        assert!(through(view, 0).abs_diff_eq([-1.5, 0.5].into(), 1e-15));
        assert!(through(view, 7).abs_diff_eq([1.5, -0.5].into(), 1e-15));
        // The rays of later passes go through other points of the same pixel. Their mean is near the centre.
        let passes = (1..=64).map(|pass| through(view.with_pass(pass), 7)).collect::<Vec<_>>();
        assert!(passes.iter().all(|point| (1.0..2.0).contains(&point.x) && (-1.0..0.0).contains(&point.y)), "{passes:?}");
        let mean = passes.iter().fold(glam::DVec2::ZERO, |sum, point| sum + point / 64.0);
        assert!(mean.abs_diff_eq([1.5, -0.5].into(), 0.02), "{mean}");
    }

    #[test]
    fn values_out_of_range_are_refused() {
        assert_eq!(View::new(0, 5), Err(ViewError::Size(0, 5)));
        assert_eq!(View::new(5, MAX_SIDE + 1), Err(ViewError::Size(5, MAX_SIDE + 1)));
        let view = View::new(MAX_SIDE, MAX_SIDE).unwrap();
        assert_eq!(view.pixels(), 1 << 30);
        assert_eq!(view.with_depth(0), Err(ViewError::Depth(0)));
        assert_eq!(view.with_depth(10), Err(ViewError::Depth(10)));
        assert!(view.with_default_index(f64::NAN).is_err());
    }
}
