//! The shapes of lights on the screen: cones, circles, edges, arrows.

use super::object::shown_rays;
use super::view::SceneView;
use crate::scene::light::{RectangleLight, SphereLight, SpotLight};
use crate::scene::{LightId, LightKind};
use egui::{Pos2, Vec2};
use glam::DVec3;

/// The pieces of a circle.
const CIRCLE: usize = 64;
/// The pieces of a line: those behind the camera are left out.
const LINE: usize = 12;
/// The lines from the top of a cone to its edge.
const SIDES: usize = 4;
/// From where to where the arrow of parallel light goes, in points from its marker.
const ARROW: [f32; 2] = [13.0, 40.0];

/// The lines of a light on the screen.
#[derive(Debug, Clone, Default)]
pub(super) struct LightShape {
    /// The ends of the pieces.
    pub(super) pieces: Vec<[Pos2; 2]>,
    /// Fainter ones: where the light of a cone begins to get weaker.
    pub(super) faint: Vec<[Pos2; 2]>,
    /// The tip of an arrow, and its direction of unit length.
    pub(super) tip: Option<(Pos2, Vec2)>,
}

impl SceneView<'_> {
    /// The lines of a light. A point and an environment have none.
    pub(super) fn light_shape(&self, id: LightId) -> LightShape {
        let Some(light) = self.world.scene().lights.get(id.index()) else { return LightShape::default() };
        match &light.kind {
            LightKind::Point(_) | LightKind::Environment(_) => LightShape::default(),
            LightKind::Directional(_) => self.arrow(&light.kind),
            LightKind::Spot(spot) => self.cone(spot),
            LightKind::Sphere(sphere) => self.silhouette(sphere),
            LightKind::Rectangle(rectangle) => self.edges(rectangle),
        }
    }

    /// The pieces between neighbouring points, without those behind the camera.
    fn lines(&self, points: impl IntoIterator<Item = DVec3>) -> Vec<[Pos2; 2]> {
        let seen: Vec<Option<Pos2>> = points.into_iter().map(|point| self.project(point)).collect();
        seen.windows(2).filter_map(|ends| Some([ends[0]?, ends[1]?])).collect()
    }

    fn line_between(&self, from: DVec3, to: DVec3) -> Vec<[Pos2; 2]> {
        self.lines((0..=LINE).map(|piece| from.lerp(to, piece as f64 / LINE as f64)))
    }

    /// A circle about a middle, in the plane that is perpendicular to a normal of unit length.
    fn circle(&self, middle: DVec3, normal: DVec3, radius: f64) -> Vec<[Pos2; 2]> {
        let (one, other) = normal.any_orthonormal_pair();
        self.lines((0..=CIRCLE).map(|piece| {
            let (sine, cosine) = (piece as f64 / CIRCLE as f64 * std::f64::consts::TAU).sin_cos();
            middle + radius * (cosine * one + sine * other)
        }))
    }

    /// From the marker towards the middle of the picture.
    fn arrow(&self, kind: &LightKind) -> LightShape {
        let ends = shown_rays(self.world, kind).and_then(|[from, to]| Some([self.project(from)?, self.project(to)?]));
        let Some([from, to]) = ends.filter(|[from, to]| from.distance(*to) > ARROW[0]) else { return LightShape::default() };
        let towards = (to - from).normalized();
        let [start, end] = ARROW.map(|along| from + along.min(from.distance(to)) * towards);
        LightShape { pieces: vec![[start, end]], tip: Some((end, towards)), ..LightShape::default() }
    }

    /// The cone up to where its sides are as long as the way to the target.
    fn cone(&self, spot: &SpotLight) -> LightShape {
        let (top, way) = (spot.position(), spot.target() - spot.position());
        let (length, axis) = (way.length(), way.normalize());
        let edge = |degrees: f64| {
            let (sine, cosine) = degrees.to_radians().sin_cos();
            (top + length * cosine * axis, length * sine)
        };
        let (middle, radius) = edge(spot.angle());
        let (one, other) = axis.any_orthonormal_pair();
        let mut pieces = self.circle(middle, axis, radius);
        for side in 0..SIDES {
            let (sine, cosine) = (side as f64 / SIDES as f64 * std::f64::consts::TAU).sin_cos();
            pieces.extend(self.line_between(top, middle + radius * (cosine * one + sine * other)));
        }
        let mut faint = self.line_between(top, spot.target());
        if spot.soft() > 0.0 && spot.soft() < spot.angle() {
            let (middle, radius) = edge(spot.angle() - spot.soft());
            faint.extend(self.circle(middle, axis, radius));
        }
        LightShape { pieces, faint, tip: None }
    }

    /// The circle in which the camera sees a sphere.
    fn silhouette(&self, light: &SphereLight) -> LightShape {
        let (center, radius) = (light.sphere().center(), light.sphere().radius());
        let way = self.camera().position() - center;
        let share = radius / way.length();
        if share.is_nan() || share >= 1.0 {
            return LightShape::default();
        }
        // Where rays from the camera touch the sphere.
        let pieces = self.circle(center + share * share * way, way.normalize(), radius * (1.0 - share * share).sqrt());
        LightShape { pieces, ..LightShape::default() }
    }

    fn edges(&self, light: &RectangleLight) -> LightShape {
        let [a, b, c] = light.rectangle().corners();
        let corners = [a, b, c, a + c - b, a];
        let pieces = corners.windows(2).flat_map(|ends| self.line_between(ends[0], ends[1]));
        LightShape { pieces: pieces.collect(), ..LightShape::default() }
    }
}
