//! The parameter panel: the owners, and the sliders of the selected one.

use crate::formula::{Parameter, ParameterId};
use crate::lang::types::Type;
use crate::lang::variables::{Owner, Predefined};
use crate::preview::app::materials::MaterialRow;
use crate::preview::workshop::Workshop;
use crate::workspace::{OwnerId, Values};
use egui::{Color32, DragValue, Response, ScrollArea, Slider, TextEdit, Ui};

/// The panel.
pub(super) struct ParameterPanel {
    selected: OwnerId,
    /// Whether only the parameters of ambient light are shown.
    ambient: bool,
    search: String,
    /// Whether the list must scroll to an owner that was selected elsewhere.
    hidden: bool,
    /// A value that could not be set as wanted, and why.
    limited: Option<(OwnerId, ParameterId, String)>,
}

impl Default for ParameterPanel {
    fn default() -> Self {
        Self { selected: OwnerId::Global, ambient: false, search: String::new(), hidden: false, limited: None }
    }
}

/// The parameters of ambient light.
const AMBIENT: [Predefined; 2] = [Predefined::Ambient, Predefined::AmbientColour];

/// What the user did with a value.
enum ValueEdit {
    /// Moved it while holding it.
    Drag([f32; 3]),
    /// Set it.
    Set([f32; 3]),
    /// Released it, maybe with a last movement.
    Release([f32; 3]),
    Copy,
}

impl ParameterPanel {
    /// Selects an owner.
    pub(super) fn select(&mut self, owner: OwnerId) {
        self.selected = owner;
        self.ambient = false;
        self.search.clear();
        self.hidden = true;
    }

    /// Draws the panel. `picked` is the body that was clicked in the picture last. Returns an error message if there
    /// is one.
    pub(super) fn ui(
        &mut self,
        ui: &mut Ui,
        workshop: &mut Workshop,
        materials: &mut MaterialRow,
        picked: Option<OwnerId>,
    ) -> Option<String> {
        if !workshop.values().table().owners().has(self.selected) {
            self.selected = picked.filter(|owner| workshop.values().table().owners().has(*owner)).unwrap_or(OwnerId::Global);
        }
        ui.add_space(4.0);
        ui.horizontal(|ui| {
            ui.add(TextEdit::singleline(&mut self.search).hint_text("Search: kd, floor, ball.h").desired_width(f32::INFINITY));
        });
        let share = (ui.available_height() * 0.32).max(90.0);
        ScrollArea::vertical().id_salt("owners").max_height(share).auto_shrink(false).show(ui, |ui| {
            self.owners_ui(ui, workshop.values());
        });
        ui.separator();
        // While searching, it would not be clear which body a material is for.
        let message = if self.search.trim().is_empty() { materials.ui(ui, workshop, self.selected) } else { None };
        ui.separator();
        let wanted = self.wanted(workshop.values());
        let mut edits = Vec::new();
        ScrollArea::vertical().id_salt("values").auto_shrink(false).show(ui, |ui| {
            if wanted.is_empty() {
                ui.weak("No match.");
            }
            let mut before = None;
            for (owner, id) in wanted {
                if before != Some(owner) {
                    ui.add_space(2.0);
                    ui.strong(owner_name(workshop.values(), owner));
                    before = Some(owner);
                }
                if let Some(edit) = value_ui(ui, workshop.values(), owner, id) {
                    edits.push((owner, id, edit));
                }
                if let Some((_, _, reason)) = self.limited.as_ref().filter(|(of, limited, _)| (*of, *limited) == (owner, id)) {
                    ui.small(reason);
                }
            }
        });
        for (owner, id, edit) in edits {
            match edit {
                ValueEdit::Drag(value) => {
                    workshop.drag(owner, id, value);
                    self.note_limit(workshop.values(), owner, id, value);
                }
                ValueEdit::Set(value) => {
                    workshop.set(owner, id, value);
                    self.note_limit(workshop.values(), owner, id, value);
                }
                ValueEdit::Release(value) => {
                    if workshop.values().get(owner, id).iter().zip(value).any(|(there, wanted)| *there != wanted) {
                        workshop.drag(owner, id, value);
                        self.note_limit(workshop.values(), owner, id, value);
                    }
                    workshop.release();
                }
                ValueEdit::Copy => workshop.copy_to_all(owner, id),
            }
        }
        message
    }

