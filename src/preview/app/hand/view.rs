//! Points of the scene on the screen, and what of the scene can be taken hold of there.

use super::gesture::SceneAxis;
use super::object::{self, shown_place};
use super::outline::Outline;
use super::sight::{anchor, distance, seen_at};
use crate::preview::app::HandleTool;
use crate::preview::app::pane::Placement;
use crate::scene::edit::SceneObject;
use crate::scene::{Camera, LightId};
use crate::world::World;
use egui::{Pos2, Rect, Vec2, pos2};
use glam::DVec3;
use std::sync::Arc;

/// How close the pointer must be to a handle or a marker, in points.
pub(super) const REACH: f32 = 9.0;
/// The length of the arrows along the axes, in points.
pub(super) const ARROW: f32 = 54.0;
/// Where an arrow can be taken hold of, as parts of its length: the middle belongs to the thing itself.
const ARROW_GRIP: [f32; 2] = [0.3, 1.15];
/// An arrow that leads into the picture is too short to be taken hold of, in points.
pub(super) const SHORTEST_ARROW: f32 = 14.0;
/// How far markers of lights outside the picture are from its edge, in points.
const INSET: f32 = 16.0;

/// What can be taken hold of.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::preview::app) enum Grip {
    /// A body or a light, to be moved parallel to the picture.
    Object(SceneObject),
    /// An arrow, to move a body or a light along an axis.
    Arrow(SceneObject, SceneAxis),
    /// The target of a light.
    Target(LightId),
    /// The handle of the radius of a body or a light.
    Radius(SceneObject),
    /// A ring, to turn a body or a light about an axis of the scene.
    Ring(SceneObject, SceneAxis),
    /// A handle along an own axis of a body or a light, to stretch it.
    Factor(SceneObject, SceneAxis),
    /// The square in the middle of a body or a light, to scale it as a whole.
    Middle(SceneObject),
}

impl Grip {
    /// Whether it is a handle, and not the thing itself.
    pub(super) fn is_handle(self) -> bool {
        match self {
            Grip::Object(_) => false,
            Grip::Arrow(..) | Grip::Target(_) | Grip::Radius(_) | Grip::Ring(..) | Grip::Factor(..) | Grip::Middle(_) => true,
        }
    }
}

/// A marker of a light.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct LightMarker {
    pub(super) light: LightId,
    pub(super) at: Pos2,
    /// Where the light is from there, if it is outside the picture: a direction of unit length.
    pub(super) outside: Option<Vec2>,
}

/// The arrows of the selected body or light.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Arrows {
    pub(super) object: SceneObject,
    /// Where all arrows begin.
    pub(super) origin: Pos2,
    /// Where each of them ends.
    pub(super) tips: [(SceneAxis, Pos2); 3],
}

/// A scene on the screen.
pub(in crate::preview::app) struct SceneView<'w> {
    pub(in crate::preview::app) world: &'w Arc<World>,
    pub(in crate::preview::app) placement: Placement,
    /// The pane.
    pub(in crate::preview::app) area: Rect,
    pub(in crate::preview::app) selected: Option<SceneObject>,
    /// What handles do.
    pub(in crate::preview::app) tool: HandleTool,
    /// The outline of the selected body.
    pub(in crate::preview::app) outline: &'w Outline,
}

