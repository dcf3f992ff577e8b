//! What the camera of a world sees, where something is that is added there, and other cameras that see it.

use crate::scene::edit::SceneObject;
use crate::scene::{BodyId, Camera, Scene, ViewSide};
use crate::world::{Ray, World};
use glam::DVec3;

/// The point that stands for a body or light. `None` if it is nowhere in particular.
pub(in crate::preview::app) fn anchor(scene: &Scene, object: SceneObject) -> Option<DVec3> {
    match object {
        SceneObject::Body(id) => scene.bodies.get(id.index())?.form.anchor(),
        SceneObject::Light(id) => scene.lights.get(id.index())?.kind.anchor(),
    }
}

/// The point that is seen at a point of the image plane.
pub(in crate::preview::app) fn seen_at(world: &World, [x, y]: [f64; 2]) -> Option<(BodyId, DVec3)> {
    let camera = &world.scene().camera;
    let ray = Ray { origin: camera.position(), direction: camera.direction(x, y), leaves: None };
    world.nearest(&ray).map(|met| (met.body, ray.at(met.distance)))
}

/// The point that a motion of the camera is about: what is seen at a point of the image plane; otherwise the selected
/// thing, otherwise a point there as far away as the middle of the scene.
pub(in crate::preview::app) fn pivot(world: &World, at: [f64; 2], selected: Option<SceneObject>) -> DVec3 {
    let camera = &world.scene().camera;
    if let Some((_, point)) = seen_at(world, at) {
        return point;
    }
    let selected = selected.and_then(|object| anchor(world.scene(), object)).filter(|point| camera.depth_of(*point) > 0.0);
    selected.unwrap_or_else(|| camera.point_at(at, distance(world)))
}

/// The point on which something stands that is added where a point of the image plane is seen. `size` is how large it
/// is. If what is seen there does not look up, the place is in front of it, on what is below.
pub(in crate::preview::app) fn place_to_stand(world: &World, at: [f64; 2], size: f64) -> DVec3 {
    let (camera, seen) = (&world.scene().camera, pivot(world, at, None));
    let upright = camera.upright();
    let below = |from: DVec3| {
        let met = world.nearest(&Ray { origin: from, direction: -upright, leaves: None })?;
        Some((met.distance, from - met.distance * upright))
    };
    let lift = 0.05 * size;
    if below(seen + lift * upright).is_some_and(|(distance, _)| distance < 1.5 * lift) {
        return seen;
    }
    let towards = (camera.position() - seen).reject_from(upright).normalize_or_zero();
    let place = below(seen + size * towards).map(|(_, place)| place);
    // What is far below would be out of view.
    place.filter(|place| camera.project(*place).is_some_and(|[_, y]| y > -0.95)).unwrap_or(seen)
}

/// How far away the scene is, in world units, greater than 0.
pub(in crate::preview::app) fn distance(world: &World) -> f64 {
    let camera = &world.scene().camera;
    if let Some((_, point)) = seen_at(world, [0.0, 0.0]) {
        return camera.depth_of(point);
    }
    let anchors = world.scene().body_ids().filter_map(|id| world.scene().body(id).form.anchor());
    let depths = anchors.map(|anchor| camera.depth_of(anchor)).filter(|depth| *depth > 0.0);
    depths.reduce(f64::min).unwrap_or(1.0)
}

/// The camera that views the scene from a side: about the selected thing, or about what is in the middle.
pub(in crate::preview::app) fn from_side(world: &World, side: ViewSide, selected: Option<SceneObject>) -> Option<Camera> {
    let selected = selected.and_then(|object| anchor(world.scene(), object));
    world.scene().camera.from_side(side, selected.unwrap_or_else(|| pivot(world, [0.0, 0.0], None)))
}

/// The camera that sees a body, a light or, without one, the whole scene as large as possible.
pub(in crate::preview::app) fn framing(world: &World, object: Option<SceneObject>, aspect: f64) -> Option<Camera> {
    let camera = &world.scene().camera;
    match object {
        Some(SceneObject::Body(id)) => {
            let bounds = world.bounds(id);
            camera.framing(bounds.low, bounds.high, aspect)
        }
        Some(light @ SceneObject::Light(_)) => {
            // What is everywhere is seen by what it shines on.
            let Some(anchor) = anchor(world.scene(), light) else { return framing(world, None, aspect) };
            // A light is small. The scene stays as far away as it is.
            let [.., forward] = camera.axes();
            Camera::new(anchor - distance(world) * forward, camera.gaze(), camera.up(), camera.fov()).ok()
        }
        None => {
            // Without floors and walls, which are far larger than what stands on them.
            let bounds: Vec<_> = world.scene().body_ids().map(|id| world.bounds(id)).collect();
            let mut sizes: Vec<f64> = bounds.iter().map(crate::world::Bounds::diagonal).collect();
            sizes.sort_by(f64::total_cmp);
            let usual = sizes.get(sizes.len().saturating_sub(1) / 2).copied()?;
            let fitting = bounds.iter().filter(|bounds| bounds.diagonal() <= 8.0 * usual);
            let whole = fitting.copied().reduce(crate::world::Bounds::union)?;
            camera.framing(whole.low, whole.high, aspect)
        }
    }
}
