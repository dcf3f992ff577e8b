//! The handles that turn and scale what is selected: rings about the axes of the scene, and handles along the own axes
//! of a body or light.

use super::gesture::SceneAxis;
use super::object;
use super::sight::anchor;
use super::view::{ARROW, Grip, REACH, SHORTEST_ARROW, SceneView, is_on_arrow};
use crate::preview::app::HandleTool;
use crate::scene::edit::SceneObject;
use egui::{Pos2, Vec2};
use glam::DVec3;

/// The radius of the rings, as a part of the length of an arrow.
pub(super) const RING: f64 = 1.25;
/// The number of pieces of a ring.
const PIECES: usize = 72;
/// How far behind its centre a ring is still in front, as a part of its radius. A ring that faces the camera is in
/// front everywhere.
const BEHIND: f64 = 0.3;

/// A ring on the screen.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Ring {
    pub(super) axis: SceneAxis,
    /// The ends of each piece, and whether it is in front of the middle.
    pub(super) pieces: Vec<([Pos2; 2], bool)>,
}

/// The handles along the own axes of a body or light.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct FactorHandles {
    pub(super) object: SceneObject,
    /// Where all of them begin.
    pub(super) origin: Pos2,
    /// Where each of them ends.
    pub(super) tips: Vec<(SceneAxis, Pos2)>,
}

impl SceneView<'_> {
    /// The selected thing, with its anchor in view, if its handles are of this tool.
    fn object_with(&self, tool: HandleTool) -> Option<(SceneObject, DVec3, Pos2)> {
        let object = self.selected.filter(|object| self.tool_of(*object) == tool)?;
        Some((object, anchor(self.world.scene(), object)?, self.origin()?))
    }

    /// The rings about the anchor of the selected thing.
    pub(super) fn rings(&self) -> Option<(SceneObject, [Ring; 3])> {
        let (object, anchor, _) = self.object_with(HandleTool::Rotate)?;
        let radius = RING * self.reach_at(anchor);
        let view = (anchor - self.camera().position()).normalize();
        let ring = |axis: SceneAxis| {
            let along = axis.direction();
            let (one, other) = along.any_orthonormal_pair();
            let points: Vec<(DVec3, Option<Pos2>)> = (0..=PIECES)
                .map(|piece| {
                    let (sine, cosine) = (piece as f64 / PIECES as f64 * std::f64::consts::TAU).sin_cos();
                    let from = cosine * one + sine * other;
                    (from, self.project(anchor + radius * from))
                })
                .collect();
            let pieces = points.windows(2).filter_map(|ends| {
                let [(from, start), (to, end)] = [ends[0], ends[1]];
                Some(([start?, end?], 0.5 * (from + to).dot(view) <= BEHIND))
            });
            Ring { axis, pieces: pieces.collect() }
        };
        Some((object, SceneAxis::ALL.map(ring)))
    }

    /// The handles along the own axes of the selected thing, from its origin. What is flat has two, a sphere that
    /// shines none.
    pub(super) fn factor_handles(&self) -> Option<FactorHandles> {
        let (object, anchor, origin) = self.object_with(HandleTool::Scale)?;
        let scene = self.world.scene();
        let (length, directions) = (self.reach_at(anchor), object::axes(scene, object)?);
        let axes = SceneAxis::ALL.into_iter().filter(|axis| object::has_extent_along(scene, object, axis.index()));
        let tips = axes.filter_map(|axis| {
            let tip = self.project(anchor + length * directions[axis.index()])?;
            (tip.distance(origin) >= SHORTEST_ARROW).then_some((axis, tip))
        });
        Some(FactorHandles { object, origin, tips: tips.collect() })
    }

    /// The ring, or the handle that scales, at a position of the screen.
    pub(super) fn turning_or_scaling_handle_at(&self, at: Pos2) -> Option<Grip> {
        if let Some((object, rings)) = self.rings() {
            let nearest = rings.iter().filter_map(|ring| {
                let front = ring.pieces.iter().filter(|(_, is_front)| *is_front);
                let distances = front.map(|(ends, _)| distance_to_piece(at, *ends));
                distances.min_by(f32::total_cmp).map(|distance| (distance, ring.axis))
            });
            let nearest = nearest.min_by(|(one, _), (other, _)| one.total_cmp(other))?;
            return (nearest.0 <= 0.75 * REACH).then_some(Grip::Ring(object, nearest.1));
        }
        let FactorHandles { object, origin, tips } = self.factor_handles()?;
        let on_axis = tips.into_iter().find(|(_, tip)| is_on_arrow(at, origin, *tip));
        let on_middle = (origin.distance(at) <= REACH).then_some(Grip::Middle(object));
        on_axis.map(|(axis, _)| Grip::Factor(object, axis)).or(on_middle)
    }

    /// Where the words about a gesture stand: beside the handles of a thing, where they cover none.
    pub(super) fn place_for_words(&self) -> Option<Pos2> {
        let origin = self.origin()?;
        let below = origin + Vec2::new(0.0, (RING as f32 * ARROW) + 22.0);
        let above = origin - Vec2::new(0.0, (RING as f32 * ARROW) + 22.0);
        Some(if self.picture().contains(below + Vec2::new(0.0, 12.0)) { below } else { above })
    }
}

/// The distance from a position to a piece of a line.
fn distance_to_piece(at: Pos2, [start, end]: [Pos2; 2]) -> f32 {
    let (piece, from) = (end - start, at - start);
    let along = (from.dot(piece) / piece.length_sq().max(f32::MIN_POSITIVE)).clamp(0.0, 1.0);
    (from - along * piece).length()
}
