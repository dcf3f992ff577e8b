//! The text editor for formulas and scenes: colours, marks of errors, completion, search, undo.
//!
//! [`Document`] is the text, [`Editor`] is the widget that edits one document at a time. [`problems_ui`] and
//! [`reference_ui`] are panels beside it. No files or windows are known here. What is known about the words of a text
//! comes from [`assist`](crate::assist). The modules: `lines`, `history` and `commands` work on texts; `keys` handles
//! the keyboard; `colouring`, `marks`, `list`, `hover` and `palette` draw; `find` is the search bar, `edit_menu` the
//! menu of edits.

mod colouring;
mod commands;
mod document;
mod edit_menu;
mod find;
mod history;
mod hover;
mod keys;
mod lines;
mod list;
mod marks;
mod palette;
mod problems;
mod reference;
#[cfg(test)]
mod tests;
mod view;

pub use crate::assist::words::Class;
pub use document::Document;
pub use edit_menu::{PossibleEdits, edit_menu_ui};
pub use keys::EditorCommand;
pub use palette::Palette;
pub use problems::problems_ui;
pub use reference::reference_ui;

use crate::assist::completion::complete;
use crate::lang::source::SourceSpan;
use colouring::{Colouring, Laid};
use egui::{Context, Event, FontId, Id, Key, TextStyle, Ui, ViewportCommand};
use find::{Find, Wish};
use history::{Edit, Selection};
use keys::{Open, Queue};
use lines::{fitting, floor};
use list::List;
use std::collections::HashMap;
use std::sync::Arc;
use std::time::Duration;

/// A text that is slow to check is checked after this many seconds without a change.
const CHECK_AFTER: f64 = 0.5;

/// What happened in the editor in a frame.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct EditorResponse {
    /// Whether the text was changed.
    pub changed: bool,
    /// Whether the text should be applied: Ctrl+Enter was pressed.
    pub apply: bool,
    /// Whether the text has the keyboard.
    pub focused: bool,
    /// Line and column of the cursor, counted from 1. The column counts characters.
    pub place: (usize, usize),
}

/// How the text is drawn, and the context for its layout.
#[derive(Clone, Copy)]
struct TextStyling<'a> {
    context: &'a Context,
    font: &'a FontId,
    palette: &'a Palette,
}

/// The widget that edits a [`Document`]. It can show different documents one after the other.
#[derive(Default)]
pub struct Editor {
    colouring: Colouring,
    queue: Queue,
    list: List,
    find: Find,
    pointed: hover::PointedNames,
    /// The document that was shown last, and the selection in each document.
    shown: Option<u64>,
    selections: HashMap<u64, Selection>,
    selection: Selection,
    /// Whether egui's widget does not know the selection yet.
    moved: bool,
    /// Whether to scroll to the cursor; whether to centre it.
    reveal: bool,
    wants_focus: bool,
    /// Requests from outside since the last frame.
    ordered: Vec<Order>,
    changed_at: f64,
    /// Whether the mouse has not moved since the last key. It then rests wherever it was left, and points at nothing.
    mouse_rests: bool,
}

/// A request from outside.
enum Order {
    Jump(SourceSpan),
    Insert(String),
    Command(EditorCommand),
}

impl Editor {
    /// Selects a span of the document that is shown next, scrolls to it, and takes the keyboard.
    pub fn jump_to(&mut self, span: SourceSpan) {
        self.ordered.push(Order::Jump(span));
    }

    /// Replaces the selection by a text, and takes the keyboard.
    pub fn insert(&mut self, text: impl Into<String>) {
        self.ordered.push(Order::Insert(text.into()));
    }

    /// Performs a command, as its key does: for menus and buttons.
    pub fn order(&mut self, command: EditorCommand) {
        self.ordered.push(Order::Command(command));
    }

    /// Takes the keyboard.
    pub fn focus(&mut self) {
        self.wants_focus = true;
    }

    /// The identifier of a document's widget in egui.
    pub fn id_of(document: &Document) -> Id {
        Id::new(("editor of a document", document.id()))
    }

