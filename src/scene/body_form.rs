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
    fn since_fit(&self) -> (Option<(DVec3, f64)>, &[Transform]) {
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
    fn map(transforms: &[Transform]) -> DAffine3 {
        transforms.iter().filter_map(Transform::map).fold(DAffine3::IDENTITY, |map, next| next * map)
    }

    /// The point that stands for the body, in world coordinates: that of the shape, or the middle of the box of a
    /// `fit`, as it is moved by the transforms behind. `None` if it is nowhere in particular.
    pub fn anchor(&self) -> Option<DVec3> {
        let (fit, transforms) = self.since_fit();
        let point = fit.map(|(center, _)| center).or_else(|| self.shape.anchor())?;
        Some(Self::map(transforms).transform_point3(point))
    }

    /// The same, moved by a vector in world units; `None` if it would be too far away.
    ///
    /// A shape that is not transformed is moved itself. Otherwise the last transform moves the body, or one that is
    /// added.
    pub fn moved(&self, by: DVec3) -> Option<Self> {
        let mut form = self.clone();
        match form.transforms.last_mut() {
            // A mesh is where its file says.
            None if form.shape.mesh().is_some() => form.transforms.push(Transform::Translate(by)),
            None => form.shape = form.shape.moved(by)?,
            Some(Transform::Translate(place) | Transform::Fit { center: place, .. }) => *place += by,
            Some(Transform::Scale(_) | Transform::Stretch(_) | Transform::Rotate { .. }) => {
                form.transforms.push(Transform::Translate(by));
            }
        }
        form.checked()
    }

    /// The same, larger by a factor greater than 0, with the anchor where it is; `None` if it has no size, or if it
    /// would be too large or too small.
    pub fn scaled(&self, by: f64) -> Option<Self> {
        let mut form = self.clone();
        let fit = form.transforms.iter_mut().rev().find_map(|transform| match transform {
            Transform::Fit { size, .. } => Some(size),
            Transform::Scale(_) | Transform::Stretch(_) | Transform::Rotate { .. } | Transform::Translate(_) => None,
        });
        match fit {
            Some(size) => *size *= by,
            // The transforms behind enlarge the larger shape about the place of its anchor.
            None => form.shape = form.shape.scaled(by)?,
        }
        form.checked()
    }

    /// The form, if every value of its transforms is within the reach of scenes.
    fn checked(self) -> Option<Self> {
        let sound = |transform: &Transform| match transform {
            Transform::Translate(by) => is_within_reach(*by),
            Transform::Fit { center, size } => is_within_reach(*center) && (MIN_LENGTH..=MAX_COORDINATE).contains(size),
            Transform::Scale(_) | Transform::Stretch(_) | Transform::Rotate { .. } => true,
        };
        let product = self.transforms.iter().try_fold(CombinedTransform::NONE, |product, transform| product.then(transform));
        (self.transforms.iter().all(sound) && product.is_ok()).then_some(self)
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

    #[test]
    fn a_body_is_moved_by_its_last_transform() {
        let by = DVec3::new(0.5, -2.0, 8.0);
        for (text, moved) in [
            ("", ""),
            (", rotate <0, 1, 0> 30", ", rotate <0, 1, 0> 30, translate <0.5, -2, 8>"),
            (", scale 2, translate <1, 1, 1>", ", scale 2, translate <1.5, -1, 9>"),
            (", fit <1, 1, 1> 3", ", fit <1.5, -1, 9> 3"),
            (", fit <1, 1, 1> 3, scale <1, 2, 3>", ", fit <1, 1, 1> 3, scale <1, 2, 3>, translate <0.5, -2, 8>"),
        ] {
            let form = form(&format!("{BALL}{text}"));
            let found = form.moved(by).unwrap();
            let ball = if text.is_empty() { "sphere, center <1.5, -2, 8>, radius 2" } else { BALL };
            assert_eq!(found.to_string(), format!("{ball}{moved}"));
            assert!(found.anchor().unwrap().abs_diff_eq(form.anchor().unwrap() + by, 1e-12));
            assert_eq!(form.moved(DVec3::splat(2e30)), None);
        }
    }

    #[test]
    fn a_transformed_body_is_resized_about_its_anchor() {
        for text in [", rotate <0, 1, 0> 30, scale <1, 2, 3>", ", fit <1, 1, 1> 3, translate <1, 0, 0>", ", translate <9, 0, 0>"]
        {
            let form = form(&format!("{BALL}{text}"));
            let larger = form.scaled(2.0).unwrap();
            assert_eq!((larger.anchor(), larger.radius()), (form.anchor(), form.radius().map(|radius| 2.0 * radius)), "{text}");
            assert_eq!(larger.transforms.len(), form.transforms.len());
            assert_eq!(form.scaled(1e-40), None);
        }
    }
}
