//! Draws markers over the picture: lights with their shapes, the outline of the selected body, and handles.

use super::gesture::{Gesture, Motion, SceneAxis, Sweep};
use super::handles::{FactorHandles, RING, Ring};
use super::light_shapes::LightShape;
use super::view::{Arrows, Grip, LightMarker, SceneView};
use crate::scene::edit::SceneObject;
use egui::{Align2, Color32, FontId, Painter, Pos2, Shape, Stroke, Vec2};

/// The colour of what is selected, which is seen on any picture with the dark line under it.
const SELECTED: Color32 = Color32::from_rgb(255, 166, 43);
/// The colour of what is under the pointer.
const HOVERED: Color32 = Color32::WHITE;
/// The colour of lights.
const LIGHT: Color32 = Color32::from_rgb(255, 221, 87);
/// The line under every other one.
const UNDER: Color32 = Color32::from_black_alpha(170);
/// What is under words.
const UNDER_WORDS: Color32 = Color32::from_black_alpha(205);

/// The usual colour of an axis.
fn axis_colour(axis: SceneAxis) -> Color32 {
    match axis {
        SceneAxis::X => Color32::from_rgb(240, 84, 84),
        SceneAxis::Y => Color32::from_rgb(118, 208, 80),
        SceneAxis::Z => Color32::from_rgb(86, 148, 255),
    }
}

/// Draws a line that is seen on any picture.
fn line(painter: &Painter, ends: [Pos2; 2], width: f32, colour: Color32) {
    painter.line_segment(ends, Stroke::new(width + 2.0, UNDER));
    painter.line_segment(ends, Stroke::new(width, colour));
}

/// Draws all markers. `hovered` is what the pointer could take hold of, or holds. A gesture says how far it has gone.
pub(super) fn draw(painter: &Painter, view: &SceneView<'_>, hovered: Option<Grip>, gesture: Option<&Gesture>) {
    draw_outline(painter, view);
    for marker in view.light_markers() {
        let is_selected = view.selected == Some(SceneObject::Light(marker.light));
        let is_hovered = hovered == Some(Grip::Object(SceneObject::Light(marker.light)));
        let colour = match (is_hovered, is_selected) {
            (true, _) => HOVERED,
            (false, true) => SELECTED,
            (false, false) => LIGHT,
        };
        let inside = painter.with_clip_rect(view.picture());
        draw_light_shape(&inside, &view.light_shape(marker.light), colour, is_hovered || is_selected);
        draw_light(painter, view, &marker, colour);
    }
    draw_arrows(painter, view, hovered);
    draw_rings(painter, view, hovered, gesture);
    draw_factors(painter, view, hovered, gesture);
    if let Some((text, at)) = gesture.and_then(Gesture::words).zip(view.place_for_words()) {
        words(painter, at, Align2::CENTER_CENTER, &text, HOVERED);
    }
}

fn draw_outline(painter: &Painter, view: &SceneView<'_>) {
    let pieces: Vec<[Pos2; 2]> = view.outline.pieces.iter().map(|piece| piece.map(|point| view.position(point))).collect();
    for (width, colour) in [(3.5, UNDER), (1.75, SELECTED)] {
        painter.extend(pieces.iter().map(|ends| Shape::line_segment(*ends, Stroke::new(width, colour))));
    }
}

/// The lines of a light. Those of a light that is neither selected nor under the pointer are faint.
fn draw_light_shape(painter: &Painter, shape: &LightShape, colour: Color32, is_marked: bool) {
    let draw = |pieces: &[[Pos2; 2]], stroke: Stroke| {
        painter.extend(pieces.iter().map(|ends| Shape::line_segment(*ends, stroke)));
    };
    if is_marked {
        draw(&shape.faint, Stroke::new(1.0, colour.gamma_multiply(0.7)));
        draw(&shape.pieces, Stroke::new(3.5, UNDER));
    }
    let strength = if is_marked { 1.0 } else { 0.55 };
    draw(&shape.pieces, Stroke::new(if is_marked { 1.75 } else { 1.0 }, colour.gamma_multiply(strength)));
    if let Some((tip, towards)) = shape.tip {
        let across = Vec2::new(-towards.y, towards.x);
        let head = vec![tip + 9.0 * towards, tip + 4.5 * across, tip - 4.5 * across];
        painter.add(Shape::convex_polygon(head, colour, Stroke::new(1.0, UNDER)));
    }
}

