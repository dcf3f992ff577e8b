//! What values were before, and could be again.

use crate::workspace::Values;

/// So many changes can be undone.
const MOST: usize = 500;

/// Values as they were before each change, and after each that was undone.
#[derive(Default)]
pub(super) struct History {
    before: Vec<Values>,
    after: Vec<Values>,
}

impl History {
    /// Keeps values that are going to change.
    pub(super) fn note(&mut self, before: &Values) {
        self.after.clear();
        if self.before.len() == MOST {
            self.before.remove(0);
        }
        self.before.push(before.clone());
    }

    /// Goes back to before the last change; whether there was one.
    pub(super) fn undo(&mut self, values: &mut Values) -> bool {
        step(&mut self.before, &mut self.after, values)
    }

    /// Goes on to after it again; whether there was anything.
    pub(super) fn redo(&mut self, values: &mut Values) -> bool {
        step(&mut self.after, &mut self.before, values)
    }

    /// Whether either is possible.
    pub(super) fn can_undo_and_redo(&self) -> [bool; 2] {
        [!self.before.is_empty(), !self.after.is_empty()]
    }
}

fn step(from: &mut Vec<Values>, to: &mut Vec<Values>, values: &mut Values) -> bool {
    let Some(other) = from.pop() else { return false };
    to.push(std::mem::replace(values, other));
    true
}
