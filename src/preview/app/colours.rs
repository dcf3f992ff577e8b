//! Colours of parameters as the picture shows them: swatches, hexadecimal fields, and the picker.
//!
//! Values are linear. What is displayed went through the transfer of the session, as in the picture, but not through
//! its exposure and tone curve: a swatch shows the value, not the light on it. The picker and the field work on the
//! displayed colour.

use crate::picture::{Transfer, ViewTransform};
use crate::preview::app::number_field::{EditPhase, component_ui};
use egui::epaint::Mesh;
use egui::{Color32, Id, Key, Pos2, Rect, Response, RichText, Sense, Stroke, StrokeKind, TextEdit, TextStyle, Ui, vec2};

/// A linear colour as it is displayed, each component 0..1.
fn displayed(view: impl Into<ViewTransform>, linear: [f32; 3]) -> [f32; 3] {
    let view = view.into();
    linear.map(|component| view.at(f64::from(component)) as f32)
}

/// A displayed colour as bytes.
fn bytes(displayed: [f32; 3]) -> [u8; 3] {
    displayed.map(|component| (255.0 * component).round() as u8)
}

/// A displayed colour for widgets.
fn opaque(displayed: [f32; 3]) -> Color32 {
    let [red, green, blue] = bytes(displayed);
    Color32::from_rgb(red, green, blue)
}

/// A linear colour as it is displayed.
pub(super) fn shown_colour(view: impl Into<ViewTransform>, linear: [f32; 3]) -> Color32 {
    opaque(displayed(view, linear))
}

/// Paints a square of a colour, with a thin frame so that it shows on any background.
pub(super) fn paint_swatch(ui: &Ui, rect: Rect, colour: Color32) {
    ui.painter().rect_filled(rect, 3.0, colour);
    ui.painter().rect_stroke(rect, 3.0, Stroke::new(1.0, ui.visuals().text_color().gamma_multiply(0.35)), StrokeKind::Inside);
}

/// A button that shows a colour.
pub(super) fn swatch_button(ui: &mut Ui, transfer: Transfer, linear: [f32; 3]) -> Response {
    let height = ui.spacing().interact_size.y;
    let (rect, response) = ui.allocate_exact_size(vec2(40.0, height), Sense::click());
    response.widget_info(|| egui::WidgetInfo::labeled(egui::WidgetType::ColorButton, ui.is_enabled(), "Colour"));
    paint_swatch(ui, rect.shrink2(vec2(0.0, 2.0)), shown_colour(transfer, linear));
    if response.hovered() || response.has_focus() {
        let stroke = ui.visuals().widgets.hovered.fg_stroke;
        ui.painter().rect_stroke(rect.shrink2(vec2(0.0, 2.0)), 3.0, stroke, StrokeKind::Inside);
    }
    response.on_hover_text("Pick the colour")
}

/// The text `#rrggbb` of a linear colour as it is displayed.
fn hex_text(transfer: Transfer, linear: [f32; 3]) -> String {
    let [red, green, blue] = bytes(displayed(transfer, linear));
    format!("#{red:02x}{green:02x}{blue:02x}")
}

/// The linear colour of a text `#rrggbb` or `#rgb`, with or without `#`.
fn linear_of_hex(transfer: Transfer, text: &str) -> Option<[f32; 3]> {
    let digits = text.trim().trim_start_matches('#');
    if !digits.chars().all(|digit| digit.is_ascii_hexdigit()) {
        return None;
    }
    let pairs = match digits.len() {
        3 => digits.chars().flat_map(|digit| [digit, digit]).collect(),
        6 => digits.to_owned(),
        _ => return None,
    };
    let mut linear = [0.0; 3];
    for (index, component) in linear.iter_mut().enumerate() {
        let byte = u8::from_str_radix(pairs.get(2 * index..2 * index + 2)?, 16).ok()?;
        *component = transfer.decode(f64::from(byte) / 255.0) as f32;
    }
    Some(linear)
}

/// A field with the displayed colour. Returns the linear colour that was entered.
pub(super) fn hex_ui(ui: &mut Ui, transfer: Transfer, linear: [f32; 3]) -> Option<[f32; 3]> {
    let id = ui.make_persistent_id("hex");
    let shown = hex_text(transfer, linear);
    let mut text = ui.data(|data| data.get_temp::<String>(id)).unwrap_or_else(|| shown.clone());
    let is_wrong = linear_of_hex(transfer, &text).is_none();
    let colour = if is_wrong { ui.visuals().error_fg_color } else { ui.visuals().text_color() };
    let field = TextEdit::singleline(&mut text).id(id).font(TextStyle::Monospace).text_color(colour);
    let response = ui.add(field.desired_width(62.0).char_limit(24));
    let response = response.on_hover_text("The colour as it is displayed: #rrggbb");
    if response.has_focus() {
        ui.data_mut(|data| data.insert_temp(id, text));
        return None;
    }
    ui.data_mut(|data| data.remove::<String>(id));
    let given_up = ui.input(|input| input.key_pressed(Key::Escape));
    // A text that was not changed would round the value.
    (response.lost_focus() && !given_up && text != shown).then(|| linear_of_hex(transfer, &text)).flatten()
}

/// Hue, saturation and value of a displayed colour, each 0..1.
type Hsv = [f32; 3];

fn rgb_of([hue, saturation, value]: Hsv) -> [f32; 3] {
    // Each component is the same curve of the hue, shifted by a third.
    [5.0, 3.0, 1.0].map(|shift| {
        let k = (shift + 6.0 * hue) % 6.0;
        value - value * saturation * k.min(4.0 - k).clamp(0.0, 1.0)
    })
}

