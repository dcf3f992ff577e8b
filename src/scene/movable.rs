//! Where things of a scene are, and how they are moved and resized: for whoever arranges a scene by hand.

use glam::DVec3;

/// How a shape or a kind of light is moved and resized. Each kind implements it in its own file; the enumerations
/// [`Shape`](crate::scene::Shape) and [`LightKind`](crate::scene::LightKind) answer for all of them.
pub(super) trait Movable: Sized {
    /// The point that stands for it, in world coordinates. `None` if it is nowhere in particular.
    fn anchor(&self) -> Option<DVec3>;

    /// The same, moved by a vector in world units. `None` if there is no such thing: it would be too far away.
    fn moved(&self, by: DVec3) -> Option<Self>;

    /// The same, larger by a factor greater than 0, with the anchor where it is. `None` if it has no size, or if there
    /// is no such thing.
    fn scaled(&self, by: f64) -> Option<Self> {
        let _ = by;
        None
    }

    /// The same, larger by a factor along each axis of the scene, with the anchor where it is. `None` if that is
    /// another kind of thing, or none.
    fn stretched(&self, by: DVec3) -> Option<Self> {
        let _ = by;
        None
    }

    /// Its radius in world units, if it has one.
    fn radius(&self) -> Option<f64> {
        None
    }

    /// The normal of what is flat. A factor along it changes nothing.
    fn flat_normal(&self) -> Option<DVec3> {
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lang::source::Source;
    use crate::scene::{LightKind, Scene, Shape};

    fn examples() -> (Vec<Shape>, Vec<LightKind>) {
        let bodies: String = Shape::SYNTAX.iter().map(|row| format!("b_{}: {};", row.keyword.word, row.example)).collect();
        let lights: String = LightKind::SYNTAX.iter().map(|row| format!("l_{}: {};", row.keyword.word, row.example)).collect();
        let camera = "camera; position <0, 0, 9>; gaze <0, 0, -1>; up <0, 1, 0>; fov 45;";
        let source = Source::new("scene", format!("bodies; {bodies} lights; {lights} {camera}"));
        let (scene, _) = Scene::parse(&source).unwrap();
        (
            scene.bodies.into_iter().map(|body| body.form.shape).collect(),
            scene.lights.into_iter().map(|light| light.kind).collect(),
        )
    }

    #[test]
    fn every_kind_is_moved_and_resized_about_its_anchor() {
        let (shapes, lights) = examples();
        let by = DVec3::new(0.5, -2.0, 8.0);
        // A mesh is where its file says.
        for shape in shapes.into_iter().filter(|shape| !matches!(shape, Shape::Mesh(_))) {
            let anchor = shape.anchor().unwrap();
            let moved = shape.moved(by).unwrap();
            assert!(moved != shape && moved.anchor() == Some(anchor + by) && moved.moved(-by) == Some(shape.clone()), "{shape}");
            let larger = shape.scaled(2.0).unwrap();
            assert!(larger != shape && larger.scaled(0.5) == Some(shape.clone()), "{shape}");
            assert_eq!((larger.anchor(), larger.radius()), (Some(anchor), shape.radius().map(|radius| 2.0 * radius)));
            assert_eq!(shape.moved(DVec3::splat(2e30)), None);
            assert_eq!(shape.scaled(1e-40), None, "{shape}");
        }
        for light in lights {
            let Some(anchor) = light.anchor() else {
                assert_eq!((light.moved(by), light.scaled(2.0)), (Some(light.clone()), None), "{light}");
                continue;
            };
            let moved = light.moved(by).unwrap();
            assert!(moved.anchor() == Some(anchor + by) && moved.moved(-by) == Some(light.clone()), "{light}");
            assert_eq!(light.moved(DVec3::splat(2e30)), None);
            if let Some(larger) = light.scaled(2.0) {
                assert!(larger != light && larger.scaled(0.5) == Some(light.clone()), "{light}");
                assert_eq!((larger.anchor(), larger.radius()), (Some(anchor), light.radius().map(|radius| 2.0 * radius)));
                assert_eq!(light.scaled(1e-40), None, "{light}");
            }
        }
    }
}
