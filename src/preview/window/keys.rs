//! The keyboard: keys and characters in the order of typing, translated for egui.

use super::clipboard::Clipboard;
use egui::{Event, Key, Modifiers};
use minifb::Key as Typed;
use std::cell::RefCell;
use std::collections::BTreeSet;
use std::rc::Rc;

/// Input from the keyboard.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Stroke {
    /// A key was pressed (repeatedly, while it is held) or released.
    Key(Typed, bool),
    /// A character was typed.
    Character(char),
}

/// Input that was not handled yet. minifb pushes to a clone of it.
#[derive(Debug, Clone, Default)]
pub(super) struct Strokes(Rc<RefCell<Vec<Stroke>>>);

impl minifb::InputCallback for Strokes {
    fn add_char(&mut self, character: u32) {
        self.0.borrow_mut().extend(char::from_u32(character).map(Stroke::Character));
    }

    fn set_key_state(&mut self, key: Typed, state: bool) {
        self.0.borrow_mut().push(Stroke::Key(key, state));
    }
}

impl Strokes {
    pub(super) fn take(&self) -> Vec<Stroke> {
        self.0.take()
    }

    pub(super) fn is_empty(&self) -> bool {
        self.0.borrow().is_empty()
    }
}

/// The keys that are held.
#[derive(Debug, Default)]
pub(super) struct Keyboard {
    held: BTreeSet<Typed>,
    modifiers: Modifiers,
}

impl Keyboard {
    pub(super) fn modifiers(&self) -> Modifiers {
        self.modifiers
    }

    /// Sets the modifiers to what another source says: keys may have changed while the window had no focus.
    pub(super) fn correct(&mut self, modifiers: Modifiers) -> Option<Event> {
        (modifiers != self.modifiers).then(|| {
            self.modifiers = modifiers;
            Event::ModifiersChanged(modifiers)
        })
    }

    /// Translates an input into events.
    pub(super) fn stroke(&mut self, stroke: Stroke, clipboard: &mut Clipboard, told: &mut Vec<Event>) {
        match stroke {
            Stroke::Key(key, down) => {
                if down {
                    self.held.insert(key);
                } else {
                    self.held.remove(&key);
                }
                if is_modifier(key) {
                    let modifiers = self.of_held();
                    told.extend(self.correct(modifiers));
                }
                let Some(key) = known(key) else { return };
                match edit(key, self.modifiers).filter(|_| down) {
                    Some(Edit::Copy) => told.push(Event::Copy),
                    Some(Edit::Cut) => told.push(Event::Cut),
                    Some(Edit::Paste) => told.extend(clipboard.text().map(Event::Paste)),
                    None => told.push(self.event(key, down)),
                }
            }
            Stroke::Character(character) => {
                if !self.modifiers.ctrl && !character.is_control() {
                    told.push(Event::Text(character.into()));
                }
            }
        }
    }

    /// The window lost the keyboard, so all keys count as released.
    pub(super) fn release(&mut self, told: &mut Vec<Event>) {
        self.modifiers = Modifiers::NONE;
        for key in std::mem::take(&mut self.held) {
            told.extend(known(key).map(|key| self.event(key, false)));
        }
        told.push(Event::ModifiersChanged(Modifiers::NONE));
    }

    fn event(&self, key: Key, pressed: bool) -> Event {
        Event::Key { key, physical_key: None, pressed, repeat: false, modifiers: self.modifiers }
    }

    fn of_held(&self) -> Modifiers {
        let any = |keys: [Typed; 2]| keys.iter().any(|key| self.held.contains(key));
        let ctrl = any([Typed::LeftCtrl, Typed::RightCtrl]);
        Modifiers {
            alt: any([Typed::LeftAlt, Typed::RightAlt]),
            ctrl,
            shift: any([Typed::LeftShift, Typed::RightShift]),
            mac_cmd: false,
            command: ctrl,
        }
    }
}

enum Edit {
    Copy,
    Cut,
    Paste,
}

