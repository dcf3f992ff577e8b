//! A gesture: something in the scene follows the pointer, the wheel or keys, from a start to an end.
//!
//! The scene of a gesture is always computed from the scene at its start, so it does not depend on the number of steps.

use super::object;
use super::sight::anchor;
use crate::scene::edit::{Precision, SceneChange, SceneObject, rounded};
use crate::scene::{Camera, LightId, Scene};
use crate::world::World;
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
    /// The target of a light, in the same ways.
    Aim(LightId, Option<SceneAxis>),
    /// The radius of a body or a light.
    Resize(SceneObject),
    /// A body or a light, about an axis of the scene through its anchor.
    Turn(SceneObject, SceneAxis),
    /// A body or a light, larger along one of its own axes.
    Stretch(SceneObject, SceneAxis),
    /// A body or a light, larger in all directions.
    Grow(SceneObject),
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
            Motion::Move(object, _)
            | Motion::Resize(object)
            | Motion::Turn(object, _)
            | Motion::Stretch(object, _)
            | Motion::Grow(object) => object::name(self.scene(), object).to_owned(),
            Motion::Aim(id, _) => object::name(self.scene(), SceneObject::Light(id)).to_owned(),
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
            Motion::Move(object, _) => object::moved(&self.start, object, self.way()?, self.snaps.then_some(SNAPPED_ANGLE)),
            Motion::Aim(id, _) => {
                let kind = &self.scene().light(id).kind;
                let aimed = kind.aimed(kind.anchor()?, kind.target()? + self.way()?)?;
                Some(SceneChange::Light(id, aimed))
            }
            Motion::Resize(object) | Motion::Grow(object) => object::scaled(self.scene(), object, self.factor()?),
            Motion::Stretch(object, axis) => {
                let mut factors = DVec3::ONE;
                factors[axis.index()] = self.factor()?;
                object::stretched(self.scene(), object, factors)
            }
            Motion::Turn(object, _) => {
                let Sweep { axis, degrees, .. } = self.sweep()?;
                object::turned(self.scene(), object, axis, degrees)
            }
        }
    }

    /// The way by which something is moved.
    fn way(&self) -> Option<DVec3> {
        let (Motion::Move(_, axis) | Motion::Aim(_, axis), Travel { from, to, .. }) = (self.motion, self.travel) else {
            return None;
        };
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

    /// The factor by which a body or a light is scaled.
    pub(in crate::preview::app) fn factor(&self) -> Option<f64> {
        let Travel { from, to, amount } = self.travel;
        let factor = match self.motion {
            Motion::Resize(object) => {
                let (camera, anchor) = (&self.scene().camera, anchor(self.scene(), object)?);
                let depth = camera.depth_of(anchor);
                let [before, after] = [from, to].map(|point| camera.point_at(point, depth).distance(anchor));
                after / before
            }
            Motion::Stretch(object, axis) => {
                let direction = object::axes(self.scene(), object)?[axis.index()];
                let [before, after] = [from, to].map(|point| Some((self.along(direction, point)? - self.pivot).dot(direction)));
                (after? / before?).max(LEAST_FACTOR)
            }
            Motion::Grow(_) => amount[1].exp(),
            Motion::Orbit
            | Motion::Pan
            | Motion::Dolly
            | Motion::FieldOfView
            | Motion::Move(..)
            | Motion::Aim(..)
            | Motion::Turn(..) => return None,
        };
        if self.snaps {
            return Some(rounded((factor / SNAPPED_FACTOR).round().max(1.0) * SNAPPED_FACTOR, 1));
        }
        let digits = FACTOR_DIGITS - 1 - factor.log10().floor() as i32;
        (factor.is_finite() && factor > 0.0).then(|| rounded(factor, digits))
    }

    /// How far a body or a light is turned, if it is.
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
            Motion::Move(_, Some(axis)) | Motion::Aim(_, Some(axis)) => {
                let way = self.way()?[axis.index()];
                let sign = if way < 0.0 { "−" } else { "+" };
                Some(format!("{} {sign}{}", axis.name(), way.abs()))
            }
            Motion::Move(_, None) | Motion::Aim(_, None) | Motion::Orbit | Motion::Pan | Motion::Dolly | Motion::FieldOfView => {
                None
            }
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
