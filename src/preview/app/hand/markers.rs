//! Draws markers over the picture: lights, the outline of the selected body, and its handles.

use super::gesture::SceneAxis;
use super::view::{Arrows, Grip, LightMarker, SceneView};
use crate::scene::edit::SceneObject;
use egui::{Align2, Color32, FontId, Painter, Pos2, Shape, Stroke, Vec2, pos2};

/// The colour of what is selected, which is seen on any picture with the dark line under it.
const SELECTED: Color32 = Color32::from_rgb(255, 166, 43);
/// The colour of what is under the pointer.
const HOVERED: Color32 = Color32::WHITE;
/// The colour of lights.
const LIGHT: Color32 = Color32::from_rgb(255, 221, 87);
/// The line under every other one.
const UNDER: Color32 = Color32::from_black_alpha(170);

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

/// Draws all markers. `hovered` is what the pointer could take hold of, or holds.
pub(super) fn draw(painter: &Painter, view: &SceneView<'_>, hovered: Option<Grip>) {
    draw_outline(painter, view);
    for marker in view.light_markers() {
        let is_selected = view.selected == Some(marker.light);
        let is_hovered = hovered == Some(Grip::Object(marker.light));
        draw_light(
            painter,
            view,
            &marker,
            if is_hovered {
                HOVERED
            } else if is_selected {
                SELECTED
            } else {
                LIGHT
            },
        );
    }
    draw_handles(painter, view, hovered);
}

fn draw_outline(painter: &Painter, view: &SceneView<'_>) {
    let pieces: Vec<[Pos2; 2]> = view.outline.pieces.iter().map(|piece| piece.map(|point| view.position(point))).collect();
    for (width, colour) in [(3.5, UNDER), (1.75, SELECTED)] {
        painter.extend(pieces.iter().map(|ends| Shape::line_segment(*ends, Stroke::new(width, colour))));
    }
}

/// A sun; an arrow at the edge of the picture if the light is outside.
fn draw_light(painter: &Painter, view: &SceneView<'_>, marker: &LightMarker, colour: Color32) {
    let at = marker.at;
    let name = match marker.light {
        SceneObject::Light(id) => view.world.scene().light(id).name.as_str(),
        SceneObject::Body(_) => "",
    };
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
    painter.rect_filled(place.expand2(Vec2::new(3.0, 1.0)), 3.0, UNDER);
    painter.galley(place.min, galley, colour);
}

fn draw_handles(painter: &Painter, view: &SceneView<'_>, hovered: Option<Grip>) {
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
    if let Some((id, at)) = view.radius_handle() {
        let colour = if hovered == Some(Grip::Radius(id)) { HOVERED } else { SELECTED };
        let square = egui::Rect::from_center_size(pos2(at.x, at.y), Vec2::splat(9.0));
        painter.rect_filled(square.expand(1.5), 2.0, UNDER);
        painter.rect_filled(square, 1.0, colour);
    }
}
