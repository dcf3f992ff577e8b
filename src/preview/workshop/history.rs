//! Undo and redo of value changes.

use crate::formula::Formula;
use crate::scene::Scene;
use crate::workspace::Values;
use std::sync::Arc;

/// How many changes can be undone.
const MAX_ENTRIES: usize = 500;

/// Values with their formula and scene.
#[derive(Clone)]
pub(super) struct HistoryEntry {
    pub(super) values: Values,
    pub(super) formula: Arc<Formula>,
    pub(super) scene: Arc<Scene>,
}

impl HistoryEntry {
    /// The values for a formula and a scene: unchanged, or carried over by owner and name.
    pub(super) fn values_for(self, formula: &Arc<Formula>, scene: &Arc<Scene>) -> Values {
        if Arc::ptr_eq(&self.formula, formula) && Arc::ptr_eq(&self.scene, scene) {
            self.values
        } else {
            self.values.carry_over(formula, scene).0
        }
    }
}

/// The states before each change, and after each undone change.
#[derive(Default)]
pub(super) struct ValueHistory {
    before: Vec<HistoryEntry>,
    after: Vec<HistoryEntry>,
}

impl ValueHistory {
    /// Adds a state that is about to change.
    pub(super) fn push(&mut self, before: HistoryEntry) {
        self.after.clear();
        if self.before.len() == MAX_ENTRIES {
            self.before.remove(0);
        }
        self.before.push(before);
    }

    /// The state before the last change. `now` is the current state.
    pub(super) fn undo(&mut self, now: HistoryEntry) -> Option<HistoryEntry> {
        move_entry(&mut self.before, &mut self.after, now)
    }

    /// The state after the change that was undone last.
    pub(super) fn redo(&mut self, now: HistoryEntry) -> Option<HistoryEntry> {
        move_entry(&mut self.after, &mut self.before, now)
    }

    /// Whether there is a change to undo, and one to redo.
    pub(super) fn can_undo_and_redo(&self) -> [bool; 2] {
        [!self.before.is_empty(), !self.after.is_empty()]
    }
}

fn move_entry(from: &mut Vec<HistoryEntry>, to: &mut Vec<HistoryEntry>, now: HistoryEntry) -> Option<HistoryEntry> {
    let other = from.pop()?;
    to.push(now);
    Some(other)
}
