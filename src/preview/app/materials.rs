//! The row of materials: those of the formula's library, for the selected body.

use crate::files::Readable;
use crate::lang::display_text::one_line;
use crate::preview::app::action::MaterialChange;
use crate::preview::app::question::Question;
use crate::preview::app::steps::OtherStep;
use crate::preview::app::{Action, App};
use crate::preview::workshop::Workshop;
use crate::scene::BodyId;
use crate::workspace::materials::{LibraryLocation, Material, Materials};
use crate::workspace::{Location, OwnerId};
use egui::{ComboBox, TextEdit, Ui};
use std::path::Path;

/// The row, with the open library.
pub(super) struct MaterialRow {
    /// The materials, or why there are none.
    library: Result<Materials, String>,
    /// The material whose values the body has, and the stamp of the values and the body for which that was found.
    current: Option<String>,
    of: Option<(u64, OwnerId)>,
    /// The name for the next material to save.
    name: String,
    /// Whether the list was open in the last frame.
    open: bool,
    /// What the user wants.
    actions: Vec<Action>,
}

impl Default for MaterialRow {
    fn default() -> Self {
        let library = Err(String::new());
        Self { library, current: None, of: None, name: String::new(), open: false, actions: Vec::new() }
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
        self.of = None;
        message
    }

    /// Whether there is a usable library.
    pub(super) fn is_open(&self) -> bool {
        self.library.is_ok()
    }

    /// What the user has asked for since the last call.
    pub(super) fn take_actions(&mut self) -> Vec<Action> {
        std::mem::take(&mut self.actions)
    }

    /// Finds the material whose values a body has. Of several, it is the one that was found before.
    fn find_current(&mut self, workshop: &Workshop, owner: OwnerId, body: BodyId) {
        let of = Some((workshop.stamp(), owner));
        let same_owner = self.of.is_some_and(|(_, before)| before == owner);
        if self.of == of {
            return;
        }
        self.of = of;
        let Ok(library) = &self.library else { return };
        let fits = |material: &&Material| material.is_of(workshop.values(), body);
        let before = self.current.take().filter(|_| same_owner);
        let same = before.as_deref().and_then(|name| library.get(name)).filter(fits);
        let found = same.or_else(|| library.library().iter().find(fits)).map(|material| material.name().to_owned());
        if found != before || !same_owner {
            // Only the user's own materials can be saved under the same name.
            self.name = found.clone().filter(|name| !library.is_built_in(name)).unwrap_or_default();
        }
        self.current = found;
    }

    /// Draws the row.
    pub(super) fn ui(&mut self, ui: &mut Ui, workshop: &mut Workshop, owner: OwnerId) {
        if let Err(reason) = &self.library {
            ui.add_enabled_ui(false, |ui| ui.button("Materials are off")).response.on_disabled_hover_text(reason.as_str());
            return;
        }
        let OwnerId::Body(body) = owner else {
            ui.add_enabled_ui(false, |ui| ui.button("Material")).response.on_disabled_hover_text("Choose a body first");
            return;
        };
        self.find_current(workshop, owner, body);
        let Ok(library) = &self.library else { return };
        ui.horizontal(|ui| {
            let mut wanted = None;
            let title = self.current.as_deref().map_or_else(|| "own values".to_owned(), one_line);
            let list = ComboBox::from_id_salt("materials").selected_text(title).width(130.0).show_ui(ui, |ui| {
                for material in library.library().iter() {
                    let is_current = Some(material.name()) == self.current.as_deref();
                    let entry = ui.selectable_label(is_current, one_line(material.name()));
                    if is_current && !self.open {
                        entry.scroll_to_me(Some(egui::Align::Center));
                    }
                    if entry.clicked() {
                        wanted = Some(material);
                    }
                }
            });
            list.response.on_hover_text("The material whose values this body has");
            self.open = list.inner.is_some();
            if let Some(material) = wanted {
                let (given, _) = material.assignments(workshop.values().table(), body);
                workshop.change(|values| {
                    values.assign(&given);
                });
                self.current = Some(material.name().to_owned());
                self.name = if library.is_built_in(material.name()) { String::new() } else { material.name().to_owned() };
            }
            let own = self.current.clone().filter(|name| !library.is_built_in(name));
            let reason = if self.current.is_some() {
                "Built-in materials cannot be deleted"
            } else {
                "This is no material of the library"
            };
            let delete = ui.add_enabled(own.is_some(), egui::Button::new("Delete")).on_disabled_hover_text(reason);
            if delete.clicked() {
                self.actions.extend(own.map(Action::DeleteMaterial));
            }
        });
        ui.horizontal(|ui| {
            ui.add(TextEdit::singleline(&mut self.name).hint_text("new name").desired_width(122.0));
            let name = self.name.trim().to_owned();
            let save = ui.add_enabled(!name.is_empty(), egui::Button::new("Save material"));
            let save = save.on_hover_text("Save the values of this body under this name");
            if save.on_disabled_hover_text("Enter a name first").clicked() {
                self.actions.push(Action::SaveMaterial { name, body });
            }
        });
    }
}

