//! A gesture: something in the scene follows the pointer, the wheel or keys, from a start to an end.
//!
//! The scene of a gesture is always computed from the scene at its start, so it does not depend on the number of steps.

use crate::scene::edit::{Precision, SceneChange, SceneObject, rounded};
use crate::scene::{BodyId, Camera, Scene, ViewSide};
use crate::world::{Ray, World};
use glam::DVec3;
use std::sync::Arc;

/// What a gesture moves.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::preview::app) enum Motion {
    /// The camera, about the pivot.
    Orbit,
    /// The camera, parallel to the picture.
    Pan,
    /// The camera, towards the pivot.
    Dolly,
    /// The field of view.
    FieldOfView,
    /// A body or a light, parallel to the picture; or along an axis of the scene.
    Move(SceneObject, Option<SceneAxis>),
    /// The radius of a body.
    Resize(BodyId),
    /// A body, about an axis of the scene through its anchor.
    Turn(BodyId, SceneAxis),
    /// A body, larger along one of its own axes.
    Stretch(BodyId, SceneAxis),
    /// A body, larger in all directions.
    Grow(BodyId),
}

/// Angles that snap are multiples of this, in degrees.
const SNAPPED_ANGLE: f64 = 15.0;
/// Factors that snap are multiples of this.
const SNAPPED_FACTOR: f64 = 0.1;
/// Places that snap have this many digits less.
const SNAPPED_DIGITS: i32 = 2;
/// The digits of a factor.
const FACTOR_DIGITS: i32 = 3;
/// The least factor of one gesture: the body is not turned inside out.
const LEAST_FACTOR: f64 = 0.01;
/// A ring is turned in its plane if the cosine between its axis and the view is at least this. Otherwise it is seen
/// from its edge, and turned along it.
const FACING: f64 = 0.2;

/// An axis of the scene.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::preview::app) enum SceneAxis {
    X,
    Y,
    Z,
}

impl SceneAxis {
    pub(in crate::preview::app) const ALL: [SceneAxis; 3] = [SceneAxis::X, SceneAxis::Y, SceneAxis::Z];

    /// Its place among the axes.
    pub(in crate::preview::app) fn index(self) -> usize {
        match self {
            SceneAxis::X => 0,
            SceneAxis::Y => 1,
            SceneAxis::Z => 2,
        }
    }

    /// Its direction, of unit length.
    pub(in crate::preview::app) fn direction(self) -> DVec3 {
        DVec3::AXES[self.index()]
    }

    pub(in crate::preview::app) fn name(self) -> &'static str {
        match self {
            SceneAxis::X => "x",
            SceneAxis::Y => "y",
            SceneAxis::Z => "z",
        }
    }
}

/// How far a gesture has gone.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(in crate::preview::app) struct Travel {
    /// From where to where the pointer went, in the image plane of the camera.
    pub(in crate::preview::app) from: [f64; 2],
    pub(in crate::preview::app) to: [f64; 2],
    /// Turn and climb of an orbit in radians, or 0 and the logarithm of a factor.
    pub(in crate::preview::app) amount: [f64; 2],
}

/// A gesture in progress.
#[derive(Debug, Clone)]
pub(in crate::preview::app) struct Gesture {
    pub(in crate::preview::app) motion: Motion,
    /// What it moved at the start, before a key chose an axis.
    pub(in crate::preview::app) begun: Motion,
    /// The world at the start.
    pub(in crate::preview::app) start: Arc<World>,
    /// The point that the gesture is about: it was under the pointer at the start.
    pub(in crate::preview::app) pivot: DVec3,
    pub(in crate::preview::app) travel: Travel,
    /// The length of the handles, in world units.
    pub(in crate::preview::app) reach: f64,
    /// Whether only round angles, factors and steps count.
    pub(in crate::preview::app) snaps: bool,
}

/// What a turn has swept: from where, about which axis, and by how many degrees.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::preview::app) struct Sweep {
    pub(in crate::preview::app) center: DVec3,
    pub(in crate::preview::app) axis: DVec3,
    /// A direction of unit length, at a right angle to the axis.
    pub(in crate::preview::app) start: DVec3,
    pub(in crate::preview::app) degrees: f64,
}

impl Gesture {
    fn scene(&self) -> &Scene {
        self.start.scene()
    }

