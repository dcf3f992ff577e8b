//! The undo history of a text. Edits that belong together form one step.
//!
//! Only the changed parts are kept, not whole texts. Moving the cursor is not a step.

use std::ops::Range;

/// A pause of this many seconds starts a new step.
const PAUSE: f64 = 1.5;
/// The largest size of all removed and inserted texts, in bytes. The oldest steps are dropped first.
const KEPT_BYTES: usize = 16 << 20;

/// A selection, in bytes: from where it was started to the cursor.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) struct Selection {
    /// Where the selection was started; the cursor if nothing is selected.
    pub anchor: usize,
    /// The cursor.
    pub head: usize,
}

impl Selection {
    /// A cursor without selected text.
    pub(super) fn cursor(at: usize) -> Self {
        Self { anchor: at, head: at }
    }

    /// The selected bytes, in the order of the text.
    pub(super) fn range(self) -> Range<usize> {
        self.anchor.min(self.head)..self.anchor.max(self.head)
    }
}

/// The replacement of a part of a text.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Edit {
    /// The byte where the part starts.
    pub at: usize,
    /// The old text.
    pub removed: String,
    /// The new text.
    pub inserted: String,
}

impl Edit {
    /// The edit that replaces a range of `text` by `inserted`.
    pub(super) fn replacing(text: &str, range: Range<usize>, inserted: impl Into<String>) -> Self {
        Self { at: range.start, removed: text[range].to_owned(), inserted: inserted.into() }
    }

    /// The smallest edit that turns `old` into `new`; `None` if they are equal.
    pub(super) fn between(old: &str, new: &str) -> Option<Self> {
        if old == new {
            return None;
        }
        let alike = |one: &[u8], other: &[u8]| one.iter().zip(other).take_while(|(one, other)| one == other).count();
        let mut start = alike(old.as_bytes(), new.as_bytes());
        while !old.is_char_boundary(start) || !new.is_char_boundary(start) {
            start -= 1;
        }
        let (rest_old, rest_new) = (&old[start..], &new[start..]);
        let backwards = rest_old.bytes().rev().zip(rest_new.bytes().rev());
        let mut tail = backwards.take_while(|(one, other)| one == other).count();
        while !rest_old.is_char_boundary(rest_old.len() - tail) || !rest_new.is_char_boundary(rest_new.len() - tail) {
            tail -= 1;
        }
        let piece = |rest: &str| rest[..rest.len() - tail].to_owned();
        Some(Self { at: start, removed: piece(rest_old), inserted: piece(rest_new) })
    }

    /// Applies the edit to a text.
    pub(super) fn apply(&self, text: &mut String) {
        text.replace_range(self.at..self.at + self.removed.len(), &self.inserted);
    }

    /// The edit that undoes this one.
    #[must_use]
    pub(super) fn reversed(&self) -> Self {
        Self { at: self.at, removed: self.inserted.clone(), inserted: self.removed.clone() }
    }

    fn bytes(&self) -> usize {
        self.removed.len() + self.inserted.len()
    }
}

/// A step: an edit with the selections before and after it.
#[derive(Debug, Clone)]
struct EditStep {
    edit: Edit,
    before: Selection,
    after: Selection,
    /// When it was last extended, in seconds; `None` if it must not be extended.
    time: Option<f64>,
    /// Whether something was moved, added or removed in the scene, and the text followed.
    by_hand: bool,
}

/// The steps to undo and to redo.
#[derive(Debug, Clone, Default)]
pub(super) struct EditHistory {
    done: Vec<EditStep>,
    undone: Vec<EditStep>,
    /// Whether a step by hand was undone or redone since somebody asked.
    by_hand_moved: bool,
}

impl EditHistory {
    /// Adds an edit. Typing on at the same place without a pause extends the last step. `time` is in seconds; `None`
    /// makes the edit a step of its own.
    pub(super) fn note(&mut self, edit: Edit, before: Selection, after: Selection, time: Option<f64>) {
        self.undone.clear();
        if let (Some(last), Some(now)) = (self.done.last_mut(), time)
            && last.time.is_some_and(|time| now - time < PAUSE)
            && joined(&mut last.edit, &edit)
        {
            (last.after, last.time) = (after, time);
            return;
        }
        self.push(EditStep { edit, before, after, time, by_hand: false });
    }

    /// Adds an edit that follows a change of the scene, as a step of its own.
    pub(super) fn note_by_hand(&mut self, edit: Edit, before: Selection, after: Selection) {
        self.undone.clear();
        self.push(EditStep { edit, before, after, time: None, by_hand: true });
    }

