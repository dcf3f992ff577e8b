//! Searching in a text, and the search bar.

use super::lines::floor;
use egui::{Key, Modifiers, TextEdit, Ui};
use std::ops::Range;

/// The ranges of all matches in a text, in bytes. They do not overlap.
pub(super) fn find_all(text: &str, sought: &str, exact_case: bool) -> Vec<Range<usize>> {
    if sought.is_empty() {
        return Vec::new();
    }
    if exact_case {
        return text.match_indices(sought).map(|(start, found)| start..start + found.len()).collect();
    }
    let sought: Vec<char> = sought.chars().flat_map(char::to_lowercase).collect();
    let mut found = Vec::new();
    let mut from = 0;
    for (start, first) in text.char_indices() {
        if start < from || first.to_lowercase().next() != sought.first().copied() {
            continue;
        }
        let mut left = sought.as_slice();
        for (offset, character) in text[start..].char_indices() {
            let Some(rest) = strip(left, character) else { break };
            left = rest;
            if left.is_empty() {
                from = start + offset + character.len_utf8();
                found.push(start..from);
                break;
            }
        }
    }
    found
}

/// The rest of a search text after a character; `None` if it starts with another one.
fn strip(sought: &[char], character: char) -> Option<&[char]> {
    let mut left = sought;
    for lower in character.to_lowercase() {
        left = left.strip_prefix(&[lower])?;
    }
    Some(left)
}

/// What the search bar asks for.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum Wish {
    /// Select a match, and scroll to it.
    Show(Range<usize>),
    /// Replace a match, and show the next one.
    Replace(Range<usize>),
    /// Replace all matches.
    ReplaceAll,
    /// The bar was closed.
    Close,
}

/// The search bar.
#[derive(Debug, Default)]
pub(super) struct Find {
    open: bool,
    wants_focus: bool,
    sought: String,
    replacement: String,
    exact_case: bool,
    found: Vec<Range<usize>>,
    /// The text and the search that `found` belongs to.
    of: Option<(u64, u64, String, bool)>,
}

impl Find {
    /// Whether the bar is open.
    pub(super) fn is_open(&self) -> bool {
        self.open
    }

    /// The replacement.
    pub(super) fn replacement(&self) -> &str {
        &self.replacement
    }

    /// Opens the bar. A selection within one line becomes the search text.
    pub(super) fn open(&mut self, selected: &str) {
        (self.open, self.wants_focus) = (true, true);
        if !selected.is_empty() && !selected.contains('\n') {
            selected.clone_into(&mut self.sought);
        }
    }

    /// Closes the bar.
    pub(super) fn close(&mut self) {
        self.open = false;
    }

    /// The matches, in order; none while the bar is closed.
    pub(super) fn found(&self) -> &[Range<usize>] {
        if self.open { &self.found } else { &[] }
    }

    /// Searches a text, unless that was done already. `document` and `revision` identify the text.
    pub(super) fn search(&mut self, document: u64, revision: u64, text: &str) {
        let of = (document, revision, self.sought.clone(), self.exact_case);
        if self.open && self.of.as_ref() != Some(&of) {
            self.found = find_all(text, &self.sought, self.exact_case);
            self.of = Some(of);
        }
    }

    /// The first match after a byte, or the first of all.
    pub(super) fn next(&self, behind: usize) -> Option<Range<usize>> {
        self.found.iter().find(|range| range.start >= behind).or(self.found.first()).cloned()
    }

    /// The last match before a byte, or the last of all.
    pub(super) fn previous(&self, before: usize) -> Option<Range<usize>> {
        self.found.iter().rev().find(|range| range.end <= before).or(self.found.last()).cloned()
    }