    /// What is moved, for the log.
    pub(in crate::preview::app) fn what(&self) -> String {
        match self.motion {
            Motion::Orbit | Motion::Pan | Motion::Dolly | Motion::FieldOfView => "the camera".to_owned(),
            Motion::Move(SceneObject::Body(id), _)
            | Motion::Resize(id)
            | Motion::Turn(id, _)
            | Motion::Stretch(id, _)
            | Motion::Grow(id) => self.scene().body(id).name.clone(),
            Motion::Move(SceneObject::Light(id), _) => self.scene().light(id).name.clone(),
        }
    }

    /// How exactly the text is written: in steps that the picture shows.
    pub(in crate::preview::app) fn precision(&self) -> Precision {
        Precision::for_size(self.scene().camera.position().distance(self.pivot))
    }

    /// The change of the scene so far; `None` if the scene cannot be like that.
    pub(in crate::preview::app) fn change(&self) -> Option<SceneChange> {
        let (camera, Travel { from, to, amount: [turn, climb] }) = (&self.scene().camera, self.travel);
        let depth = camera.depth_of(self.pivot);
        let led = |camera: Option<Camera>| camera.map(SceneChange::Camera);
        match self.motion {
            Motion::Orbit => led(camera.orbited(self.pivot, turn, climb)),
            Motion::Pan => led(camera.panned(depth, from, to)),
            Motion::Dolly => led(camera.dollied(self.pivot, climb.exp())),
            Motion::FieldOfView => led(camera.widened(climb.exp())),
            Motion::Move(object, _) => {
                let by = self.way()?;
                match object {
                    SceneObject::Body(id) => Some(SceneChange::Form(id, self.scene().body(id).form.moved(by)?)),
                    SceneObject::Light(id) => Some(SceneChange::Light(id, self.scene().light(id).kind.moved(by)?)),
                }
            }
            Motion::Resize(id) | Motion::Grow(id) => {
                Some(SceneChange::Form(id, self.scene().body(id).form.scaled(self.factor()?)?))
            }
            Motion::Stretch(id, axis) => {
                let mut factors = DVec3::ONE;
                factors[axis.index()] = self.factor()?;
                Some(SceneChange::Form(id, self.scene().body(id).form.stretched(factors)?))
            }
            Motion::Turn(id, _) => {
                let Sweep { axis, degrees, .. } = self.sweep()?;
                Some(SceneChange::Form(id, self.scene().body(id).form.turned(axis, degrees)?))
            }
        }
    }

    /// The way by which something is moved.
    fn way(&self) -> Option<DVec3> {
        let (Motion::Move(_, axis), Travel { from, to, .. }) = (self.motion, self.travel) else { return None };
        let camera = &self.scene().camera;
        let depth = camera.depth_of(self.pivot);
        let by = match axis {
            None => camera.point_at(to, depth) - camera.point_at(from, depth),
            Some(axis) => self.along(axis.direction(), to)? - self.along(axis.direction(), from)?,
        };
        let precision = match self.precision() {
            Precision::Decimals(decimals) if self.snaps => Precision::Decimals(decimals - SNAPPED_DIGITS),
            other @ (Precision::Exact | Precision::Decimals(_)) => other,
        };
        Some(precision.round(by))
    }

    /// The factor by which a body is scaled.
    pub(in crate::preview::app) fn factor(&self) -> Option<f64> {
        let Travel { from, to, amount } = self.travel;
        let factor = match self.motion {
            Motion::Resize(id) => {
                let (camera, anchor) = (&self.scene().camera, self.scene().body(id).form.anchor()?);
                let depth = camera.depth_of(anchor);
                let [before, after] = [from, to].map(|point| camera.point_at(point, depth).distance(anchor));
                after / before
            }
            Motion::Stretch(id, axis) => {
                let direction = self.scene().body(id).form.axes()[axis.index()];
                let [before, after] = [from, to].map(|point| Some((self.along(direction, point)? - self.pivot).dot(direction)));
                (after? / before?).max(LEAST_FACTOR)
            }
            Motion::Grow(_) => amount[1].exp(),
            Motion::Orbit | Motion::Pan | Motion::Dolly | Motion::FieldOfView | Motion::Move(..) | Motion::Turn(..) => {
                return None;
            }
        };
        if self.snaps {
            return Some(rounded((factor / SNAPPED_FACTOR).round().max(1.0) * SNAPPED_FACTOR, 1));
        }
        let digits = FACTOR_DIGITS - 1 - factor.log10().floor() as i32;
        (factor.is_finite() && factor > 0.0).then(|| rounded(factor, digits))
    }

