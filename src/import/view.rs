//! The camera and the lights of an imported scene.

use crate::import::names::UniqueNames;
use crate::import::target::ImportError;
use crate::lang::source::SourceSpan;
use crate::mesh::{LightSource, ModelCamera, ModelLight, ModelPart, Omissions};
use crate::scene::edit::rounded;
use crate::scene::light::{DirectionalLight, PointLight, SpotLight};
use crate::scene::{Camera, Light, LightKind, MAX_COORDINATE};
use crate::trace::MAX_SIDE;
use glam::DVec3;

/// The height of pictures in pixels, and their width where the file does not say it.
const HEIGHT: u32 = 720;
const WIDTH: u32 = 1280;
/// The direction from the middle of the bodies to the camera where the file has none: from the front, a little from
/// the right and from above.
const FROM: DVec3 = DVec3::new(0.45, 0.4, 1.0);
const FOV: f64 = 35.0;
/// How many digits the longest side of the box around the bodies has behind its first one.
const DIGITS: i32 = 5;
/// Lights for files without any: their names, their places (right, up, towards the camera, as multiples of the radius
/// of the box around the bodies), and their intensities.
const DEFAULT_LIGHTS: [(&str, [f64; 3], f32); 2] = [("key", [-1.5, 2.0, 2.0], 0.9), ("fill", [2.5, 0.5, 1.5], 0.3)];

/// A light of the scene.
pub(super) struct ImportedLight {
    pub(super) name: String,
    pub(super) kind: LightKind,
    pub(super) intensity: f32,
    pub(super) color: [f32; 3],
}

impl ImportedLight {
    /// The light in the scene.
    pub(super) fn in_scene(self) -> Light {
        Light { name: self.name, name_span: SourceSpan::default(), kind: self.kind }
    }
}

/// The camera of the file, or one that shows the whole; the size of its picture; and whether it is that of the file.
pub(super) fn camera(
    given: Option<&ModelCamera>,
    parts: &[ModelPart],
    [low, high]: [DVec3; 2],
    simplified: &mut Omissions,
) -> Result<(Camera, [u32; 2], bool), ImportError> {
    let size = given.and_then(|given| given.aspect).map_or([WIDTH, HEIGHT], |aspect| {
        // The cast saturates.
        let width = (f64::from(HEIGHT) * aspect).round() as u32;
        [width.clamp(1, MAX_SIDE), HEIGHT]
    });
    let side = (high - low).max_element();
    if let Some(ModelCamera { position, gaze, up, fov, .. }) = given {
        let [gaze, up] = [gaze, up].map(|direction| tidy(*direction, 1.0));
        match Camera::new(tidy(*position, side), gaze, up, rounded(*fov, DIGITS)) {
            Ok(camera) => return Ok((camera, size, true)),
            Err(error) => simplified.add(1, "camera(s) that cannot be used", &error.to_string()),
        }
    }
    let aspect = f64::from(size[0]) / f64::from(size[1]);
    let somewhere = Camera::new(low.midpoint(high) + FROM, -FROM, DVec3::Y, FOV).ok();
    let points = parts.iter().flat_map(|part| part.mesh.positions()).copied();
    let framed = somewhere.and_then(|camera| camera.framing_all(points, aspect));
    let framed = framed.and_then(|camera| Camera::new(tidy(camera.position(), side), camera.gaze(), camera.up(), FOV).ok());
    framed.map(|camera| (camera, size, false)).ok_or(ImportError::TooLarge)
}

