//! An edited text: its kind, its location, its history and its diagnostics.
//!
//! No files are read or written here, and no widget is known. While it is edited, a text has no byte order mark, and `
//! ` as line ends. Its file gets the ones that it had.

use super::history::{Edit, EditHistory, Selection};
use crate::formula::Formula;
use crate::lang::diagnostic::{Diagnostic, Diagnostics, Severity};
use crate::lang::display_text::one_line;
use crate::lang::lines::{LineEnd, with_line_feeds};
use crate::lang::source::{BYTE_ORDER_MARK, Source};
use crate::scene::Scene;
use crate::workspace::FileKind;
use crate::workspace::Location;
use std::path::Path;
use std::sync::atomic::{AtomicU64, Ordering};

/// Texts up to this many bytes are checked at every change. That takes no longer than drawing them.
const CHECKED_AT_ONCE: usize = 32 << 10;

/// A text with its history and its diagnostics.
#[derive(Debug)]
pub struct Document {
    id: u64,
    kind: FileKind,
    location: Option<Location>,
    /// Why the file at the location could not be read, until something else is saved there.
    unread: Option<Diagnostics>,
    pub(super) text: String,
    saved: String,
    /// The text that the picture is made from; `None` if it is another one.
    applied: Option<String>,
    marked: bool,
    line_end: LineEnd,
    revision: u64,
    checked: Option<u64>,
    diagnostics: Vec<Diagnostic>,
    history: EditHistory,
}

impl Document {
    /// A text that is in no file yet. It counts as saved until it is changed.
    pub fn untitled(kind: FileKind, text: &str) -> Self {
        static NEXT: AtomicU64 = AtomicU64::new(0);
        let marked = text.starts_with(BYTE_ORDER_MARK);
        let text = text.strip_prefix(BYTE_ORDER_MARK).unwrap_or(text);
        let line_end = LineEnd::first_in(text);
        let text = with_line_feeds(text);
        let mut document = Self {
            id: NEXT.fetch_add(1, Ordering::Relaxed),
            kind,
            location: None,
            unread: None,
            saved: text.clone(),
            applied: None,
            text,
            marked,
            line_end,
            revision: 0,
            checked: None,
            diagnostics: Vec::new(),
            history: EditHistory::default(),
        };
        document.check();
        document
    }

    /// A text that was read from a location.
    pub fn opened(kind: FileKind, location: Location, text: &str) -> Self {
        let mut document = Self { location: Some(location), ..Self::untitled(kind, text) };
        document.check();
        document
    }

    /// A text of which only the location is known, because the file cannot be read for this reason. The reason is shown
    /// until there is a text.
    pub fn unread(kind: FileKind, location: Location, reason: Diagnostics) -> Self {
        let mut document = Self { location: Some(location), unread: Some(reason), ..Self::untitled(kind, "") };
        document.set_diagnostics(Diagnostics::new());
        document
    }

    /// Identifies the document in this run.
    pub fn id(&self) -> u64 {
        self.id
    }

    /// The kind of text.
    pub fn kind(&self) -> FileKind {
        self.kind
    }

    /// Where the text is saved; `None` if it never was.
    pub fn location(&self) -> Option<&Location> {
        self.location.as_ref()
    }

    /// The location from which paths in the text start; the working directory for a text that was never saved.
    pub fn place(&self) -> Location {
        self.location.clone().unwrap_or_else(|| Location::new(""))
    }

    /// The file that the text may replace without a question; `None` if there is none, or if its contents are not
    /// known.
    pub fn own_file(&self) -> Option<&Path> {
        self.location.as_ref().and_then(Location::file).filter(|path| self.unread.is_none() || !path.exists())
    }

    /// The text, with `
    /// ` as line ends.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// The text with its name, for parsers. Spans in their diagnostics refer to [`text`](Self::text).
    pub fn source(&self) -> Source {
        Source::new(self.name(), self.text.clone())
    }

    /// The text as it was saved last, or opened.
    pub fn saved_source(&self) -> Source {
        Source::new(self.name(), self.saved.clone())
    }

    /// The text for its file, with the line ends and the byte order mark that it had.
    pub fn file_text(&self) -> String {
        let mark = if self.marked { String::from(BYTE_ORDER_MARK) } else { String::new() };
        mark + &self.text.replace('\n', self.line_end.text())
    }

