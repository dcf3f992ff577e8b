//! The keys of editor commands, and the order of typed input.
//!
//! Slow frames can have several keys. The widget gets the input before a command, then the command is performed, and
//! the input after it waits for the next frame. So everything happens in the order of typing.

use crate::lang::lines::with_line_feeds;
use egui::{Event, Key, Modifiers};
use std::collections::VecDeque;

/// A command of the editor, which egui's widget does not have.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum EditorCommand {
    /// Apply the text.
    Apply,
    /// Undo the last step.
    Undo,
    /// Redo the step that was undone last.
    Redo,
    /// Insert a line break.
    LineBreak,
    /// Insert four spaces, or indent the selected lines.
    Indent,
    /// Unindent the selected lines.
    Outdent,
    /// Comment the selected lines out, or remove the comments.
    Comment,
    /// Copy the selected text to the clipboard, and remove it. For menus; egui's widget has the key.
    Cut,
    /// Copy the selected text to the clipboard. For menus, as `Cut`.
    Copy,
    /// Insert the text of the clipboard. For menus, as `Cut`.
    Paste,
    /// Select the whole text. For menus, as `Cut`.
    SelectAll,
    /// Open the search bar.
    Find,
    /// Go to the next match.
    FindNext,
    /// Go to the previous match.
    FindPrevious,
    /// Show completions.
    Complete,
    /// Select the previous completion.
    ListUp,
    /// Select the next completion.
    ListDown,
    /// Insert the selected completion.
    Accept,
    /// Close the list of completions, or the search bar.
    Dismiss,
}

/// What is open and has keys of its own.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) struct Open {
    /// The list of completions.
    pub list: bool,
    /// The search bar.
    pub find: bool,
}

/// The command of an event, if it is one.
#[expect(clippy::wildcard_enum_match_arm, reason = "there are a hundred keys, and a new one is no command")]
pub(super) fn command(event: &Event, open: Open) -> Option<EditorCommand> {
    let Event::Key { key, pressed: true, modifiers, .. } = event else { return None };
    let control = modifiers.command || modifiers.ctrl;
    let plain = modifiers.is_none();
    match key {
        Key::ArrowUp if open.list && plain => Some(EditorCommand::ListUp),
        Key::ArrowDown if open.list && plain => Some(EditorCommand::ListDown),
        Key::Enter | Key::Tab if open.list && plain => Some(EditorCommand::Accept),
        Key::Escape if open.list || open.find => Some(EditorCommand::Dismiss),
        Key::Enter if control => Some(EditorCommand::Apply),
        Key::Enter if !modifiers.alt => Some(EditorCommand::LineBreak),
        Key::Tab if plain => Some(EditorCommand::Indent),
        Key::Tab if *modifiers == Modifiers::SHIFT => Some(EditorCommand::Outdent),
        Key::Z if control && modifiers.shift => Some(EditorCommand::Redo),
        Key::Z if control => Some(EditorCommand::Undo),
        Key::Y if control => Some(EditorCommand::Redo),
        Key::Slash if control => Some(EditorCommand::Comment),
        Key::F if control => Some(EditorCommand::Find),
        Key::F3 if modifiers.shift => Some(EditorCommand::FindPrevious),
        Key::F3 => Some(EditorCommand::FindNext),
        Key::Space if control => Some(EditorCommand::Complete),
        _ => None,
    }
}

/// Whether an event comes from the keyboard or the clipboard, so its order matters.
fn is_typed(event: &Event) -> bool {
    matches!(event, Event::Key { .. } | Event::Text(_) | Event::Paste(_) | Event::Copy | Event::Cut | Event::Ime(_))
}

/// The typed input that was not handled yet, in order.
#[derive(Debug, Default)]
pub(super) struct Queue {
    waiting: VecDeque<Event>,
}

impl Queue {
    /// Drops everything, because another widget has the keyboard.
    pub(super) fn clear(&mut self) {
        self.waiting.clear();
    }

    /// Whether input waits for the next frame.
    pub(super) fn is_empty(&self) -> bool {
        self.waiting.is_empty()
    }

    /// Takes the typed input out of the events of a frame.
    pub(super) fn take_from(&mut self, events: &mut Vec<Event>) {
        events.retain_mut(|event| {
            if !is_typed(event) {
                return true;
            }
            // The editor only uses line feeds, wherever a text comes from.
            if let Event::Paste(text) = event {
                *text = with_line_feeds(text);
            }
            self.waiting.push_back(event.clone());
            false
        });
    }

    /// The next event as a command, if it is one.
    pub(super) fn next_command(&mut self, open: Open) -> Option<EditorCommand> {
        let found = command(self.waiting.front()?, open)?;
        self.waiting.pop_front();
        // The key of a command may be followed by the character that it types, as with Ctrl+Space.
        if found == EditorCommand::Complete && self.waiting.front() == Some(&Event::Text(" ".to_owned())) {
            self.waiting.pop_front();
        }
        Some(found)
    }

    /// The input before the next event that is a command, or that may become one when the widget has handled the input
    /// before it.
    pub(super) fn up_to_command(&mut self, open: Open) -> Vec<Event> {
        let mut typed = Vec::new();
        let mut changes = false;
        while let Some(event) = self.waiting.front() {
            let list = open.list || changes;
            if command(event, Open { list, ..open }).is_some() && !(typed.is_empty() && command(event, open).is_none()) {
                break;
            }
            changes |= matches!(event, Event::Text(_) | Event::Key { key: Key::Backspace, .. });
            typed.extend(self.waiting.pop_front());
        }
        typed
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn key(key: Key, modifiers: Modifiers) -> Event {
        Event::Key { key, physical_key: None, pressed: true, repeat: false, modifiers }
    }

    #[test]
    fn what_is_typed_keeps_its_order_around_commands() {
        let text = |text: &str| Event::Text(text.to_owned());
        let mut events =
            vec![text("a"), key(Key::Enter, Modifiers::NONE), text("b"), Event::PointerGone, Event::Paste("x\r\ny\rz".into())];
        let mut queue = Queue::default();
        queue.take_from(&mut events);
        assert_eq!(events, [Event::PointerGone]);
        let open = Open::default();
        assert_eq!(queue.next_command(open), None);
        assert_eq!(queue.up_to_command(open), [text("a")]);
        assert_eq!(queue.next_command(open), Some(EditorCommand::LineBreak));
        assert_eq!(queue.next_command(open), None);
        assert_eq!(queue.up_to_command(open), [text("b"), Event::Paste("x\ny\nz".into())]);
        assert!(queue.is_empty());
    }

    #[test]
    fn arrows_wait_where_typing_may_open_the_list() {
        let (text, down) = (Event::Text("a".to_owned()), key(Key::ArrowDown, Modifiers::NONE));
        let mut queue = Queue::default();
        queue.take_from(&mut vec![text.clone(), down.clone()]);
        let closed = Open::default();
        assert_eq!(queue.up_to_command(closed), [text]);
        assert_eq!(queue.next_command(Open { list: true, find: false }), Some(EditorCommand::ListDown));
        queue.take_from(&mut vec![down.clone()]);
        assert_eq!(queue.next_command(closed), None);
        assert_eq!(queue.up_to_command(closed), [down]);
    }
}
