//! Lights, as a scene declares them. In which direction a hit sees them is computed in [`crate::world`].

mod directional;
mod environment;
mod point;
mod rectangle;
mod sphere;
mod spot;

pub use directional::{DirectionalLight, DirectionalLightError};
pub use environment::EnvironmentLight;
pub use point::PointLight;
pub use rectangle::RectangleLight;
pub use sphere::SphereLight;
pub use spot::{SpotLight, SpotLightError};

use crate::lang::source::SourceSpan;
use crate::scene::syntax::declarations;
use glam::DVec3;

/// A light: it has a name, and so parameters of its own, and emits by its kind.
#[derive(Debug, Clone, PartialEq)]
pub struct Light {
    /// Its name, unique among bodies and lights.
    pub name: String,
    /// Where the name stands in the text.
    pub name_span: SourceSpan,
    /// How it emits light.
    pub kind: LightKind,
}

declarations! {
    /// How a light emits.
    LightKind {
        /// From a point, in all directions.
        Point(PointLight),
        /// From far away, in one direction.
        Directional(DirectionalLight),
        /// From a point, within a cone.
        Spot(SpotLight),
        /// From a sphere.
        Sphere(SphereLight),
        /// From a rectangle.
        Rectangle(RectangleLight),
        /// From all around.
        Environment(EnvironmentLight),
    }
}

impl LightKind {
    /// The environment; `None` for other kinds.
    pub fn environment(&self) -> Option<&EnvironmentLight> {
        match self {
            LightKind::Environment(environment) => Some(environment),
            LightKind::Point(_)
            | LightKind::Directional(_)
            | LightKind::Spot(_)
            | LightKind::Sphere(_)
            | LightKind::Rectangle(_) => None,
        }
    }
}

/// Where lights shine to, and how they are turned and stretched by hand.
impl LightKind {
    /// The direction in which it shines, of unit length; `None` if it shines in all directions.
    pub fn direction(&self) -> Option<DVec3> {
        match self {
            LightKind::Directional(light) => Some(light.direction().normalize()),
            LightKind::Spot(light) => Some((light.target() - light.position()).normalize()),
            LightKind::Point(_) | LightKind::Environment(_) | LightKind::Sphere(_) | LightKind::Rectangle(_) => None,
        }
    }

    /// The place to which it shines, in world coordinates; `None` if it has none.
    pub fn target(&self) -> Option<DVec3> {
        match self {
            LightKind::Spot(light) => Some(light.target()),
            LightKind::Point(_)
            | LightKind::Environment(_)
            | LightKind::Directional(_)
            | LightKind::Sphere(_)
            | LightKind::Rectangle(_) => None,
        }
    }

    /// How large it is in world units: its diameter, or its longer side. `None` if it has no size.
    pub fn size(&self) -> Option<f64> {
        match self {
            LightKind::Sphere(light) => Some(2.0 * light.sphere().radius()),
            LightKind::Rectangle(light) => {
                let [a, b, c] = light.rectangle().corners();
                Some(a.distance(b).max(b.distance(c)))
            }
            LightKind::Point(_) | LightKind::Environment(_) | LightKind::Directional(_) | LightKind::Spot(_) => None,
        }
    }

    /// The same that shines from one place to another one: a light with a target gets this target, and one without a
    /// place this direction. `None` if it does not shine in one direction, or if there is no such light.
    pub fn aimed(&self, from: DVec3, to: DVec3) -> Option<Self> {
        match self {
            LightKind::Directional(light) => light.aimed(to - from).map(LightKind::Directional),
            LightKind::Spot(light) => light.aimed(to).map(LightKind::Spot),
            LightKind::Point(_) | LightKind::Environment(_) | LightKind::Sphere(_) | LightKind::Rectangle(_) => None,
        }
    }

    /// The same, turned about an axis of the scene through its anchor, counter-clockwise seen from where the axis
    /// points to. `None` if it has no anchor, or if it looks the same from all sides.
    pub fn turned(&self, axis: DVec3, degrees: f64) -> Option<Self> {
        match self {
            LightKind::Spot(light) => light.turned(axis, degrees).map(LightKind::Spot),
            LightKind::Rectangle(light) => light.turned(axis, degrees).map(LightKind::Rectangle),
            LightKind::Point(_) | LightKind::Environment(_) | LightKind::Directional(_) | LightKind::Sphere(_) => None,
        }
    }

