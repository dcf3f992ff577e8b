//! What can be done by hand with a body or a light: where it is, which handles it has, and the changes that move, turn
//! and scale it.

use super::sight::{anchor, distance};
use crate::preview::app::HandleTool;
use crate::scene::edit::{SceneChange, SceneObject};
use crate::scene::{LightKind, Scene};
use crate::world::World;
use glam::DVec3;

/// How far from the middle of the picture the marker of parallel light is, as a part of the picture's half height.
const SUN_OFFSET: f64 = 0.6;
/// Axes whose sine is less are the same.
const PARALLEL: f64 = 1e-9;

/// Where parallel light is shown: from a point to the middle of the picture, in its direction. `None` for other lights.
pub(super) fn shown_rays(world: &World, kind: &LightKind) -> Option<[DVec3; 2]> {
    let direction = kind.direction().filter(|_| kind.anchor().is_none())?;
    let (camera, depth) = (&world.scene().camera, distance(world));
    let middle = camera.point_at([0.0, 0.0], depth);
    // At most 1, so that it is not behind the camera.
    let half_height = (camera.fov().to_radians() / 2.0).tan().min(1.0);
    Some([middle - SUN_OFFSET * depth * half_height * direction, middle])
}

/// Where a body or light is shown: its anchor, or the marker of parallel light.
pub(super) fn shown_place(world: &World, object: SceneObject) -> Option<DVec3> {
    let parallel = || match object {
        SceneObject::Body(_) => None,
        SceneObject::Light(id) => shown_rays(world, &world.scene().lights.get(id.index())?.kind).map(|[from, _]| from),
    };
    anchor(world.scene(), object).or_else(parallel)
}

/// Its radius in world units, if it has one.
pub(super) fn radius(scene: &Scene, object: SceneObject) -> Option<f64> {
    match object {
        SceneObject::Body(id) => scene.bodies.get(id.index())?.form.radius(),
        SceneObject::Light(id) => scene.lights.get(id.index())?.kind.radius(),
    }
}

/// The directions of its own axes, of unit length.
pub(super) fn axes(scene: &Scene, object: SceneObject) -> Option<[DVec3; 3]> {
    match object {
        SceneObject::Body(id) => Some(scene.bodies.get(id.index())?.form.axes()),
        SceneObject::Light(id) => Some(scene.lights.get(id.index())?.kind.axes()),
    }
}

/// Whether a factor along one of its own axes, counted from 0, changes it.
pub(super) fn has_extent_along(scene: &Scene, object: SceneObject, axis: usize) -> bool {
    match object {
        SceneObject::Body(id) => scene.bodies.get(id.index()).is_some_and(|body| body.form.has_extent_along(axis)),
        SceneObject::Light(id) => scene.lights.get(id.index()).is_some_and(|light| {
            let normal = light.kind.flat_normal();
            let is_flat = normal.is_some_and(|normal| normal.cross(light.kind.axes()[axis % 3]).length() <= PARALLEL);
            !is_flat && light.kind.stretched_along_axes(DVec3::ONE).is_some()
        }),
    }
}

/// Whether it has the handles of a tool. Everything can be moved.
pub(super) fn has_tool(scene: &Scene, object: SceneObject, tool: HandleTool) -> bool {
    match (object, tool) {
        (SceneObject::Body(_), _) | (SceneObject::Light(_), HandleTool::Move) => true,
        (SceneObject::Light(_), HandleTool::Rotate) => turned(scene, object, DVec3::Y, 0.0).is_some(),
        (SceneObject::Light(_), HandleTool::Scale) => scaled(scene, object, 1.0).is_some(),
    }
}

/// A direction whose height above the horizon and whose bearing about the y axis are multiples of an angle in degrees.
fn snapped_direction(direction: DVec3, degrees: f64) -> DVec3 {
    let direction = direction.normalize_or_zero();
    let step = degrees.to_radians();
    let [height, bearing] =
        [direction.y.clamp(-1.0, 1.0).asin(), direction.x.atan2(direction.z)].map(|angle| (angle / step).round() * step);
    DVec3::new(height.cos() * bearing.sin(), height.sin(), height.cos() * bearing.cos())
}

/// The change that moves it by a vector in world units. Parallel light turns, as if its marker were moved; with `snap`,
/// to multiples of this angle in degrees. `None` if it would be too far away.
pub(super) fn moved(world: &World, object: SceneObject, by: DVec3, snap: Option<f64>) -> Option<SceneChange> {
    let scene = world.scene();
    Some(match object {
        SceneObject::Body(id) => SceneChange::Form(id, scene.bodies.get(id.index())?.form.moved(by)?),
        SceneObject::Light(id) => {
            let kind = &scene.lights.get(id.index())?.kind;
            SceneChange::Light(
                id,
                match shown_rays(world, kind) {
                    Some([from, to]) => {
                        let direction = to - (from + by);
                        kind.aimed(DVec3::ZERO, snap.map_or(direction, |degrees| snapped_direction(direction, degrees)))?
                    }
                    None => kind.moved(by)?,
                },
            )
        }
    })
}

/// The change that makes it larger by a factor. `None` if it has no size, or if it would be too large or too small.
pub(super) fn scaled(scene: &Scene, object: SceneObject, by: f64) -> Option<SceneChange> {
    Some(match object {
        SceneObject::Body(id) => SceneChange::Form(id, scene.bodies.get(id.index())?.form.scaled(by)?),
        SceneObject::Light(id) => SceneChange::Light(id, scene.lights.get(id.index())?.kind.scaled(by)?),
    })
}

/// The change that makes it larger by a factor along each of its own axes. `None` if it has no size, or if it would be
/// too large or too small.
pub(super) fn stretched(scene: &Scene, object: SceneObject, by: DVec3) -> Option<SceneChange> {
    Some(match object {
        SceneObject::Body(id) => SceneChange::Form(id, scene.bodies.get(id.index())?.form.stretched(by)?),
        SceneObject::Light(id) => SceneChange::Light(id, scene.lights.get(id.index())?.kind.stretched_along_axes(by)?),
    })
}

/// The change that turns it about an axis of the scene through its anchor. `None` if it looks the same from all sides.
pub(super) fn turned(scene: &Scene, object: SceneObject, axis: DVec3, degrees: f64) -> Option<SceneChange> {
    Some(match object {
        SceneObject::Body(id) => SceneChange::Form(id, scene.bodies.get(id.index())?.form.turned(axis, degrees)?),
        SceneObject::Light(id) => SceneChange::Light(id, scene.lights.get(id.index())?.kind.turned(axis, degrees)?),
    })
}

/// Its name.
pub(super) fn name(scene: &Scene, object: SceneObject) -> &str {
    match object {
        SceneObject::Body(id) => scene.bodies.get(id.index()).map_or("", |body| &body.name),
        SceneObject::Light(id) => scene.lights.get(id.index()).map_or("", |light| &light.name),
    }
}