    /// Draws the bar. `selected` is the selected text.
    pub(super) fn ui(&mut self, ui: &mut Ui, document: (u64, u64), text: &str, selected: Range<usize>) -> Option<Wish> {
        let mut wish = None;
        // Two rows with the same columns: search text and replacement.
        let width = (ui.available_width() * 0.3).clamp(60.0, 220.0);
        let is_selected = ui
            .horizontal(|ui| {
                let label = name_ui(ui, "Find");
                let field = ui.add(TextEdit::singleline(&mut self.sought).desired_width(width)).labelled_by(label.id);
                if std::mem::take(&mut self.wants_focus) {
                    field.request_focus();
                }
                let pressed = |ui: &Ui, modifiers| ui.input_mut(|input| input.consume_key(modifiers, Key::Enter));
                let entered = field.has_focus() || field.lost_focus();
                let back = entered && pressed(ui, Modifiers::SHIFT);
                let onward = entered && pressed(ui, Modifiers::NONE);
                self.search(document.0, document.1, text);
                if field.changed() {
                    // While the user types, search from the start of the selection, so the match does not move on.
                    wish = self.next(selected.start).map(Wish::Show);
                }
                if back || onward {
                    field.request_focus();
                }
                let index = self.found.iter().position(|range| *range == selected);
                if ui.small_button("⏶").on_hover_text("Previous match (Shift+F3)").clicked() || back {
                    wish = self.previous(selected.start).map(Wish::Show);
                }
                if ui.small_button("⏷").on_hover_text("Next match (F3)").clicked() || onward {
                    wish = self.next(selected.end).map(Wish::Show);
                }
                ui.toggle_value(&mut self.exact_case, "Aa").on_hover_text("Match case");
                ui.label(match (index, self.found.len()) {
                    (_, 0) if self.sought.is_empty() => String::new(),
                    (_, 0) => "none".to_owned(),
                    (Some(index), count) => format!("{} of {count}", index + 1),
                    (None, count) => count.to_string(),
                });
                index.is_some()
            })
            .inner;
        ui.horizontal(|ui| {
            let label = name_ui(ui, "Replace with");
            ui.add(TextEdit::singleline(&mut self.replacement).desired_width(width)).labelled_by(label.id);
            if ui.add_enabled(!self.found.is_empty(), egui::Button::new("Replace").small()).clicked() {
                let at = floor(text, selected.start);
                wish = if is_selected { Some(Wish::Replace(selected)) } else { self.next(at).map(Wish::Show) };
            }
            if ui.add_enabled(!self.found.is_empty(), egui::Button::new("All").small()).clicked() {
                wish = Some(Wish::ReplaceAll);
            }
            if ui.small_button("Close").on_hover_text("Esc").clicked() {
                wish = Some(Wish::Close);
            }
        });
        wish
    }
}

/// The label of a field, in a column of labels.
fn name_ui(ui: &mut Ui, name: &str) -> egui::Response {
    let size = egui::vec2(68.0, ui.spacing().interact_size.y);
    ui.allocate_ui_with_layout(size, egui::Layout::left_to_right(egui::Align::Center), |ui| {
        ui.set_min_width(size.x);
        ui.label(name)
    })
    .inner
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_are_bytes_and_case_may_count() {
        assert_eq!(find_all("Čaj čaj ča", "čaj", false), [0..4, 5..9]);
        assert_eq!(find_all("Čaj čaj ča", "čaj", true).first(), Some(&(5..9)));
        assert_eq!(find_all("aaaa", "aa", false), [0..2, 2..4]);
        assert_eq!(find_all("kd + KD", "Kd", false), [0..2, 5..7]);
        assert!(find_all("abc", "", false).is_empty());
        assert!(find_all("", "a", false).is_empty());
    }

    #[test]
    fn the_next_after_the_last_is_the_first() {
        let mut find = Find::default();
        find.open("a");
        find.search(0, 0, "a b a");
        assert_eq!((find.next(1), find.next(5)), (Some(4..5), Some(0..1)));
        assert_eq!((find.previous(4), find.previous(0)), (Some(0..1), Some(4..5)));
        find.close();
        assert!(find.found().is_empty());
    }
}