/// A sun; an arrow at the edge of the picture if the light is outside.
fn draw_light(painter: &Painter, view: &SceneView<'_>, marker: &LightMarker, colour: Color32) {
    let at = marker.at;
    let name = view.world.scene().lights.get(marker.light.index()).map_or("", |light| &light.name);
    if let Some(towards) = marker.outside {
        let across = Vec2::new(-towards.y, towards.x);
        let triangle = |size: f32| {
            vec![
                at + size * 1.1 * towards,
                at - 0.6 * size * towards + 0.8 * size * across,
                at - 0.6 * size * towards - 0.8 * size * across,
            ]
        };
        painter.add(Shape::convex_polygon(triangle(11.0), UNDER, Stroke::NONE));
        painter.add(Shape::convex_polygon(triangle(8.0), colour, Stroke::NONE));
    } else {
        for ray in 0..8 {
            let direction = Vec2::angled(ray as f32 * std::f32::consts::FRAC_PI_4);
            line(painter, [at + 6.5 * direction, at + 10.0 * direction], 1.5, colour);
        }
        painter.circle(at, 4.5, colour, Stroke::new(1.5, UNDER));
    }
    // The name is on the side that has room.
    let side = if at.x > view.picture().center().x { -1.0 } else { 1.0 };
    let align = if side > 0.0 { Align2::LEFT_CENTER } else { Align2::RIGHT_CENTER };
    words(painter, at + Vec2::new(side * 14.0, 0.0), align, name, colour);
}

fn words(painter: &Painter, at: Pos2, align: Align2, text: &str, colour: Color32) {
    let galley = painter.layout_no_wrap(text.to_owned(), FontId::proportional(12.0), colour);
    let place = align.anchor_size(at, galley.size());
    painter.rect_filled(place.expand2(Vec2::new(3.0, 1.0)), 3.0, UNDER_WORDS);
    painter.galley(place.min, galley, colour);
}

fn draw_arrows(painter: &Painter, view: &SceneView<'_>, hovered: Option<Grip>) {
    if let Some(Arrows { object, origin, tips }) = view.arrows() {
        for (axis, tip) in tips {
            let towards = (tip - origin).normalized();
            if (tip - origin).length() < 4.0 {
                continue;
            }
            let is_hovered = hovered == Some(Grip::Arrow(object, axis));
            let colour = if is_hovered { HOVERED } else { axis_colour(axis) };
            line(painter, [origin + 8.0 * towards, tip], 2.0, colour);
            let across = Vec2::new(-towards.y, towards.x);
            let head = vec![tip + 9.0 * towards, tip + 4.5 * across, tip - 4.5 * across];
            painter.add(Shape::convex_polygon(head, colour, Stroke::new(1.0, UNDER)));
            words(painter, tip + 19.0 * towards, Align2::CENTER_CENTER, axis.name(), colour);
        }
        let colour = if hovered == Some(Grip::Object(object)) { HOVERED } else { SELECTED };
        if matches!(object, SceneObject::Body(_)) {
            painter.circle(origin, 4.0, colour, Stroke::new(1.5, UNDER));
        }
    }
    if let Some((object, at)) = view.radius_handle() {
        square(painter, at, if hovered == Some(Grip::Radius(object)) { HOVERED } else { SELECTED });
    }
    if let Some((id, at)) = view.target_handle() {
        square(painter, at, if hovered == Some(Grip::Target(id)) { HOVERED } else { SELECTED });
    }
}

fn square(painter: &Painter, at: Pos2, colour: Color32) {
    let square = egui::Rect::from_center_size(at, Vec2::splat(9.0));
    painter.rect_filled(square.expand(1.5), 2.0, UNDER);
    painter.rect_filled(square, 1.0, colour);
}

