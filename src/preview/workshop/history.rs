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
    /// How many changes were made and not undone.
    position: u64,
    /// How many changes were made, undone or not.
    changes: u64,
}

impl ValueHistory {
    /// Adds a state that is about to change.
    pub(super) fn push(&mut self, before: HistoryEntry) {
        self.after.clear();
        if self.before.len() == MAX_ENTRIES {
            self.before.remove(0);
        }
        self.before.push(before);
        self.position += 1;
        self.changes += 1;
    }

    /// How many changes were made and not undone, and how many were made at all.
    pub(super) fn position(&self) -> [u64; 2] {
        [self.position, self.changes]
    }

    /// The state before the last change. `now` is the current state.
    pub(super) fn undo(&mut self, now: HistoryEntry) -> Option<HistoryEntry> {
        let entry = move_entry(&mut self.before, &mut self.after, now)?;
        self.position -= 1;
        Some(entry)
    }

    /// The state after the change that was undone last.
    pub(super) fn redo(&mut self, now: HistoryEntry) -> Option<HistoryEntry> {
        let entry = move_entry(&mut self.after, &mut self.before, now)?;
        self.position += 1;
        Some(entry)
    }

    /// The state before the last change, and that after the change that was undone last.
    pub(super) fn last_and_next(&self) -> [Option<&HistoryEntry>; 2] {
        [self.before.last(), self.after.last()]
    }

    /// Whether there is a change to undo, and one to redo.
    pub(super) fn can_undo_and_redo(&self) -> [bool; 2] {
        [!self.before.is_empty(), !self.after.is_empty()]
    }
}

/// What differs between two sets of values of the same formula and scene: a parameter, an owner, or several.
pub(super) fn changed(one: &Values, other: &Values) -> String {
    let differing = one.iter().zip(other.iter()).filter(|((.., one), (.., other))| one != other);
    let all: Vec<_> = differing.map(|((owner, id, _), _)| (owner, id)).collect();
    let table = one.table();
    match all.as_slice() {
        [] => "values".to_owned(),
        [(owner, id)] => table.label(*owner, *id),
        [(first, id), rest @ ..] if rest.iter().all(|(owner, _)| owner == first) => {
            table.owners().name(*first).map_or_else(|| table.label(*first, *id), str::to_owned)
        }
        [(_, first), rest @ ..] if rest.iter().all(|(_, id)| id == first) => {
            format!("{} of several", table.parameter(*first).name)
        }
        _ => "several values".to_owned(),
    }
}

fn move_entry(from: &mut Vec<HistoryEntry>, to: &mut Vec<HistoryEntry>, now: HistoryEntry) -> Option<HistoryEntry> {
    let other = from.pop()?;
    to.push(now);
    Some(other)
}