    /// Notes why a value is not what the user wanted, if so.
    fn note_limit(&mut self, values: &Values, owner: OwnerId, id: ParameterId, wanted: [f32; 3]) {
        let taken = values.get(owner, id);
        let is_near = |(taken, wanted): (&f32, &f32)| (taken - wanted).abs() <= 1e-4 * wanted.abs().max(1.0);
        self.limited = None;
        if !taken.iter().zip(&wanted).all(is_near)
            && let Some([low, high]) = values.range_of(owner, id)
        {
            let name = &values.table().parameter(id).name;
            let by = if Some([low, high]) == values.table().parameter(id).range { "" } else { ", by invariants" };
            let [low, high] = [low, high].map(|bound| (bound * 1e4).round() / 1e4);
            self.limited = Some((owner, id, format!("{name} is from {low} to {high} here{by}")));
        }
    }

    fn owners_ui(&mut self, ui: &mut Ui, values: &Values) {
        let owners = values.table().owners();
        for (kind, title) in [(Owner::Global, ""), (Owner::Light, "Lights"), (Owner::Body, "Bodies")] {
            if !title.is_empty() {
                ui.weak(title);
            }
            for owner in owners.of_kind(kind) {
                let selected = self.selected == owner && !self.ambient && self.search.is_empty();
                let entry = ui.selectable_label(selected, owner_name(values, owner));
                if selected && std::mem::take(&mut self.hidden) {
                    entry.scroll_to_me(None);
                }
                if entry.clicked() {
                    self.select(owner);
                    self.hidden = false;
                }
            }
            if kind == Owner::Global && ui.selectable_label(self.ambient && self.search.is_empty(), "Ambient light").clicked() {
                self.select(OwnerId::Global);
                self.ambient = true;
            }
        }
    }

    /// The parameters to show: those of the selected owner, or those that the search finds.
    fn wanted(&self, values: &Values) -> Vec<(OwnerId, ParameterId)> {
        let table = values.table();
        let search = self.search.trim().to_lowercase();
        if search.is_empty() {
            let is_ambient = |id: &ParameterId| table.parameter(*id).predefined.is_some_and(|own| AMBIENT.contains(&own));
            let own = table.parameters_of(self.selected.kind()).filter(|id| !self.ambient || is_ambient(id));
            return own.map(|id| (self.selected, id)).collect();
        }
        let all = values.iter().map(|(owner, id, _)| (owner, id));
        all.filter(|(owner, id)| table.label(*owner, *id).to_lowercase().contains(&search)).collect()
    }
}

/// The name of an owner.
fn owner_name(values: &Values, owner: OwnerId) -> &str {
    values.table().owners().name(owner).unwrap_or("Scene")
}

/// Draws a value with its name.
fn value_ui(ui: &mut Ui, values: &Values, owner: OwnerId, id: ParameterId) -> Option<ValueEdit> {
    let parameter = values.table().parameter(id);
    let lock = values.lock_of(owner, id);
    let mut value = [0.0; 3];
    values.get(owner, id).iter().zip(&mut value).for_each(|(from, to)| *to = *from);
    ui.push_id((owner, id), |ui| {
        let mut edit = None;
        ui.horizontal(|ui| {
            let name = name_ui(ui, &parameter.name).on_hover_text(tooltip(parameter, lock.as_deref()));
            name.context_menu(|ui| {
                if ui.button("Default").clicked() {
                    edit = Some(ValueEdit::Set(parameter.default));
                }
                if owner.kind() != Owner::Global && ui.button("Copy to all owners of this kind").clicked() {
                    edit = Some(ValueEdit::Copy);
                }
            });
            if name.double_clicked() {
                edit = Some(ValueEdit::Set(parameter.default));
            }
            let edited = ui.add_enabled_ui(lock.is_none(), |ui| match parameter.ty {
                Type::Vector => vector_ui(ui, parameter, value),
                Type::Scalar | Type::Truth => {
                    scalar_ui(ui, parameter, value[0]).map(|(number, phase)| ([number, 0.0, 0.0], phase))
                }
            });
            edit = match edited.inner {
                Some((value, EditPhase::Dragged)) => Some(ValueEdit::Drag(value)),
                Some((value, EditPhase::Set)) => Some(ValueEdit::Set(value)),
                Some((value, EditPhase::Released)) => Some(ValueEdit::Release(value)),
                None => edit.take(),
            };
        });
        if let Some(lock) = lock {
            ui.small(format!("locked: {lock}"));
        }
        edit
    })
    .inner
}

