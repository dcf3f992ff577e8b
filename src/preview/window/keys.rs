//! The keyboard: keys and characters in the order of typing, translated for egui.

use super::clipboard::Clipboard;
use egui::{Event, Key, Modifiers};
use minifb::Key as MinifbKey;
use std::cell::RefCell;
use std::collections::BTreeSet;
use std::rc::Rc;

/// Input from the keyboard.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum KeyInput {
    /// A key was pressed (repeatedly, while it is held) or released.
    Key(MinifbKey, bool),
    /// A character was typed.
    Character(char),
}

/// Input that was not handled yet. minifb pushes to a clone of it.
#[derive(Debug, Clone, Default)]
pub(super) struct KeyQueue(Rc<RefCell<Vec<KeyInput>>>);

impl minifb::InputCallback for KeyQueue {
    fn add_char(&mut self, character: u32) {
        self.0.borrow_mut().extend(char::from_u32(character).map(KeyInput::Character));
    }

    fn set_key_state(&mut self, key: MinifbKey, state: bool) {
        self.0.borrow_mut().push(KeyInput::Key(key, state));
    }
}

impl KeyQueue {
    pub(super) fn take(&self) -> Vec<KeyInput> {
        self.0.take()
    }

    pub(super) fn is_empty(&self) -> bool {
        self.0.borrow().is_empty()
    }
}

/// The keys that are held.
#[derive(Debug, Default)]
pub(super) struct Keyboard {
    held: BTreeSet<MinifbKey>,
    modifiers: Modifiers,
}

impl Keyboard {
    pub(super) fn modifiers(&self) -> Modifiers {
        self.modifiers
    }

    /// Sets the modifiers to what another source says: keys may have changed while the window had no focus.
    pub(super) fn sync_modifiers(&mut self, modifiers: Modifiers) -> Option<Event> {
        (modifiers != self.modifiers).then(|| {
            self.modifiers = modifiers;
            Event::ModifiersChanged(modifiers)
        })
    }

    /// Translates an input into events.
    pub(super) fn handle(&mut self, input: KeyInput, clipboard: &mut Clipboard, events: &mut Vec<Event>) {
        match input {
            KeyInput::Key(key, down) => {
                if down {
                    self.held.insert(key);
                } else {
                    self.held.remove(&key);
                }
                if is_modifier(key) {
                    let modifiers = self.held_modifiers();
                    events.extend(self.sync_modifiers(modifiers));
                }
                let Some(key) = egui_key(key) else { return };
                match clipboard_edit(key, self.modifiers).filter(|_| down) {
                    Some(ClipboardEdit::Copy) => events.push(Event::Copy),
                    Some(ClipboardEdit::Cut) => events.push(Event::Cut),
                    Some(ClipboardEdit::Paste) => events.extend(clipboard.text().map(Event::Paste)),
                    None => events.push(self.event(key, down)),
                }
            }
            KeyInput::Character(character) => {
                if !self.modifiers.ctrl && !character.is_control() {
                    events.push(Event::Text(character.into()));
                }
            }
        }
    }

    /// The window lost the keyboard, so all keys count as released.
    pub(super) fn release(&mut self, events: &mut Vec<Event>) {
        self.modifiers = Modifiers::NONE;
        for key in std::mem::take(&mut self.held) {
            events.extend(egui_key(key).map(|key| self.event(key, false)));
        }
        events.push(Event::ModifiersChanged(Modifiers::NONE));
    }

    fn event(&self, key: Key, pressed: bool) -> Event {
        Event::Key { key, physical_key: None, pressed, repeat: false, modifiers: self.modifiers }
    }

    fn held_modifiers(&self) -> Modifiers {
        let any = |keys: [MinifbKey; 2]| keys.iter().any(|key| self.held.contains(key));
        let ctrl = any([MinifbKey::LeftCtrl, MinifbKey::RightCtrl]);
        Modifiers {
            alt: any([MinifbKey::LeftAlt, MinifbKey::RightAlt]),
            ctrl,
            shift: any([MinifbKey::LeftShift, MinifbKey::RightShift]),
            mac_cmd: false,
            command: ctrl,
        }
    }
}

enum ClipboardEdit {
    Copy,
    Cut,
    Paste,
}

/// The clipboard shortcuts, for which egui has events of their own.
fn clipboard_edit(key: Key, modifiers: Modifiers) -> Option<ClipboardEdit> {
    let Modifiers { ctrl, shift, alt, .. } = modifiers;
    let [with_ctrl, with_shift] = [ctrl && !alt, shift && !ctrl && !alt];
    if with_ctrl && !shift && [Key::C, Key::Insert].contains(&key) {
        Some(ClipboardEdit::Copy)
    } else if (with_ctrl && !shift && key == Key::X) || (with_shift && key == Key::Delete) {
        Some(ClipboardEdit::Cut)
    } else if (with_ctrl && key == Key::V) || (with_shift && key == Key::Insert) {
        Some(ClipboardEdit::Paste)
    } else {
        None
    }
}

