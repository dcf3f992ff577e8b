//! The status bar: the pixel under the pointer, the progress of tracing, the time of the last picture.

use crate::backends::CHOICES;
use crate::preview::app::comparison::PaneMode;
use crate::preview::app::log::thousands;
use crate::preview::app::pane::body_at;
use crate::preview::app::session_mistakes::capital;
use crate::preview::app::{Action, App};
use crate::preview::renderer::PassCount;
use egui::{Button, ProgressBar, RichText, Ui};

/// Draws the status bar.
pub(super) fn bar(app: &App, ui: &mut Ui, actions: &mut Vec<Action>) {
    ui.horizontal(|ui| {
        let [width, height] = app.workshop.size();
        ui.label(format!("{width} × {height} pixels"));
        ui.separator();
        let backend = app.backend();
        let index = CHOICES.iter().position(|choice| *choice == backend).unwrap_or(0);
        let next = CHOICES[(index + 1) % CHOICES.len()];
        let tooltip =
            "How formulas are evaluated: as machine code compiled for them, or by the reference interpreter. Click to change.";
        if ui.small_button(backend.title).on_hover_text(tooltip).clicked() {
            actions.push(Action::SetBackend(next));
        }
        let [done, wanted] = app.workshop.renderer().passes();
        if wanted > 1 {
            ui.separator();
            let text = if done < wanted { format!("pass {done} of {wanted}") } else { format!("{done} passes") };
            let about = "The picture is the mean of its passes. Their number is that of the session, or of the settings, as far as \
                 there is memory for them.";
            ui.label(text).on_hover_text(about);
        }
        if let Some((count, first)) = app.log.undefined().filter(|_| app.workshop.is_up_to_date()) {
            ui.separator();
            let title = RichText::new(format!("⚠ NaN in {} pixels", thousands(count as u64))).color(ui.visuals().warn_fg_color);
            let about = "There the formula yields no number, and the picture is black. Click to inspect the first of them.";
            let origin = app.finding.as_ref().map(|finding| format!("\n\n{}", capital(&finding.message()))).unwrap_or_default();
            if ui.add(Button::new(title).small()).on_hover_text(format!("{about}{origin}")).clicked() {
                actions.push(Action::InspectPixel(first));
            }
        }
        // While something else is on its way, the figures would be those of an old picture.
        if app.workshop.is_up_to_date() || app.workshop.held().is_some() {
            if let Some(time) = app.log.last_frame() {
                ui.separator();
                let PassCount { evaluated, shown } = app.log.last_passes();
                let some = if evaluated < shown { format!(" ({evaluated} of {shown} passes)") } else { String::new() };
                let about = "The time for the last picture, without tracing. Where not all passes fit a frame, some are evaluated \
                     for what changes, and the rest when the slider rests.";
                ui.label(format!("evaluated in {time:.2} ms{some}")).on_hover_text(about);
            }
            if let Some(bytes) = app.log.bytes_per_pixel() {
                ui.separator();
                ui.label(format!("{bytes:.0} bytes per pixel")).on_hover_text("Memory for hits and their static values");
            }
        }
        ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
            if let Some(progress) = app.asset_loading.progress() {
                ui.add(ProgressBar::new(progress).desired_width(110.0));
                ui.label("reading files");
            } else if let Some(progress) = app.workshop.renderer().progress() {
                ui.add(ProgressBar::new(progress).desired_width(110.0));
                ui.label("tracing");
            } else if let Some(about) = app.measured.progress() {
                ui.label("comparing…").on_hover_text(format!("The picture with {about} is being made"));
            }
            if let Some(pixel @ [x, y]) = app.pane.pointed() {
                let name = body_at(&app.workshop, pixel).map(|body| app.workshop.scene().body(body).name.as_str());
                ui.label(format!("({x}, {y})  {}", name.unwrap_or("background")));
                colours(app, ui, pixel);
            }
        });
    });
}

/// Draws the linear colour of a pixel and its bytes on the display. There is no linear colour while a slider is held.
fn colours(app: &App, ui: &mut Ui, [x, y]: [u32; 2]) {
    let shown = app.workshop.shown();
    // In a comparison, other pictures are in view too.
    if app.pane.mode != PaneMode::Current || !shown.is_full() || x >= shown.width || y >= shown.height {
        return;
    }
    let index = y as usize * shown.width as usize + x as usize;
    if let Some(pixel) = shown.pixels.get(index) {
        let [_, red, green, blue] = pixel.to_be_bytes();
        ui.monospace(format!("#{:06x}", pixel & 0x00ff_ffff)).on_hover_text(format!("As displayed: {red}, {green}, {blue}"));
        let (rect, _) = ui.allocate_exact_size(egui::vec2(12.0, 12.0), egui::Sense::hover());
        ui.painter().rect_filled(rect, 2.0, egui::Color32::from_rgb(red, green, blue));
    }
    if let Some(colour) = shown.linear.as_ref().and_then(|frame| frame.linear.get(index)) {
        let about = "Linear colour, before exposure and tone curve. NaN is displayed as 0";
        ui.monospace(linear_text(*colour, shown.nan.at(index))).on_hover_text(about);
    }
}

/// The components of a linear colour. The picture has 0 for those that are NaN.
fn linear_text(colour: [f32; 3], nan: [bool; 3]) -> String {
    let text = |(component, is_nan): (f32, bool)| if is_nan { "NaN".to_owned() } else { format!("{component:.3}") };
    colour.into_iter().zip(nan).map(text).collect::<Vec<_>>().join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_component_that_is_nan_is_named() {
        assert_eq!(linear_text([0.0, 0.25, 0.0], [true, false, false]), "NaN 0.250 0.000");
    }
}