    /// Whether there are unsaved changes.
    pub fn unsaved(&self) -> bool {
        self.text != self.saved
    }

    /// Notes that the current text was saved at a location.
    pub fn note_saved(&mut self, location: Location) {
        self.saved.clone_from(&self.text);
        self.unread = None;
        if self.location.as_ref() != Some(&location) {
            self.location = Some(location);
        }
    }

    /// Whether the picture is made from the current text.
    pub fn is_applied(&self) -> bool {
        self.applied.as_ref() == Some(&self.text)
    }

    /// Notes whether the picture is made from the current text, or from another one.
    pub fn note_applied(&mut self, applied: bool) {
        self.applied = applied.then(|| self.text.clone());
    }

    /// The full name, safe to display: the location, or that there is none.
    pub fn name(&self) -> String {
        match &self.location {
            Some(location) => one_line(&location.to_string()),
            None => format!("untitled {}", self.kind.noun()),
        }
    }

    /// The name without folders.
    pub fn short_name(&self) -> String {
        let name = match &self.location {
            Some(Location::File(path)) => path.file_name().map(|name| one_line(&name.to_string_lossy())),
            Some(Location::Preset(_)) | None => None,
        };
        name.unwrap_or_else(|| self.name())
    }

    /// The title of a tab: the name without folders, with a mark if there are unsaved changes.
    pub fn title(&self) -> String {
        let name = self.short_name();
        if self.unsaved() { format!("{name} •") } else { name }
    }

    /// Changes with every change of the text.
    pub fn revision(&self) -> u64 {
        self.revision
    }

    /// Replaces the whole text, as one step of the history.
    pub fn replace_text(&mut self, text: &str) {
        let text = with_line_feeds(text.strip_prefix(BYTE_ORDER_MARK).unwrap_or(text));
        if let Some(edit) = Edit::between(&self.text, &text) {
            let after = Selection::cursor(edit.at);
            self.edit(edit, after, after);
        }
    }

    /// The diagnostics of the last [`check`](Self::check). The text may have changed since.
    pub fn diagnostics(&self) -> &[Diagnostic] {
        &self.diagnostics
    }

    /// Whether the diagnostics are those of the current text.
    pub fn is_checked(&self) -> bool {
        self.checked == Some(self.revision)
    }

    /// Whether checking is fast enough to do it at every change.
    pub fn is_checked_at_once(&self) -> bool {
        self.text.len() <= CHECKED_AT_ONCE
    }

    /// The number of errors and of warnings.
    pub fn counts(&self) -> [usize; 2] {
        [Severity::Error, Severity::Warning]
            .map(|severity| self.diagnostics.iter().filter(|one| one.severity() == severity).count())
    }

    /// Checks the text if it has changed. Only formulas and scenes are checked.
    pub fn check(&mut self) {
        if self.is_checked() {
            return;
        }
        let source = self.source();
        let diagnostics = match self.kind {
            FileKind::Formula => Formula::parse(&source).map_or_else(|errors| errors, |(_, warnings)| warnings),
            FileKind::Scene => Scene::parse(&source).map_or_else(|errors| errors, |(_, warnings)| warnings),
            FileKind::Session | FileKind::Material => Diagnostics::new(),
        };
        self.set_diagnostics(diagnostics);
    }

    /// Sets the diagnostics of the current text.
    pub fn set_diagnostics(&mut self, mut diagnostics: Diagnostics) {
        if let Some(reason) = self.unread.as_ref().filter(|_| self.text.is_empty()) {
            diagnostics = reason.clone();
        }
        diagnostics.sort();
        self.diagnostics = diagnostics.into_iter().collect();
        self.checked = Some(self.revision);
    }

    /// Whether there is a step to undo.
    pub fn can_undo(&self) -> bool {
        self.history.can_undo()
    }

    /// Whether there is a step to redo.
    pub fn can_redo(&self) -> bool {
        self.history.can_redo()
    }

    /// Undoes the last step. Returns the selection to restore.
    pub(super) fn undo(&mut self) -> Option<Selection> {
        let selection = self.history.undo(&mut self.text)?;
        self.revision += 1;
        Some(selection)
    }

    /// Redoes the step that was undone last. Returns the selection to restore.
    pub(super) fn redo(&mut self) -> Option<Selection> {
        let selection = self.history.redo(&mut self.text)?;
        self.revision += 1;
        Some(selection)
    }

