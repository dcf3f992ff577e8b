//! The controls under the picture: zoom, what is shown over the picture, exposure, tone curve and transfer.

use crate::picture::{EXPOSURES, ToneCurve, Transfer, ViewTransform};
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

/// Bars narrower than this, in points, have short labels.
const SHORT_BELOW: f32 = 920.0;
/// The width of the controls of light with short labels. They are in one row.
const SECOND_HALF: f32 = 282.0;
/// Bars narrower than this have no slider. The number can be dragged.
const NO_SLIDER_BELOW: f32 = 250.0;

/// Draws the controls: in one row, or in two if the pane is narrow.
pub(super) fn bar(app: &mut App, ui: &mut Ui, actions: &mut Vec<Action>) {
    let short = ui.max_rect().width() < SHORT_BELOW;
    ui.horizontal_wrapped(|ui| {
        if short {
            ui.spacing_mut().item_spacing.x = 3.0;
            ui.spacing_mut().button_padding.x = 5.0;
        }
        zoom(app, ui, actions);
        gap(ui, short);
        overlays(app, ui, short, actions);
        gap(ui, short);
        make_room(ui, SECOND_HALF);
        let mut view = app.workshop.settings().view;
        let before = view;
        let phase = exposure(app, ui, &mut view, short);
        gap(ui, short);
        encoding(ui, &mut view, short);
        match phase {
            Some(EditPhase::Dragged) => app.workshop.drag_view(view),
            Some(EditPhase::Released) => {
                app.workshop.drag_view(view);
                app.workshop.release_view();
            }
            Some(EditPhase::Set) | None if view != before => app.workshop.set_view(view),
            Some(EditPhase::Set) | None => {}
        }
    });
}

/// The space between two groups.
fn gap(ui: &mut Ui, short: bool) {
    if short {
        ui.add_space(6.0);
    } else {
        ui.separator();
    }
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
        (Zoom::Pane, "Pane", "The picture is made as large as its pane. The session keeps its size"),
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
    ui.add_sized([38.0, ROW_HEIGHT], Label::new(RichText::new(format!("{percent:.0} %")).weak()));
}

/// Draws the controls of the exposure. Returns what the user does with the slider or the number.
fn exposure(app: &App, ui: &mut Ui, view: &mut ViewTransform, short: bool) -> Option<EditPhase> {
    // The name, the slider and the number are in one row.
    let has_slider = ui.max_rect().width() > NO_SLIDER_BELOW;
    make_room(ui, if has_slider { 160.0 } else { 112.0 });
    // As high as the row: the first widget of a further row would be placed too high otherwise.
    let (name, width) = if short { ("EV", 18.0) } else { ("Exposure", 60.0) };
    let name = ui.add_sized([width, ROW_HEIGHT], Label::new(name));
    name.on_hover_text("Exposure in stops: 1 is twice as bright. Double-click the number for 0.");
    let mut of_slider = None;
    if has_slider {
        ui.spacing_mut().slider_width = if short { 48.0 } else { 90.0 };
        let slider = Slider::new(&mut view.exposure, SLIDER).show_value(false).clamping(SliderClamping::Edits);
        of_slider = phase(&ui.add(slider));
    }
    let number = DragValue::new(&mut view.exposure).range(EXPOSURES).speed(0.02).fixed_decimals(1);
    let number = number.custom_formatter(|stops, _| format!("{stops:+.1}")).update_while_editing(false);
    let number = ui.add_sized([44.0, ROW_HEIGHT], number);
    let of_number = phase(&number);
    if number.double_clicked() {
        view.exposure = 0.0;
    }
    let linear = app.workshop.shown().linear.as_ref();
    let auto = ui.add_enabled(linear.is_some(), Button::new("Auto"));
    if auto.on_hover_text("The exposure at which the brightest parts are just below white").clicked()
        && let Some(stops) = linear.and_then(|frame| suitable_exposure(frame, view.curve))
    {
        view.exposure = stops;
    }
    of_slider.or(of_number)
}

/// The tone curve and the transfer.
fn encoding(ui: &mut Ui, view: &mut ViewTransform, short: bool) {
    let curve = view.curve.title();
    let (text, width) = match (short, view.curve) {
        (false, _) => (format!("Tone: {curve}"), 112.0),
        (true, ToneCurve::None) => ("Tone".to_owned(), 64.0),
        (true, ToneCurve::Reinhard | ToneCurve::Aces) => (curve.to_owned(), 64.0),
    };
    make_room(ui, 92.0);
    let combo = ComboBox::from_id_salt("curve").selected_text(text).width(width).truncate();
    let combo = combo.show_ui(ui, |ui| {
        for curve in ToneCurve::ALL {
            ui.selectable_value(&mut view.curve, curve, curve.title()).on_hover_text(curve.doc());
        }
    });
    combo.response.on_hover_text(format!("Tone curve: {}", view.curve.doc()));
    make_room(ui, 46.0);
    let srgb = view.transfer == Transfer::Srgb;
    let tooltip = "Encode linear colours with the curve of sRGB, as displays expect. Without it, they are shown as they are.";
    if ui.add(Button::selectable(srgb, "sRGB")).on_hover_text(tooltip).clicked() {
        view.transfer = if srgb { Transfer::Linear } else { Transfer::Srgb };
    }
}

/// What is shown over the picture.
fn overlays(app: &App, ui: &mut Ui, short: bool, actions: &mut Vec<Action>) {
    let clipping = "Mark pixels that are too bright to show, or black";
    let histogram = "Histogram: how often each brightness occurs, as displayed";
    for (overlay, [name, short_name], seen, about) in [
        (PictureOverlay::Clipping, ["Clipping", "Clip"], app.pane.clipping, clipping),
        (PictureOverlay::Histogram, ["Histogram", "Hist"], app.pane.histogram, histogram),
    ] {
        let action = Action::ToggleOverlay(overlay);
        let tooltip = format!("{about} ({})", shortcut_of(&action, ui));
        make_room(ui, if short { 36.0 } else { 84.0 });
        if ui.add(Button::selectable(seen, if short { short_name } else { name })).on_hover_text(tooltip).clicked() {
            actions.push(action);
        }
    }
}
