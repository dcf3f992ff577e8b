//! The parameter panel: the owners, and the sliders of the selected one.

use crate::formula::ParameterId;
use crate::lang::variables::{Owner, Predefined};
use crate::picture::Transfer;
use crate::preview::app::colours::{paint_swatch, shown_colour};
use crate::preview::app::materials::MaterialRow;
use crate::preview::app::panel_sizes::{remember, wanted_size};
use crate::preview::app::theme::section;
use crate::preview::app::value_rows::{RowColumns, RowContext, ValueEdit};
use crate::preview::app::{Action, InstrumentAction};
use crate::preview::workshop::Workshop;
use crate::user_data::settings::{PanelSide, PanelSizes};
use crate::workspace::{OwnerId, Values};
use egui::{Align, Align2, Id, Layout, Panel, Rect, Response, ScrollArea, Sense, TextEdit, TextStyle, Ui, vec2};

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
    /// What the user wants that the panel cannot do.
    actions: Vec<Action>,
}

impl Default for ParameterPanel {
    fn default() -> Self {
        Self {
            selected: OwnerId::Global,
            ambient: false,
            search: String::new(),
            hidden: false,
            limited: None,
            actions: Vec::new(),
        }
    }
}

/// The height of a row of the list of owners with the space below it, and that space, in points.
const OWNER_ROW: f32 = 22.0;
const OWNER_GAP: f32 = 1.0;
/// The least heights of the list of owners and of what is below it, in points.
const LEAST_OWNERS: f32 = 3.0 * OWNER_ROW + 8.0;
const LEAST_VALUES: f32 = 300.0;

/// The parameters of ambient light.
const AMBIENT: [Predefined; 2] = [Predefined::Ambient, Predefined::AmbientColour];

impl ParameterPanel {
    /// Selects an owner.
    pub(super) fn select(&mut self, owner: OwnerId) {
        self.selected = owner;
        self.ambient = false;
        self.search.clear();
        self.hidden = true;
    }

    /// The actions that the user wants.
    pub(super) fn take_actions(&mut self) -> Vec<Action> {
        std::mem::take(&mut self.actions)
    }

    /// The selected owner.
    pub(super) fn selected(&self) -> OwnerId {
        self.selected
    }