/// The clipboard shortcuts, for which egui has events of their own.
fn edit(key: Key, modifiers: Modifiers) -> Option<Edit> {
    let Modifiers { ctrl, shift, alt, .. } = modifiers;
    let [with_ctrl, with_shift] = [ctrl && !alt, shift && !ctrl && !alt];
    if with_ctrl && !shift && [Key::C, Key::Insert].contains(&key) {
        Some(Edit::Copy)
    } else if (with_ctrl && !shift && key == Key::X) || (with_shift && key == Key::Delete) {
        Some(Edit::Cut)
    } else if (with_ctrl && key == Key::V) || (with_shift && key == Key::Insert) {
        Some(Edit::Paste)
    } else {
        None
    }
}

fn is_modifier(key: Typed) -> bool {
    [Typed::LeftCtrl, Typed::RightCtrl, Typed::LeftShift, Typed::RightShift, Typed::LeftAlt, Typed::RightAlt].contains(&key)
}

/// Maps keys with the same name in both libraries, and keys with different names.
macro_rules! keys {
    ($given:expr, same: $($same:ident)*, other: $($typed:ident $key:ident)*) => {
        match $given {
            $(Typed::$same => Some(Key::$same),)*
            $(Typed::$typed => Some(Key::$key),)*
            // egui has no such keys. For `*` there is the character.
            Typed::Menu | Typed::Pause | Typed::NumLock | Typed::CapsLock | Typed::ScrollLock => None,
            Typed::NumPadAsterisk | Typed::Unknown | Typed::Count => None,
        }
    };
}

/// The key of egui for one of minifb.
fn known(key: Typed) -> Option<Key> {
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

    use Stroke::{Character, Key as Press};

    fn typed(keyboard: &mut Keyboard, strokes: &[Stroke]) -> Vec<Event> {
        let mut told = Vec::new();
        strokes.iter().for_each(|stroke| keyboard.stroke(*stroke, &mut Clipboard::default(), &mut told));
        told
    }

    #[test]
    fn letters_are_a_key_and_a_text() {
        let told = typed(&mut Keyboard::default(), &[Press(Typed::A, true), Character('a'), Press(Typed::A, false)]);
        let key = |pressed| Event::Key { key: Key::A, physical_key: None, pressed, repeat: false, modifiers: Modifiers::NONE };
        assert_eq!(told, [key(true), Event::Text("a".into()), key(false)]);
    }

    #[test]
    fn with_ctrl_there_is_no_text_and_copying_has_a_name_of_its_own() {
        let mut keyboard = Keyboard::default();
        let told = typed(
            &mut keyboard,
            &[Press(Typed::LeftCtrl, true), Press(Typed::C, true), Character('\u{3}'), Press(Typed::X, true)],
        );
        assert!(
            told.contains(&Event::Copy)
                && told.contains(&Event::Cut)
                && told.contains(&Event::ModifiersChanged(Modifiers::COMMAND | Modifiers::CTRL)),
            "{told:?}"
        );
        assert!(!told.iter().any(|event| matches!(event, Event::Text(_) | Event::Key { key: Key::C | Key::X, .. })), "{told:?}");
        let told = typed(&mut keyboard, &[Press(Typed::S, true), Character('s')]);
        assert!(matches!(told[..], [Event::Key { key: Key::S, modifiers: Modifiers { command: true, .. }, .. }]), "{told:?}");
    }

    #[test]
    fn what_is_held_goes_up_with_the_focus() {
        let mut keyboard = Keyboard::default();
        typed(&mut keyboard, &[Press(Typed::LeftCtrl, true), Press(Typed::S, true)]);
        let mut told = Vec::new();
        keyboard.release(&mut told);
        assert!(told.iter().any(|event| matches!(event, Event::Key { key: Key::S, pressed: false, .. })), "{told:?}");
        assert_eq!(told.last(), Some(&Event::ModifiersChanged(Modifiers::NONE)));
        assert_eq!(typed(&mut keyboard, &[Character('s')]), [Event::Text("s".into())]);
    }
}
