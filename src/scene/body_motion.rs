//! How a body is moved, turned and scaled by hand, in few transforms that are easy to read.
//!
//! A body that is turned or stretched for the first time is put at the origin, and moved to its place by a `translate`
//! behind. So every number has a meaning of its own: `box, <-1, -1, -1>, <1, 1, 1>, rotate <0, 1, 0> 30, translate <3,
//! 1, 0>`. Afterwards, its place is moved by the `translate` alone, and another turn about the same axis changes the
//! angle.

use crate::scene::body_form::{BodyForm, CombinedTransform};
use crate::scene::{MAX_COORDINATE, MIN_LENGTH, Transform, is_within_reach};
use glam::{DQuat, DVec3};

/// More turns than these in a row are written as one.
const MOST_TURNS: usize = 3;
/// Axes whose sine is less are the same.
const PARALLEL: f64 = 1e-9;
/// Places that differ by less than this part of their distance to the origin are the same.
const SAME_PLACE: f64 = 1e-12;

/// An angle in degrees between -180, exclusive, and 180.
fn wrapped(degrees: f64) -> f64 {
    let turn = degrees.rem_euclid(360.0);
    if turn > 180.0 { turn - 360.0 } else { turn }
}

/// A transform that turns by several rotations, one after the other.
fn combined(turns: &[Transform]) -> Option<Transform> {
    let all = turns.iter().fold(DQuat::IDENTITY, |all, turn| match turn {
        Transform::Rotate { axis, degrees } => DQuat::from_axis_angle(axis.normalize(), degrees.to_radians()) * all,
        Transform::Scale(_) | Transform::Stretch(_) | Transform::Translate(_) | Transform::Fit { .. } => all,
    });
    let (axis, angle) = all.to_axis_angle();
    let degrees = wrapped(angle.to_degrees());
    (degrees.abs() > 1e-9).then_some(Transform::Rotate { axis, degrees })
}

impl BodyForm {
    /// Where the transforms begin that are behind the last `fit`.
    fn behind_fit(&self) -> usize {
        self.transforms.len() - self.since_fit().1.len()
    }

    /// The directions of the body's own axes x, y and z, of unit length: those of its shape, as the transforms turn
    /// them.
    pub fn axes(&self) -> [DVec3; 3] {
        let map = Self::map(self.since_fit().1).matrix3;
        let direction = |of: DVec3, plain: DVec3| of.try_normalize().unwrap_or(plain);
        [direction(map.x_axis, DVec3::X), direction(map.y_axis, DVec3::Y), direction(map.z_axis, DVec3::Z)]
    }