impl App {
    /// Saves the values of a body as a material. If there is one of this name, the user is asked, unless `replaces`
    /// says that the answer is known.
    pub(super) fn save_material(&mut self, name: &str, body: BodyId, replaces: bool) {
        let Ok(library) = &mut self.materials.library else { return };
        if library.get(name).is_some() && !replaces {
            let body_name = one_line(&self.workshop.scene().body(body).name);
            let text = if library.is_built_in(name) {
                format!(
                    "`{}` is a built-in material. Yours, with the values of {body_name}, would take its place.",
                    one_line(name)
                )
            } else {
                format!("There is already a material `{}`. It would get the values of {body_name}.", one_line(name))
            };
            let replace = Action::ReplaceMaterial { name: name.to_owned(), body };
            return self.dialogs.ask(Question::new("Replace the material?", text).answer("Replace", replace).or("Cancel"));
        }
        let before = if library.is_built_in(name) { None } else { library.get(name).cloned() };
        let location = library.location().clone();
        let made = Material::of_body(name, self.workshop.values(), body).map_err(|error| error.to_string());
        let saved = made
            .and_then(|material| library.put(material.clone()).map(|()| material).map_err(|findings| format!("{findings:#}")));
        match saved {
            Ok(material) => {
                self.materials.current = Some(name.to_owned());
                self.materials.of = None;
                if replaces {
                    let change = MaterialChange { name: name.to_owned(), library: location, before, after: Some(material) };
                    self.note_material_change(change, &format!("replaced the material {name}"));
                } else {
                    self.confirm(format!("saved the material {name}"));
                }
            }
            Err(message) => self.dialogs.show_message("The material was not saved", message),
        }
    }

    /// Deletes a material. That can be undone.
    pub(super) fn delete_material(&mut self, name: &str) {
        let Ok(library) = &mut self.materials.library else { return };
        let Some(before) = library.get(name).cloned() else { return };
        let library_location = library.location().clone();
        match library.remove(name) {
            Ok(()) => {
                self.materials.of = None;
                let name = name.to_owned();
                let said = format!("deleted the material {name}");
                let change = MaterialChange { name, library: library_location, before: Some(before), after: None };
                self.note_material_change(change, &said);
            }
            Err(findings) => self.dialogs.show_message("The material was not deleted", format!("{findings:#}")),
        }
    }

    /// Notes a step of undo, and says what was done, with a button that takes it back.
    fn note_material_change(&mut self, change: MaterialChange, said: &str) {
        let change = Box::new(change);
        self.steps.note(OtherStep::Material(change.clone()), self.workshop.history_position());
        self.log.add(said);
        self.confirmation.say_with(said, "Undo", Action::RestoreMaterial(change));
    }

    /// Takes back the deletion or the replacement of a material, also if it is not the last step.
    pub(super) fn restore_material(&mut self, change: MaterialChange) {
        let step = OtherStep::Material(Box::new(change));
        if self.steps.next(false, self.workshop.history_position()) == Some(&step) {
            // It can be redone then.
            self.move_in_history(false);
        } else if let OtherStep::Material(change) = &step {
            self.steps.forget(&step);
            self.move_material(change, false);
        }
    }

    /// Makes a material what it was before a change, or after it. Its library may be that of another formula.
    pub(super) fn move_material(&mut self, change: &MaterialChange, forwards: bool) {
        let MaterialChange { name, library, before, after } = change;
        let wanted = if forwards { after } else { before };
        let write = |library: &mut Materials| match wanted {
            Some(material) => library.put(material.clone()),
            None => library.remove(name),
        };
        let outcome = match &mut self.materials.library {
            Ok(open) if open.location() == library => write(open),
            Ok(_) | Err(_) => {
                Materials::open(library.clone(), Readable::Regular).and_then(|(mut library, _)| write(&mut library))
            }
        };
        match outcome {
            Ok(()) => {
                self.materials.of = None;
                self.confirm(match (wanted, forwards) {
                    (Some(_), true) => format!("replaced the material {name}"),
                    (Some(_), false) => format!("restored the material {name}"),
                    (None, true) => format!("deleted the material {name}"),
                    (None, false) => format!("the built-in material {name} is back"),
                });
            }
            Err(findings) => self.dialogs.show_message("The material stays as it is", format!("{findings:#}")),
        }
    }
}
