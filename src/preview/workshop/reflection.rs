//! The formula as a model of reflection: its values for one body and one light.

use super::Workshop;
use crate::instrument::model::{ParameterNumbers, default_numbers};
use crate::lang::variables::Owner;
use crate::scene::{BodyId, LightId};
use crate::workspace::OwnerId;

impl Workshop {
    /// The value of every parameter of the formula: of the scene, of this body and of this light. Where there is no
    /// body or no light, the defaults.
    pub fn reflection_numbers(&self, body: Option<BodyId>, light: Option<LightId>) -> ParameterNumbers {
        let mut numbers = default_numbers(&self.formula);
        for (id, number) in self.formula.parameter_ids().zip(&mut numbers) {
            let owner = match self.formula.parameter(id).owner {
                Owner::Global => Some(OwnerId::Global),
                Owner::Body => body.map(OwnerId::Body),
                Owner::Light => light.map(OwnerId::Light),
            };
            match owner.map(|owner| self.values.get(owner, id)) {
                Some([one]) => *number = [*one; 3],
                Some([red, green, blue]) => *number = [*red, *green, *blue],
                Some(_) | None => {}
            }
        }
        numbers
    }
}
