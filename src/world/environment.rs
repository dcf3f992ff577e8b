//! The environment of a scene: the light that comes from all around.

use crate::environment::{Heading, RadianceMap, RadianceSample};
use crate::scene::{LightId, Scene};
use crate::world::assets::Assets;
use crate::world::missing_asset::MissingAsset;
use glam::DVec3;
use std::sync::Arc;

/// The environment of a scene. A copy is cheap: it shares the map.
#[derive(Debug, Clone, PartialEq)]
pub struct Environment {
    light: LightId,
    map: Arc<RadianceMap>,
    heading: Heading,
}

impl Environment {
    /// The environment of a scene, if it has one.
    pub(super) fn of(scene: &Scene, assets: &Assets) -> Result<Option<Self>, MissingAsset> {
        let environment_of = |light: LightId| scene.light(light).kind.environment().map(|environment| (light, environment));
        let Some((light, environment)) = scene.light_ids().find_map(environment_of) else { return Ok(None) };
        let map = assets.map_of(&scene.light(light).name, environment)?;
        let (sine, cosine) = environment.sine_and_cosine();
        Ok(Some(Self { light, map, heading: Heading::new(sine, cosine) }))
    }

    /// The light whose colour and intensity it has.
    pub fn light(&self) -> LightId {
        self.light
    }

    /// The radiance from a direction of the scene, of any length greater than 0: linear RGB, at least 0, without the
    /// colour and the intensity of the light.
    #[inline]
    pub fn radiance(&self, direction: DVec3) -> [f32; 3] {
        self.map.radiance(self.heading.to_map(direction))
    }

    /// Draws a direction of the scene by a point of the unit square, see [`RadianceMap::sample`].
    #[inline]
    pub fn sample(&self, point: [f64; 2]) -> Option<RadianceSample> {
        let drawn = self.map.sample(point)?;
        Some(RadianceSample { direction: self.heading.to_scene(drawn.direction), ..drawn })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lang::source::Source;
    use crate::world::{NamedMap, World};

    #[test]
    fn a_ray_sees_the_map_turned() {
        // Red towards +x, green towards +z, blue towards −x, and dark towards −z.
        let colours = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let write = |_: u32, written: &mut [[f32; 3]]| {
            // The middle of four texels is at an eighth of the width and so on; eight put them on the axes.
            written.iter_mut().zip(0_usize..).for_each(|(texel, column)| *texel = colours[(column + 1) / 4 % 4]);
        };
        let (map, _) = RadianceMap::of_rows(16, 2, write).unwrap();
        let environment = Some(NamedMap { path: "four".to_owned(), map: Arc::new(map) });
        let assets = Assets { environment, ..Assets::NONE };
        let world = |light: &str| {
            let camera = "camera; position <0, 0, 9>; gaze <0, 0, -1>; up <0, 1, 0>; fov 45;";
            let text = format!("bodies; lights; key: point, <1, 2, 3>; sky: {light}; {camera}");
            World::new(Scene::parse(&Source::new("scene", text)).unwrap().0, &assets).unwrap()
        };
        let axes = [DVec3::X, DVec3::Z, -DVec3::X, -DVec3::Z];
        let seen = |light: &str| axes.map(|axis| world(light).environment().unwrap().radiance(2.5 * axis));
        let [red, green, blue, dark] = [colours[1], colours[2], colours[3], colours[0]];
        assert_eq!(seen("environment, \"four\""), [red, green, blue, dark]);
        // A quarter turn leads from +z to +x, and from +x to −z.
        assert_eq!(seen("environment, \"four\", rotate 90"), [green, blue, dark, red]);
        assert_eq!(seen("environment, \"four\", rotate -90"), [dark, red, green, blue]);
        assert_eq!(seen("environment, \"four\", rotate 360"), [red, green, blue, dark]);
        assert_eq!(seen("environment"), [[1.0; 3]; 4]);
        let world = world("environment, \"four\"");
        assert_eq!(world.environment().map(Environment::light), Some(LightId(1)));
        assert_eq!(world.assets().memory(), world.environment().unwrap().map.memory());
    }
}