    /// Whether a factor along one of its own axes, counted from 0, changes it. A flat body has none along its normal.
    pub fn has_extent_along(&self, axis: usize) -> bool {
        let normal = self.shape.flat_normal().and_then(DVec3::try_normalize);
        normal.is_none_or(|normal| normal.cross(DVec3::AXES[axis % 3]).length() > PARALLEL)
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
            None if form.shape.mesh().is_some() => return self.with_factors(DVec3::splat(by)),
            // The transforms behind enlarge the larger shape about the place of its anchor.
            None => form.shape = form.shape.scaled(by)?,
        }
        form.checked()
    }

    /// The same, turned about an axis through its anchor, counter-clockwise seen from where the axis points to; `None`
    /// if it would be too far away. `axis` is a direction of the scene.
    pub fn turned(&self, axis: DVec3, degrees: f64) -> Option<Self> {
        let anchor = self.anchor()?;
        if degrees == 0.0 {
            return Some(self.clone());
        }
        let mut form = self.centred()?;
        let place = usize::from(matches!(form.transforms.last(), Some(Transform::Translate(_))));
        let (begin, end) = (form.behind_fit(), form.transforms.len() - place);
        let last = end.checked_sub(1).filter(|last| *last >= begin).map(|last| (last, form.transforms[last]));
        match last {
            Some((last, Transform::Rotate { axis: old, degrees: by }))
                if old.normalize().cross(axis.normalize()).length() < PARALLEL =>
            {
                let degrees = wrapped(by + degrees * old.dot(axis).signum());
                if degrees.abs() < 1e-9 {
                    form.transforms.remove(last);
                } else {
                    form.transforms[last] = Transform::Rotate { axis: old, degrees };
                }
            }
            Some(_) | None => form.transforms.insert(end, Transform::Rotate { axis, degrees: wrapped(degrees) }),
        }
        form.limit_turns(begin);
        form.with_anchor(anchor)
    }

    /// Writes the last turns in a row as one if they are many.
    fn limit_turns(&mut self, begin: usize) {
        let end = self.transforms.len() - usize::from(matches!(self.transforms.last(), Some(Transform::Translate(_))));
        let is_turn = |transform: &&Transform| matches!(transform, Transform::Rotate { .. });
        let turns = self.transforms[begin.min(end)..end].iter().rev().take_while(is_turn).count();
        if turns > MOST_TURNS {
            let combined = combined(&self.transforms[end - turns..end]);
            self.transforms.splice(end - turns..end, combined);
        }
    }

    /// The same, larger by a factor along each of its own axes, with the anchor where it is; `None` if it would be too
    /// large or too small.
    pub fn stretched(&self, by: DVec3) -> Option<Self> {
        let (fit, _) = self.since_fit();
        match self.shape.stretched(by).filter(|_| fit.is_none()) {
            Some(shape) => Self { shape, transforms: self.transforms.clone() }.checked(),
            None => self.with_factors(by),
        }
    }

    /// The same with factors in a `scale`, which is the first transform behind the shape or the last `fit`.
    fn with_factors(&self, by: DVec3) -> Option<Self> {
        let anchor = self.anchor()?;
        if by == DVec3::ONE {
            return Some(self.clone());
        }
        let mut form = self.centred()?;
        let begin = form.behind_fit();
        let (written, before) = match form.transforms.get(begin) {
            Some(Transform::Scale(factor)) => (true, DVec3::splat(*factor)),
            Some(Transform::Stretch(factors)) => (true, *factors),
            Some(Transform::Rotate { .. } | Transform::Translate(_) | Transform::Fit { .. }) | None => (false, DVec3::ONE),
        };
        let factors = before * by;
        let scale = if factors.x == factors.y && factors.y == factors.z {
            Transform::Scale(factors.x)
        } else {
            Transform::Stretch(factors)
        };
        form.transforms.splice(begin..begin + usize::from(written), (factors != DVec3::ONE).then_some(scale));
        form.with_anchor(anchor)
    }

    /// The same about the origin, unless it is turned or stretched already: then its anchor is elsewhere, and what
    /// follows is to put it back.
    fn centred(&self) -> Option<Self> {
        let begin = self.behind_fit();
        if !self.transforms[begin..].iter().all(|transform| matches!(transform, Transform::Translate(_))) {
            return Some(self.clone());
        }
        let mut form = Self { shape: self.shape.clone(), transforms: self.transforms[..begin].to_vec() };
        match form.transforms.last_mut() {
            Some(Transform::Fit { center, .. }) => *center = DVec3::ZERO,
            Some(_) | None if form.shape.mesh().is_some() => {}
            Some(_) | None => form.shape = form.shape.moved(-form.shape.anchor()?)?,
        }
        Some(form)
    }

    /// The same, moved so that its anchor is at a place.
    fn with_anchor(mut self, anchor: DVec3) -> Option<Self> {
        let reach = anchor.abs().max_element().max(MIN_LENGTH) * SAME_PLACE;
        let by = (anchor - self.anchor()?).map(|part| if part.abs() <= reach { 0.0 } else { part });
        if by == DVec3::ZERO {
            return self.checked();
        }
        self = self.moved(by)?;
        if let Some(Transform::Translate(place)) = self.transforms.last_mut() {
            // Without what rounding leaves of a distance.
            *place = place.map(|part| if part.abs() <= reach { 0.0 } else { part });
            if *place == DVec3::ZERO {
                self.transforms.pop();
            }
        }
        Some(self)
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
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lang::source::Source;
    use crate::scene::{Scene, Shape};
    use glam::DAffine3;

    fn form(text: &str) -> BodyForm {
        let text = format!("bodies; b: {text}; lights; camera; position <0, 0, 9>; gaze <0, 0, -1>; up <0, 1, 0>; fov 45;");
        Scene::parse(&Source::new("scene", text)).unwrap().0.bodies.remove(0).form
    }

    const BALL: &str = "sphere, center <1, 0, 0>, radius 2";

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
        assert_eq!(form("mesh, \"preset:gem\"").scaled(2.0).unwrap().to_string(), "mesh, \"preset:gem\", scale 2");
        let gem = "mesh, \"preset:gem\", scale 2, translate <1, 0, 0>";
        assert_eq!(form(gem).scaled(0.25).unwrap().to_string(), gem.replace("scale 2", "scale 0.5"));
    }

    #[test]
    fn turns_are_written_in_transforms_that_can_be_read() {
        let turned = |text: &str, axis, degrees| form(text).turned(axis, degrees).unwrap().to_string();
        let square = "box, <2, 0, -1>, <4, 2, 1>";
        let first = "box, <-1, -1, -1>, <1, 1, 1>, rotate <0, 1, 0> 30, translate <3, 1, 0>";
        assert_eq!(turned(square, DVec3::Y, 30.0), first);
        assert_eq!(turned(first, DVec3::Y, 15.0), first.replace("30", "45"));
        assert_eq!(turned(first, -DVec3::Y, 15.0), first.replace("30", "15"));
        assert_eq!(turned(first, DVec3::Y, 170.0), first.replace("30", "-160"));
        assert_eq!(turned(first, DVec3::Y, -30.0), "box, <-1, -1, -1>, <1, 1, 1>, translate <3, 1, 0>");
        assert_eq!(turned(first, DVec3::X, 90.0), first.replace(", translate", ", rotate <1, 0, 0> 90, translate"));
        assert_eq!(
            turned("mesh, \"preset:gem\", fit <0, 1, 0> 2", DVec3::Z, 5.0),
            "mesh, \"preset:gem\", fit <0, 0, 0> 2, rotate <0, 0, 1> 5, translate <0, 1, 0>"
        );
        assert_eq!(turned(square, DVec3::Y, 0.0), square);
        // In the middle of the scene, no place is needed.
        assert_eq!(turned("box, <-1, -2, -1>, <1, 2, 1>", DVec3::Y, 7.5), "box, <-1, -2, -1>, <1, 2, 1>, rotate <0, 1, 0> 7.5");
    }

    #[test]
    fn a_stretched_body_keeps_its_kind_if_it_can() {
        let stretched = |text: &str, by: [f64; 3]| form(text).stretched(DVec3::from(by)).unwrap().to_string();
        assert_eq!(stretched("box, <2, 0, -1>, <4, 2, 1>", [2.0, 1.0, 1.0]), "box, <1, 0, -1>, <5, 2, 1>");
        let turned = ", rotate <0, 1, 0> 30, translate <3, 1, 0>";
        assert_eq!(
            stretched(&format!("box, <-1, -1, -1>, <1, 1, 1>{turned}"), [1.0, 3.0, 1.0]),
            format!("box, <-1, -3, -1>, <1, 3, 1>{turned}")
        );
        assert_eq!(
            stretched("rectangle, <-2, 0, -1>, <2, 0, -1>, <2, 0, 1>", [1.0, 1.0, 2.0]),
            "rectangle, <-2, 0, -2>, <2, 0, -2>, <2, 0, 2>"
        );
        assert_eq!(
            stretched("triangle, <0, 0, 0>, <0, 3, 0>, <3, 0, 0>", [2.0, 1.0, 1.0]),
            "triangle, <-1, 0, 0>, <-1, 3, 0>, <5, 0, 0>"
        );
        let oval = "sphere, center <0, 0, 0>, radius 2, scale <2, 1, 1>, translate <1, 0, 0>";
        assert_eq!(stretched(BALL, [2.0, 1.0, 1.0]), oval);
        assert_eq!(stretched(oval, [1.0, 1.0, 3.0]), oval.replace("<2, 1, 1>", "<2, 1, 3>"));
        assert_eq!(stretched(oval, [1.0, 2.0, 2.0]), oval.replace("<2, 1, 1>", "2"));
        assert_eq!(stretched(oval, [0.5, 1.0, 1.0]), "sphere, center <0, 0, 0>, radius 2, translate <1, 0, 0>");
        assert_eq!(stretched(&format!("{BALL}{turned}"), [1.0, 1.0, 2.0]).matches("scale <1, 1, 2>, rotate").count(), 1);
        assert_eq!(
            stretched("mesh, \"preset:gem\", fit <0, 1, 0> 2", [2.0, 1.0, 1.0]),
            "mesh, \"preset:gem\", fit <0, 0, 0> 2, scale <2, 1, 1>, translate <0, 1, 0>"
        );
        assert!(!form("disc, center <0, 1, 0>, normal <0, 2, 0>, radius 1").has_extent_along(1));
    }

    /// What a form without `fit` does to points.
    fn whole(form: &BodyForm) -> DAffine3 {
        BodyForm::map(&form.transforms)
    }

    #[test]
    fn turns_and_stretches_are_about_the_anchor_whatever_was_before() {
        let before =
            ["", ", translate <1, 2, 3>", ", scale <1, 2, 3>, rotate <1, 2, 3> 40, translate <4, 5, 6>, rotate <0, 0, 1> 77"];
        for text in before {
            let shape =
                if text.is_empty() { "cylinder, <-1, -1, 1>, <1, 1, 3>, radius 1" } else { "sphere, center <0, 0, 0>, radius 2" };
            let form = form(&format!("{shape}{text}"));
            let anchor = form.anchor().unwrap();
            let mut turned = form.clone();
            let turns =
                [(DVec3::X, 20.0), (DVec3::Y, -30.0), (DVec3::Z, 140.0), (DVec3::X, 50.0), (DVec3::new(1.0, 1.0, 0.0), 9.0)];
            let mut expected = whole(&form);
            // A cylinder is put at the origin first.
            let origin = if text.is_empty() { form.shape.anchor().unwrap() } else { DVec3::ZERO };
            for (axis, degrees) in turns {
                turned = turned.turned(axis, degrees).unwrap();
                let turn = DAffine3::from_axis_angle(axis.normalize(), f64::to_radians(degrees));
                expected = DAffine3::from_translation(anchor) * turn * DAffine3::from_translation(-anchor) * expected;
                let found = whole(&turned) * DAffine3::from_translation(-origin);
                assert!(found.abs_diff_eq(expected, 1e-9), "{turned}: {found} {expected}");
                assert!(turned.anchor().unwrap().abs_diff_eq(anchor, 1e-12));
            }
            assert!(
                turned.transforms.iter().filter(|one| matches!(one, Transform::Rotate { .. })).count() <= MOST_TURNS + 1,
                "{turned}"
            );
            // A factor along an own axis: what is there is that much longer, and what is across stays.
            let own = turned.axes();
            let longer = turned.with_factors(DVec3::new(1.0, 3.0, 1.0)).unwrap();
            let lengths = |of: &BodyForm| [0, 1, 2].map(|axis| whole(of).matrix3.col(axis).length());
            let ([x, y, z], after) = (lengths(&turned), lengths(&longer));
            assert!(after.iter().zip([x, 3.0 * y, z]).all(|(one, other)| (one - other).abs() < 1e-9));
            assert!(longer.axes().iter().zip(own).all(|(one, other)| one.abs_diff_eq(other, 1e-9)));
            assert!(longer.anchor().unwrap().abs_diff_eq(anchor, 1e-9));
        }
        assert!(matches!(form(BALL).shape, Shape::Sphere(_)));
        assert_eq!(form(BALL).stretched(DVec3::new(1e-40, 1.0, 1.0)), None);
        assert_eq!(form(BALL).stretched(DVec3::new(1e40, 1.0, 1.0)), None);
    }
}