/// Draws the rings. What is behind their middle is thin. While one is turned, the others are not shown.
fn draw_rings(painter: &Painter, view: &SceneView<'_>, hovered: Option<Grip>, gesture: Option<&Gesture>) {
    let Some((object, rings)) = view.rings() else { return };
    let turned = match gesture.map(|gesture| gesture.motion) {
        Some(Motion::Turn(_, axis)) => Some(axis),
        Some(_) | None => None,
    };
    if let Some(sweep) = gesture.and_then(Gesture::sweep) {
        draw_sweep(painter, view, &sweep, turned.map_or(SELECTED, axis_colour));
    }
    let shown = || rings.iter().filter(|ring| turned.is_none_or(|axis| axis == ring.axis));
    let draw = |ring: &Ring, front: bool, stroke: Stroke| {
        let pieces = ring.pieces.iter().filter(|(_, is_front)| *is_front == front);
        painter.extend(pieces.map(|(ends, _)| Shape::line_segment(*ends, stroke)));
    };
    for ring in shown() {
        draw(ring, false, Stroke::new(1.0, axis_colour(ring.axis).gamma_multiply(0.45)));
    }
    for ring in shown() {
        draw(ring, true, Stroke::new(4.0, UNDER));
    }
    for ring in shown() {
        let is_hovered = hovered == Some(Grip::Ring(object, ring.axis));
        draw(ring, true, Stroke::new(2.0, if is_hovered && turned.is_none() { HOVERED } else { axis_colour(ring.axis) }));
    }
    if let Some(origin) = view.origin() {
        painter.circle(origin, 4.0, SELECTED, Stroke::new(1.5, UNDER));
    }
}

/// Draws what a turn has swept: a sector between two lines.
fn draw_sweep(painter: &Painter, view: &SceneView<'_>, sweep: &Sweep, colour: Color32) {
    /// The most degrees of a piece.
    const PIECE: f64 = 5.0;
    let radius = RING * view.reach_at(sweep.center);
    let Some(center) = view.project(sweep.center) else { return };
    let pieces = (sweep.degrees.abs() / PIECE).ceil().max(1.0) as u32;
    let across = sweep.axis.cross(sweep.start);
    let rim = (0..=pieces).filter_map(|piece| {
        let (sine, cosine) = (sweep.degrees.to_radians() * f64::from(piece) / f64::from(pieces)).sin_cos();
        view.project(sweep.center + radius * (cosine * sweep.start + sine * across))
    });
    let rim: Vec<Pos2> = rim.collect();
    for piece in rim.windows(2) {
        let triangle = vec![center, piece[0], piece[1]];
        painter.add(Shape::convex_polygon(triangle, colour.gamma_multiply(0.35), Stroke::NONE));
    }
    for end in rim.first().into_iter().chain(rim.last()) {
        line(painter, [center, *end], 1.5, HOVERED);
    }
}

/// Draws the handles that scale. One that is held goes with the pointer.
fn draw_factors(painter: &Painter, view: &SceneView<'_>, hovered: Option<Grip>, gesture: Option<&Gesture>) {
    let Some(FactorHandles { object, origin, tips }) = view.factor_handles() else { return };
    for (axis, tip) in tips {
        let is_held = gesture.is_some_and(|gesture| gesture.motion == Motion::Stretch(object, axis));
        let factor = gesture.filter(|_| is_held).and_then(Gesture::factor).unwrap_or(1.0) as f32;
        let towards = (tip - origin).normalized();
        let tip = origin + factor.clamp(0.3, 20.0) * (tip - origin);
        let colour = if hovered == Some(Grip::Factor(object, axis)) { HOVERED } else { axis_colour(axis) };
        line(painter, [origin + 8.0 * towards, tip], 2.0, colour);
        square(painter, tip, colour);
        words(painter, tip + 17.0 * towards, Align2::CENTER_CENTER, axis.name(), colour);
    }
    square(painter, origin, if hovered == Some(Grip::Middle(object)) { HOVERED } else { SELECTED });
}