    /// Draws the editor into all free space, and handles keys and clicks.
    pub fn ui(&mut self, ui: &mut Ui, document: &mut Document, palette: &Palette) -> EditorResponse {
        let (context, font) = (ui.ctx().clone(), TextStyle::Monospace.resolve(ui.style()));
        let look = TextStyling { context: &context, font: &font, palette };
        let id = Self::id_of(document);
        let revision = document.revision();
        let mut response = EditorResponse::default();
        self.turn_to(document);
        if self.find.is_open() {
            self.find_ui(ui, document);
        }
        for order in std::mem::take(&mut self.ordered) {
            match order {
                Order::Jump(span) => self.show_range(document, span.range(), true),
                Order::Insert(text) => self.replace_selected(document, text),
                Order::Command(command) => {
                    self.run(look, document, command, &mut response);
                    // The search bar takes the keyboard itself.
                    self.wants_focus |= command != EditorCommand::Find;
                }
            }
        }
        let wants_focus = std::mem::take(&mut self.wants_focus);
        if wants_focus {
            context.memory_mut(|memory| memory.request_focus(id));
        }
        let focused = context.memory(|memory| memory.has_focus(id));
        self.note_mouse(&context, focused);
        let typed = if focused { self.before_typing(look, document, &mut response) } else { Vec::new() };
        if !focused {
            self.queue.clear();
        }
        self.text_ui(ui, look, document, &typed, wants_focus);
        if focused {
            while let Some(command) = self.queue.next_command(self.open()) {
                self.run(look, document, command, &mut response);
            }
        }
        response.changed = document.revision() != revision;
        self.check(look, document, response.changed);
        if response.changed || self.moved || self.reveal || !self.queue.is_empty() {
            context.request_repaint();
        }
        response.focused = context.memory(|memory| memory.has_focus(id));
        let laid = self.lay(look, document);
        let (line, column) = laid.lines.place(&document.text, self.selection.head);
        response.place = (line + 1, column + 1);
        self.selections.insert(document.id(), self.selection);
        response
    }

    /// Notes whether the mouse or the keyboard was used last.
    fn note_mouse(&mut self, context: &Context, focused: bool) {
        context.input(|input| {
            for event in &input.events {
                let typed = focused && matches!(event, Event::Key { pressed: true, .. } | Event::Text(_));
                let moved = matches!(event, Event::PointerMoved(_) | Event::PointerButton { .. } | Event::MouseWheel { .. });
                self.mouse_rests = (self.mouse_rests || typed) && !moved;
            }
        });
    }

    /// Switches to a document, with the selection that it had.
    fn turn_to(&mut self, document: &Document) {
        if self.shown != Some(document.id()) {
            self.shown = Some(document.id());
            self.selection = self.selections.get(&document.id()).copied().unwrap_or_default();
            (self.moved, self.reveal) = (true, true);
            self.queue.clear();
            self.list.close();
        }
        // The text may have been changed elsewhere.
        let fit = |at: usize| floor(&document.text, at);
        self.selection = Selection { anchor: fit(self.selection.anchor), head: fit(self.selection.head) };
    }

    fn open(&self) -> Open {
        Open { list: self.list.is_open(), find: self.find.is_open() }
    }

    /// Performs the commands at the start of the typed input, and passes the input up to the next command to the
    /// widget.
    fn before_typing(&mut self, look: TextStyling<'_>, document: &mut Document, response: &mut EditorResponse) -> Vec<Event> {
        look.context.input_mut(|input| self.queue.take_from(&mut input.events));
        while let Some(command) = self.queue.next_command(self.open()) {
            self.run(look, document, command, response);
        }
        let typed = self.queue.up_to_command(self.open());
        look.context.input_mut(|input| input.events.extend(typed.iter().cloned()));
        typed
    }

    /// Draws the search bar, and does what it asks for.
    fn find_ui(&mut self, ui: &mut Ui, document: &mut Document) {
        let of = (document.id(), document.revision());
        let wish = self.find.ui(ui, of, &document.text, self.selection.range());
        // Only if no widget has the keyboard: a field of the bar gives it up when Esc is pressed.
        let escaped = ui.memory(|memory| memory.focused().is_none()) && ui.input(|input| input.key_pressed(Key::Escape));
        match wish {
            Some(Wish::Show(range)) => self.show_range(document, range, false),
            Some(Wish::Replace(range)) => {
                let after = range.start + self.find.replacement().len();
                let edit = Edit::replacing(&document.text, range, self.find.replacement());
                self.edit(document, edit, Selection::cursor(after));
                self.find.search(document.id(), document.revision(), &document.text);
                if let Some(next) = self.find.next(after) {
                    self.show_range(document, next, false);
                }
            }
            Some(Wish::ReplaceAll) => {
                let mut text = document.text.clone();
                for range in self.find.found().iter().rev() {
                    text.replace_range(range.clone(), self.find.replacement());
                }
                if let Some(edit) = Edit::between(&document.text, &text) {
                    let after = Selection::cursor(edit.at);
                    self.edit(document, edit, after);
                }
            }
            Some(Wish::Close) => self.close_find(),
            None if escaped => self.close_find(),
            None => {}
        }
        self.find.search(document.id(), document.revision(), &document.text);
    }

    fn close_find(&mut self) {
        self.find.close();
        (self.wants_focus, self.moved) = (true, true);
    }

    /// Selects a range, and scrolls to it.
    fn show_range(&mut self, document: &Document, range: std::ops::Range<usize>, focus: bool) {
        let range = fitting(&document.text, range);
        self.selection = Selection { anchor: range.start, head: range.end };
        (self.moved, self.reveal) = (true, true);
        self.wants_focus |= focus;
        self.list.close();
    }

