//! Which keys are commands of the editor, and the order in which what was typed is handled.
//!
//! Several keys may come with one frame where frames are slow. The widget gets what is typed before a command, the command is done next,
//! and what comes behind waits for the next frame, so that everything happens in the order in which it was typed.

use crate::lang::lines::with_line_feeds;
use egui::{Event, Key, Modifiers};
use std::collections::VecDeque;

/// What a key asks of the editor, beyond what the widget does by itself.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Command {
    /// Take the text as it is for the picture.
    Apply,
    /// Take the last step back.
    Undo,
    /// Do it again.
    Redo,
    /// A line break.
    LineBreak,
    /// Four spaces, or the selected lines to the right.
    Indent,
    /// The selected lines to the left.
    Outdent,
    /// The selected lines into comments, or back.
    Comment,
    /// Show the bar for searching.
    Find,
    /// The next that was found.
    FindNext,
    /// The one before.
    FindPrevious,
    /// Show what may be written here.
    Complete,
    /// The one above in the list of what may be written.
    ListUp,
    /// The one below.
    ListDown,
    /// Write the one at hand.
    Accept,
    /// Close what is open: the list, or the bar.
    Dismiss,
}

/// What is open, and so has keys of its own.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) struct Open {
    /// The list of what may be written.
    pub list: bool,
    /// The bar for searching.
    pub find: bool,
}

/// The command that an event is, if it is one.
#[expect(clippy::wildcard_enum_match_arm, reason = "there are a hundred keys, and a new one is no command")]
pub(super) fn command(event: &Event, open: Open) -> Option<Command> {
    let Event::Key { key, pressed: true, modifiers, .. } = event else { return None };
    let control = modifiers.command || modifiers.ctrl;
    let plain = modifiers.is_none();
    match key {
        Key::ArrowUp if open.list && plain => Some(Command::ListUp),
        Key::ArrowDown if open.list && plain => Some(Command::ListDown),
        Key::Enter | Key::Tab if open.list && plain => Some(Command::Accept),
        Key::Escape if open.list || open.find => Some(Command::Dismiss),
        Key::Enter if control => Some(Command::Apply),
        Key::Enter if !modifiers.alt => Some(Command::LineBreak),
        Key::Tab if plain => Some(Command::Indent),
        Key::Tab if *modifiers == Modifiers::SHIFT => Some(Command::Outdent),
        Key::Z if control && modifiers.shift => Some(Command::Redo),
        Key::Z if control => Some(Command::Undo),
        Key::Y if control => Some(Command::Redo),
        Key::Slash if control => Some(Command::Comment),
        Key::F if control => Some(Command::Find),
        Key::F3 if modifiers.shift => Some(Command::FindPrevious),
        Key::F3 => Some(Command::FindNext),
        Key::Space if control => Some(Command::Complete),
        _ => None,
    }
}

/// Whether an event is of the keyboard or the clipboard, so that its place among others matters.
fn is_typed(event: &Event) -> bool {
    matches!(event, Event::Key { .. } | Event::Text(_) | Event::Paste(_) | Event::Copy | Event::Cut | Event::Ime(_))
}

/// What was typed and is not handled yet, in order.
#[derive(Debug, Default)]
pub(super) struct Queue {
    waiting: VecDeque<Event>,
}

impl Queue {
    /// Forgets everything: the editor is not the one that is typed into.
    pub(super) fn clear(&mut self) {
        self.waiting.clear();
    }

    /// Whether something waits for the next frame.
    pub(super) fn is_empty(&self) -> bool {
        self.waiting.is_empty()
    }

    /// Takes what was typed out of the events of a frame.
    pub(super) fn take_from(&mut self, events: &mut Vec<Event>) {
        events.retain_mut(|event| {
            if !is_typed(event) {
                return true;
            }
            // Lines end in one way within the editor, wherever a text comes from.
            if let Event::Paste(text) = event {
                *text = with_line_feeds(text);
            }
            self.waiting.push_back(event.clone());
            false
        });
    }

    /// The command that is next, if it is one.
    pub(super) fn next_command(&mut self, open: Open) -> Option<Command> {
        let found = command(self.waiting.front()?, open)?;
        self.waiting.pop_front();
        // A key that is a command may come with the character it types, as Ctrl+Space does.
        if found == Command::Complete && self.waiting.front() == Some(&Event::Text(" ".to_owned())) {
            self.waiting.pop_front();
        }
        Some(found)
    }

    /// What comes before the next event that is a command, or may be one once the widget has handled what is before it.
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
        assert_eq!(queue.next_command(open), Some(Command::LineBreak));
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
        assert_eq!(queue.next_command(Open { list: true, find: false }), Some(Command::ListDown));
        queue.take_from(&mut vec![down.clone()]);
        assert_eq!(queue.next_command(closed), None);
        assert_eq!(queue.up_to_command(closed), [down]);
    }
}