    /// The directions of its own axes, of unit length; those of the scene if it has none.
    pub fn axes(&self) -> [DVec3; 3] {
        match self {
            LightKind::Rectangle(light) => light.axes(),
            LightKind::Point(_)
            | LightKind::Environment(_)
            | LightKind::Directional(_)
            | LightKind::Spot(_)
            | LightKind::Sphere(_) => DVec3::AXES,
        }
    }

    /// The same, larger by a factor along each of its own [axes](Self::axes), with the anchor where it is. `None` if
    /// that is no longer of this kind.
    pub fn stretched_along_axes(&self, by: DVec3) -> Option<Self> {
        match self {
            LightKind::Rectangle(light) => light.stretched_along(by).map(LightKind::Rectangle),
            LightKind::Point(_)
            | LightKind::Environment(_)
            | LightKind::Directional(_)
            | LightKind::Spot(_)
            | LightKind::Sphere(_) => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lang::source::Source;
    use crate::scene::Scene;

    fn light(text: &str) -> LightKind {
        let camera = "camera; position <0, 0, 9>; gaze <0, 0, -1>; up <0, 1, 0>; fov 45;";
        let source = Source::new("scene", format!("bodies; lights; l: {text}; {camera}"));
        Scene::parse(&source).unwrap().0.lights.remove(0).kind
    }

    #[test]
    fn lights_that_shine_in_one_direction_are_aimed() {
        let (from, to) = (DVec3::new(1.0, 2.0, 3.0), DVec3::new(1.0, 2.0, -9.0));
        let sun = light("directional, <3, 0, -4>");
        assert_eq!(sun.aimed(from, to).unwrap().to_string(), "directional, <0, 0, -5>", "of the same length");
        assert_eq!(sun.aimed(from, from), None);
        assert!(sun.direction().unwrap().abs_diff_eq(DVec3::new(0.6, 0.0, -0.8), 1e-15));
        let spot = light("spot, <1, 2, 3>, target <1, 0, 3>, angle 20, soft 3");
        assert_eq!((spot.direction(), spot.target()), (Some(DVec3::NEG_Y), Some(DVec3::new(1.0, 0.0, 3.0))));
        let aimed = spot.aimed(from, to).unwrap();
        assert_eq!(aimed.to_string(), "spot, <1, 2, 3>, target <1, 2, -9>, angle 20, soft 3");
        assert_eq!(spot.aimed(from, from), None);
        for others in ["point, <1, 2, 3>", "sphere, center <1, 2, 3>, radius 1", "rectangle, <0,0,0>, <0,1,0>, <1,1,0>"] {
            let light = light(others);
            assert_eq!((light.aimed(from, to), light.direction(), light.target()), (None, None, None), "{others}");
        }
    }

    #[test]
    fn lights_are_turned_and_stretched_about_their_anchors() {
        let spot = light("spot, <1, 2, 3>, target <1, 0, 3>, angle 20");
        // What is below goes to the front.
        assert_eq!(spot.turned(DVec3::X, -90.0).unwrap().to_string(), "spot, <1, 2, 3>, target <1, 2, 5>, angle 20");
        let panel = light("rectangle, <-2, 5, -1>, <2, 5, -1>, <2, 5, 1>");
        let turned = panel.turned(DVec3::Y, 90.0).unwrap();
        assert_eq!(turned.to_string(), "rectangle, <-1, 5, 2>, <-1, 5, -2>, <1, 5, -2>");
        assert_eq!(turned.axes(), [DVec3::NEG_Z, DVec3::X, DVec3::Y]);
        let long = turned.stretched_along_axes(DVec3::new(2.0, 1.0, 7.0)).unwrap();
        assert_eq!(long.to_string(), "rectangle, <-1, 5, 4>, <-1, 5, -4>, <1, 5, -4>");
        assert_eq!((long.size(), light("sphere, center <0,0,0>, radius 3").size(), spot.size()), (Some(8.0), Some(6.0), None));
        let slanted = panel.turned(DVec3::new(1.0, 2.0, 3.0), 77.0).unwrap();
        assert!(slanted.anchor().unwrap().abs_diff_eq(DVec3::new(0.0, 5.0, 0.0), 1e-12));
        for round in ["point, <1, 2, 3>", "directional, <1, 0, 0>", "sphere, center <1, 2, 3>, radius 1"] {
            let light = light(round);
            assert_eq!((light.turned(DVec3::Y, 30.0), light.stretched_along_axes(DVec3::ONE)), (None, None), "{round}");
        }
    }
}
