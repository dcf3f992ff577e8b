//! The row of materials: those of the formula's library, for the selected body.

use crate::files::Readable;
use crate::lang::display_text::one_line;
use crate::preview::workshop::Workshop;
use crate::workspace::materials::{LibraryLocation, Material, Materials};
use crate::workspace::{Location, OwnerId};
use egui::{ComboBox, TextEdit, Ui};
use std::path::Path;

/// The row, with the open library.
pub(super) struct MaterialRow {
    /// The materials, or why there are none.
    library: Result<Materials, String>,
    /// The material that the body was given last.
    chosen: String,
    /// The name for the next material to save.
    name: String,
    /// Whether the list was open in the last frame.
    open: bool,
    /// The owner that the row was drawn for last.
    of: Option<OwnerId>,
}

impl Default for MaterialRow {
    fn default() -> Self {
        Self { library: Err(String::new()), chosen: String::new(), name: String::new(), open: false, of: None }
    }
}

impl MaterialRow {
    /// Opens the library that a formula names. Returns errors and warnings as text.
    pub(super) fn open(&mut self, uses: Option<&str>, formula: Option<&Location>, data: Option<&Path>) -> Option<String> {
        let location = LibraryLocation::find(uses, formula, data).map_err(|reason| reason.message().to_owned());
        let (library, message) = match location.map(|location| Materials::open(location, Readable::Regular)) {
            Ok(Ok((library, findings))) => (Ok(library), Some(format!("{findings:#}")).filter(|text| !text.is_empty())),
            Ok(Err(findings)) => (Err(findings.to_string()), Some(format!("{findings:#}"))),
            Err(reason) => (Err(reason), None),
        };
        self.library = library;
        self.chosen.clear();
        message
    }

    /// Whether there is a usable library.
    pub(super) fn is_open(&self) -> bool {
        self.library.is_ok()
    }

    /// Draws the row. Returns an error message if there is one.
    pub(super) fn ui(&mut self, ui: &mut Ui, workshop: &mut Workshop, owner: OwnerId) -> Option<String> {
        if self.of.replace(owner) != Some(owner) {
            // Another body has another material.
            self.chosen.clear();
            self.name.clear();
        }
        let library = match &mut self.library {
            Ok(library) => library,
            Err(reason) => {
                ui.add_enabled_ui(false, |ui| ui.button("Materials are off")).response.on_disabled_hover_text(reason.as_str());
                return None;
            }
        };
        let OwnerId::Body(body) = owner else {
            ui.add_enabled_ui(false, |ui| ui.button("Material")).response.on_disabled_hover_text("Choose a body first");
            return None;
        };
        let mut error = None;
        ui.horizontal(|ui| {
            let mut wanted = None;
            let title = if self.chosen.is_empty() { "Material".to_owned() } else { one_line(&self.chosen) };
            let list = ComboBox::from_id_salt("materials").selected_text(title).width(130.0).show_ui(ui, |ui| {
                for material in library.library().iter() {
                    let is_chosen = material.name() == self.chosen;
                    let entry = ui.selectable_label(is_chosen, one_line(material.name()));
                    if is_chosen && !self.open {
                        entry.scroll_to_me(Some(egui::Align::Center));
                    }
                    if entry.clicked() {
                        wanted = Some(material.name().to_owned());
                    }
                }
            });
            self.open = list.inner.is_some();
            if let Some(material) = wanted.as_deref().and_then(|name| library.get(name)) {
                let (given, _) = material.assignments(workshop.values().table(), body);
                workshop.change(|values| {
                    values.assign(&given);
                });
                self.chosen = material.name().to_owned();
                // Only the user's own materials can be saved under the same name.
                self.name = if library.is_built_in(&self.chosen) { String::new() } else { self.chosen.clone() };
            }
            let own = library.get(&self.chosen).is_some() && !library.is_built_in(&self.chosen);
            let delete = ui.add_enabled(own, egui::Button::new("Delete"));
            if delete.on_disabled_hover_text("Built-in materials cannot be deleted").clicked() {
                error = library.remove(&self.chosen).err().map(|findings| format!("{findings:#}"));
                self.chosen.clear();
                self.name.clear();
            }
        });
        ui.horizontal(|ui| {
            ui.add(TextEdit::singleline(&mut self.name).hint_text("new name").desired_width(122.0));
            let save = ui.add_enabled(!self.name.trim().is_empty(), egui::Button::new("Save material"));
            if save.on_hover_text("Save the values of this body under this name").clicked() {
                let kept = Material::of_body(self.name.trim(), workshop.values(), body).map_err(|error| error.to_string());
                match kept.and_then(|material| library.put(material).map_err(|findings| format!("{findings:#}"))) {
                    Ok(()) => self.name.trim().clone_into(&mut self.chosen),
                    Err(message) => error = Some(message),
                }
            }
        });
        error
    }
}