/// The lights of the file, or two that show it.
pub(super) fn lights(
    given: &[ModelLight],
    [low, high]: [DVec3; 2],
    camera: &Camera,
    names: &mut UniqueNames,
    simplified: &mut Omissions,
) -> Vec<ImportedLight> {
    let (middle, side) = (low.midpoint(high), (high - low).max_element());
    if given.is_empty() {
        let radius = (high - low).length() / 2.0;
        let [right, up, forward] = camera.axes();
        return DEFAULT_LIGHTS
            .map(|(name, [across, above, towards], intensity)| ImportedLight {
                name: names.take(name, "", "light"),
                kind: point_at(middle + radius * (across * right + above * up - towards * forward), side),
                intensity,
                color: [1.0; 3],
            })
            .into();
    }
    let mut lights = Vec::new();
    let mut strongest: f64 = 0.0;
    let mut strengths = Vec::new();
    for light in given {
        let tint = light.color.into_iter().fold(0.0, f64::max);
        let lux = |place: DVec3| light.intensity / place.distance_squared(middle).max((side / 2.0).powi(2) * 1e-6);
        let (kind, strength) = match light.source {
            LightSource::Point(place) => (point_at(place, side), lux(place)),
            LightSource::Spot { place, direction, angles } => {
                let towards = direction * place.distance(middle).max(side / 2.0);
                let spot = spot_at(place, towards, angles, side).unwrap_or_else(|| {
                    simplified.add(1, "spot light(s) whose cone cannot be used", "light goes in all directions instead");
                    point_at(place, side)
                });
                (spot, lux(place))
            }
            LightSource::Directional(direction) => {
                let parallel = DirectionalLight::new(tidy(direction, 1.0)).map(LightKind::Directional);
                // Directions of unit length are taken, also when rounded.
                (parallel.unwrap_or_else(|_| point_at(middle - side * direction, side)), light.intensity)
            }
        };
        // A colour above 1 is a stronger light.
        let strength = strength * tint.max(1.0);
        strongest = strongest.max(strength);
        strengths.push(strength);
        lights.push(ImportedLight {
            name: names.take(&light.name, "", "light"),
            kind,
            intensity: 0.0,
            color: light.color.map(|component| four_digits(component / tint.max(1.0))),
        });
    }
    for (light, strength) in lights.iter_mut().zip(strengths) {
        light.intensity = if strongest > 0.0 { four_digits(strength / strongest) } else { 0.0 };
    }
    let note = if strongest > 0.0 {
        "ki is 1 for the strongest in the middle of the bodies, and none gets weaker with the distance"
    } else {
        "ki is 0, because no intensity is above 0"
    };
    simplified.add(lights.len() as u64, "strength(s) of lights", note);
    lights
}

/// A place that a scene may name.
fn place_at(place: DVec3, side: f64) -> DVec3 {
    let reach = DVec3::splat(MAX_COORDINATE);
    tidy(place, side).clamp(-reach, reach)
}

fn point_at(place: DVec3, side: f64) -> LightKind {
    LightKind::Point(PointLight::new(place_at(place, side)))
}

/// A light at a place that shines `towards` a vector, within a cone of these angles in radians: where its light begins
/// to get weaker, and the edge. `None` if there is no such cone.
fn spot_at(place: DVec3, towards: DVec3, angles: [f64; 2], side: f64) -> Option<LightKind> {
    let [full, edge] = angles.map(|angle| rounded(angle.to_degrees(), DIGITS));
    let soft = rounded(edge - full, DIGITS);
    let soft = (soft != 0.0).then_some(soft);
    let spot = SpotLight::new(place_at(place, side), place_at(place + towards, side), edge, soft);
    spot.ok().map(LightKind::Spot)
}

/// A place or a direction without digits that nobody sees, where the longest side of what is seen has this length.
fn tidy(place: DVec3, side: f64) -> DVec3 {
    let decimals = DIGITS - side.log10().floor() as i32;
    DVec3::from_array(place.to_array().map(|coordinate| rounded(coordinate, decimals)))
}

/// A share to four digits behind the point.
fn four_digits(share: f64) -> f32 {
    const STEPS: f64 = 1e4;
    ((share.clamp(0.0, 1.0) * STEPS).round() / STEPS) as f32
}
