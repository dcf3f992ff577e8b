//! Undo and redo of changes of values and of the view transform.

use crate::formula::Formula;
use crate::picture::ViewTransform;
use crate::scene::Scene;
use crate::workspace::Values;
use std::sync::Arc;

/// How many changes can be undone.
const MAX_ENTRIES: usize = 500;

/// What a change replaced. A change of values leaves the view transform alone, and the other way round.
#[derive(Clone)]
pub(super) enum HistoryEntry {
    /// The values.
    Values(PastValues),
    /// The view transform.
    View(ViewTransform),
}

/// Values with their formula and scene.
#[derive(Clone)]
pub(super) struct PastValues {
    pub(super) values: Values,
    pub(super) formula: Arc<Formula>,
    pub(super) scene: Arc<Scene>,
}

impl PastValues {
    /// The values for a formula and a scene: unchanged, or carried over by owner and name.
    pub(super) fn values_for(self, formula: &Arc<Formula>, scene: &Arc<Scene>) -> Values {
        if Arc::ptr_eq(&self.formula, formula) && Arc::ptr_eq(&self.scene, scene) {
            self.values
        } else {
            self.values.carry_over(formula, scene).0
        }
    }
}

/// The current state, to come back to.
pub(super) struct CurrentState {
    pub(super) values: PastValues,
    pub(super) view: ViewTransform,
}

impl CurrentState {
    /// The part of it that an entry is of.
    fn part_of(self, entry: &HistoryEntry) -> HistoryEntry {
        match entry {
            HistoryEntry::Values(_) => HistoryEntry::Values(self.values),
            HistoryEntry::View(_) => HistoryEntry::View(self.view),
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

    /// The state before the last change.
    pub(super) fn undo(&mut self, now: CurrentState) -> Option<HistoryEntry> {
        let entry = move_entry(&mut self.before, &mut self.after, now)?;
        self.position -= 1;
        Some(entry)
    }

    /// The state after the change that was undone last.
    pub(super) fn redo(&mut self, now: CurrentState) -> Option<HistoryEntry> {
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

/// What differs between two view transforms, as the controls call it.
pub(super) fn changed_in_view(one: &ViewTransform, other: &ViewTransform) -> &'static str {
    let differs = [one.exposure != other.exposure, one.curve != other.curve, one.transfer != other.transfer];
    match differs {
        [true, false, false] => "the exposure",
        [false, true, false] => "the tone curve",
        [false, false, true] => "sRGB",
        _ => "exposure and tone",
    }
}

fn move_entry(from: &mut Vec<HistoryEntry>, to: &mut Vec<HistoryEntry>, now: CurrentState) -> Option<HistoryEntry> {
    let other = from.pop()?;
    to.push(now.part_of(&other));
    Some(other)
}