    /// How far a body is turned, if it is.
    pub(in crate::preview::app) fn sweep(&self) -> Option<Sweep> {
        let (Motion::Turn(_, axis), camera, center) = (self.motion, &self.scene().camera, self.pivot) else { return None };
        let axis = axis.direction();
        let view = (center - camera.position()).normalize();
        let Travel { from, to, .. } = self.travel;
        let (start, angle) = if view.dot(axis).abs() >= FACING {
            let [start, end] = [from, to].map(|point| self.on_ring(axis, point));
            let (start, end) = (start?, end?);
            (start.try_normalize()?, axis.dot(start.cross(end)).atan2(start.dot(end)))
        } else {
            // What is nearest goes along the edge.
            let (edge, depth) = (view.cross(axis).normalize(), camera.depth_of(center));
            let way = camera.point_at(to, depth) - camera.point_at(from, depth);
            (edge.cross(axis), way.dot(edge) / self.reach)
        };
        let degrees = angle.to_degrees();
        let degrees = if self.snaps { (degrees / SNAPPED_ANGLE).round() * SNAPPED_ANGLE } else { rounded(degrees, 1) };
        Some(Sweep { center, axis, start, degrees })
    }

    /// Where a point of the image plane is seen in the plane of a ring, from its centre.
    fn on_ring(&self, axis: DVec3, [x, y]: [f64; 2]) -> Option<DVec3> {
        let camera = &self.scene().camera;
        let (ray, offset) = (camera.direction(x, y), self.pivot - camera.position());
        let distance = offset.dot(axis) / ray.dot(axis);
        (distance.is_finite() && distance > 0.0).then(|| distance * ray - offset)
    }

    /// How far the gesture has gone, in a few words to be shown beside the pointer.
    pub(in crate::preview::app) fn words(&self) -> Option<String> {
        match self.motion {
            Motion::Turn(..) => Some(format!("{}°", self.sweep()?.degrees).replace('-', "−")),
            Motion::Resize(_) | Motion::Stretch(..) | Motion::Grow(_) => Some(format!("× {}", self.factor()?)),
            Motion::Move(_, Some(axis)) => {
                let way = self.way()?[axis.index()];
                let sign = if way < 0.0 { "−" } else { "+" };
                Some(format!("{} {sign}{}", axis.name(), way.abs()))
            }
            Motion::Move(_, None) | Motion::Orbit | Motion::Pan | Motion::Dolly | Motion::FieldOfView => None,
        }
    }

    /// The point of the line through the pivot along an axis that is nearest to what is seen at a point of the image
    /// plane. `None` if the line leads almost into the picture.
    fn along(&self, axis: DVec3, [x, y]: [f64; 2]) -> Option<DVec3> {
        let camera = &self.scene().camera;
        let (ray, offset) = (camera.direction(x, y), camera.position() - self.pivot);
        let cosine = ray.dot(axis);
        let slant = 1.0 - cosine * cosine;
        // Closest points of two lines.
        let along = (offset.dot(axis) - cosine * offset.dot(ray)) / slant;
        (slant > 1e-3).then_some(self.pivot + along * axis)
    }

    /// The scene with the change so far; `None` if it cannot be like that.
    pub(in crate::preview::app) fn moved(&self) -> Option<Scene> {
        let mut scene = self.scene().clone();
        match self.change()? {
            SceneChange::Camera(camera) => scene.camera = camera,
            SceneChange::Form(id, form) => scene.bodies.get_mut(id.index())?.form = form,
            SceneChange::Light(id, kind) => scene.lights.get_mut(id.index())?.kind = kind,
            SceneChange::AddBody(..) | SceneChange::AddLight(..) | SceneChange::Duplicate(..) | SceneChange::Remove(_) => {
                return None;
            }
        }
        Some(scene)
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

/// The point that stands for a body or light.
pub(in crate::preview::app) fn anchor(scene: &Scene, object: SceneObject) -> Option<DVec3> {
    match object {
        SceneObject::Body(id) => scene.bodies.get(id.index())?.form.anchor(),
        SceneObject::Light(id) => scene.lights.get(id.index())?.kind.anchor(),
    }
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
            // A light has no size. The scene stays as far away as it is.
            let anchor = anchor(world.scene(), light)?;
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