impl SceneView<'_> {
    pub(super) fn camera(&self) -> &Camera {
        &self.world.scene().camera
    }

    fn size(&self) -> [f32; 2] {
        self.placement.full().map(|side| side.max(1) as f32)
    }

    /// The point of the camera's image plane at a position of the screen.
    pub(in crate::preview::app) fn image_point(&self, at: Pos2) -> [f64; 2] {
        let ([x, y], [width, height]) = (self.placement.point_at(at), self.size());
        [(2.0 * x - width) / height, (height - 2.0 * y) / height].map(f64::from)
    }

    /// The position of a point of the image plane on the screen.
    pub(super) fn position(&self, [x, y]: [f64; 2]) -> Pos2 {
        let [width, height] = self.size();
        self.placement.position_of([0.5 * (width + x as f32 * height), 0.5 * (height - y as f32 * height)])
    }

    /// Where a point of the scene is on the screen; `None` behind the camera.
    pub(in crate::preview::app) fn project(&self, point: DVec3) -> Option<Pos2> {
        let at = self.position(self.camera().project(point)?);
        (at.x.abs() < 1e6 && at.y.abs() < 1e6).then_some(at)
    }

    /// The part of the pane that the picture covers.
    pub(in crate::preview::app) fn picture(&self) -> Rect {
        let [width, height] = self.size();
        let corners = [self.placement.position_of([0.0; 2]), self.placement.position_of([width, height])];
        Rect::from_two_pos(corners[0], corners[1]).intersect(self.area)
    }

    /// The markers of all lights that are shown somewhere.
    pub(super) fn light_markers(&self) -> Vec<LightMarker> {
        let scene = self.world.scene();
        let room = self.picture().shrink(INSET);
        if !room.is_positive() {
            return Vec::new();
        }
        let placed = scene.light_ids().filter_map(|id| Some((id, shown_place(self.world, SceneObject::Light(id))?)));
        placed
            .map(|(light, point)| match self.project(point).filter(|at| room.contains(*at)) {
                Some(at) => LightMarker { light, at, outside: None },
                None => {
                    let [right, above, _] = self.camera().axes().map(|axis| (point - self.camera().position()).dot(axis));
                    // What is behind the camera is seen over the shoulder.
                    let towards = self.project(point).map_or(Vec2::new(right as f32, -above as f32), |at| at - room.center());
                    let towards = if towards.length() > 1e-9 { towards.normalized() } else { Vec2::DOWN };
                    let reach = [(towards.x, room.width()), (towards.y, room.height())]
                        .map(|(part, side)| if part.abs() > 1e-6 { 0.5 * side / part.abs() } else { f32::INFINITY });
                    LightMarker { light, at: room.center() + reach[0].min(reach[1]) * towards, outside: Some(towards) }
                }
            })
            .collect()
    }

    /// Where the selected thing is on the screen, if it is in view: the origin of its arrows.
    pub(super) fn origin(&self) -> Option<Pos2> {
        let anchor = anchor(self.world.scene(), self.selected?)?;
        self.project(anchor).filter(|at| self.picture().contains(*at))
    }

    /// The length in the world that is as long as an arrow at a point, parallel to the picture.
    pub(in crate::preview::app) fn reach_at(&self, point: DVec3) -> f64 {
        let depth = self.camera().depth_of(point);
        let height = self.placement.position_of([0.0, self.size()[1]]).y - self.placement.position_of([0.0, 0.0]).y;
        let half = (self.camera().fov().to_radians() / 2.0).tan();
        2.0 * depth * half * f64::from(ARROW / height.max(1.0))
    }

    /// What the handles of a body or a light do. Where it has no handles of the tool, they move it.
    pub(super) fn tool_of(&self, object: SceneObject) -> HandleTool {
        if object::has_tool(self.world.scene(), object, self.tool) { self.tool } else { HandleTool::Move }
    }

    /// The arrows of the selected thing, from its origin.
    pub(super) fn arrows(&self) -> Option<Arrows> {
        let (object, origin) = (self.selected?, self.origin()?);
        if self.tool_of(object) != HandleTool::Move {
            return None;
        }
        let anchor = anchor(self.world.scene(), object)?;
        let length = self.reach_at(anchor);
        let tips = SceneAxis::ALL.map(|axis| (axis, self.project(anchor + length * axis.direction()).unwrap_or(origin)));
        Some(Arrows { object, origin, tips })
    }

    /// Where the handle of the radius of the selected thing is.
    pub(super) fn radius_handle(&self) -> Option<(SceneObject, Pos2)> {
        let object = self.selected.filter(|object| self.tool_of(*object) == HandleTool::Move)?;
        let (anchor, radius) = (anchor(self.world.scene(), object)?, object::radius(self.world.scene(), object)?);
        let [right, above, _] = self.camera().axes();
        let at = self.project(anchor + radius * (right - above).normalize())?;
        self.area.contains(at).then_some((object, at))
    }

    /// Where the target of the selected light is.
    pub(super) fn target_handle(&self) -> Option<(LightId, Pos2)> {
        let SceneObject::Light(id) = self.selected? else { return None };
        let at = self.project(self.world.scene().lights.get(id.index())?.kind.target()?)?;
        self.picture().contains(at).then_some((id, at))
    }

    /// What can be taken hold of at a position of the screen. Markers and handles count if they are shown.
    pub(in crate::preview::app) fn grip_at(&self, at: Pos2, markers: bool) -> Option<Grip> {
        let near = |point: Pos2| point.distance(at) <= REACH;
        if markers {
            if let Some((object, _)) = self.radius_handle().filter(|(_, point)| near(*point)) {
                return Some(Grip::Radius(object));
            }
            if let Some((id, _)) = self.target_handle().filter(|(_, point)| near(*point)) {
                return Some(Grip::Target(id));
            }
            if let Some(Arrows { object, origin, tips }) = self.arrows() {
                let arrow = tips.into_iter().find(|(_, tip)| is_on_arrow(at, origin, *tip));
                if let Some((axis, _)) = arrow {
                    return Some(Grip::Arrow(object, axis));
                }
                if near(origin) {
                    return Some(Grip::Object(object));
                }
            }
            if let Some(grip) = self.turning_or_scaling_handle_at(at) {
                return Some(grip);
            }
            let markers = || self.light_markers().into_iter().filter(|marker| near(marker.at));
            let selected = markers().find(|marker| self.selected == Some(SceneObject::Light(marker.light)));
            if let Some(marker) = selected.or_else(|| markers().next()) {
                return Some(Grip::Object(SceneObject::Light(marker.light)));
            }
        }
        let [x, y] = self.image_point(at);
        let (body, _) = seen_at(self.world, [x, y])?;
        let grabbed = self.selected == Some(SceneObject::Body(body)) && !self.outline.beyond;
        grabbed.then_some(Grip::Object(SceneObject::Body(body)))
    }

    /// The point of the scene that is taken hold of.
    pub(in crate::preview::app) fn held_point(&self, grip: Grip, at: Pos2) -> DVec3 {
        let from = self.image_point(at);
        let object = match grip {
            Grip::Object(object) | Grip::Arrow(object, _) => object,
            // Turned and scaled about its anchor.
            Grip::Ring(object, _) | Grip::Factor(object, _) | Grip::Middle(object) | Grip::Radius(object) => {
                let anchor = anchor(self.world.scene(), object);
                return anchor.unwrap_or_else(|| self.camera().point_at(from, distance(self.world)));
            }
            Grip::Target(id) => {
                let target = self.world.scene().lights.get(id.index()).and_then(|light| light.kind.target());
                return target.unwrap_or_else(|| self.camera().point_at(from, distance(self.world)));
            }
        };
        match (shown_place(self.world, object), object) {
            (_, SceneObject::Body(id))
                if let Some((body, point)) = seen_at(self.world, from)
                    && body == id =>
            {
                point
            }
            (Some(point), _) if self.project(point).is_some_and(|seen| self.picture().contains(seen)) => point,
            // A light outside the picture moves as if it were as far away as the scene.
            _ => self.camera().point_at(from, distance(self.world)),
        }
    }
}

/// Whether a position is on the arrow from an origin to a tip.
pub(super) fn is_on_arrow(at: Pos2, origin: Pos2, tip: Pos2) -> bool {
    let (arrow, from) = (tip - origin, at - origin);
    let length = arrow.length();
    if length < SHORTEST_ARROW {
        return false;
    }
    let along = from.dot(arrow) / (length * length);
    let beside = (pos2(at.x, at.y) - (origin + along * arrow)).length();
    (ARROW_GRIP[0]..=ARROW_GRIP[1]).contains(&along) && beside <= 0.75 * REACH
}
