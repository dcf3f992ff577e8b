//! The form of a body: its shape, and the transforms that follow it.

use crate::scene::{MAX_COORDINATE, MIN_LENGTH, Shape, Transform, is_within_reach};
use glam::{DAffine3, DVec3};
use std::fmt::{Display, Formatter, Result as FmtResult};

/// A shape and what happens to it, step by step.
///
/// `Display` prints it in the scene language.
#[derive(Debug, Clone, PartialEq)]
pub struct BodyForm {
    /// The shape.
    pub shape: Shape,
    /// The transforms in the order in which they are applied.
    pub transforms: Vec<Transform>,
}

/// Why a body cannot be transformed like that.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub(super) enum TransformError {
    /// The transforms together enlarge or move it by more than [`MAX_COORDINATE`].
    #[error("the transforms together make the body too large, or move it too far")]
    TooLarge,
    /// The transforms together make it smaller by more than [`MIN_LENGTH`].
    #[error("the transforms together make the body too small")]
    TooSmall,
}

/// What transforms do together. `fit` gives a body a size and a place of its own, whatever was before.
#[derive(Debug, Clone, Copy)]
pub(super) struct CombinedTransform(DAffine3);

impl CombinedTransform {
    /// No transform.
    pub(super) const NONE: CombinedTransform = CombinedTransform(DAffine3::IDENTITY);

    /// With one more transform.
    ///
    /// # Errors
    /// The body would be beyond the reach of scenes.
    pub(super) fn then(self, transform: &Transform) -> Result<Self, TransformError> {
        let Some(map) = transform.map() else { return Ok(Self::NONE) };
        let product = map * self.0;
        let lengths = [product.x_axis, product.y_axis, product.z_axis].map(|axis: DVec3| axis.length());
        if !(lengths.iter().all(|length| *length <= MAX_COORDINATE) && is_within_reach(product.translation)) {
            return Err(TransformError::TooLarge);
        }
        if lengths.iter().any(|length| *length < MIN_LENGTH) {
            return Err(TransformError::TooSmall);
        }
        Ok(Self(product))
    }
}

impl From<Shape> for BodyForm {
    /// A shape that is not transformed.
    fn from(shape: Shape) -> Self {
        Self { shape, transforms: Vec::new() }
    }
}

impl BodyForm {
    /// The transforms from the last `fit` on, and that `fit`.
    pub(super) fn since_fit(&self) -> (Option<(DVec3, f64)>, &[Transform]) {
        let fits = self.transforms.iter().enumerate().rev();
        let last = fits.filter_map(|(index, transform)| match transform {
            Transform::Fit { center, size } => Some((index, *center, *size)),
            Transform::Scale(_) | Transform::Stretch(_) | Transform::Rotate { .. } | Transform::Translate(_) => None,
        });
        match last.into_iter().next() {
            Some((index, center, size)) => (Some((center, size)), &self.transforms[index + 1..]),
            None => (None, &self.transforms),
        }
    }

    /// What the transforms behind the last `fit` do.
    pub(super) fn map(transforms: &[Transform]) -> DAffine3 {
        transforms.iter().filter_map(Transform::map).fold(DAffine3::IDENTITY, |map, next| next * map)
    }

    /// The point that stands for the body, in world coordinates: that of the shape, or the middle of the box of a
    /// `fit`, as it is moved by the transforms behind. `None` if it is nowhere in particular.
    pub fn anchor(&self) -> Option<DVec3> {
        let (fit, transforms) = self.since_fit();
        let point = fit.map(|(center, _)| center).or_else(|| self.shape.anchor())?;
        Some(Self::map(transforms).transform_point3(point))
    }

    /// Its radius in world units, if it has one. That of a stretched body is a mean one.
    pub fn radius(&self) -> Option<f64> {
        let (fit, transforms) = self.since_fit();
        let radius = fit.map(|(_, size)| size / 2.0).or_else(|| self.shape.radius())?;
        Some(radius * Self::map(transforms).matrix3.determinant().abs().cbrt())
    }
}

impl Display for BodyForm {
    fn fmt(&self, f: &mut Formatter<'_>) -> FmtResult {
        write!(f, "{}", self.shape)?;
        self.transforms.iter().try_for_each(|transform| write!(f, ", {transform}"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lang::source::Source;
    use crate::scene::Scene;

    fn form(text: &str) -> BodyForm {
        let text = format!("bodies; b: {text}; lights; camera; position <0, 0, 9>; gaze <0, 0, -1>; up <0, 1, 0>; fov 45;");
        Scene::parse(&Source::new("scene", text)).unwrap().0.bodies.remove(0).form
    }

    const BALL: &str = "sphere, center <1, 0, 0>, radius 2";

    #[test]
    fn the_anchor_goes_with_the_body() {
        assert_eq!(form(BALL).anchor(), Some(DVec3::X));
        let turned = form(&format!("{BALL}, scale <3, 1, 1>, rotate <0, 0, 1> 90, translate <0, 1, 0>"));
        assert_eq!(turned.anchor(), Some(DVec3::new(0.0, 4.0, 0.0)));
        let fitted = form(&format!("{BALL}, translate <5, 5, 5>, fit <1, 2, 3> 4, scale -2"));
        assert_eq!((fitted.anchor(), fitted.radius()), (Some(DVec3::new(-2.0, -4.0, -6.0)), Some(4.0)));
    }
}
