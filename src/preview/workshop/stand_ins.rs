//! What stands in for a formula or a scene that cannot be used, and the values that wait for it. Values of parameters
//! that another formula does not have wait too, for the case that they come back.

use super::Workshop;
use crate::formula::Formula;
use crate::workspace::project::SessionMistakes;
use crate::workspace::session::NamedValue;
use crate::workspace::{Assignment, FileKind, ParameterTable, Session, Values};
use crate::world::World;
use std::sync::Arc;

/// What stands in, and what waits.
#[derive(Default)]
pub(super) struct StandIns {
    formula: Option<Arc<Formula>>,
    world: Option<Arc<World>>,
    /// Values of the session for texts that cannot be used.
    waiting: Vec<NamedValue>,
    /// Values of parameters that an earlier formula had.
    gone: Vec<NamedValue>,
}

impl StandIns {
    /// Notes the values of the parameters that only `old` has.
    pub(super) fn note_gone(&mut self, old: &Values, new: &Values) {
        let gone = Session::name_values(old).into_iter().filter(|value| {
            let is_there = new.table().parameter_named(&value.parameter).is_some();
            !is_there && value.assignment(old.table()).is_ok()
        });
        for value in gone {
            self.gone.retain(|other| (&other.owner, &other.parameter) != (&value.owner, &value.parameter));
            self.gone.push(value);
        }
    }

    /// Forgets all values.
    pub(super) fn forget_values(&mut self) {
        self.waiting.clear();
        self.gone.clear();
    }

    /// Gives the values that have a place now to it.
    pub(super) fn place(&mut self, values: &mut Values) {
        let table = values.table().clone();
        // What the user saved is older than what was used since.
        let placed: Vec<Assignment> =
            take_placed(&mut self.waiting, &table).into_iter().chain(take_placed(&mut self.gone, &table)).collect();
        if !placed.is_empty() {
            values.assign(&placed);
        }
    }
}

/// Takes the values that have a place in the table.
fn take_placed(values: &mut Vec<NamedValue>, table: &ParameterTable) -> Vec<Assignment> {
    let mut placed = Vec::new();
    values.retain(|value| value.assignment(table).map(|assignment| placed.push(assignment)).is_err());
    placed
}

impl Workshop {
    /// Notes that something stands in for texts of the session that was opened.
    pub fn note_mistakes(&mut self, mistakes: &SessionMistakes) {
        let is_unusable = |kind: FileKind| mistakes.unusable.iter().any(|text| text.kind == kind);
        self.stand_ins = StandIns {
            formula: is_unusable(FileKind::Formula).then(|| Arc::clone(&self.formula)),
            world: is_unusable(FileKind::Scene).then(|| Arc::clone(&self.world)),
            waiting: mistakes.waiting.clone(),
            gone: Vec::new(),
        };
    }

    /// Whether something stands in for the formula or the scene of the session.
    pub fn stands_in(&self, kind: FileKind) -> bool {
        match kind {
            FileKind::Formula => self.stand_ins.formula.as_ref().is_some_and(|one| Arc::ptr_eq(one, &self.formula)),
            FileKind::Scene => self.stand_ins.world.as_ref().is_some_and(|one| Arc::ptr_eq(one, &self.world)),
            FileKind::Session | FileKind::Material => false,
        }
    }

    /// The values of the session that wait for its formula or its scene. There are none if nothing stands in.
    pub fn waiting_values(&self) -> &[NamedValue] {
        let stands_in = self.stands_in(FileKind::Formula) || self.stands_in(FileKind::Scene);
        if stands_in { &self.stand_ins.waiting } else { &[] }
    }
}
