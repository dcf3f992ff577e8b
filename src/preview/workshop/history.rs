//! What values were before, and could be again.

use crate::formula::Formula;
use crate::scene::Scene;
use crate::workspace::Values;
use std::sync::Arc;

/// So many changes can be undone.
const MOST: usize = 500;

/// Values, with what they are values of.
#[derive(Clone)]
pub(super) struct Moment {
    pub(super) values: Values,
    pub(super) formula: Arc<Formula>,
    pub(super) scene: Arc<Scene>,
}

impl Moment {
    /// The values as others of this formula and scene: as they were, or by owner and name.
    pub(super) fn values_for(self, formula: &Arc<Formula>, scene: &Arc<Scene>) -> Values {
        if Arc::ptr_eq(&self.formula, formula) && Arc::ptr_eq(&self.scene, scene) {
            self.values
        } else {
            self.values.carry_over(formula, scene).0
        }
    }
}

/// Values as they were before each change, and after each that was undone.
#[derive(Default)]
pub(super) struct History {
    before: Vec<Moment>,
    after: Vec<Moment>,
}

impl History {
    /// Keeps values that are going to change.
    pub(super) fn note(&mut self, before: Moment) {
        self.after.clear();
        if self.before.len() == MOST {
            self.before.remove(0);
        }
        self.before.push(before);
    }

    /// What there was before the last change, which was from there to `now`.
    pub(super) fn undo(&mut self, now: Moment) -> Option<Moment> {
        step(&mut self.before, &mut self.after, now)
    }

    /// What there was after the change that was undone last.
    pub(super) fn redo(&mut self, now: Moment) -> Option<Moment> {
        step(&mut self.after, &mut self.before, now)
    }

    /// Whether either is possible.
    pub(super) fn can_undo_and_redo(&self) -> [bool; 2] {
        [!self.before.is_empty(), !self.after.is_empty()]
    }
}

fn step(from: &mut Vec<Moment>, to: &mut Vec<Moment>, now: Moment) -> Option<Moment> {
    let other = from.pop()?;
    to.push(now);
    Some(other)
}