/// Draws a name in the column of names.
fn name_ui(ui: &mut Ui, name: &str) -> Response {
    let (rect, response) = ui.allocate_exact_size(egui::vec2(78.0, 20.0), egui::Sense::click());
    response.widget_info(|| egui::WidgetInfo::labeled(egui::WidgetType::Label, true, name));
    let font = egui::TextStyle::Body.resolve(ui.style());
    let colour = if response.hovered() { ui.visuals().strong_text_color() } else { ui.visuals().text_color() };
    ui.painter_at(rect).text(rect.left_center(), egui::Align2::LEFT_CENTER, name, font, colour);
    response
}

/// A description of a parameter for the tooltip.
fn tooltip(parameter: &Parameter, lock: Option<&str>) -> String {
    let mut text = format!("{}: {}", parameter.name, parameter.ty);
    if let Some([low, high]) = parameter.range {
        text.push_str(&format!(", {low} to {high}"));
    }
    if let Some(predefined) = parameter.predefined {
        text.push_str(&format!("\n{}", predefined.doc()));
    }
    match lock {
        Some(lock) => text.push_str(&format!("\nLocked: {lock}")),
        None => text.push_str("\nDouble-click: default. Right-click: more."),
    }
    text
}

/// How the user changed a value.
#[derive(Clone, Copy, PartialEq, Eq)]
enum EditPhase {
    Dragged,
    Set,
    Released,
}

/// How a widget was used.
fn phase(response: &Response) -> Option<EditPhase> {
    if response.drag_stopped() {
        Some(EditPhase::Released)
    } else if response.changed() {
        Some(if response.dragged() { EditPhase::Dragged } else { EditPhase::Set })
    } else {
        None
    }
}

/// A slider is logarithmic if its range covers more than two decades.
fn is_logarithmic([low, high]: [f32; 2]) -> bool {
    low > 0.0 && high / low > 100.0
}

fn scalar_ui(ui: &mut Ui, parameter: &Parameter, mut number: f32) -> Option<(f32, EditPhase)> {
    let mut done = None;
    if let Some([low, high]) = parameter.range {
        let slider = Slider::new(&mut number, low..=high).show_value(false).logarithmic(is_logarithmic([low, high]));
        ui.spacing_mut().slider_width = (ui.available_width() - 74.0).max(60.0);
        done = phase(&ui.add(slider));
    }
    let entered = number_ui(ui, parameter, &mut number);
    done.or(entered).map(|phase| (number, phase))
}

/// A number that can be typed or dragged.
fn number_ui(ui: &mut Ui, parameter: &Parameter, number: &mut f32) -> Option<EditPhase> {
    let speed = match parameter.range {
        Some([low, high]) => f64::from(high - low) / 400.0,
        None => f64::from(number.abs()).max(0.1) / 100.0,
    };
    // The widget has no limits: a number out of range is corrected later, with a message.
    let field = DragValue::new(number).speed(speed).max_decimals(4).update_while_editing(false);
    phase(&ui.add_sized([62.0, 20.0], field))
}

/// Three sliders, and a button for their colour.
fn vector_ui(ui: &mut Ui, parameter: &Parameter, value: [f32; 3]) -> Option<([f32; 3], EditPhase)> {
    let mut done = None;
    let mut edited = value;
    ui.vertical(|ui| {
        if parameter.colour || parameter.predefined.is_some() {
            // Linear, as in the picture.
            let mut bytes = value.map(|component| (255.0 * component.clamp(0.0, 1.0)).round() as u8);
            let response = ui.color_edit_button_srgb(&mut bytes);
            if response.changed() {
                edited = bytes.map(|byte| f32::from(byte) / 255.0);
                done = Some(EditPhase::Set);
            }
        }
        let marks = [Color32::from_rgb(226, 92, 92), Color32::from_rgb(96, 190, 104), Color32::from_rgb(96, 140, 232)];
        for (index, (component, mark)) in edited.iter_mut().zip(marks).enumerate() {
            ui.push_id(index, |ui| {
                ui.horizontal(|ui| {
                    let (rect, _) = ui.allocate_exact_size(egui::vec2(6.0, 20.0), egui::Sense::hover());
                    ui.painter().rect_filled(rect.shrink2(egui::vec2(1.5, 4.0)), 1.0, mark);
                    if let Some((number, phase)) = scalar_ui(ui, parameter, *component) {
                        *component = number;
                        done = Some(phase);
                    }
                });
            });
        }
    });
    done.map(|phase| (edited, phase))
}
