//! The controls under the picture: zoom, exposure, tone curve, transfer, and what is shown over the picture.

use crate::picture::{EXPOSURES, ToneCurve, Transfer};
use crate::preview::app::action::{PictureOverlay, shortcut_of};
use crate::preview::app::histogram::suitable_exposure;
use crate::preview::app::number_field::{EditPhase, phase};
use crate::preview::app::pane::Zoom;
use crate::preview::app::theme::ROW_HEIGHT;
use crate::preview::app::{Action, App};
use egui::{Button, ComboBox, DragValue, Label, RichText, Slider, SliderClamping, Ui};

/// The exposures of the slider, in stops.
const SLIDER: std::ops::RangeInclusive<f32> = -6.0..=6.0;

impl App {
    /// Exposes the first picture of a new session or scene, whose lights have no chosen intensities yet. A session that
    /// was saved still counts as saved.
    pub(super) fn expose_first_picture(&mut self) {
        /// A picture that is this close to its suitable exposure, in stops, stays as it is.
        const CLOSE: f32 = 0.35;
        if !self.exposes_first || !self.workshop.is_up_to_date() {
            return;
        }
        let mut settings = self.workshop.settings();
        let Some(frame) = &self.workshop.shown().linear else { return };
        self.exposes_first = false;
        let suitable = suitable_exposure(frame, settings.view.curve);
        if let Some(stops) = suitable.filter(|stops| (stops - settings.view.exposure).abs() > CLOSE) {
            let was_saved = !self.session_is_unsaved();
            settings.view.exposure = stops;
            // The exposure is within its range.
            let _ = self.workshop.set_picture(settings);
            if was_saved {
                self.note_saved_session();
            }
        }
    }
}

/// Draws the controls.
pub(super) fn bar(app: &mut App, ui: &mut Ui, actions: &mut Vec<Action>) {
    ui.horizontal_wrapped(|ui| {
        zoom(app, ui, actions);
        ui.separator();
        exposure(app, ui);
        ui.separator();
        for (overlay, name, seen, about) in [
            (PictureOverlay::Clipping, "Clipping", app.pane.clipping, "Mark pixels that are too bright to show, or black"),
            (PictureOverlay::Histogram, "Histogram", app.pane.histogram, "How often each brightness occurs, as displayed"),
        ] {
            let action = Action::ToggleOverlay(overlay);
            let tooltip = format!("{about} ({})", shortcut_of(&action, ui));
            make_room(ui, 84.0);
            if ui.add(Button::selectable(seen, name)).on_hover_text(tooltip).clicked() {
                actions.push(action);
            }
        }
    });
}

/// Starts another row unless this many points are left in this one. Not every widget wraps by itself.
fn make_room(ui: &mut Ui, width: f32) {
    if ui.available_size_before_wrap().x < width {
        ui.end_row();
    }
}

fn zoom(app: &App, ui: &mut Ui, actions: &mut Vec<Action>) {
    for (zoom, name, about) in [
        (Zoom::Fit, "Fit", "The whole picture, fitted into the pane"),
        (Zoom::ACTUAL, "1:1", "One pixel of the screen for each pixel of the picture"),
    ] {
        let action = Action::Zoom(zoom);
        let tooltip = format!("{about} ({})", shortcut_of(&action, ui));
        if ui.add(Button::selectable(app.pane.zoom == zoom, name)).on_hover_text(tooltip).clicked() {
            actions.push(action);
        }
    }
    let percent = 100.0 * app.pane.placement(&app.workshop).factor();
    for (name, steps, about) in [("−", -1, "Zoom out"), ("+", 1, "Zoom in")] {
        let action = Action::ZoomBy(steps);
        let tooltip = format!("{about} ({})", shortcut_of(&action, ui));
        if ui.add(Button::new(name).small()).on_hover_text(tooltip).clicked() {
            actions.push(action);
        }
    }
    // Of one width: otherwise the controls could need another line, and the pane another size, at another percentage.
    ui.add_sized([48.0, ROW_HEIGHT], Label::new(RichText::new(format!("{percent:.0} %")).weak()));
}

fn exposure(app: &mut App, ui: &mut Ui) {
    let mut view = app.workshop.settings().view;
    let before = view;
    // The name, the slider and the number are in one row. A very narrow pane has no slider; the number can be dragged.
    let has_slider = ui.max_rect().width() > 250.0;
    make_room(ui, if has_slider { 240.0 } else { 130.0 });
    ui.label("Exposure").on_hover_text("In stops: 1 is twice as bright. Double-click the number for 0.");
    let mut phases = [None, None];
    if has_slider {
        ui.spacing_mut().slider_width = 90.0;
        let slider = Slider::new(&mut view.exposure, SLIDER).show_value(false).clamping(SliderClamping::Edits);
        phases[0] = phase(&ui.add(slider));
    }
    let number = DragValue::new(&mut view.exposure).range(EXPOSURES).speed(0.02).fixed_decimals(1);
    let number = number.custom_formatter(|stops, _| format!("{stops:+.1}")).update_while_editing(false);
    let number = ui.add_sized([46.0, 20.0], number);
    phases[1] = phase(&number);
    if number.double_clicked() {
        view.exposure = 0.0;
    }
    let curve = view.curve;
    let linear = app.workshop.shown().linear.as_ref();
    let auto = ui.add_enabled(linear.is_some(), Button::new("Auto"));
    if auto.on_hover_text("The exposure at which the brightest parts are just below white").clicked()
        && let Some(stops) = linear.and_then(|frame| suitable_exposure(frame, curve))
    {
        view.exposure = stops;
    }
    make_room(ui, 134.0);
    ComboBox::from_id_salt("curve").selected_text(format!("Tone: {}", curve.title())).width(112.0).show_ui(ui, |ui| {
        for curve in ToneCurve::ALL {
            ui.selectable_value(&mut view.curve, curve, curve.title()).on_hover_text(curve.doc());
        }
    });
    make_room(ui, 74.0);
    let mut srgb = view.transfer == Transfer::Srgb;
    let tooltip = "Encode linear colours with the curve of sRGB, as displays expect. Without it, they are shown as they are.";
    if ui.checkbox(&mut srgb, "sRGB").on_hover_text(tooltip).changed() {
        view.transfer = if srgb { Transfer::Srgb } else { Transfer::Linear };
    }
    match phases[0].or(phases[1]) {
        Some(EditPhase::Dragged) => app.workshop.drag_view(view),
        Some(EditPhase::Released) => {
            app.workshop.drag_view(view);
            app.workshop.release_view();
        }
        Some(EditPhase::Set) | None if view != before => app.workshop.set_view(view),
        Some(EditPhase::Set) | None => {}
    }
}