    /// Makes an edit that is undone on its own.
    fn edit(&mut self, document: &mut Document, edit: Edit, after: Selection) {
        document.edit(edit, self.selection, after);
        self.selection = after;
        (self.moved, self.reveal) = (true, true);
        self.list.close();
    }

    fn replace_selected(&mut self, document: &mut Document, text: String) {
        let range = self.selection.range();
        let after = Selection::cursor(range.start + text.len());
        let edit = Edit::replacing(&document.text, range, text);
        self.edit(document, edit, after);
        self.wants_focus = true;
    }

    fn run(&mut self, look: TextStyling<'_>, document: &mut Document, command: EditorCommand, response: &mut EditorResponse) {
        let (text, selection) = (document.text.as_str(), self.selection);
        let edit = match command {
            EditorCommand::LineBreak => Some(commands::line_break(text, selection)),
            EditorCommand::Indent => commands::indent(text, selection),
            EditorCommand::Outdent => commands::outdent(text, selection),
            EditorCommand::Comment => commands::toggle_comment(text, selection),
            EditorCommand::Accept => self.list.chosen().map(|(word, candidate)| {
                let after = Selection::cursor(word.start + candidate.insert.len());
                (Edit::replacing(text, word, candidate.insert.as_str()), after)
            }),
            EditorCommand::Undo | EditorCommand::Redo => {
                if let Some(selection) = if command == EditorCommand::Undo { document.undo() } else { document.redo() } {
                    self.selection = selection;
                    (self.moved, self.reveal) = (true, true);
                    self.list.close();
                }
                None
            }
            EditorCommand::Cut | EditorCommand::Copy => {
                let range = fitting(text, selection.range());
                if !range.is_empty() {
                    look.context.copy_text(text[range.clone()].to_owned());
                }
                let cuts = command == EditorCommand::Cut && !range.is_empty();
                cuts.then(|| (Edit::replacing(text, range.clone(), ""), Selection::cursor(range.start)))
            }
            EditorCommand::Paste => {
                // The text comes as an event, as if its key was pressed.
                look.context.send_viewport_cmd(ViewportCommand::RequestPaste);
                None
            }
            EditorCommand::SelectAll => {
                self.selection = Selection { anchor: 0, head: text.len() };
                (self.moved, self.reveal) = (true, true);
                None
            }
            EditorCommand::Apply => {
                response.apply = true;
                self.list.close();
                None
            }
            EditorCommand::Find => {
                let selected = &text[fitting(text, selection.range())];
                self.find.open(selected);
                None
            }
            EditorCommand::FindNext | EditorCommand::FindPrevious => {
                if !self.find.is_open() {
                    self.find.open("");
                }
                self.find.search(document.id(), document.revision(), text);
                let next = command == EditorCommand::FindNext;
                let range =
                    if next { self.find.next(selection.range().end) } else { self.find.previous(selection.range().start) };
                if let Some(range) = range {
                    self.show_range(document, range, true);
                }
                None
            }
            EditorCommand::Complete => {
                self.offer(look, document, true);
                None
            }
            EditorCommand::ListUp | EditorCommand::ListDown => {
                self.list.step(command == EditorCommand::ListDown);
                None
            }
            EditorCommand::Dismiss => {
                if self.list.is_open() {
                    self.list.dismiss();
                } else {
                    self.close_find();
                }
                None
            }
        };
        if let Some((edit, after)) = edit {
            self.edit(document, edit, after);
        }
    }

    /// Shows completions for the cursor, if there are any.
    fn offer(&mut self, look: TextStyling<'_>, document: &Document, asked: bool) {
        let laid = self.lay(look, document);
        let cursor = self.selection.head;
        let completion = complete(document.kind(), &document.text, &laid.words, cursor);
        self.list.offer(completion.filter(|_| self.selection.range().is_empty()), &document.text, asked);
    }

    /// Checks the text: at once, or after a pause if it is slow.
    fn check(&mut self, look: TextStyling<'_>, document: &mut Document, changed: bool) {
        let now = look.context.input(|input| input.time);
        if changed {
            self.changed_at = now;
        }
        if !document.is_checked() {
            let waits = CHECK_AFTER - (now - self.changed_at);
            if document.is_checked_at_once() || waits <= 0.0 {
                document.check();
                look.context.request_repaint();
            } else {
                look.context.request_repaint_after(Duration::from_secs_f64(waits));
            }
        }
    }

    /// The current layout of the text.
    fn lay(&mut self, look: TextStyling<'_>, document: &Document) -> Arc<Laid> {
        self.colouring.lay(look.context, document.kind(), &document.text, look.font, look.palette)
    }
}
