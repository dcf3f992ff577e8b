//! Entries of menus, each with its shortcut at the right. A shortcut has the colour of its entry. So it is legible on a
//! highlighted entry, too.

use crate::preview::app::Action;
use crate::preview::app::action::shortcut_of;
use egui::{Atom, Button, Checkbox, Ui};

/// A menu entry with its shortcut.
pub(super) fn entry(ui: &mut Ui, name: &str, action: Action, actions: &mut Vec<Action>) {
    entry_if(ui, true, name, action, actions);
}

/// A menu entry that may be disabled.
pub(super) fn entry_if(ui: &mut Ui, enabled: bool, name: &str, action: Action, actions: &mut Vec<Action>) {
    let button = Button::new(name).right_text(shortcut_of(&action, ui));
    if ui.add_enabled(enabled, button).clicked() {
        actions.push(action);
        ui.close();
    }
}

/// Something that is shown or hidden, with its shortcut. Returns whether it was chosen.
pub(super) fn check_entry(ui: &mut Ui, mut seen: bool, name: &str, action: Action, actions: &mut Vec<Action>) -> bool {
    let title = (name, Atom::grow(), shortcut_of(&action, ui));
    let is_chosen = ui.add(Checkbox::new(&mut seen, title)).changed();
    if is_chosen {
        actions.push(action);
    }
    is_chosen
}