fn hsv_of(rgb: [f32; 3]) -> Hsv {
    let [red, green, blue] = rgb;
    let (most, least) = (rgb.into_iter().fold(0.0, f32::max), rgb.into_iter().fold(1.0, f32::min));
    let chroma = most - least;
    if chroma <= 0.0 {
        return [0.0, 0.0, most];
    }
    let sixth = if most == red {
        (green - blue) / chroma
    } else if most == green {
        (blue - red) / chroma + 2.0
    } else {
        (red - green) / chroma + 4.0
    };
    [sixth.rem_euclid(6.0) / 6.0, chroma / most, most]
}

/// The colour that the picker shows. A grey has no hue, and black has no saturation either. So the picker keeps the
/// last hue and saturation, until the colour is changed elsewhere.
fn picked(ui: &Ui, id: Id, rgb: [f32; 3]) -> Hsv {
    let last = ui.data(|data| data.get_temp::<Hsv>(id));
    let is_same = |hsv: &Hsv| rgb_of(*hsv).into_iter().zip(rgb).all(|(one, other)| (one - other).abs() < 2e-3);
    last.filter(is_same).unwrap_or_else(|| hsv_of(rgb))
}

/// Draws the picker. Returns the linear colour that was picked.
pub(super) fn picker_ui(ui: &mut Ui, transfer: Transfer, linear: [f32; 3]) -> Option<([f32; 3], EditPhase)> {
    const WIDTH: f32 = 204.0;
    ui.set_width(WIDTH);
    let id = ui.make_persistent_id("picker");
    let mut hsv = picked(ui, id, displayed(transfer, linear));
    let square = area_ui(ui, vec2(WIDTH, 150.0), |ui, rect| {
        const CELLS: u32 = 12;
        paint_field(ui, rect, [CELLS, CELLS], |x, y| opaque(rgb_of([hsv[0], x, 1.0 - y])));
        ring(ui, rect.lerp_inside(vec2(hsv[1], 1.0 - hsv[2])));
    });
    let bar = area_ui(ui, vec2(WIDTH, 16.0), |ui, rect| {
        // The corners of the hue's curve are at multiples of a sixth.
        paint_field(ui, rect, [6, 1], |x, _| opaque(rgb_of([x, 1.0, 1.0])));
        ring(ui, rect.lerp_inside(vec2(hsv[0], 0.5)));
    });
    let mut done = None;
    if let Some(([x, y], phase)) = square {
        hsv = [hsv[0], x, 1.0 - y];
        done = Some(phase);
    }
    if let Some(([x, _], phase)) = bar {
        // At the end of the bar the hue would be that of its start.
        hsv[0] = x.min(0.999);
        done = Some(phase);
    }
    if let Some(phase) = done {
        let last = ui.data(|data| data.get_temp::<Hsv>(id));
        if phase == EditPhase::Dragged && last == Some(hsv) {
            // The pointer rests, and so does the picture.
            return None;
        }
        ui.data_mut(|data| data.insert_temp(id, hsv));
        return Some((rgb_of(hsv).map(|component| transfer.decode(f64::from(component)) as f32), phase));
    }
    let entered = ui.horizontal(|ui| {
        let width = (WIDTH - 2.0 * ui.spacing().item_spacing.x) / 3.0;
        let mut edited = linear;
        let mut phase = None;
        for component in &mut edited {
            phase = component_ui(ui, width, component).or(phase);
        }
        phase.map(|phase| (edited, phase))
    });
    ui.label(RichText::new("Linear red, green and blue").small().weak());
    entered.inner
}

/// An area that the user points into. Returns where, each coordinate 0..1, and how.
fn area_ui(ui: &mut Ui, size: egui::Vec2, paint: impl FnOnce(&Ui, Rect)) -> Option<([f32; 2], EditPhase)> {
    let (rect, response) = ui.allocate_exact_size(size, Sense::click_and_drag());
    paint(ui, rect);
    let at = response.interact_pointer_pos()?;
    let part = [(at.x - rect.left()) / rect.width(), (at.y - rect.top()) / rect.height()];
    let part = part.map(|coordinate| coordinate.clamp(0.0, 1.0));
    if response.drag_stopped() || response.clicked() {
        Some((part, EditPhase::Released))
    } else {
        response.is_pointer_button_down_on().then_some((part, EditPhase::Dragged))
    }
}

/// Paints a field of colours, given at the corners of its cells: `colour` takes coordinates 0..1 from the upper left.
fn paint_field(ui: &Ui, rect: Rect, [columns, rows]: [u32; 2], colour: impl Fn(f32, f32) -> Color32) {
    let mut mesh = Mesh::default();
    for row in 0..=rows {
        for column in 0..=columns {
            let part = vec2(column as f32 / columns as f32, row as f32 / rows as f32);
            mesh.colored_vertex(rect.lerp_inside(part), colour(part.x, part.y));
        }
    }
    for row in 0..rows {
        for column in 0..columns {
            let first = row * (columns + 1) + column;
            let below = first + columns + 1;
            mesh.add_triangle(first, first + 1, below);
            mesh.add_triangle(first + 1, below + 1, below);
        }
    }
    ui.painter().add(mesh);
}

/// Paints the mark of the picked colour.
fn ring(ui: &Ui, at: Pos2) {
    ui.painter().circle_stroke(at, 6.0, Stroke::new(3.0, Color32::from_black_alpha(150)));
    ui.painter().circle_stroke(at, 6.0, Stroke::new(1.5, Color32::WHITE));
}