fn is_modifier(key: MinifbKey) -> bool {
    [
        MinifbKey::LeftCtrl,
        MinifbKey::RightCtrl,
        MinifbKey::LeftShift,
        MinifbKey::RightShift,
        MinifbKey::LeftAlt,
        MinifbKey::RightAlt,
    ]
    .contains(&key)
}

/// Maps keys with the same name in both libraries, and keys with different names.
macro_rules! keys {
    ($given:expr, same: $($same:ident)*, other: $($typed:ident $key:ident)*) => {
        match $given {
            $(MinifbKey::$same => Some(Key::$same),)*
            $(MinifbKey::$typed => Some(Key::$key),)*
            // egui has no such keys. For `*` there is the character.
            MinifbKey::Menu | MinifbKey::Pause | MinifbKey::NumLock | MinifbKey::CapsLock | MinifbKey::ScrollLock => None,
            MinifbKey::NumPadAsterisk | MinifbKey::Unknown | MinifbKey::Count => None,
        }
    };
}

/// The key of egui for one of minifb.
fn egui_key(key: MinifbKey) -> Option<Key> {
    keys!(key,
        same: A B C D E F G H I J K L M N O P Q R S T U V W X Y Z F1 F2 F3 F4 F5 F6 F7 F8 F9 F10 F11 F12 F13 F14 F15
            Backslash Comma Minus Period Semicolon Slash Backspace Delete End Enter Escape Home Insert PageDown PageUp Space Tab,
        other: Key0 Num0 Key1 Num1 Key2 Num2 Key3 Num3 Key4 Num4 Key5 Num5 Key6 Num6 Key7 Num7 Key8 Num8 Key9 Num9
            NumPad0 Num0 NumPad1 Num1 NumPad2 Num2 NumPad3 Num3 NumPad4 Num4 NumPad5 Num5 NumPad6 Num6 NumPad7 Num7 NumPad8 Num8 NumPad9 Num9
            NumPadDot Period NumPadSlash Slash NumPadMinus Minus NumPadPlus Plus NumPadEnter Enter
            Down ArrowDown Left ArrowLeft Right ArrowRight Up ArrowUp Apostrophe Quote Backquote Backtick Equal Equals
            LeftBracket OpenBracket RightBracket CloseBracket LeftShift ShiftLeft RightShift ShiftRight LeftCtrl ControlLeft
            RightCtrl ControlRight LeftAlt AltLeft RightAlt AltRight LeftSuper SuperLeft RightSuper SuperRight
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    use KeyInput::{Character, Key as Press};

    fn typed(keyboard: &mut Keyboard, inputs: &[KeyInput]) -> Vec<Event> {
        let mut events = Vec::new();
        inputs.iter().for_each(|input| keyboard.handle(*input, &mut Clipboard::default(), &mut events));
        events
    }

    #[test]
    fn letters_are_a_key_and_a_text() {
        let events = typed(&mut Keyboard::default(), &[Press(MinifbKey::A, true), Character('a'), Press(MinifbKey::A, false)]);
        let key = |pressed| Event::Key { key: Key::A, physical_key: None, pressed, repeat: false, modifiers: Modifiers::NONE };
        assert_eq!(events, [key(true), Event::Text("a".into()), key(false)]);
    }

    #[test]
    fn with_ctrl_there_is_no_text_and_copying_has_a_name_of_its_own() {
        let mut keyboard = Keyboard::default();
        let events = typed(
            &mut keyboard,
            &[Press(MinifbKey::LeftCtrl, true), Press(MinifbKey::C, true), Character('\u{3}'), Press(MinifbKey::X, true)],
        );
        assert!(
            events.contains(&Event::Copy)
                && events.contains(&Event::Cut)
                && events.contains(&Event::ModifiersChanged(Modifiers::COMMAND | Modifiers::CTRL)),
            "{events:?}"
        );
        assert!(
            !events.iter().any(|event| matches!(event, Event::Text(_) | Event::Key { key: Key::C | Key::X, .. })),
            "{events:?}"
        );
        let events = typed(&mut keyboard, &[Press(MinifbKey::S, true), Character('s')]);
        assert!(matches!(events[..], [Event::Key { key: Key::S, modifiers: Modifiers { command: true, .. }, .. }]), "{events:?}");
    }

    #[test]
    fn what_is_held_goes_up_with_the_focus() {
        let mut keyboard = Keyboard::default();
        typed(&mut keyboard, &[Press(MinifbKey::LeftCtrl, true), Press(MinifbKey::S, true)]);
        let mut events = Vec::new();
        keyboard.release(&mut events);
        assert!(events.iter().any(|event| matches!(event, Event::Key { key: Key::S, pressed: false, .. })), "{events:?}");
        assert_eq!(events.last(), Some(&Event::ModifiersChanged(Modifiers::NONE)));
        assert_eq!(typed(&mut keyboard, &[Character('s')]), [Event::Text("s".into())]);
    }
}