    fn push(&mut self, step: EditStep) {
        self.done.push(step);
        let mut kept = 0;
        let fits = self.done.iter().rev().take_while(|step| {
            kept += step.edit.bytes();
            kept <= KEPT_BYTES
        });
        // The last step is kept, whatever its size.
        let fits = fits.count().max(1);
        self.done.drain(..self.done.len() - fits);
    }

    /// Undoes the last step. Returns the selection to restore; `None` if there is no step.
    pub(super) fn undo(&mut self, text: &mut String) -> Option<Selection> {
        let mut step = self.done.pop()?;
        step.time = None;
        step.edit.reversed().apply(text);
        let selection = step.before;
        self.by_hand_moved |= step.by_hand;
        self.undone.push(step);
        Some(selection)
    }

    /// Redoes the step that was undone last. Returns the selection to restore; `None` if there is no step.
    pub(super) fn redo(&mut self, text: &mut String) -> Option<Selection> {
        let step = self.undone.pop()?;
        step.edit.apply(text);
        let selection = step.after;
        self.by_hand_moved |= step.by_hand;
        self.done.push(step);
        Some(selection)
    }

    /// Whether the step to undo, and the step to redo, follow a change of the scene.
    pub(super) fn by_hand(&self) -> [bool; 2] {
        [&self.done, &self.undone].map(|steps| steps.last().is_some_and(|step| step.by_hand))
    }

    /// Whether such a step was undone or redone since the last call.
    pub(super) fn take_by_hand_moved(&mut self) -> bool {
        std::mem::take(&mut self.by_hand_moved)
    }

    /// Whether there is a step to undo.
    pub(super) fn can_undo(&self) -> bool {
        !self.done.is_empty()
    }

    /// Whether there is a step to redo.
    pub(super) fn can_redo(&self) -> bool {
        !self.undone.is_empty()
    }
}

/// Extends an edit by another one that continues it: typing on within a line, or deleting in either direction.
fn joined(last: &mut Edit, next: &Edit) -> bool {
    let typed = next.removed.is_empty() && !next.inserted.contains('\n') && next.at == last.at + last.inserted.len();
    // A new word after a space is a step of its own.
    let new_word = last.inserted.ends_with(char::is_whitespace) && !next.inserted.starts_with(char::is_whitespace);
    if typed && !last.inserted.is_empty() && !new_word {
        last.inserted.push_str(&next.inserted);
        return true;
    }
    let deleted = next.inserted.is_empty() && last.inserted.is_empty();
    if deleted && next.at + next.removed.len() == last.at {
        last.removed.insert_str(0, &next.removed);
        last.at = next.at;
        return true;
    }
    if deleted && next.at == last.at {
        last.removed.push_str(&next.removed);
        return true;
    }
    false
}

#[cfg(test)]
mod tests {
    use super::*;

    fn typed(history: &mut EditHistory, text: &mut String, at: usize, inserted: &str, time: f64) {
        let edit = Edit::replacing(text, at..at, inserted);
        edit.apply(text);
        history.note(edit, Selection::cursor(at), Selection::cursor(at + inserted.len()), Some(time));
    }

    #[test]
    fn edits_between_texts_keep_characters_whole() {
        for (old, new) in [("aččb", "ačďb"), ("", "😀"), ("😀", "😁"), ("abc", "abcabc"), ("aa", "a")] {
            let edit = Edit::between(old, new).unwrap();
            let mut text = old.to_owned();
            edit.apply(&mut text);
            assert_eq!(text, new);
            edit.reversed().apply(&mut text);
            assert_eq!(text, old);
        }
        assert_eq!(Edit::between("x", "x"), None);
    }

    #[test]
    fn a_word_is_a_step_and_a_pause_parts_steps() {
        let (mut history, mut text) = (EditHistory::default(), String::new());
        for (at, letter) in ["k", "d", " ", "k", "s"].into_iter().enumerate() {
            typed(&mut history, &mut text, at, letter, at as f64 * 0.1);
        }
        typed(&mut history, &mut text, 5, "x", 60.0);
        for expected in ["kd ks", "kd ", ""] {
            assert!(history.undo(&mut text).is_some());
            assert_eq!(text, expected);
        }
        assert_eq!(history.undo(&mut text), None);
        assert_eq!(history.redo(&mut text), Some(Selection::cursor(3)));
        assert_eq!(text, "kd ");
        typed(&mut history, &mut text, 0, "y", 61.0);
        assert!(!history.can_redo() && history.can_undo());
    }

    #[test]
    fn old_steps_go_where_they_take_too_much() {
        let mut history = EditHistory::default();
        for _ in 0..5 {
            let edit = Edit::replacing("", 0..0, "x".repeat(KEPT_BYTES / 3));
            history.note(edit, Selection::default(), Selection::default(), None);
        }
        assert_eq!(history.done.len(), 3);
    }
}