    /// Takes the text of a scene that was changed by hand, as one step of the history. Returns whether it is another
    /// text.
    pub fn take_text_by_hand(&mut self, text: &str) -> bool {
        let Some(edit) = Edit::between(&self.text, text) else { return false };
        let after = Selection { anchor: edit.at, head: edit.at + edit.inserted.len() };
        edit.apply(&mut self.text);
        self.history.note_by_hand(edit, Selection::cursor(after.anchor), after);
        self.revision += 1;
        true
    }

    /// Undoes or redoes a step if it follows a change of the scene by hand. Returns whether it did.
    pub fn move_by_hand(&mut self, forwards: bool) -> bool {
        let moved = self.history.by_hand()[usize::from(forwards)];
        if moved {
            let _ = if forwards { self.redo() } else { self.undo() };
        }
        moved
    }

    /// Whether a step that follows a change of the scene was undone or redone since the last call, so that the picture
    /// must follow.
    pub fn take_by_hand_moved(&mut self) -> bool {
        self.history.take_by_hand_moved()
    }

    /// Makes an edit that is undone on its own.
    pub(super) fn edit(&mut self, edit: Edit, before: Selection, after: Selection) {
        edit.apply(&mut self.text);
        self.history.note(edit, before, after, None);
        self.revision += 1;
    }

    /// Notes that the widget has changed the text, at a time in seconds.
    pub(super) fn note_typed(&mut self, edit: Edit, before: Selection, after: Selection, time: f64) {
        self.history.note(edit, before, after, Some(time));
        self.revision += 1;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::PathBuf;

    #[test]
    fn files_keep_their_line_ends_and_mark() {
        for text in ["\u{feff}formula;\r\n= Cd;\r\n", "formula;\n= Cd;", "formula;\r= Cd;\r", "", "\r\n", "\n", "\r"] {
            let document = Document::untitled(FileKind::Formula, text);
            assert_eq!(document.file_text(), text);
            assert!(!document.text().contains(['\r', BYTE_ORDER_MARK]));
        }
    }

    #[test]
    fn steps_by_hand_are_told_apart_from_typing() {
        let mut document = Document::untitled(FileKind::Scene, "bodies;");
        assert!(document.take_text_by_hand("bodies; lights;") && !document.take_text_by_hand("bodies; lights;"));
        document.replace_text("bodies; lights; camera;");
        assert!(!document.move_by_hand(false), "typing is undone first");
        assert!(document.undo().is_some() && !document.take_by_hand_moved());
        assert!(!document.move_by_hand(true) && document.move_by_hand(false) && document.text() == "bodies;");
        assert!(document.take_by_hand_moved() && !document.take_by_hand_moved());
        // As by keys in the editor.
        assert!(document.redo().is_some() && document.take_by_hand_moved());
        assert_eq!(document.text(), "bodies; lights;");
    }

    #[test]
    fn the_title_says_what_is_not_saved() {
        let location = Location::File(PathBuf::from("models/phong.formula"));
        let mut document = Document::opened(FileKind::Formula, location.clone(), "formula;\n= Cd;\n");
        assert_eq!((document.title().as_str(), document.counts()), ("phong.formula", [0, 0]));
        document.note_applied(true);
        document.replace_text("formula;\n= kd;\n");
        assert!(!document.is_applied());
        assert_eq!(document.title(), "phong.formula •");
        assert!(!document.is_checked());
        document.check();
        assert_eq!(document.counts()[0], 1);
        assert!(document.undo().is_some());
        assert!(!document.unsaved(), "what is undone is as it was saved");
        assert!(document.is_applied(), "and as it was applied");
        assert!(document.redo().is_some());
        document.note_saved(location);
        assert!(!document.unsaved());
        assert_eq!(Document::untitled(FileKind::Scene, "").title(), "untitled scene");
        let hostile = Document::opened(FileKind::Scene, Location::new("a/\u{202e}b\n.scene"), "");
        assert_eq!((hostile.title().as_str(), hostile.name().as_str()), ("\\u{202e}b\\n.scene", "a/\\u{202e}b\\n.scene"));
        assert_eq!(Document::opened(FileKind::Scene, Location::new("preset:glass"), "").title(), "preset:glass");
    }
}