    /// Draws the panel. `picked` is the body that was clicked in the picture last.
    pub(super) fn ui(
        &mut self,
        ui: &mut Ui,
        workshop: &mut Workshop,
        materials: &mut MaterialRow,
        (picked, sizes): (Option<OwnerId>, &mut PanelSizes),
    ) {
        if !workshop.values().table().owners().has(self.selected) {
            self.selected = picked.filter(|owner| workshop.values().table().owners().has(*owner)).unwrap_or(OwnerId::Global);
        }
        let transfer = workshop.settings().view.transfer;
        ui.add_space(4.0);
        ui.add(TextEdit::singleline(&mut self.search).hint_text("Search: kd, floor, ball.h").desired_width(f32::INFINITY));
        // The list never takes the room of the values.
        let most = (ui.available_height() - LEAST_VALUES).max(LEAST_OWNERS);
        let id = Id::new("owners");
        let size = wanted_size(ui.ctx(), id, PanelSide::Owners, sizes);
        let list = Panel::top(id).resizable(true).default_size(size).size_range(LEAST_OWNERS..=most);
        let list = list.frame(egui::Frame::NONE.inner_margin(egui::Margin::symmetric(0, 4)));
        list.show(ui, |ui| {
            // Whole rows, so none is cut in two. The panel keeps its height.
            ui.take_available_height();
            // A row of the list is short: faded, it would look half selected.
            ui.spacing_mut().scroll.fade.strength = 0.0;
            let rows = ((ui.available_height() + OWNER_GAP) / OWNER_ROW).floor().max(1.0);
            let height = rows * OWNER_ROW - OWNER_GAP;
            ScrollArea::vertical().id_salt("owners").auto_shrink(false).max_height(height).show(ui, |ui| {
                self.owners_ui(ui, workshop.values(), transfer);
            });
        });
        remember(ui.ctx(), id, PanelSide::Owners, sizes);
        ui.add_space(2.0);
        // While searching, it would not be clear which body a material is for.
        if self.search.trim().is_empty() {
            materials.ui(ui, workshop, self.selected);
        }
        ui.separator();
        let wanted = self.wanted(workshop.values());
        let mut edits = Vec::new();
        ScrollArea::vertical().id_salt("values").auto_shrink(false).show(ui, |ui| {
            if wanted.is_empty() {
                ui.weak("No match.");
            }
            let values = workshop.values();
            let names = wanted.iter().map(|(_, id)| values.table().parameter(*id).name.as_str());
            let rows = RowContext { values, transfer, columns: RowColumns::new(ui, names) };
            let mut before = None;
            for (owner, id) in wanted {
                if before != Some(owner) {
                    if before.is_some() {
                        ui.add_space(8.0);
                    }
                    section(ui, owner_name(values, owner));
                    before = Some(owner);
                }
                let limited = self.limited.as_ref().filter(|(of, limited, _)| (*of, *limited) == (owner, id));
                if let Some(edit) = rows.value_ui(ui, owner, id, limited.map(|(.., reason)| reason.as_str())) {
                    edits.push((owner, id, edit));
                }
            }
        });
        if edits.is_empty() && !ui.input(|input| input.pointer.any_down()) {
            // The widget that was held may be gone, such as a picker that was closed.
            workshop.release();
        }
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
                ValueEdit::ShowSensitivity => {
                    self.actions.push(Action::Instruments(InstrumentAction::ShowSensitivity(Some((owner, id)))))
                }
                ValueEdit::ChooseImage => {
                    let name = workshop.values().table().parameter(id).name.clone();
                    self.actions.push(Action::ShowImageDialog(owner, name));
                }
            }
        }
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
            let by = if Some([low, high]) == values.table().parameter(id).range { "" } else { ": the invariants allow no more" };
            let [low, high] = [low, high].map(|bound| (bound * 1e4).round() / 1e4);
            self.limited = Some((owner, id, format!("{name} is from {low} to {high} here{by}")));
        }
    }

    fn owners_ui(&mut self, ui: &mut Ui, values: &Values, transfer: Transfer) {
        ui.spacing_mut().item_spacing.y = OWNER_GAP;
        let owners = values.table().owners();
        for (kind, title) in [(Owner::Global, ""), (Owner::Light, "Lights"), (Owner::Body, "Bodies")] {
            if !title.is_empty() {
                let size = vec2(ui.available_width(), OWNER_ROW - OWNER_GAP);
                ui.allocate_ui_with_layout(size, Layout::left_to_right(Align::Max), |ui| {
                    ui.set_min_size(size);
                    section(ui, title);
                });
            }
            for owner in owners.of_kind(kind) {
                let selected = self.selected == owner && !self.ambient && self.search.is_empty();
                let colour = colour_of(values, owner).map(|linear| shown_colour(transfer, linear));
                let entry = owner_ui(ui, selected, owner_name(values, owner), colour);
                if selected && std::mem::take(&mut self.hidden) {
                    entry.scroll_to_me(None);
                }
                if entry.clicked() {
                    self.select(owner);
                    self.hidden = false;
                }
            }
            let ambient = self.ambient && self.search.is_empty();
            if kind == Owner::Global && owner_ui(ui, ambient, "Ambient light", None).clicked() {
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

/// The colour of a body or a light.
fn colour_of(values: &Values, owner: OwnerId) -> Option<[f32; 3]> {
    let predefined = match owner.kind() {
        Owner::Body => Predefined::BodyColour,
        Owner::Light => Predefined::LightColour,
        Owner::Global => return None,
    };
    let id = values.table().parameter_named(predefined.name())?;
    <[f32; 3]>::try_from(values.get(owner, id)).ok()
}

/// Draws an entry of the list of owners, as wide as the list.
fn owner_ui(ui: &mut Ui, selected: bool, name: &str, colour: Option<egui::Color32>) -> Response {
    const SWATCH: f32 = 11.0;
    const INDENT: f32 = 8.0;
    let (rect, response) = ui.allocate_exact_size(vec2(ui.available_width(), OWNER_ROW - OWNER_GAP), Sense::click());
    response.widget_info(|| egui::WidgetInfo::selected(egui::WidgetType::SelectableLabel, true, selected, name));
    if ui.is_rect_visible(rect) {
        let visuals = ui.style().interact_selectable(&response, selected);
        if selected || response.hovered() {
            ui.painter().rect_filled(rect, visuals.corner_radius, visuals.weak_bg_fill);
        }
        let mut left = rect.left() + INDENT;
        if let Some(colour) = colour {
            let swatch = Rect::from_min_size(egui::pos2(left, rect.center().y - SWATCH / 2.0), vec2(SWATCH, SWATCH));
            paint_swatch(ui, swatch, colour);
            left += SWATCH + INDENT;
        }
        let text = egui::WidgetText::from(name);
        let room = rect.right() - left - INDENT;
        let text = text.into_galley(ui, Some(egui::TextWrapMode::Truncate), room, TextStyle::Body);
        let at = Align2::LEFT_CENTER.anchor_size(egui::pos2(left, rect.center().y), text.size()).min;
        ui.painter().galley(at, text, visuals.text_color());
    }
    response.on_hover_text(name)
}

/// The name of an owner.
fn owner_name(values: &Values, owner: OwnerId) -> &str {
    values.table().owners().name(owner).unwrap_or("Scene")
}
